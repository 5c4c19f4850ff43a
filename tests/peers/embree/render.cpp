// render.cpp - a picture, tile by tile, on every core.
#include "render.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <pmmintrin.h>
#include <thread>
#include <xmmintrin.h>

namespace {

constexpr int tile = 16;

// `right` and `down` lead from the picture's middle to its border's pixel centres.
struct Camera {
    Point eye, forward, right, down;
    int size, cells; // cells: of a pixel, each way
};

Camera make_camera(const Scene &scene, int size, int samples) {
    const Point forward = unit(scene.at - scene.from), right = unit(cross(forward, scene.up));
    const float slope = std::tan(scene.angle * static_cast<float>(M_PI) / 360);
    const float step = slope / static_cast<float>(std::max(size - 1, 1));
    return {scene.from, forward, right * step, cross(forward, right) * step, size, samples == 16 ? 4 : 1};
}

// The rays of the samples first, first + 1, ... of a pixel.
template <int N> Packet<N> eye_rays(const Camera &c, int x, int y, int first) {
    Reals<N> across, down;
    for (int k = 0; k < N; k++) {
        const float cells = static_cast<float>(c.cells);
        const float px = static_cast<float>(x) + (static_cast<float>((first + k) % c.cells) + 0.5f) / cells;
        const float py = static_cast<float>(y) + (static_cast<float>((first + k) / c.cells) + 0.5f) / cells;
        as_array(across)[k] = 2 * px - static_cast<float>(c.size);
        as_array(down)[k] = 2 * py - static_cast<float>(c.size);
    }
    using T = Reals<N>;
    Packet<N> p;
    p.origin = splat<T>(c.eye);
    p.direction = unit(splat<T>(c.forward) + splat<T>(c.right) * across + splat<T>(c.down) * down);
    p.weight = T{} + 1;
    p.active = Ints<N>{} - 1;
    return p;
}

template <int N> Point add_lanes(const Vec<Reals<N>> &v) {
    Point sum{};
    for (int k = 0; k < N; k++)
        sum = sum + Point{as_array(v.x)[k], as_array(v.y)[k], as_array(v.z)[k]};
    return sum;
}

template <int N> Point trace_pixel(Tracer &tracer, const Camera &camera, int x, int y) {
    const int samples = camera.cells * camera.cells;
    Vec<Reals<N>> sum{};
    for (int first = 0; first < samples; first += N)
        trace<N>(tracer, eye_rays<N>(camera, x, y, first), 1, sum);
    tracer.counts.eye += samples;
    return add_lanes<N>(sum) * (1 / static_cast<float>(samples));
}

// Takes tiles until there are none left.
void trace_tiles(Tracer &tracer, const Camera &camera, Mode mode, std::atomic<int> &next, std::vector<Point> &pixels) {
    const int size = camera.size, columns = (size + tile - 1) / tile;
    for (int id; (id = next++) < columns * columns;)
        for (int y = id / columns * tile; y < std::min(size, (id / columns + 1) * tile); y++)
            for (int x = id % columns * tile; x < std::min(size, (id % columns + 1) * tile); x++)
                pixels[static_cast<size_t>(y) * size + x] =
                    mode == Mode::single ? trace_pixel<1>(tracer, camera, x, y) : trace_pixel<16>(tracer, camera, x, y);
}

Counts operator+(Counts a, const Counts &b) {
    return {a.eye + b.eye, a.eye_hits + b.eye_hits, a.reflection + b.reflection, a.transmission + b.transmission,
            a.shadow + b.shadow};
}

} // namespace

Picture render(const Scene &scene, const Geometry &geometry, int size, int samples, Mode mode) {
    const Camera camera = make_camera(scene, size, samples);
    Picture picture{size, std::vector<Point>(static_cast<size_t>(size) * size), {}, 0};
    std::vector<Tracer> tracers(std::thread::hardware_concurrency(),
                                {scene, geometry, Queries(mode == Mode::coherent), {}});
    std::vector<std::thread> threads;
    std::atomic<int> next{0};
    const auto start = std::chrono::steady_clock::now();
    for (Tracer &shared : tracers)
        threads.emplace_back([&] {
            _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
            _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
            Tracer own = shared; // on this thread's stack: no cache line is shared
            trace_tiles(own, camera, mode, next, picture.pixels);
            shared.counts = own.counts;
        });
    for (std::thread &thread : threads)
        thread.join();
    picture.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    for (const Tracer &tracer : tracers)
        picture.counts = picture.counts + tracer.counts;
    return picture;
}
