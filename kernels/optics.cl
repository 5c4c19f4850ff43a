// optics.cl - where reflected and transmitted rays go, and how much goes there. v points to where the ray came from, n is
// on v's side.

// A direction turned, if need be, to leave a surface on the side of the geometric normal n: interpolated normals may send
// it below, and so may rounding at a grazing angle.
vectors keep_above(vectors direction, vectors n) {
    const reals height = dot3(direction, n);
    const vectors lifted = normalise(along(direction, n, R(0x1p-10) - height));
    return choose(height > splat(0), direction, lifted);
}

// r_v = 2 (v.n) n - v (16.9)
vectors reflect(vectors v, vectors n) {
    return normalise(along(negate(v), n, R(2) * dot3(v, n)));
}

typedef struct {
    ints found;
    vectors direction;
} refraction;

// t = t_par + t_perp (16.15 - 16.18); none on total internal reflection. eta = eta_v / eta_t.
refraction refract(vectors v, vectors n, reals eta) {
    const vectors parallel = scale(along(negate(v), n, dot3(v, n)), eta); // (16.17)
    const reals squared = dot3(parallel, parallel);
    refraction t;
    t.found = squared < splat(1);
    const reals perpendicular = sqrt(max(splat(1) - squared, splat(0)));
    t.direction = normalise(along(parallel, n, -perpendicular)); // (16.18)
    return t;
}

// The share of unpolarised light that is reflected (Fresnel; Born and Wolf 1.5.2), for the cosines on both sides.
reals fresnel(reals cos_v, reals cos_t, reals eta) {
    const reals across = (eta * cos_v - cos_t) / (eta * cos_v + cos_t);
    const reals within = (cos_v - eta * cos_t) / (cos_v + eta * cos_t);
    return R(0.5) * fma(across, across, within * within);
}
