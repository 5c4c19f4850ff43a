// cone.cl - cones, truncated cones and cylinders about an axis, open or capped, in the frame u, v, axis at the base.

typedef struct {
    vectors base;
    rows frame; // u, v and the axis
    reals radius, slope, height;
} frustum;

frustum make_frustum(quads base_radius, quads u_height, quads v_slope, quads axis) {
    frustum f;
    f.base = base_radius.xyz;
    f.frame.x = u_height.xyz;
    f.frame.y = v_slope.xyz;
    f.frame.z = axis.xyz;
    f.radius = base_radius.w;
    f.height = u_height.w;
    f.slope = v_slope.w;
    return f;
}

// Where a ray is inside the infinite double cone: from `first` to `last`, or, for a ray steeper than the side (`steep`),
// before `first` and after `last`.
typedef struct {
    ints found, steep;
    reals first, last;
} chord;

// Q(t) = (x + t dx)^2 + (y + t dy)^2 - (R + t w)^2, with R the radius at the origin's height and w its change along the
// ray. The discriminant is Lagrange's identity in the form's own signature, (R dx - x w)^2 + (R dy - y w)^2
// - (x dy - y dx)^2, each a difference of products: nothing of the distance's square is left to cancel.
chord intersect_double_cone(vectors o, vectors d, reals radius, reals change) {
    const reals s = difference_of_products(radius, d.x, o.x, change);
    const reals t = difference_of_products(radius, d.y, o.y, change);
    const reals w = difference_of_products(o.x, d.y, o.y, d.x);
    const reals wide = sqrt(fma(s, s, t * t));
    const reals discriminant = (wide - fabs(w)) * (wide + fabs(w));
    const reals speed = sqrt(fma(d.x, d.x, d.y * d.y)), distance = sqrt(fma(o.x, o.x, o.y * o.y));
    const reals a = (speed - fabs(change)) * (speed + fabs(change));
    const reals b = -fma(o.x, d.x, difference_of_products(o.y, d.y, radius, change));
    const reals c = (distance - fabs(radius)) * (distance + fabs(radius));
    const reals q = b + copysign(sqrt(max(discriminant, splat(0))), b);
    // To the axis of a cylinder: inside everywhere or nowhere (a may be a vanishing square). Or past the cone, b being 0.
    const ints parallel = q == splat(0);
    const reals one = parallel ? splat(-INFINITY) : c / q;
    const reals two = parallel ? splat(INFINITY) : q / a; // infinite when parallel to the side, a = 0
    chord k;
    k.steep = a < splat(0);
    k.found = parallel ? (c < splat(0)) | ((a == splat(0)) & (c <= splat(0)))
                       : (discriminant >= splat(0)) | (c < splat(0)) | k.steep;
    k.first = min(one, two);
    k.last = max(one, two);
    return k;
}

// The part of a capped cone that a crossing lies on, as its u.
#define PART_SIDE 0
#define PART_BASE 1
#define PART_TOP 2

// A capped cone is where the double cone's and the two planes' intervals overlap: side and caps meet without a seam.
crossing intersect_capped(ray r, chord k, interval height, ints rising, ints widening, uint flags) {
    const reals first = k.steep ? (widening ? k.last : splat(-INFINITY)) : k.first;
    const reals last = k.steep ? (widening ? splat(INFINITY) : k.first) : k.last;
    const reals enter = max(first, height.near), leave = min(last, height.far);
    crossing c = first_ahead(r, k.found & (enter <= leave), enter, leave, flags);
    const ints entering = c.distance == enter;
    const ints side = entering ? first >= height.near : last <= height.far;
    c.u = side ? splat(PART_SIDE) : (entering == rising ? splat(PART_BASE) : splat(PART_TOP));
    return c;
}

// An open one is its side alone: the first of the two crossings that is ahead, within the height and seen. Of a steep ray's
// two, one is beyond the tip: the one that comes first if the cone widens, however near the tip both are.
crossing intersect_open(ray r, chord k, interval height, ints widening, uint flags) {
    const ints front = mask(!HAS_ONE_SIDED || !(flags & FLAG_FRONT_HIDDEN));
    const ints back = mask(!HAS_ONE_SIDED || !(flags & FLAG_BACK_HIDDEN));
    const ints first = (k.steep ? back & !widening : front) & is_ahead(r, k.first) & (k.first >= height.near) &
                       (k.first <= height.far);
    const ints last =
        (k.steep ? front & widening : back) & is_ahead(r, k.last) & (k.last >= height.near) & (k.last <= height.far);
    crossing c;
    c.found = k.found & (first | last);
    c.distance = first ? k.first : k.last;
    c.u = splat(PART_SIDE);
    c.v = splat(0);
    return c;
}

crossing intersect_cone(ray r, frustum f, uint flags) {
    const vectors o = apply(f.frame, sub(r.origin, f.base)), d = apply(f.frame, r.direction);
    const reals change = f.slope * d.z;
    const chord k = intersect_double_cone(o, d, fma(f.slope, o.z, f.radius), change);
    const reals inverse = reciprocal(d.z);
    const reals base = -o.z * inverse, top = (f.height - o.z) * inverse;
    interval height;
    height.near = min(base, top);
    height.far = max(base, top);
    if (flags & FLAG_CAPPED)
        return intersect_capped(r, k, height, d.z > splat(0), change > splat(0), flags);
    return intersect_open(r, k, height, change > splat(0), flags);
}

// The point is put back onto the part that was hit, in the cone's frame. Errors: the frame's three products and sums, the
// world's sum, and the radius, which is a sum of its own.
surface surface_cone(ray r, reals distance, reals part, frustum f) {
    const vectors o = apply(f.frame, sub(r.origin, f.base)), d = apply(f.frame, r.direction);
    vectors p = along(o, d, distance);
    const ints side = part == splat(PART_SIDE), top = part == splat(PART_TOP);
    const reals slant = splat(1) / sqrt(fma(f.slope, f.slope, splat(1)));
    const reals across = sqrt(fma(p.x, p.x, p.y * p.y));
    const ints apex = across == splat(0);
    const reals inverse = splat(1) / (apex ? splat(1) : across);
    p.z = side ? min(max(p.z, splat(0)), f.height) : (top ? f.height : splat(0));
    const reals stretch = (side & !apex) ? fma(f.slope, p.z, f.radius) * inverse : splat(1);
    const reals tilt = apex ? splat(0) : slant * inverse;
    const vectors normal = make_vectors(side ? p.x * tilt : splat(0), side ? p.y * tilt : splat(0),
                                        side ? -f.slope * slant : (top ? splat(1) : splat(-1)));
    p.x *= stretch;
    p.y *= stretch;
    surface s;
    s.normal = s.shading = normalise_or(apply_transposed(f.frame, normal), negate(r.direction));
    s.point = add(f.base, apply_transposed(f.frame, p));
    const vectors in_frame =
        add(absolute(scale(f.frame.x, p.x)), add(absolute(scale(f.frame.y, p.y)), absolute(scale(f.frame.z, p.z))));
    const reals of_radius = (f.radius + fabs(f.slope) * p.z) * slant * GAMMA(4);
    s.error = add(scale(in_frame, splat(GAMMA(12))), scale(add(absolute(f.base), absolute(s.point)), splat(GAMMA(3))));
    s.error = add(s.error, make_vectors(of_radius, of_radius, of_radius));
    return s;
}
