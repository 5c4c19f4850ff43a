// naive.cl - what textbooks do, so that its failures can be shown beside the remedies (docs/numerics.md, tests/stability).
//
// Each build option NAIVE_... brings a function of a robust one's signature, which takes its name for all that follows.
// Without such an option nothing here is compiled.

#if defined(NAIVE_SPHERE) && HAS_SPHERE
// b^2 - 4ac. With 2: the chord's distance decides as it should, but c is |f|^2 - r^2.
crossing naive_intersect_sphere(ray r, vectors centre, reals radius, uint flags) {
    const vectors f = sub(r.origin, centre);
    const reals a = dot3(r.direction, r.direction), b = R(2) * dot3(f, r.direction);
    const reals c = dot3(f, f) - radius * radius;
#if NAIVE_SPHERE == 2
    const vectors chord = along(f, r.direction, R(-0.5) * b / a);
    const reals discriminant = R(4) * a * (radius * radius - dot3(chord, chord));
    const reals q = R(-0.5) * (b + copysign(sqrt(max(discriminant, splat(0))), b));
    const reals s = c / q, t = q / a;
    return first_ahead(r, discriminant >= splat(0), min(s, t), max(s, t), flags);
#else
    const reals discriminant = b * b - R(4) * a * c;
    const reals root = sqrt(max(discriminant, splat(0))), twice = R(2) * a;
    return first_ahead(r, discriminant >= splat(0), (-b - root) / twice, (-b + root) / twice, flags);
#endif
}
#define intersect_sphere naive_intersect_sphere
#endif

#if defined(NAIVE_POINT) && HAS_SPHERE
// The point as far along the ray as the distance says, and the normal that it has then.
surface naive_surface_sphere(ray r, reals distance, vectors centre, reals radius) {
    surface s = surface_sphere(r, distance, centre, radius);
    s.point = along(r.origin, r.direction, distance);
    s.normal = s.shading = normalise(sub(s.point, centre));
    return s;
}
#define surface_sphere naive_surface_sphere
#endif

#if defined(NAIVE_PLANE)
// The point as far along the ray as the distance says.
surface naive_surface_plane(ray r, reals distance, vectors point, vectors normal) {
    surface s = surface_plane(r, distance, point, normal);
    s.point = along(r.origin, r.direction, distance);
    return s;
}
#define surface_plane naive_surface_plane
#endif

#if defined(NAIVE_CONE) && HAS_CONE
// The nearer of two crossings that are there and ahead.
crossing naive_nearer(ray r, crossing a, crossing b) {
    const ints first =
        a.found & is_ahead(r, a.distance) & (!(b.found & is_ahead(r, b.distance)) | (a.distance <= b.distance));
    const ints second = !first & b.found & is_ahead(r, b.distance);
    crossing c;
    c.found = first | second;
    c.distance = first ? a.distance : b.distance;
    c.u = first ? a.u : b.u;
    c.v = splat(0);
    return c;
}

// A side met at one root of the quadratic, within the height.
crossing naive_side(vectors o, vectors d, reals height, ints found, reals distance) {
    const reals z = fma(d.z, distance, o.z);
    crossing c = {found & (z >= splat(0)) & (z <= height), distance, splat(PART_SIDE), splat(0)};
    return c;
}

crossing naive_cap(vectors o, vectors d, reals z, reals radius, reals part) {
    const reals t = (z - o.z) / d.z, x = fma(d.x, t, o.x), y = fma(d.y, t, o.y);
    crossing c = {x * x + y * y <= radius * radius, t, part, splat(0)};
    return c;
}

// b^2 - 4ac for the side, a disc for each cap, the nearest of them all. Both sides of everything are seen.
crossing naive_intersect_cone(ray r, frustum f, uint flags) {
    const vectors o = apply(f.frame, sub(r.origin, f.base)), d = apply(f.frame, r.direction);
    const reals radius = fma(f.slope, o.z, f.radius), change = f.slope * d.z;
    const reals a = d.x * d.x + d.y * d.y - change * change;
    const reals b = R(2) * (o.x * d.x + o.y * d.y - radius * change);
    const reals c = o.x * o.x + o.y * o.y - radius * radius;
    const reals discriminant = b * b - R(4) * a * c;
    const reals root = sqrt(max(discriminant, splat(0))), twice = R(2) * a;
    const ints found = discriminant >= splat(0);
    crossing x = naive_nearer(r, naive_side(o, d, f.height, found, (-b - root) / twice),
                              naive_side(o, d, f.height, found, (-b + root) / twice));
    if (flags & FLAG_CAPPED) {
        x = naive_nearer(r, x, naive_cap(o, d, splat(0), f.radius, splat(PART_BASE)));
        x = naive_nearer(r, x, naive_cap(o, d, f.height, fma(f.slope, f.height, f.radius), splat(PART_TOP)));
    }
    return x;
}
#define intersect_cone naive_intersect_cone
#endif

#if defined(NAIVE_TRIANGLE) && HAS_TRIANGLE
// Moeller and Trumbore 1997. With 2: its products contracted, as a compiler may do.
#if NAIVE_TRIANGLE == 2
#define NAIVE_SUM(a, b, c, d) fma(a, b, c *d)
#else
#define NAIVE_SUM(a, b, c, d) ((a) * (b) + (c) * (d))
#endif

vectors naive_cross(vectors a, vectors b) {
    return make_vectors(NAIVE_SUM(a.y, b.z, -a.z, b.y), NAIVE_SUM(a.z, b.x, -a.x, b.z), NAIVE_SUM(a.x, b.y, -a.y, b.x));
}

reals naive_dot(vectors a, vectors b) {
#if NAIVE_TRIANGLE == 2
    return dot3(a, b);
#else
    return a.x * b.x + a.y * b.y + a.z * b.z;
#endif
}

crossing naive_intersect_triangle(ray r, vectors v0, vectors v1, vectors v2, uint flags) {
    const vectors edge1 = sub(v1, v0), edge2 = sub(v2, v0), s = sub(r.origin, v0);
    const vectors p = naive_cross(r.direction, edge2), q = naive_cross(s, edge1);
    const reals inverse = splat(1) / naive_dot(edge1, p);
    crossing x;
    x.u = naive_dot(s, p) * inverse;
    x.v = naive_dot(r.direction, q) * inverse;
    x.distance = naive_dot(edge2, q) * inverse;
    x.found = (x.u >= splat(0)) & (x.v >= splat(0)) & (x.u + x.v <= splat(1));
    return x;
}
#define intersect_triangle naive_intersect_triangle
#elif (defined(NAIVE_EDGES) || defined(NAIVE_TIES)) && HAS_TRIANGLE
// Woop's test with other edges. NAIVE_EDGES: the difference of rounded products; with 2: contracted, as a compiler may do.
// NAIVE_TIES: a point on an edge is in both triangles, as published.
reals naive_edge(reals a, reals b, reals c, reals d) {
#if !defined(NAIVE_EDGES)
    return difference_of_products(a, b, c, d);
#elif NAIVE_EDGES == 2
    return fma(a, b, -(c * d));
#else
    return a * b - c * d;
#endif
}

ints naive_is_within(vectors a, vectors b, vectors c, reals e0, reals e1, reals e2) {
#if defined(NAIVE_TIES)
    const reals zero = splat(0);
    return ((e0 >= zero) & (e1 >= zero) & (e2 >= zero)) | ((e0 <= zero) & (e1 <= zero) & (e2 <= zero));
#else
    const ints s0 = is_left(c, b, e0), s1 = is_left(a, c, e1), s2 = is_left(b, a, e2);
    return (s0 & s1 & s2) | !(s0 | s1 | s2);
#endif
}

crossing naive_intersect_triangle(ray r, vectors v0, vectors v1, vectors v2, uint flags) {
    const vectors a = apply_shear(r, v0), b = apply_shear(r, v1), c = apply_shear(r, v2);
    const reals e0 = naive_edge(c.x, b.y, c.y, b.x);
    const reals e1 = naive_edge(a.x, c.y, a.y, c.x);
    const reals e2 = naive_edge(b.x, a.y, b.y, a.x);
    const reals sum = e0 + e1 + e2;
    crossing x;
    x.found = naive_is_within(a, b, c, e0, e1, e2) & (sum != splat(0));
    x.u = e1 / sum;
    x.v = e2 / sum;
    x.distance = fma(e0 / sum, a.z, fma(x.u, b.z, x.v * c.z));
    return x;
}
#define intersect_triangle naive_intersect_triangle
#endif

#if defined(NAIVE_SLAB) || defined(NAIVE_TMIN)
// NAIVE_SLAB: 1/d may be infinite. NAIVE_TMIN: what is nearer than this is overlooked.
ray naive_make_ray(vectors origin, vectors direction) {
    ray r = make_ray(origin, direction);
#if defined(NAIVE_SLAB)
    r.inverse = make_vectors(splat(1) / direction.x, splat(1) / direction.y, splat(1) / direction.z);
#endif
#if defined(NAIVE_TMIN)
    r.least = splat(R(NAIVE_TMIN));
#endif
    return r;
}
#define make_ray naive_make_ray
#endif

#if defined(NAIVE_WIDEN)
// An interval's end as it was rounded.
#define intersect_bounds intersect_slabs
#define widen(far) (far)
#endif

#if defined(NAIVE_CLAMP)
// A distance as the primitive found it.
crossing naive_clamp_crossing(ray r, vectors low, vectors high, crossing c) {
    c.found &= c.distance > splat(0);
    return c;
}
#define clamp_crossing naive_clamp_crossing
#endif

#if defined(NAIVE_TMIN) || defined(NAIVE_OFFSET) || defined(NAIVE_ULPS)
// Where a ray starts. NAIVE_TMIN: at the point as it is. NAIVE_OFFSET: by this number along the normal. NAIVE_ULPS: by a
// number of ulps (Waechter and Binder, Ray Tracing Gems ch. 6).
reals naive_move(reals p, reals n) {
#if defined(NAIVE_ULPS)
    const ints steps = TO_INTS(n * R(256));
    const reals moved = AS_REALS(AS_INTS(p) + (p < splat(0) ? -steps : steps));
    return fabs(p) < splat(R(1) / R(32)) ? p + n * (R(1) / R(65536)) : moved;
#elif defined(NAIVE_OFFSET)
    return p + n * R(NAIVE_OFFSET);
#else
    return p;
#endif
}

vectors naive_spawn(vectors p, vectors error, vectors n) {
    return make_vectors(naive_move(p.x, n.x), naive_move(p.y, n.y), naive_move(p.z, n.z));
}
#define spawn naive_spawn
#endif

#if defined(NAIVE_TIR)
// The sine decides, and the root is of another formula: 1 - c^2 loses what the sine had.
refraction naive_refract(vectors v, vectors n, reals eta) {
    const reals c = dot3(v, n), sine = sqrt(splat(1) - c * c), squared = eta * eta * (splat(1) - c * c);
    refraction t;
    t.found = eta * sine <= splat(1);
    t.direction = along(scale(v, -eta), n, eta * c - sqrt(splat(1) - squared));
    return t;
}
#define refract naive_refract
#endif

#if defined(NAIVE_NORMALISE)
// (16.9) without a new length: rounding adds up from bounce to bounce.
vectors naive_reflect(vectors v, vectors n) {
    return along(negate(v), n, R(2) * dot3(v, n));
}
#define reflect naive_reflect
#endif

#if defined(NAIVE_SHADING)
// The interpolated normal's word is the last.
vectors naive_keep_above(vectors direction, vectors n) {
    return direction;
}
#define keep_above naive_keep_above
#endif

#if defined(NAIVE_POW)
reals naive_power(reals base, reals exponent) {
    return pow(base, exponent);
}
#define power naive_power
#endif

#if defined(NAIVE_MEDIA)
// Every surface bounds its material against air, and no list is kept.
boundary naive_cross_boundary(const scene *s, const media *in, ints material, ints entering) {
    const reals index = index_of(s, material);
    const boundary b = {entering ? splat(1) / index : index, material, mask(true), *in};
    return b;
}
#define cross_boundary naive_cross_boundary
#endif

#if defined(NAIVE_FEELER)
// A feeler's whole way to the light.
#define FEELER_SHORT R(1)
#endif
