// numerics.cl - rounding errors and how to keep them small; pow.

// Bound of the relative error of n roundings: n u / (1 - n u) (Higham, Accuracy and Stability of Numerical Algorithms, 3.1).
#define GAMMA(n) (R(n) * UNIT / (R(1) - R(n) * UNIT))

// Directions shorter than this count as parallel to a face; squares of it are still normal numbers.
#ifdef DOUBLE
#define LEAST_DIRECTION R(0x1p-400)
#define SMALLEST_NORMAL R(0x1p-1022)
#define LEAST_EXPONENT R(-1022)
#else
#define LEAST_DIRECTION R(0x1p-60)
#define SMALLEST_NORMAL R(0x1p-126)
#define LEAST_EXPONENT R(-126)
#endif

// a b - c d with an error of at most 1.5 ulp, so that its sign is right (Kahan; Jeannerod, Louvet, Muller 2013).
reals difference_of_products(reals a, reals b, reals c, reals d) {
    const reals cd = c * d;
    const reals difference = fma(a, b, -cd);
    const reals error = fma(-c, d, cd);
    return difference + error;
}

// The power of two that brings x >= 0 to [1, 2): with it, the errors of products do not vanish among the denormal numbers,
// and a scene that is scaled by a power of two keeps its bits.
reals power_over(reals x) {
    const ints exponent = AS_INTS(x) & ~((((integer)1) << MANTISSA) - 1);
    return AS_REALS((((integer)(2 * EXPONENT_BIAS)) << MANTISSA) - exponent);
}

vectors cross3(vectors a, vectors b) {
    return make_vectors(difference_of_products(a.y, b.z, a.z, b.y), difference_of_products(a.z, b.x, a.x, b.z),
                        difference_of_products(a.x, b.y, a.y, b.x));
}

// x moved away from itself in the direction of `towards` by at least one ulp; a zero stays: an ulp of nothing is nothing.
reals next_away(reals x, reals towards) {
    return towards == splat(0) ? x : x + copysign(fabs(x) * (R(2) * UNIT), towards);
}

// Where a ray starts that leaves the point p, known to within `error` in each coordinate, on the side of the normal n
// (pbrt 4th ed., 6.8.6): outside the error's box, then past the sum's own rounding.
vectors spawn(vectors p, vectors error, vectors n) {
    const vectors offset = scale(n, dot3(absolute(n), error));
    const vectors moved = add(p, offset);
    return make_vectors(next_away(moved.x, offset.x), next_away(moved.y, offset.y), next_away(moved.z, offset.z));
}

#ifdef DOUBLE
#define LOG_TERMS 12
#define EXP_TERMS 14
#define LOG_LOW R(4.0710547481862064099e-17)
#define THIRD_LOW R(5.0577616648125906047e-17)
#elif defined(DRAFT)
#define LOG_TERMS 3
#define EXP_TERMS 5
#define LOG_LOW R(0)
#define THIRD_LOW R(0)
#else
#define LOG_TERMS 6
#define EXP_TERMS 8
#define LOG_LOW R(3.8519259822532349362e-8)
#define THIRD_LOW R(-7.028461650952758546e-9)
#endif
#define LOG_HIGH R(2.8853900817779268147198493620038)     // 2 / ln 2, its nearest real; LOG_LOW is the rest
#define THIRD_HIGH R(0.961796693925975604906616454001261) // a third of it

// base^exponent for 0 <= base and 0 < exponent: the one pow of every kernel. Powers under the least normal number are 0.
//
// log2 base is found as a sum of two reals (so that a large exponent does not magnify its error): base = 2^e m with
// m in [sqrt 1/2, sqrt 2), s = (m - 1) / (m + 1), log2 m = 2/ln2 (s + s^3/3 + s^5/5 + ...). Then 2^y by its Taylor series.
reals power(reals base, reals exponent) {
    const ints offset = (ints)(AS_INTS(splat(R(0.70710678118654752440))));
    const ints bits = AS_INTS(base) - offset;
    const reals e = TO_REALS(bits >> MANTISSA);
    const reals m = AS_REALS((bits & ((((integer)1) << MANTISSA) - 1)) + offset);

    const reals f = m - R(1), g = m + R(1);
    const reals s = f / g;
    const reals rest = (fma(-s, g, f) - s * (m - (g - R(1)))) / g; // what s lacks, g's rounding included
    // 2/ln2 (s + s^3/3), each product with what its rounding lost: errors here are magnified by the exponent.
    const reals q = s * s, cube = q * s;
    const reals first = LOG_HIGH * s, second = THIRD_HIGH * cube;
    const reals q_rest = fma(s, s, -q) + R(2) * s * rest, cube_rest = fma(q, s, -cube) + (q_rest * s + q * rest);
    const reals second_rest = fma(splat(THIRD_HIGH), cube, -second) + (THIRD_LOW * cube + THIRD_HIGH * cube_rest);
    const reals both = first + second;
    reals series = splat(0);
    for (int k = LOG_TERMS; k > 1; k--)
        series = fma(series, q, splat(LOG_HIGH / R(2 * k + 1)));
    const reals first_rest = fma(splat(LOG_HIGH), s, -first) + (LOG_LOW * s + LOG_HIGH * rest);
    const reals both_rest = (second - (both - first)) + (first_rest + second_rest);
    const reals low = fma(series, q * cube, both_rest);
    const reals sum_high = e + both;
    const reals sum_low = (both - (sum_high - e)) + low;
    const reals log_high = sum_high + sum_low;
    const reals log_low = sum_low - (log_high - sum_high);

    const reals y = exponent * log_high;
    const reals y_low = fma(exponent, log_high, -y) + exponent * log_low;
    const reals n = rint(max(y, splat(LEAST_EXPONENT - R(2))));
    const reals z = ((y - n) + y_low) * R(0.69314718055994530942);
    reals sum = splat(1);
    for (int k = EXP_TERMS; k > 0; k--)
        sum = fma(sum, z * (R(1) / R(k)), splat(1));
    const reals result = sum * AS_REALS((TO_INTS(n) + EXPONENT_BIAS) << MANTISSA);
    return ((base >= SMALLEST_NORMAL) & (y >= LEAST_EXPONENT)) ? result : splat(0);
}
