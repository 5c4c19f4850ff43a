/* flip.c - LDR-FLIP (Andersson et al. 2020, FLIP: A Difference Evaluator for Alternating Images). Section numbers are the
 * paper's. */
#include "flip.h"

#include "scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_RADIUS = 10 };

static const double pi = 3.14159265358979323846;
/* A screen 0.7 m wide of 3840 pixels, seen from 0.7 m. */
static const double pixels_per_degree = 3840 * 3.14159265358979323846 / 180;

/* ---- filters ---- */

/* One dimension of a filter that is a product of two. */
typedef struct taps {
    double at[2 * MOST_RADIUS + 1];
} taps;

typedef struct size {
    int width, height;
} size;

static size_t area(size s) {
    return (size_t)s.width * (size_t)s.height;
}

static int clamp_index(int i, int length) {
    return i < 0 ? 0 : i < length ? i : length - 1;
}

static int least(int a, int b) {
    return a < b ? a : b;
}

/* Adds a row's pixels, moved by k, to `sum`; what is outside is as the nearest pixel. */
static void add_row(const double *row, int width, int k, double weight, double *sum) {
    int x = 0;
    for (; x < least(-k, width); x++)
        sum[x] += weight * row[0];
    for (; x < least(width - k, width); x++)
        sum[x] += weight * row[x + k];
    for (; x < width; x++)
        sum[x] += weight * row[width - 1];
}

/* Across by one filter, down by another. */
static void filter(const double *in, size s, int radius, const taps *across, const taps *down, double *work,
                   double *out) {
    const size_t width = (size_t)s.width;
    memset(work, 0, area(s) * sizeof *work);
    memset(out, 0, area(s) * sizeof *out);
    for (size_t y = 0; y < (size_t)s.height; y++)
        for (int k = -radius; k <= radius; k++)
            add_row(in + y * width, s.width, k, across->at[k + radius], work + y * width);
    for (int y = 0; y < s.height; y++)
        for (int k = -radius; k <= radius; k++)
            add_row(work + (size_t)clamp_index(y + k, s.height) * width, s.width, 0, down->at[k + radius],
                    out + (size_t)y * width);
}

/* exp(-x² / 2σ²) with the sum 1; returns the sum that it would have had. */
static double make_gaussian(taps *t, int radius, double sigma) {
    double sum = 0;
    for (int k = -radius; k <= radius; k++)
        sum += t->at[k + radius] = exp(-k * k / (2 * sigma * sigma));
    for (int k = 0; k <= 2 * radius; k++)
        t->at[k] /= sum;
    return sum;
}

/* Weights above 0 then add up to 1, those below to -1. */
static void balance(taps *t, int radius) {
    double above = 0, below = 0;
    for (int k = 0; k <= 2 * radius; k++)
        *(t->at[k] > 0 ? &above : &below) += t->at[k];
    for (int k = 0; k <= 2 * radius; k++)
        t->at[k] /= t->at[k] > 0 ? above : -below;
}

/* ---- colours ---- */

typedef struct square {
    double m[3][3];
} square;

/* Linear sRGB to XYZ, by the primaries and the white of IEC 61966-2-1. */
static const square to_xyz = {{{10135552. / 24577794, 8788810. / 24577794, 4435075. / 24577794},
                               {2613072. / 12288897, 8788810. / 12288897, 887015. / 12288897},
                               {1425312. / 73733382, 8788810. / 73733382, 70074185. / 73733382}}};

static void multiply(const square *s, const double v[3], double out[3]) {
    for (int i = 0; i < 3; i++)
        out[i] = s->m[i][0] * v[0] + s->m[i][1] * v[1] + s->m[i][2] * v[2];
}

static square invert(const square *s) {
    square out;
    double determinant = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            out.m[i][j] = s->m[a][c] * s->m[b][d] - s->m[a][d] * s->m[b][c];
        }
    for (int i = 0; i < 3; i++)
        determinant += s->m[0][i] * out.m[i][0];
    for (int i = 0; i < 9; i++)
        out.m[i / 3][i % 3] /= determinant;
    return out;
}

static void white_xyz(double white[3]) {
    static const double white_rgb[3] = {1, 1, 1};
    multiply(&to_xyz, white_rgb, white);
}

/* X, Y, Z as shares of white's. */
static void relative_xyz(const double rgb[3], double xyz[3]) {
    double white[3];
    white_xyz(white);
    multiply(&to_xyz, rgb, xyz);
    for (int i = 0; i < 3; i++)
        xyz[i] /= white[i];
}

/* L*a*b* without its cube roots: in YyCxCz a filter acts on light. */
static void to_ycxcz(const double rgb[3], double out[3]) {
    double t[3];
    relative_xyz(rgb, t);
    out[0] = 116 * t[1] - 16;
    out[1] = 500 * (t[0] - t[1]);
    out[2] = 200 * (t[1] - t[2]);
}

static void from_ycxcz(const double colour[3], const square *from_xyz, double rgb[3]) {
    double xyz[3], y = (colour[0] + 16) / 116;
    white_xyz(xyz);
    xyz[0] *= y + colour[1] / 500;
    xyz[1] *= y;
    xyz[2] *= y - colour[2] / 200;
    multiply(from_xyz, xyz, rgb);
}

static double lab_curve(double t) {
    const double knee = 6. / 29;
    return t > knee * knee * knee ? cbrt(t) : t / (3 * knee * knee) + 4. / 29;
}

/* L*a*b*, its chroma less where it is dark (Hunt). */
static void to_hunt_lab(const double rgb[3], double out[3]) {
    double f[3];
    relative_xyz(rgb, f);
    for (int i = 0; i < 3; i++)
        f[i] = lab_curve(f[i]);
    out[0] = 116 * f[1] - 16;
    out[1] = 0.01 * out[0] * 500 * (f[0] - f[1]);
    out[2] = 0.01 * out[0] * 200 * (f[1] - f[2]);
}

/* The distance of large colour differences (Abasi et al. 2020), as strong as the paper makes it (4.1.3). */
static double colour_distance(const double a[3], const double b[3]) {
    return pow(fabs(a[0] - b[0]) + hypot(a[1] - b[1], a[2] - b[2]), 0.7);
}

/* ---- what is seen of one picture ---- */

enum { LIGHTNESS, RED_GREEN, BLUE_YELLOW, EDGES, POINTS, WORK, MORE_WORK, PLANES };

typedef struct sight {
    size size;
    double *planes[PLANES]; /* the first is owned and holds the others */
} sight;

static int open_sight(sight *v, size s, feeler_error *error) {
    *v = (sight){.size = s};
    double *memory = malloc(area(s) * PLANES * sizeof *memory);
    if (!memory)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory for FLIP of %d x %d pixels", s.width, s.height);
    for (size_t i = 0; i < PLANES; i++)
        v->planes[i] = memory + i * area(s);
    return 0;
}

/* The eye's sensitivity to contrast, from cycles to degrees (4.1.1): Gaussians a sqrt(π/b) exp(-π²x²/b), of which blue and
 * yellow need two. */
static void blur(sight *v) {
    static const struct {
        double a, b;
    } terms[3][2] = {{{1, 0.0047}, {0, 1e-5}}, {{1, 0.0053}, {0, 1e-5}}, {{34.1, 0.04}, {13.5, 0.025}}};
    const int radius = (int)ceil(3 * sqrt(0.04 / (2 * pi * pi)) * pixels_per_degree); /* of the widest */
    double *work = v->planes[WORK], *part = v->planes[MORE_WORK];
    for (int c = 0; c < 3; c++) {
        double *sum = v->planes[EDGES], all = 0; /* edges come later */
        memset(sum, 0, area(v->size) * sizeof *sum);
        for (int i = 0; i < 2 && terms[c][i].a > 0; i++) {
            taps t;
            double length = make_gaussian(&t, radius, sqrt(terms[c][i].b / (2 * pi * pi)) * pixels_per_degree);
            double weight = terms[c][i].a * sqrt(pi / terms[c][i].b) * length * length;
            filter(v->planes[c], v->size, radius, &t, &t, work, part);
            for (size_t k = 0; k < area(v->size); k++)
                sum[k] += weight * part[k];
            all += weight;
        }
        for (size_t k = 0; k < area(v->size); k++)
            v->planes[c][k] = sum[k] / all;
    }
}

/* How strong a filter and its likeness across are at each pixel. `grey` is left alone, the work planes are not. */
static void measure_feature(sight *v, const double *grey, int radius, const taps *along, const taps *beside,
                            double *out) {
    double *work = v->planes[WORK], *down = v->planes[MORE_WORK];
    filter(grey, v->size, radius, along, beside, work, out);
    filter(grey, v->size, radius, beside, along, work, down);
    for (size_t i = 0; i < area(v->size); i++)
        out[i] = hypot(out[i], down[i]);
}

/* Edges by a Gaussian's first derivative, points by its second (4.2); 0.082 degrees are as wide as is seen. `grey` is a plane
 * that is not needed any more. */
static void find_features(sight *v, const double *grey) {
    const double sigma = 0.5 * 0.082 * pixels_per_degree;
    const int radius = (int)ceil(3 * sigma);
    taps gaussian, first, second;
    make_gaussian(&gaussian, radius, sigma);
    for (int k = -radius; k <= radius; k++) {
        first.at[k + radius] = -k * gaussian.at[k + radius];
        second.at[k + radius] = (k * k / (sigma * sigma) - 1) * gaussian.at[k + radius];
    }
    balance(&first, radius);
    balance(&second, radius);
    measure_feature(v, grey, radius, &first, &gaussian, v->planes[EDGES]);
    measure_feature(v, grey, radius, &second, &gaussian, v->planes[POINTS]);
}

static double clamp_unit(double x) {
    return x > 0 ? (x < 1 ? x : 1) : 0;
}

/* Fills the sight from a picture: first in YyCxCz, blurred, then in L*a*b*. `grey` is room for a plane. */
static void see(sight *v, const double *colours, double *grey) {
    const square from_xyz = invert(&to_xyz);
    for (size_t i = 0; i < area(v->size); i++) {
        double rgb[3], seen[3];
        for (int c = 0; c < 3; c++)
            rgb[c] = clamp_unit(colours[3 * i + (size_t)c]);
        to_ycxcz(rgb, seen);
        for (int c = 0; c < 3; c++)
            v->planes[c][i] = seen[c];
        grey[i] = (seen[0] + 16) / 116;
    }
    blur(v);
    find_features(v, grey);
    for (size_t i = 0; i < area(v->size); i++) {
        double seen[3] = {v->planes[0][i], v->planes[1][i], v->planes[2][i]}, rgb[3];
        from_ycxcz(seen, &from_xyz, rgb);
        for (int c = 0; c < 3; c++)
            rgb[c] = clamp_unit(rgb[c]);
        to_hunt_lab(rgb, seen);
        for (int c = 0; c < 3; c++)
            v->planes[c][i] = seen[c];
    }
}

/* ---- the error ---- */

/* Most of the range is for what most differences are (4.1.3): 0.95 for the lower 0.4. */
static double colour_error(const double a[3], const double b[3], double greatest) {
    const double knee = 0.4 * greatest, distance = colour_distance(a, b);
    return distance < knee ? 0.95 / knee * distance : 0.95 + (distance - knee) / (greatest - knee) * 0.05;
}

int flip_errors(const double *reference, const double *test, int width, int height, double *errors,
                feeler_error *error) {
    static const double green[3] = {0, 1, 0}, blue[3] = {0, 0, 1};
    const size s = {width, height};
    double ends[2][3];
    sight a, b;
    to_hunt_lab(green, ends[0]);
    to_hunt_lab(blue, ends[1]);
    const double greatest = colour_distance(ends[0], ends[1]); /* of all colours that a screen shows */
    if (open_sight(&a, s, error))
        return -1;
    if (open_sight(&b, s, error)) {
        free(a.planes[0]);
        return -1;
    }
    see(&a, reference, errors);
    see(&b, test, errors);
    for (size_t i = 0; i < area(s); i++) {
        const double seen_a[3] = {a.planes[0][i], a.planes[1][i], a.planes[2][i]};
        const double seen_b[3] = {b.planes[0][i], b.planes[1][i], b.planes[2][i]};
        const double feature =
            fmax(fabs(a.planes[EDGES][i] - b.planes[EDGES][i]), fabs(a.planes[POINTS][i] - b.planes[POINTS][i]));
        const double sum = reference[3 * i] + test[3 * i]; /* not a number in all channels or in none */
        errors[i] = isnan(sum) ? 1 : pow(colour_error(seen_a, seen_b, greatest), 1 - sqrt(feature / sqrt(2)));
    }
    free(a.planes[0]);
    free(b.planes[0]);
    return 0;
}
