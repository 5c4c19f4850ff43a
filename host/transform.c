/* transform.c - affine maps: made, multiplied, judged. */
#include "transform.h"
#include "vec.h"

matrix matrix_identity(void) {
    return (matrix){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

matrix matrix_multiply(const matrix *a, const matrix *b) {
    matrix product;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            product.m[i][j] =
                a->m[i][0] * b->m[0][j] + a->m[i][1] * b->m[1][j] + a->m[i][2] * b->m[2][j] + (j == 3 ? a->m[i][3] : 0);
    return product;
}

matrix matrix_translation(vec3 by) {
    return (matrix){{{1, 0, 0, by.x}, {0, 1, 0, by.y}, {0, 0, 1, by.z}}};
}

matrix matrix_scaling(vec3 by) {
    return (matrix){{{by.x, 0, 0, 0}, {0, by.y, 0, 0}, {0, 0, by.z, 0}}};
}

/* Reduced to an eighth of a turn first, so that 90 degrees has the cosine 0 and not 6e-17. */
static void sine_cosine(double degrees, double *sine, double *cosine) {
    const double radians_per_degree = 0.017453292519943295;
    double rest = fmod(degrees, 360);
    int quarter = (int)lround(rest / 90);
    rest = (rest - 90.0 * quarter) * radians_per_degree;
    double s = sin(rest), c = cos(rest);
    switch (quarter & 3) {
    case 0:
        *sine = s;
        *cosine = c;
        break;
    case 1:
        *sine = c;
        *cosine = -s;
        break;
    case 2:
        *sine = -s;
        *cosine = -c;
        break;
    default:
        *sine = -c;
        *cosine = s;
        break;
    }
}

/* Rodrigues' formula. */
matrix matrix_rotation(vec3 axis, double degrees) {
    double s, c;
    sine_cosine(degrees, &s, &c);
    vec3 u = axis;
    vec_normalize(&u);
    double k = 1 - c;
    return (matrix){{{c + u.x * u.x * k, u.x * u.y * k - u.z * s, u.x * u.z * k + u.y * s, 0},
                     {u.y * u.x * k + u.z * s, c + u.y * u.y * k, u.y * u.z * k - u.x * s, 0},
                     {u.z * u.x * k - u.y * s, u.z * u.y * k + u.x * s, c + u.z * u.z * k, 0}}};
}

bool matrix_finite(const matrix *matrix) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            if (!isfinite(matrix->m[i][j]))
                return false;
    return true;
}

/* Hadamard: |det| is at most the product of the rows' lengths; a share below 1e-12 has no sound inverse in double. */
bool matrix_singular(const matrix *matrix) {
    vec3 rows[3];
    for (int i = 0; i < 3; i++) {
        rows[i] = (vec3){matrix->m[i][0], matrix->m[i][1], matrix->m[i][2]};
        if (!vec_normalize(&rows[i]))
            return true;
    }
    return fabs(vec_dot(rows[0], vec_cross(rows[1], rows[2]))) < 1e-12;
}

bool matrix_translates(const matrix *matrix) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (matrix->m[i][j] != (i == j))
                return false;
    return true;
}

/* By cofactors, of the matrix divided by the power of two that brings it near 1. */
matrix matrix_inverse_linear(const matrix *matrix) {
    double extent = 0;
    vec3 rows[3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            extent = fmax(extent, fabs(matrix->m[i][j]));
    int exponent;
    frexp(extent, &exponent);
    for (int i = 0; i < 3; i++)
        rows[i] = (vec3){ldexp(matrix->m[i][0], -exponent), ldexp(matrix->m[i][1], -exponent),
                         ldexp(matrix->m[i][2], -exponent)};
    vec3 columns[3] = {vec_cross(rows[1], rows[2]), vec_cross(rows[2], rows[0]), vec_cross(rows[0], rows[1])};
    double determinant = vec_dot(rows[0], columns[0]);
    struct matrix inverse = {{{0}}};
    for (int j = 0; j < 3; j++) {
        inverse.m[0][j] = ldexp(columns[j].x / determinant, -exponent);
        inverse.m[1][j] = ldexp(columns[j].y / determinant, -exponent);
        inverse.m[2][j] = ldexp(columns[j].z / determinant, -exponent);
    }
    return inverse;
}

vec3 matrix_apply(const matrix *matrix, vec3 p) {
    const double(*m)[4] = matrix->m;
    return (vec3){m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z + m[0][3],
                  m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z + m[1][3],
                  m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z + m[2][3]};
}

void matrix_apply_to_box(const matrix *matrix, vec3 *low, vec3 *high) {
    vec3 middle = matrix_apply(matrix, vec_add(vec_scale(*low, 0.5), vec_scale(*high, 0.5)));
    vec3 half = vec_subtract(vec_scale(*high, 0.5), vec_scale(*low, 0.5));
    struct matrix sizes = {{{0}}};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            sizes.m[i][j] = fabs(matrix->m[i][j]);
    half = matrix_apply(&sizes, half);
    *low = vec_subtract(middle, half);
    *high = vec_add(middle, half);
}
