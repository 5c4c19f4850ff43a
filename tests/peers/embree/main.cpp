// main.cpp - a Whitted ray tracer on Embree, to measure feeler beside it: what a good C++ programmer gets from Embree's own
// intersectors. NFF scenes of any shape, and a binary PLY mesh beside them.
#include "render.hpp"

#include <cstdio>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <sys/resource.h>

namespace {

const char usage[] = "usage: embree_whitted SCENE.nff SIZE SAMPLES MODE [OUT.pfm] [--mesh FILE.ply] [--frames N]\n"
                     "SAMPLES: 1 or 16. MODE: 1 (one ray at a time), 16 (packets of a pixel's samples),\n"
                     "c (packets, Embree's coherent flag). Prints one line of JSON: the fastest of N frames (5).\n";

struct Options {
    std::string scene, mode_name, out, mesh;
    int size = 0, samples = 0, frames = 5;
    Mode mode = Mode::single;
};

Mode mode_of(const std::string &name) {
    if (name == "1")
        return Mode::single;
    if (name == "16")
        return Mode::packet;
    if (name == "c")
        return Mode::coherent;
    throw std::runtime_error("the mode is 1, 16 or c, not '" + name + "'");
}

Options read_options(int argc, char **argv) {
    Options o;
    std::vector<std::string> words;
    for (int i = 1; i < argc; i++)
        if (std::strcmp(argv[i], "--mesh") == 0 && i + 1 < argc)
            o.mesh = argv[++i];
        else if (std::strcmp(argv[i], "--frames") == 0 && i + 1 < argc)
            o.frames = std::max(1, std::atoi(argv[++i]));
        else
            words.push_back(argv[i]);
    if (words.size() < 4 || words.size() > 5)
        throw std::runtime_error(usage);
    o.scene = words[0];
    o.size = std::atoi(words[1].c_str());
    o.samples = std::atoi(words[2].c_str());
    o.mode_name = words[3];
    o.mode = mode_of(words[3]);
    o.out = words.size() == 5 ? words[4] : "";
    if (o.size < 1 || (o.samples != 1 && o.samples != 16))
        throw std::runtime_error("the size is at least 1, the samples are 1 or 16");
    if (o.samples == 1 && o.mode != Mode::single)
        throw std::runtime_error("packets are of a pixel's 16 samples");
    return o;
}

Scene read_scene(const Options &o) {
    Scene scene = read_nff(o.scene);
    if (o.mesh.empty())
        return scene;
    if (scene.materials.empty())
        throw std::runtime_error("the mesh has no fill: the scene's last would be its own");
    scene.file = read_ply(o.mesh);
    scene.file.materials = {static_cast<int>(scene.materials.size()) - 1};
    return scene;
}

void write_pfm(const std::string &path, const Picture &picture) {
    FILE *file = std::fopen(path.c_str(), "wb");
    if (!file)
        throw std::runtime_error(path + " cannot be written");
    std::fprintf(file, "PF\n%d %d\n-1.0\n", picture.size, picture.size);
    for (int y = picture.size; y-- > 0;)
        std::fwrite(&picture.pixels[static_cast<size_t>(y) * picture.size], sizeof(Point), picture.size, file);
    std::fclose(file);
}

void print(const Options &o, const Geometry &geometry, const Picture &picture, double seconds) {
    const Counts &n = picture.counts;
    struct rusage used;
    getrusage(RUSAGE_SELF, &used);
    const double rays = static_cast<double>(n.eye + n.reflection + n.transmission + n.shadow);
    std::printf("{\"mode\": \"%s\", \"size\": %d, \"samples\": %d, \"trace_s\": %.6f, \"build_s\": %.6f, "
                "\"rays\": {\"eye\": %ld, \"eye_hits\": %ld, \"reflection\": %ld, \"transmission\": %ld, "
                "\"shadow\": %ld}, \"mrays_per_s\": %.3f, \"primitives\": %zu, \"peak_bytes\": %ld}\n",
                o.mode_name.c_str(), o.size, o.samples, seconds, geometry.build_seconds(), n.eye, n.eye_hits,
                n.reflection, n.transmission, n.shadow, rays / seconds / 1e6, geometry.primitives(),
                1024 * used.ru_maxrss);
}

void run(const Options &o) {
    const Scene scene = read_scene(o);
    const Geometry geometry(scene);
    Picture picture = render(scene, geometry, o.size, o.samples, o.mode);
    double best = picture.seconds;
    for (int frame = 1; frame < o.frames; frame++) {
        picture = render(scene, geometry, o.size, o.samples, o.mode);
        best = std::min(best, picture.seconds);
    }
    if (!o.out.empty())
        write_pfm(o.out, picture);
    print(o, geometry, picture, best);
}

} // namespace

int main(int argc, char **argv) {
    try {
        run(read_options(argc, argv));
    } catch (const std::exception &e) {
        std::fprintf(stderr, "embree_whitted: %s\n", e.what());
        return 1;
    }
    return 0;
}
