// camera.cl - where in a pixel the samples are, and the eye rays through them.

// Whole numbers for each lane.
#if LANES == 1
typedef uint uints;
#define TO_UINTS convert_uint
#else
typedef JOIN(uint, LANES) uints;
#define TO_UINTS JOIN(convert_uint, LANES)
#endif

// A mask as a comparison of whole numbers gives it, as one of numbers.
#if LANES == 1
#define AS_MASK(m) mask(m)
#else
#define AS_MASK(m) TO_INTS(m)
#endif

// a / b without the division of whole numbers, which vectors do not have: right where the quotient is under 2^22.
uints divide(uints a, uint b) {
    const uints q = TO_UINTS(TO_REALS(a) * (R(1) / R(b))), rest = a - q * b;
    const uints low = rest >> 31; // 1 where q is one too large
    return q - low + (low ^ 1) * ((b - 1 - rest) >> 31);
}

// Two well mixed numbers from three (Jarzynski and Olano 2020, Hash Functions for GPU Rendering: pcg3d).
typedef struct {
    uints x, y;
} hashes;

hashes hash3(uints x, uints y, uints sample) {
    uints a = x * 1664525u + 1013904223u, b = y * 1664525u + 1013904223u;
    uints c = sample * 1664525u + 1013904223u;
    a += b * c;
    b += c * a;
    c += a * b;
    a ^= a >> 16;
    b ^= b >> 16;
    c ^= c >> 16;
    a += b * c;
    b += c * a;
    const hashes h = {a, b};
    return h;
}

reals unit_interval(uints bits) {
    return TO_REALS(bits >> 8) * R(0x1p-24);
}

// Places in a pixel, from 0 to 1 each way.
typedef struct {
    reals x, y;
} places;

// Where the samples are: cells of equal size in rows that are as many as a square's, a longer row being a higher one. A
// place depends on pixel and sample alone. One sample is at the centre.
places place_samples(uints x, uints y, uints sample, uint samples, real jitter) {
    places p;
    p.x = p.y = splat(R(0.5));
    if (samples == 1)
        return p;
    uint rows = 1;
    while ((rows + 1) * (rows + 1) <= samples)
        rows++;
    uints first, columns = rows; // the row's first sample, and how many it has
    if (rows * rows == samples) {
        first = divide(sample, rows) * rows;
    } else {
        const uints row = divide(sample * rows + rows - 1, samples);
        first = divide(row * samples, rows);
        columns = divide((row + 1) * samples, rows) - first;
    }
    const hashes h = hash3(x, y, sample);
    const reals in_x = R(0.5) + jitter * (unit_interval(h.x) - R(0.5));
    const reals in_y = R(0.5) + jitter * (unit_interval(h.y) - R(0.5));
    p.x = (TO_REALS(sample - first) + in_x) / TO_REALS(columns);
    p.y = (TO_REALS(first) + in_y * TO_REALS(columns)) / R(samples);
    return p;
}

// Pixels of a work-item; lane k is of pixel k mod PIXELS.
#ifndef PIXELS_X
#define PIXELS_X 1
#define PIXELS_Y 1
#endif
#define PIXELS (PIXELS_X * PIXELS_Y)
#define PER_PIXEL (RAYS / PIXELS)

// Whether one packet has all samples of its pixels.
#ifndef ONE_PACKET
#define ONE_PACKET 0
#endif

// The pixel and the sample of each lane: samples first, first + 1, ... of each pixel, from the pixel (x, y) on. The pixels'
// first samples come first, then the second ones.
typedef struct {
    uints x, y, sample;
} sites;

sites make_sites(uint x, uint y, uint first) {
    sites at;
#if RAYS == 1
    at.x = x;
    at.y = y;
    at.sample = first;
#else
    const uints place = JOIN(vload, LANES)(0, lane_numbers);
    at.x = x + place % PIXELS % PIXELS_X;
    at.y = y + place % PIXELS / PIXELS_X;
    at.sample = first + place / PIXELS;
#endif
    return at;
}

// The directions of the eye rays (16.5, 16.6).
vectors eye_directions(global const view *camera, sites at, uint4 frame) {
    const uint samples = (ONE_PACKET & (RAYS == 1)) ? 1 : frame.z;
    const places p = place_samples(at.x, at.y, min(at.sample, samples - 1), samples, camera->limits.y);
    const reals across = TO_REALS(at.x) * R(2) - R(frame.x) + 2 * p.x;
    const reals down = R(frame.y) - TO_REALS(at.y) * R(2) - 2 * p.y;
    const vectors d = along(splat_xyz(camera->forward), splat_xyz(camera->right), across);
    return normalise(along(d, splat_xyz(camera->up), down));
}

#if HAS_TREE
void aim_beam_axis(beam *b, int axis, real eye, real forward, real right, real up, real across, real down) {
    const real centre = forward + right * across + up * down;
    const real rounding = R(32) * UNIT * (fabs(forward) + fabs(right * across) + fabs(up * down));
    const real reach = fabs(right) * R(PIXELS_X) + fabs(up) * R(PIXELS_Y) + rounding;
    const real least = centre - reach, greatest = centre + reach, some = R(0x1p40) * LEAST_DIRECTION;
    b->backwards[axis] = greatest < R(0);
    b->both_ways[axis] = least < some && greatest > -some;
    b->near_origin[axis] = b->far_origin[axis] = eye;
    b->least_inverse[axis] = R(1) / greatest;
    b->greatest_inverse[axis] = R(1) / least;
}

// All eye rays of the pixels from (x, y) on, with directions that do not have length 1.
beam beam_of_pixels(global const view *camera, uint4 frame, uint x, uint y) {
    const real across = R(2) * R(x) + R(PIXELS_X) - R(frame.x), down = R(frame.y) - R(2) * R(y) - R(PIXELS_Y);
    beam b;
    aim_beam_axis(&b, 0, camera->eye.x, camera->forward.x, camera->right.x, camera->up.x, across, down);
    aim_beam_axis(&b, 1, camera->eye.y, camera->forward.y, camera->right.y, camera->up.y, across, down);
    aim_beam_axis(&b, 2, camera->eye.z, camera->forward.z, camera->right.z, camera->up.z, across, down);
    b.least = R(0);
    return b;
}
#endif

// Whether the tree is all that the eye could see, and no eye ray of the pixels from (x, y) on meets any of its root's boxes.
bool sees_nothing(const scene *s, global const view *camera, uint4 frame, uint x, uint y) {
#if HAS_TREE
    if (s->count.w > 0 || s->count.z == 0)
        return s->count.w == 0;
    const beam b = beam_of_pixels(camera, frame, x, y);
    uint met = 0; // empty places are boxes at infinity
    for (uint k = 0; k < WIDTH; k += CHUNK)
        met |= meet_boxes(&b, load_rows(s->nodes, k), load_rows(s->nodes + 3 * WIDTH, k), FARTHEST);
    return met == 0;
#else
    return false;
#endif
}
