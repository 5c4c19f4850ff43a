// image_read.cpp - reads pictures of any format that OpenImageIO knows.
#include "image_io.h"

#include <OpenImageIO/imageio.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

namespace {

// IEC 61966-2-1.
double decode_srgb(double coded) {
    return coded <= 0.04045 ? coded / 12.92 : std::pow((coded + 0.055) / 1.055, 2.4);
}

// Where a file's channels are: red, green, blue, alpha (-1: none). One or two channels are grey without and with alpha.
bool find_channels(const OIIO::ImageSpec &spec, int place[4]) {
    static const char *const names[] = {"R", "G", "B", "A"};
    for (int c = 0; c < 4; c++)
        place[c] = spec.channelindex(names[c]);
    if (place[0] >= 0 && place[1] >= 0 && place[2] >= 0)
        return true;
    place[0] = place[1] = place[2] = 0;
    place[3] = spec.nchannels == 2 ? 1 : -1;
    return spec.nchannels <= 2;
}

// As an image keeps it.
pixel decode(const float *values, const int place[4], bool coded, bool associated) {
    pixel p;
    p.alpha = place[3] < 0 ? 1 : double(values[place[3]]);
    const double cover = place[3] >= 0 && associated && p.alpha > 0 ? p.alpha : 1; // in the coded colour
    for (int c = 0; c < 3; c++) {
        p.rgb[c] = double(values[place[c]]);
        if (coded)
            p.rgb[c] = decode_srgb(p.rgb[c] / cover) * cover;
        if (!associated && place[3] >= 0)
            p.rgb[c] *= p.alpha;
    }
    return p;
}

// OpenImageIO may say a thing in several lines.
std::string first_line(const std::string &text) {
    return text.substr(0, text.find('\n'));
}

int read(feeler_image &image, const char *path, feeler_error *error) {
    OIIO::ImageSpec wish; // to multiply coded colours by alpha would be wrong, and loses bits
    wish.attribute("oiio:UnassociatedAlpha", 1);
    std::unique_ptr<OIIO::ImageInput> in = OIIO::ImageInput::open(path, &wish);
    if (!in)
        return fail(error, FEELER_IO, "%s: cannot read: %s", path, first_line(OIIO::geterror()).c_str());
    const OIIO::ImageSpec &spec = in->spec();
    int place[4];
    if (spec.depth > 1 || spec.width < 1 || spec.height < 1 || spec.image_pixels() > uint64_t(1) << 28)
        return fail(error, FEELER_BAD_INPUT, "%s: %d x %d x %d pixels: pictures of 1 to 2^28 pixels can be read", path,
                    spec.width, spec.height, spec.depth);
    if (!find_channels(spec, place))
        return fail(error, FEELER_BAD_INPUT, "%s: has no channels R, G and B", path);
    const size_t count = size_t(spec.image_pixels()), channels = size_t(spec.nchannels);
    std::vector<float> values(count * channels);
    if (!in->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, values.data()))
        return fail(error, FEELER_IO, "%s: cannot read: %s", path, first_line(in->geterror()).c_str());

    image.pixels = std::malloc(count * 4 * sizeof(float));
    if (!image.pixels)
        throw std::bad_alloc();
    const bool coded = !spec.format.is_floating_point() && spec.get_string_attribute("oiio:ColorSpace") != "Linear";
    const bool associated = spec.get_int_attribute("oiio:UnassociatedAlpha") == 0;
    for (size_t i = 0; i < count; i++) {
        pixel p = decode(&values[i * channels], place, coded, associated);
        for (int c = 0; c < 4; c++)
            static_cast<float *>(image.pixels)[4 * i + size_t(c)] = float(c < 3 ? p.rgb[c] : p.alpha);
    }
    image.x0 = spec.x;
    image.y0 = spec.y;
    image.width = spec.width;
    image.height = spec.height;
    image.stats.width = spec.full_width;
    image.stats.height = spec.full_height;
    image.transparent = place[3] >= 0;
    return 0;
}

} // namespace

extern "C" __attribute__((visibility("default"))) int feeler_image_io_read(feeler_image *image, const char *path,
                                                                           feeler_error *error) {
    return without_exceptions(path, "read", error, [&] { return read(*image, path, error); });
}
