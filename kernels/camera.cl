// camera.cl - where in a pixel the samples are, and the eye rays through them.

// Three well mixed numbers from three (Jarzynski and Olano 2020, Hash Functions for GPU Rendering: pcg3d).
uint4 hash3(uint x, uint y, uint z) {
    x = x * 1664525u + 1013904223u;
    y = y * 1664525u + 1013904223u;
    z = z * 1664525u + 1013904223u;
    x += y * z;
    y += z * x;
    z += x * y;
    x ^= x >> 16;
    y ^= y >> 16;
    z ^= z >> 16;
    x += y * z;
    y += z * x;
    z += x * y;
    return (uint4)(x, y, z, 0);
}

real unit_interval(uint bits) {
    return R(bits >> 8) * R(0x1p-24);
}

typedef struct {
    real x, y;
} place;

// The place of a sample in its pixel, from 0 to 1 each way: cells of equal size in rows that are as many as a square's,
// a longer row being a higher one. It depends on pixel and sample alone. One sample is at the centre.
place place_sample(uint x, uint y, uint sample, uint samples, real jitter) {
    uint rows = 1;
    while ((rows + 1) * (rows + 1) <= samples)
        rows++;
    const uint row = (sample * rows + rows - 1) / samples;
    const uint first = row * samples / rows, last = (row + 1) * samples / rows;
    const uint4 h = hash3(x, y, sample);
    const real amount = samples == 1 ? R(0) : jitter;
    const real in_x = R(0.5) + amount * (unit_interval(h.x) - R(0.5));
    const real in_y = R(0.5) + amount * (unit_interval(h.y) - R(0.5));
    place p;
    p.x = (R(sample - first) + in_x) / R(last - first);
    p.y = (R(first) + in_y * R(last - first)) / R(samples);
    return p;
}

// The directions of the eye rays (16.5, 16.6) of samples first, first + 1, ... of a pixel.
vectors eye_directions(const view *camera, uint x, uint y, uint first, uint4 frame) {
    reals across, down;
    for (int lane = 0; lane < RAYS; lane++) {
        const uint sample = min(first + lane, frame.z - 1);
        const place p = place_sample(x, y, sample, frame.z, camera->limits.y);
        REAL_LANE(across, lane) = R((int)(2 * x) - (int)frame.x) + 2 * p.x;
        REAL_LANE(down, lane) = R((int)frame.y - (int)(2 * y)) - 2 * p.y;
    }
#if RAYS == 1
    across = splat(REAL_LANE(across, 0));
    down = splat(REAL_LANE(down, 0));
#endif
    const vectors d = along(splat_xyz(camera->forward), splat_xyz(camera->right), across);
    return normalise(along(d, splat_xyz(camera->up), down));
}
