// lanes.cl - the lane types: `reals` holds one number for each of LANES rays (or primitives), `ints` an index or a mask.
//
// A mask is true where it is not 0; `&`, `|`, `^`, `!` and `m ? a : b` mean the same for one lane (0 and 1) and for many
// (0 and -1), so one source serves every width. Lanes never change a number's bits: each lane does the same operations.
#pragma OPENCL FP_CONTRACT OFF

#ifndef LANES
#define LANES 1
#endif

// Rays held by the lanes: as many as there are lanes (the samples of a pixel, one primitive at a time against all), or 1: every
// lane holds the same ray, which meets as many boxes or primitives at a time as there are lanes.
#ifndef RAYS
#define RAYS LANES
#endif

// Where each ray is alone, the lights of its hit lie side by side, and so do its feelers to them: a fan, which travels as a
// packet.
#ifndef FANS
#define FANS (RAYS == 1 && LANES > 1 && HAS_LIGHTS && !HAS_FILTERED_SHADOWS)
#endif

#ifndef INLINE // empty where a checker does not know what inlining leaves
#define INLINE __attribute__((always_inline))
#endif
#define NOINLINE __attribute__((noinline))

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)

#ifdef DOUBLE
typedef long integer;
#define MANTISSA 52
#define EXPONENT_BIAS 1023
#define UNIT R(1.1102230246251565e-16) // u = 2^-53, half an ulp of 1
#define FARTHEST R(1.7976931348623157e308)
#else
typedef int integer;
#define MANTISSA 23
#define EXPONENT_BIAS 127
#define UNIT R(5.9604644775390625e-8) // u = 2^-24
#define FARTHEST R(3.40282347e38f)
#endif

#define R(x) ((real)(x))

#if LANES == 1
typedef real reals;
typedef integer ints;
#define TRUE 1
#ifdef DOUBLE
#define AS_REALS as_double
#define AS_INTS as_long
#define TO_REALS convert_double
#define TO_INTS convert_long
#else
#define AS_REALS as_float
#define AS_INTS as_int
#define TO_REALS convert_float
#define TO_INTS convert_int
#endif
#else
#define TRUE (-1)
#ifdef DOUBLE
typedef JOIN(double, LANES) reals;
typedef JOIN(long, LANES) ints;
#define AS_REALS JOIN(as_double, LANES)
#define AS_INTS JOIN(as_long, LANES)
#define TO_REALS JOIN(convert_double, LANES)
#define TO_INTS JOIN(convert_long, LANES)
#else
typedef JOIN(float, LANES) reals;
typedef JOIN(int, LANES) ints;
#define AS_REALS JOIN(as_float, LANES)
#define AS_INTS JOIN(as_int, LANES)
#define TO_REALS JOIN(convert_float, LANES)
#define TO_INTS JOIN(convert_int, LANES)
#endif
#endif

// One lane of a vector, to read or to set.
#define REAL_LANE(v, lane) (((private real *)&(v))[lane])
#define INT_LANE(v, lane) (((private integer *)&(v))[lane])

// Bit k is set where the mask's lane k is true. One instruction where the compiler has it.
uint lane_bits(ints m) {
#if LANES == 16 && !defined(DOUBLE) && defined(__AVX512DQ__)
    return (ushort)__builtin_ia32_cvtd2mask512(m);
#elif LANES == 8 && !defined(DOUBLE) && defined(__AVX__)
    return (uchar)__builtin_ia32_movmskps256(as_float8(m));
#else
    uint bits = 0;
    for (int lane = 0; lane < LANES; lane++)
        bits |= (INT_LANE(m, lane) != 0 ? 1u : 0u) << lane;
    return bits;
#endif
}

// The lanes' own numbers and bits.
constant uint lane_numbers[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
constant integer lane_bit[16] = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768};

// The mask whose lane k is true where bit k is set.
ints mask_of_bits(uint bits) {
#if LANES == 1
    return bits & 1;
#else
    return ((ints)((integer)bits) & JOIN(vload, LANES)(0, lane_bit)) != (ints)(0);
#endif
}

// The place of the lowest bit that is set.
uint lowest_bit(uint bits) {
    return 31 - clz(bits & -bits);
}

bool any_lane(ints m) {
    return lane_bits(m) != 0;
}

// The same where all lanes of one ray are alike.
bool any_ray(ints m) {
#if RAYS == 1
    return INT_LANE(m, 0) != 0;
#else
    return any_lane(m);
#endif
}

// The least, the greatest and the sum of the lanes, from those that are half of all apart on.
#if LANES == 1
#define FOLD(a, f) (a)
#else
#if LANES >= 16
#define FOLD16(a, f) f((a).lo, (a).hi)
#else
#define FOLD16(a, f) (a)
#endif
#if LANES >= 8
#define FOLD8(a, f) f((a).lo, (a).hi)
#else
#define FOLD8(a, f) (a)
#endif
#if LANES >= 4
#define FOLD4(a, f) f((a).lo, (a).hi)
#else
#define FOLD4(a, f) (a)
#endif
#define FOLD(a, f) fold_##f(a)
#define plus(a, b) ((a) + (b))
#define count(a, b) ((a) + (b))
#define DEFINE_FOLD(one, many, f)                                                                                      \
    one fold_##f(many a) {                                                                                             \
        const __typeof__(FOLD16(a, f)) b = FOLD16(a, f);                                                               \
        const __typeof__(FOLD8(b, f)) c = FOLD8(b, f);                                                                 \
        const __typeof__(FOLD4(c, f)) d = FOLD4(c, f);                                                                 \
        return f(d.lo, d.hi);                                                                                          \
    }
DEFINE_FOLD(real, reals, min)
DEFINE_FOLD(real, reals, max)
DEFINE_FOLD(real, reals, plus)
DEFINE_FOLD(integer, ints, count)
#endif

real least_lane(reals a) {
    return FOLD(a, min);
}

real greatest_lane(reals a) {
    return FOLD(a, max);
}

reals splat(real x) {
    return (reals)(x);
}

ints whole(integer i) {
    return (ints)(i);
}

ints mask(bool b) {
    return (ints)(b ? TRUE : 0);
}

// A count for each lane, one more where the mask is true.
ints count_where(ints count, ints m) {
    return count + (m & 1);
}

// Vectors in space, and colours (x red, y green, z blue).
typedef struct {
    reals x, y, z;
} vectors;

typedef struct {
    vectors xyz;
    reals w;
} quads;

vectors make_vectors(reals x, reals y, reals z) {
    vectors v = {x, y, z};
    return v;
}

vectors splat_xyz(real4 v) {
    return make_vectors(splat(v.x), splat(v.y), splat(v.z));
}

// Lane k's, in every lane.
vectors lane_of(vectors v, uint k) {
    return make_vectors(splat(REAL_LANE(v.x, k)), splat(REAL_LANE(v.y, k)), splat(REAL_LANE(v.z, k)));
}

quads splat_quads(real4 v) {
    quads q = {splat_xyz(v), splat(v.w)};
    return q;
}

vectors add(vectors a, vectors b) {
    return make_vectors(a.x + b.x, a.y + b.y, a.z + b.z);
}

vectors sub(vectors a, vectors b) {
    return make_vectors(a.x - b.x, a.y - b.y, a.z - b.z);
}

vectors mul(vectors a, vectors b) {
    return make_vectors(a.x * b.x, a.y * b.y, a.z * b.z);
}

vectors scale(vectors a, reals s) {
    return make_vectors(a.x * s, a.y * s, a.z * s);
}

vectors negate(vectors a) {
    return make_vectors(-a.x, -a.y, -a.z);
}

vectors absolute(vectors a) {
    return make_vectors(fabs(a.x), fabs(a.y), fabs(a.z));
}

// a + b s
vectors along(vectors a, vectors b, reals s) {
    return make_vectors(fma(b.x, s, a.x), fma(b.y, s, a.y), fma(b.z, s, a.z));
}

reals dot3(vectors a, vectors b) {
    return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z));
}

// A linear map by its rows.
typedef struct {
    vectors x, y, z;
} rows;

vectors apply(rows m, vectors v) {
    return make_vectors(dot3(m.x, v), dot3(m.y, v), dot3(m.z, v));
}

vectors apply_transposed(rows m, vectors v) {
    return along(along(scale(m.x, v.x), m.y, v.y), m.z, v.z);
}

reals largest(vectors a) {
    return max(max(a.x, a.y), a.z);
}

vectors least_xyz(vectors a, vectors b) {
    return make_vectors(min(a.x, b.x), min(a.y, b.y), min(a.z, b.z));
}

vectors greatest_xyz(vectors a, vectors b) {
    return make_vectors(max(a.x, b.x), max(a.y, b.y), max(a.z, b.z));
}

vectors choose(ints m, vectors a, vectors b) {
    return make_vectors(m ? a.x : b.x, m ? a.y : b.y, m ? a.z : b.z);
}

// a where m, else 0.
vectors where(ints m, vectors a) {
    return choose(m, a, make_vectors(splat(0), splat(0), splat(0)));
}

vectors normalise(vectors a) {
    return scale(a, splat(1) / sqrt(dot3(a, a)));
}

// The same, or `other` where a has no length.
vectors normalise_or(vectors a, vectors other) {
    const reals squared = dot3(a, a);
    const ints usable = squared > splat(0);
    return choose(usable, scale(a, splat(1) / sqrt(usable ? squared : splat(1))), other);
}

// The real4 at index, and every `stride` reals from `first` on, for each ray.
quads gather(global const real *first, ints index, int stride) {
    quads q;
#if RAYS == 1
    const real4 v = *(global const real4 *)(first + (size_t)INT_LANE(index, 0) * stride);
    q.xyz = splat_xyz(v);
    q.w = splat(v.w);
#else
    if (!any_lane(index != whole(INT_LANE(index, 0)))) { // most often all rays are at the same thing
        const real4 v = *(global const real4 *)(first + (size_t)INT_LANE(index, 0) * stride);
        q.xyz = splat_xyz(v);
        q.w = splat(v.w);
        return q;
    }
    for (int lane = 0; lane < LANES; lane++) {
        const real4 v = *(global const real4 *)(first + (size_t)INT_LANE(index, lane) * stride);
        REAL_LANE(q.xyz.x, lane) = v.x;
        REAL_LANE(q.xyz.y, lane) = v.y;
        REAL_LANE(q.xyz.z, lane) = v.z;
        REAL_LANE(q.w, lane) = v.w;
    }
#endif
    return q;
}

// array[index].member for each lane, member being a real4.
#define GATHER(array, index, member)                                                                                   \
    gather((global const real *)&(array)->member, index, (int)(sizeof(*(array)) / sizeof(real)))

// Entries of a row of WIDTH numbers that the lanes hold at a time; lanes beyond hold some of them again.
#define CHUNK (LANES < WIDTH ? LANES : WIDTH)

// The entries k, k + 1, ... of a row side by side.
reals load_row(global const real *row, uint k) {
#if LANES > WIDTH
    return (reals)(JOIN(vload, WIDTH)(0, row), JOIN(vload, WIDTH)(0, row));
#elif LANES == 1
    return row[k];
#else
    return JOIN(vload, LANES)(0, row + k);
#endif
}
