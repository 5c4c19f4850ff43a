// image_io.cpp - reads and writes pictures by OpenImageIO: the only file that knows it, and the only one in C++.
extern "C" {
#include "image.h"
// Of error.c. The header that declares it is not C++.
int fail(feeler_error *error, int code, const char *format, ...) __attribute__((format(printf, 3, 4)));
}

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <memory>
#include <new>
#include <string>
#include <vector>

namespace {

// Linear, alpha associated.
struct pixel {
    double rgb[3], alpha;
};

// What `work` returns. No exception leaves it: they are errors, "PATH: cannot VERB: why".
template <typename F> int without_exceptions(const char *path, const char *verb, feeler_error *error, F work) {
    try {
        return work();
    } catch (const std::bad_alloc &) {
        return fail(error, FEELER_OUT_OF_MEMORY, "%s: cannot %s: out of memory", path, verb);
    } catch (const std::exception &e) {
        return fail(error, FEELER_IO, "%s: cannot %s: %s", path, verb, e.what());
    } catch (...) {
        return fail(error, FEELER_IO, "%s: cannot %s", path, verb);
    }
}

} // namespace

// ---- reading

namespace {

// IEC 61966-2-1.
double decode_srgb(double coded) {
    return coded <= 0.04045 ? coded / 12.92 : std::pow((coded + 0.055) / 1.055, 2.4);
}

// Where a file's channels are: red, green, blue, alpha (-1: none). OpenImageIO calls grey Y whatever the format does; in
// EXR files it may be L. More than two channels with Y are luminance and chroma.
bool find_channels(const OIIO::ImageSpec &spec, int place[4]) {
    static const char *const names[] = {"R", "G", "B", "A"};
    for (int c = 0; c < 4; c++)
        place[c] = spec.channelindex(names[c]);
    if (place[0] >= 0 && place[1] >= 0 && place[2] >= 0)
        return true;
    place[0] = place[1] = place[2] = std::max(spec.channelindex("Y"), spec.channelindex("L"));
    return place[0] >= 0 && spec.nchannels <= 2;
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
        return fail(error, FEELER_BAD_INPUT, "%s: has no channels R, G and B, and is not grey", path);
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

// ---- writing

namespace {

enum class kind { exr, hdr, png, tiff, jpeg };

struct format {
    const char *name; // OpenImageIO's
    kind what;
};

format format_of(const std::string &name) {
    size_t dot = name.find_last_of('.');
    std::string ending = dot == std::string::npos ? name : name.substr(dot + 1);
    for (char &c : ending)
        c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
    if (ending == "exr")
        return {"openexr", kind::exr};
    if (ending == "hdr")
        return {"hdr", kind::hdr};
    if (ending == "png")
        return {"png", kind::png};
    if (ending == "jpg" || ending == "jpeg")
        return {"jpeg", kind::jpeg};
    return {"tiff", kind::tiff};
}

bool is_linear(kind what) {
    return what == kind::exr || what == kind::hdr;
}

// IEC 61966-2-1.
double encode_srgb(double linear) {
    if (!(linear > 0))
        return 0; // also what is not a number
    if (linear >= 1)
        return 1;
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

double clamp_unit(double value) {
    return value > 0 ? (value < 1 ? value : 1) : 0;
}

// Only a picture without background has holes: with it, every pixel is opaque whatever its coverage.
pixel pixel_at(const feeler_image &image, size_t index) {
    pixel p;
    double values[4];
    for (int c = 0; c < 4; c++)
        values[c] = image.is_double ? static_cast<const double *>(image.pixels)[4 * index + c]
                                    : double(static_cast<const float *>(image.pixels)[4 * index + c]);
    for (int c = 0; c < 3; c++)
        p.rgb[c] = values[c];
    p.alpha = image.transparent ? clamp_unit(values[3]) : 1;
    return p;
}

// Linear, associated alpha, nothing clamped.
std::vector<float> linear_values(const feeler_image &image, int channels) {
    size_t count = size_t(image.width) * size_t(image.height);
    std::vector<float> values(count * size_t(channels));
    float *out = values.data();
    for (size_t i = 0; i < count; i++) {
        pixel p = pixel_at(image, i);
        for (int c = 0; c < channels; c++)
            *out++ = float(c < 3 ? p.rgb[c] : p.alpha);
    }
    return values;
}

// sRGB in whole numbers. A transfer curve acts on a surface's colour, not on its product with alpha: with an alpha
// channel the colours are divided by it first, and the file says that they are unassociated.
template <typename T> std::vector<T> srgb_values(const feeler_image &image, int channels) {
    const double top = double(T(~T(0)));
    size_t count = size_t(image.width) * size_t(image.height);
    std::vector<T> values(count * size_t(channels));
    T *out = values.data();
    for (size_t i = 0; i < count; i++) {
        pixel p = pixel_at(image, i);
        for (int c = 0; c < channels; c++) {
            double colour = c < 3 ? p.rgb[c] : p.alpha;
            if (c < 3 && channels == 4)
                colour = p.alpha > 0 ? colour / p.alpha : 0;
            *out++ = T((c < 3 ? encode_srgb(colour) : colour) * top + 0.5);
        }
    }
    return values;
}

std::string number(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}

std::string level_name(int level) {
    return level == FEELER_DRAFT ? "draft" : level == FEELER_STANDARD ? "standard" : "reference";
}

std::string describe_settings(const feeler_image &image) {
    const render_stats &s = image.stats;
    std::string text =
        "level " + level_name(s.level) + ", size " + std::to_string(s.width) + "x" + std::to_string(s.height);
    text += ", region " + std::to_string(image.x0) + "," + std::to_string(image.y0) + "," +
            std::to_string(image.x0 + image.width) + "," + std::to_string(image.y0 + image.height);
    text += ", samples " + std::to_string(s.samples) + ", jitter " + number(s.jitter);
    text += ", depth " + std::to_string(s.depth) + ", cutoff " + number(s.cutoff);
    text += ", work group " + std::to_string(s.work_group[0]) + "x" + std::to_string(s.work_group[1]);
    return text + ", lanes " + std::to_string(s.lanes);
}

std::string describe_rays(const render_stats &s) {
    return "eye " + std::to_string(s.eye) + ", eye hits " + std::to_string(s.eye_hits) + ", reflection " +
           std::to_string(s.reflection) + ", transmission " + std::to_string(s.transmission) + ", shadow " +
           std::to_string(s.shadow);
}

std::string describe_seconds(const render_stats &s) {
    return "load " + number(s.load) + ", tree " + number(s.tree) + ", compile " + number(s.compile) + ", trace " +
           number(s.trace);
}

// "0 glass, 1 brass": the names of the ids in the channel, those written in place having none.
std::string describe_materials(const feeler_image &image) {
    std::string text;
    for (size_t i = 0; i < image.material_count; i++)
        text += (i ? ", " : "") + std::to_string(i) + " " + image.materials[i];
    return text;
}

struct note {
    std::string key, text;
};

std::vector<note> notes_of(const feeler_image &image, const feeler_save_options &options) {
    if (!image.options)
        return {{"version", feeler_version()}};
    std::vector<note> notes = {
        {"scene", image.scene_name ? image.scene_name : ""},
        {"settings", describe_settings(image)},
        {"device", image.stats.device},
        {"version", feeler_version()},
        {"rays", describe_rays(image.stats)},
        {"seconds", describe_seconds(image.stats)},
    };
    if (image.material_count > 0)
        notes.push_back({"materials", describe_materials(image)});
    if (options.partial)
        notes.push_back({"interrupted", "the render was interrupted: only a part of the picture is there"});
    return notes;
}

// Few formats keep attributes of any name; ImageDescription is kept by all but HDR.
void add_metadata(OIIO::ImageSpec &spec, const std::vector<note> &notes) {
    std::string all;
    for (const note &n : notes) {
        spec.attribute("feeler:" + n.key, n.text);
        all += (all.empty() ? "" : "\n") + n.key + ": " + n.text;
    }
    spec.attribute("ImageDescription", all);
    spec.attribute("Software", std::string("feeler ") + feeler_version());
}

// A layer beside the picture: one component of a channel.
struct layer {
    int channel, component;
};

std::vector<layer> layers_of(const feeler_image &image) {
    std::vector<layer> layers;
    for (int c = 0; c < CHANNELS; c++)
        for (int i = 0; image.channels[c] && i < channel_kinds[c].components; i++)
            layers.push_back({c, i});
    return layers;
}

// The four bytes that the file has of a pixel: a float, or a whole number; the -1 of what is not there has all bits set.
uint32_t layer_bits(const feeler_image &image, const layer &l, size_t pixel) {
    const channel_kind &kind = channel_kinds[l.channel];
    const size_t at = pixel * size_t(kind.components) + size_t(l.component);
    if (kind.whole)
        return static_cast<const uint32_t *>(image.channels[l.channel])[at];
    const float number = image.is_double ? float(static_cast<const double *>(image.channels[l.channel])[at])
                                         : static_cast<const float *>(image.channels[l.channel])[at];
    uint32_t bits;
    std::memcpy(&bits, &number, sizeof bits);
    return bits;
}

// After the picture's own, which are floats.
void add_layers(OIIO::ImageSpec &spec, const std::vector<layer> &layers) {
    spec.channelformats.assign(size_t(spec.nchannels), OIIO::TypeDesc::FLOAT);
    for (const layer &l : layers) {
        const channel_kind &kind = channel_kinds[l.channel];
        spec.channelnames.push_back(kind.layer[l.component]);
        spec.channelformats.push_back(kind.whole ? OIIO::TypeDesc::UINT32 : OIIO::TypeDesc::FLOAT);
    }
    spec.nchannels += int(layers.size());
}

OIIO::ImageSpec describe_file(const feeler_image &image, kind what, const feeler_save_options &options) {
    OIIO::TypeDesc type = is_linear(what)       ? OIIO::TypeDesc::FLOAT
                          : options.sixteen_bit ? OIIO::TypeDesc::UINT16
                                                : OIIO::TypeDesc::UINT8;
    OIIO::ImageSpec spec(image.width, image.height, options.alpha ? 4 : 3, type);
    if (what == kind::exr) { // the others know no data window
        spec.x = image.x0;
        spec.y = image.y0;
        spec.full_width = image.stats.width;
        spec.full_height = image.stats.height;
        spec.attribute("compression", "zip");
    }
    if (what == kind::png || what == kind::tiff) {
        spec.attribute("oiio:UnassociatedAlpha", 1);
        spec.attribute("compression", "zip");
    }
    if (what == kind::jpeg) {
        spec.attribute("Compression", "jpeg:95");
        spec.attribute("jpeg:subsampling", "4:4:4");
    }
    spec.attribute("oiio:ColorSpace", is_linear(what) ? "Linear" : "sRGB");
    return spec;
}

// The picture and its layers, four bytes each, pixel after pixel.
bool write_layers(OIIO::ImageOutput &out, const feeler_image &image, int channels, const std::vector<layer> &layers) {
    const size_t count = size_t(image.width) * size_t(image.height), own = size_t(channels), all = own + layers.size();
    const std::vector<float> colours = linear_values(image, channels);
    std::vector<uint32_t> values(count * all);
    for (size_t i = 0; i < count; i++) {
        std::memcpy(&values[i * all], &colours[i * own], own * sizeof(float));
        for (size_t k = 0; k < layers.size(); k++)
            values[i * all + own + k] = layer_bits(image, layers[k], i);
    }
    return out.write_image(OIIO::TypeDesc::UNKNOWN, values.data());
}

bool write_pixels(OIIO::ImageOutput &out, const feeler_image &image, int channels, kind what, bool sixteen_bit) {
    if (is_linear(what))
        return out.write_image(OIIO::TypeDesc::FLOAT, linear_values(image, channels).data());
    if (sixteen_bit)
        return out.write_image(OIIO::TypeDesc::UINT16, srgb_values<uint16_t>(image, channels).data());
    return out.write_image(OIIO::TypeDesc::UINT8, srgb_values<uint8_t>(image, channels).data());
}

// Comment lines of an HDR file. Readers with a fixed buffer, OpenImageIO's among them, stumble over long ones.
std::string hdr_comment(const note &n) {
    const size_t longest = 100;
    std::string text = "feeler:" + n.key + ": " + n.text, lines;
    while (text.size() > longest) {
        size_t space = text.rfind(' ', longest);
        size_t cut = space == std::string::npos || space == 0 ? longest : space;
        lines += "# " + text.substr(0, cut) + "\n";
        text.erase(0, cut == space ? cut + 1 : cut);
    }
    lines += "# " + text + "\n";
    return lines;
}

// OpenImageIO writes no metadata into HDR files. Their header takes comment lines after the first line.
bool add_hdr_comments(const char *path, const std::vector<note> &notes) {
    std::ifstream in(path, std::ios::binary);
    std::string whole((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    size_t line_end = whole.find('\n');
    if (!in || line_end == std::string::npos)
        return false;
    std::string comments;
    for (const note &n : notes)
        comments += hdr_comment(n);
    whole.insert(line_end + 1, comments);
    std::ofstream out(path, std::ios::binary | std::ios::trunc);
    out.write(whole.data(), std::streamsize(whole.size()));
    out.close();
    return !out.fail();
}

int write(const feeler_image &image, const char *path, const char *format_name, const feeler_save_options &options,
          feeler_error *error) {
    format target = format_of(format_name);
    std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create(target.name);
    if (!out) {
        std::string why = OIIO::geterror();
        return fail(error, FEELER_IO, "%s: OpenImageIO cannot write this format: %s", format_name, why.c_str());
    }
    OIIO::ImageSpec spec = describe_file(image, target.what, options);
    std::vector<note> notes = notes_of(image, options);
    add_metadata(spec, notes);
    const int channels = spec.nchannels;
    const std::vector<layer> layers = target.what == kind::exr ? layers_of(image) : std::vector<layer>();
    if (!layers.empty())
        add_layers(spec, layers);

    bool done = out->open(path, spec) &&
                (layers.empty() ? write_pixels(*out, image, channels, target.what, options.sixteen_bit != 0)
                                : write_layers(*out, image, channels, layers));
    std::string why = done ? "" : out->geterror();
    // Closing writes what is still buffered, so it can fail where writing did not.
    if (!out->close() && done) {
        done = false;
        why = out->geterror();
    }
    if (!done)
        return fail(error, FEELER_IO, "%s: cannot write: %s", format_name,
                    why.empty() ? "unknown reason" : why.c_str());
    if (target.what == kind::hdr && !add_hdr_comments(path, notes))
        return fail(error, FEELER_IO, "%s: cannot write the metadata", format_name);
    return 0;
}

} // namespace

extern "C" __attribute__((visibility("default"))) int feeler_image_io_write(const feeler_image *image, const char *path,
                                                                            const char *format_name,
                                                                            const feeler_save_options *options,
                                                                            feeler_error *error) {
    return without_exceptions(format_name, "write", error,
                              [&] { return write(*image, path, format_name, *options, error); });
}
