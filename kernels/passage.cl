// passage.cl - where a ray passes through primitives' surfaces, and how sure that is: each condition for a crossing as a
// quantity over the bound of its rounding error.
//
// A bound holds what rounding may have done to the ray, to the primitive as it was packed, and to the quantity as the kernel
// computes it: gamma_n times the sizes that enter into it, n no less than the roundings on the way (docs/numerics.md).
#if MARGIN

#if HAS_SPHERE
// The chord's distance from the centre decides. What rounding takes of its middle's place lies along the ray, square to that
// distance. The root loses where the chord is short: sqrt(x + e) - sqrt(x) is at most e / sqrt(x), and at most sqrt(e).
uint pass_sphere(const pencil *p, vectors centre, real radius, uint flags, passage *ways) {
    const vectors f = sub(p->ray.origin, centre), d = p->ray.direction;
    const real a = dot3(d, d), b = -dot3(f, d), speed = sqrt(a);
    const vectors chord = along(f, d, b / a);
    const real apart = length_of(chord), length = length_of(f);
    const real astray = GAMMA(10) * length;
    const real bound = length_of(blur_at(p, b / a)) + length_of(blur_of_point(centre)) + GAMMA(5) * (length + radius) +
                       min(astray, astray * astray / (R(2) * apart));
    const real squared = max((radius - apart) * (radius + apart), R(0));
    const real q = b + copysign(sqrt(a * squared), b);
    const real s = (length - radius) * (length + radius) / q, t = q / a;
    const real loss = bound * (R(2) * radius + bound), half_chord = sqrt(squared);
    const real of_root = min(loss / half_chord, sqrt(loss)) + loss * speed / fabs(q);
    const real there = max(in_bounds(radius - apart, bound), in_bounds(radius - length, bound));
    uint n = 0;
    for (int leaving = 0; leaving < 2; leaving++) {
        const real distance = leaving ? max(s, t) : min(s, t);
        if (!(flags & (leaving ? FLAG_BACK_HIDDEN : FLAG_FRONT_HIDDEN)))
            ways[n++] = make_passage(distance, (bound + astray + of_root) / speed + GAMMA(8) * fabs(distance), there);
    }
    return n;
}
#endif

#if HAS_PLANE || HAS_DISC || HAS_POLYGON || HAS_CONE
// What n.x may be off by for the ray's point x at this distance, with the plane's own point and tilt.
real blur_across(const pencil *p, real distance, vectors point, vectors normal) {
    const vectors to = sub(point, p->ray.origin), way = scale(p->ray.direction, distance), off = sub(to, way);
    const vectors sizes = add(scale(add(absolute(to), absolute(way)), GAMMA(6)), blur_of_point(point));
    return dot3(absolute(normal), add(blur_at(p, distance), sizes)) +
           GAMMA(2) * (fabs(off.x) + fabs(off.y) + fabs(off.z));
}

// What n.d may be off by.
real blur_of_slope(const pencil *p, vectors normal) {
    const vectors size = absolute(normal);
    return dot3(size, p->direction) + GAMMA(8) * dot3(size, absolute(p->ray.direction));
}

// Whether a ray might as well be parallel to a plane.
bool grazes(const pencil *p, vectors normal) {
    return fabs(dot3(normal, p->ray.direction)) < LIMIT * blur_of_slope(p, normal);
}

// A plane that nothing bounds. A ray that grazes it meets it nowhere near, if at all.
passage pass_plane(const pencil *p, vectors point, vectors normal, uint flags) {
    const real slope = dot3(normal, p->ray.direction), gap = dot3(normal, sub(point, p->ray.origin));
    const real of_slope = blur_of_slope(p, normal), distance = gap / slope;
    real there = R(INFINITY);
    if (flags & FLAG_FRONT_HIDDEN)
        there = in_bounds(slope, of_slope);
    if (flags & FLAG_BACK_HIDDEN)
        there = in_bounds(-slope, of_slope);
    if (!grazes(p, normal))
        return make_passage(distance, blur_across(p, distance, point, normal) / fabs(slope), there);
    const real bound = blur_across(p, R(0), point, normal), steepest = fabs(slope) + LIMIT * of_slope;
    const real toward = in_bounds(slope * copysign(R(1), gap), of_slope);
    return make_passage(max(fabs(gap) - LIMIT * bound, R(0)) / steepest, bound / steepest, min(there, toward));
}
#endif

#if HAS_DISC || HAS_CONE
// A ray that grazes the plane is known to pass by where it is off the plane all the way that it is near the centre.
passage pass_disc(const pencil *p, vectors centre, vectors normal, real radius, uint flags) {
    passage c = pass_plane(p, centre, normal, flags);
    const vectors f = sub(p->ray.origin, centre), d = p->ray.direction;
    const real speed = length_of(d), nearest = -dot3(f, d) / (speed * speed);
    const real apart = length_of(along(f, d, c.distance));
    const real bound = length_of(blur_at(p, c.distance)) + length_of(blur_of_point(centre)) + GAMMA(4) * radius +
                       GAMMA(6) * (length_of(f) + speed * fabs(c.distance)) + speed * c.error;
    if (!grazes(p, normal))
        c.there = min(c.there, in_bounds(radius - apart, bound));
    const real clear = fabs(dot3(normal, along(f, d, nearest))) - fabs(dot3(normal, d)) / speed * radius;
    if (clear > R(0))
        c.there = min(c.there, -in_bounds(clear, blur_across(p, nearest, centre, normal)));
    return c;
}
#endif

#if HAS_BOX
// How sure it is that the ray's point at this distance, itself known to within `error`, is between the planes of an axis.
real between_planes(const pencil *p, int axis, real distance, real error, vectors low, vectors high) {
    const real o = component(p->ray.origin, axis, 0), d = component(p->ray.direction, axis, 0);
    const real x = fma(d, distance, o), from = component(low, axis, 0), to = component(high, axis, 0);
    const real bound = component(blur_at(p, distance), axis, 0) + fabs(d) * error +
                       GAMMA(3) * (fabs(from) + fabs(to) + fabs(o) + fabs(d * distance));
    return in_bounds(min(x - from, to - x), bound);
}

// What the distance of a plane across the axis may be off by.
real blur_of_slab(const pencil *p, int axis, real distance, vectors low, vectors high) {
    const real size = max(fabs(component(low, axis, 0)), fabs(component(high, axis, 0)));
    const real bound =
        component(blur_at(p, distance), axis, 0) + GAMMA(4) * (size + fabs(component(p->ray.origin, axis, 0)));
    return bound / fabs(component(p->ray.direction, axis, 0));
}

real between_others(const pencil *p, int axis, real distance, vectors low, vectors high) {
    const real error = blur_of_slab(p, axis, distance, low, high);
    return min(between_planes(p, (axis + 1) % 3, distance, error, low, high),
               between_planes(p, (axis + 2) % 3, distance, error, low, high));
}

// How sure it is that between the planes of the axis along which it goes most the ray is outside of another's, always on
// the same side.
real beside_box(const pencil *p, int main, vectors low, vectors high, real near, real far) {
    real most = R(0);
    for (int k = 1; k < 3; k++) {
        const int axis = (main + k) % 3;
        const real o = component(p->ray.origin, axis, 0), d = component(p->ray.direction, axis, 0);
        const real a = fma(d, near, o), b = fma(d, far, o);
        const real off = max(component(low, axis, 0) - max(a, b), min(a, b) - component(high, axis, 0));
        if (off > R(0))
            most = max(most, min(-between_planes(p, axis, near, blur_of_slab(p, main, near, low, high), low, high),
                                 -between_planes(p, axis, far, blur_of_slab(p, main, far, low, high), low, high)));
    }
    return most;
}

// Where the last pair of planes is entered, the point is between the others; and where the first is left.
uint pass_box(const pencil *p, vectors low, vectors high, uint flags, passage *ways) {
    const vectors a = mul(sub(low, p->ray.origin), p->ray.inverse), b = mul(sub(high, p->ray.origin), p->ray.inverse);
    const vectors enter = least_xyz(a, b), leave = greatest_xyz(a, b), size = absolute(p->ray.direction);
    const interval i = intersect_slabs(p->ray, low, high);
    const int first = enter.x == i.near ? 0 : (enter.y == i.near ? 1 : 2);
    const int last = leave.x == i.far ? 0 : (leave.y == i.far ? 1 : 2);
    const int main = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    real at_first = between_others(p, first, i.near, low, high), at_last = between_others(p, last, i.far, low, high);
    if (i.near > i.far) // either proves it
        at_first = at_last = min(min(at_first, at_last),
                                 -beside_box(p, main, low, high, component(enter, main, 0), component(leave, main, 0)));
    uint n = 0;
    if (!(flags & FLAG_FRONT_HIDDEN))
        ways[n++] = make_passage(i.near, blur_of_slab(p, first, i.near, low, high), at_first);
    if (!(flags & FLAG_BACK_HIDDEN))
        ways[n++] = make_passage(max(i.near, i.far), blur_of_slab(p, last, i.far, low, high), at_last);
    return n;
}
#endif

#if HAS_TRIANGLE || HAS_POLYGON
// What a corner that the ray's shear has moved may be off by across the ray (x), and along it (z).
vectors blur_of_corner(const pencil *p, vectors corner) {
    const shear h = p->ray.shear;
    const vectors to = sub(corner, p->ray.origin);
    const real far = component(to, h.axis, 0), shear_x = fabs(h.x), shear_y = fabs(h.y);
    const vectors e = add(blur_at(p, far * h.z), add(blur_of_point(corner), scale(absolute(to), GAMMA(4))));
    const real x = component(e, h.axis, 1), y = component(e, h.axis, 2), z = component(e, h.axis, 0);
    const real across = (x + shear_x * z) + (y + shear_y * z) + GAMMA(4) * (shear_x + shear_y) * fabs(far);
    return make_vectors(across, across, z * fabs(h.z));
}
#endif

#if HAS_TRIANGLE || HAS_POLYGON || HAS_CONE
// How far the line from a to b passes from (0, 0), across the third axis. Multiplied by a power of two, so that squares do not vanish.
real distance_to_edge(vectors a, vectors b) {
    const real unit = power_over(max(largest_across(a), largest_across(b)));
    const vectors from = scale_across(a, unit), to = scale_across(b, unit);
    const real x = to.x - from.x, y = to.y - from.y, squared = fma(x, x, y * y);
    const real place = -fma(from.x, x, from.y * y);
    if (place > R(0) && place < squared)
        return fabs(difference_of_products(from.x, to.y, from.y, to.x)) / sqrt(squared) / unit;
    return min(sqrt(fma(from.x, from.x, from.y * from.y)), sqrt(fma(to.x, to.x, to.y * to.y))) / unit;
}
#endif

#if HAS_TRIANGLE
// Edges decide, across the ray. The distance is linear there: its gradient times what the corners may be off by.
passage pass_triangle(const pencil *p, vectors v0, vectors v1, vectors v2, uint flags) {
    vectors a = apply_shear(p->ray, v0), b = apply_shear(p->ray, v1), c = apply_shear(p->ray, v2);
    const vectors blur =
        greatest_xyz(greatest_xyz(blur_of_corner(p, v0), blur_of_corner(p, v1)), blur_of_corner(p, v2));
    const real edge = min(min(distance_to_edge(a, b), distance_to_edge(b, c)), distance_to_edge(c, a));
    const bool inside = intersect_triangle(p->ray, v0, v1, v2, 0).found;
    real there = in_bounds(inside ? edge : -edge, blur.x);
    const real unit = power_over(max(largest_across(a), max(largest_across(b), largest_across(c))));
    a = scale_across(a, unit);
    b = scale_across(b, unit);
    c = scale_across(c, unit);
    const real e0 = difference_of_products(c.x, b.y, c.y, b.x), e1 = difference_of_products(a.x, c.y, a.y, c.x),
               e2 = difference_of_products(b.x, a.y, b.y, a.x), sum = e0 + e1 + e2;
    const vectors u = sub(b, a), v = sub(c, a);
    const real slope_x = (u.z * v.y - v.z * u.y) / sum, slope_y = (v.z * u.x - u.z * v.x) / sum;
    const real distance = fma(e0 / sum, a.z, fma(e1 / sum, b.z, e2 / sum * c.z));
    const real far = max(fabs(a.z), max(fabs(b.z), fabs(c.z)));
    const real error = (fabs(slope_x) + fabs(slope_y)) * blur.x * unit + blur.z + GAMMA(8) * far;
    if (flags & (FLAG_FRONT_HIDDEN | FLAG_BACK_HIDDEN)) {
        const bool back_hidden = flags & FLAG_BACK_HIDDEN, front = (sum > R(0)) == (p->ray.shear.z > R(0));
        const real area = fabs(sum), around = R(2) * (fabs(u.x) + fabs(u.y) + fabs(v.x) + fabs(v.y));
        there = min(there, in_bounds(front == back_hidden ? area : -area, blur.x * unit * around));
    }
    return make_passage(distance, error < R(INFINITY) ? error : R(INFINITY), there); // no area: not a number
}
#endif

#if HAS_POLYGON
passage pass_polygon(const scene *s, const pencil *p, uint index, uint flags) {
    const polygon a = s->polygons[index];
    const uint4 range = s->polygon_ranges[index];
    global const real *rows = s->corners + (size_t)range.x * WIDTH;
    const uint length = corners_row(range.y);
    passage c = pass_plane(p, splat_xyz(a.point), splat_xyz(a.normal), flags);
    real edge = R(INFINITY), blur = R(0);
    for (uint k = 0; k < range.y; k++) {
        const vectors corner = make_vectors(rows[k], rows[length + k], rows[2 * length + k]);
        blur = max(blur, blur_of_corner(p, corner).x);
        edge = min(edge, distance_to_edge(shear_corners(p->ray, rows, length, k, APART),
                                          shear_corners(p->ray, rows, length, k + 1, APART)));
    }
    const bool inside = is_inside(p->ray, rows, range.y, APART);
    c.there = min(c.there, in_bounds(inside ? edge : -edge, blur));
    return c;
}
#endif

#if HAS_CONE
// The same pencil in the cone's frame.
pencil lay_along(const pencil *p, frustum f) {
    pencil q = *p;
    const vectors to = sub(p->ray.origin, f.base);
    q.ray.origin = apply(f.frame, to);
    q.ray.direction = apply(f.frame, p->ray.direction);
    const real origin = length_of(p->origin) + length_of(blur_of_point(f.base)) + GAMMA(8) * length_of(to) +
                        GAMMA(1) * length_of(p->ray.origin);
    const real direction = length_of(p->direction) + GAMMA(8) * length_of(p->ray.direction);
    q.origin = make_vectors(origin, origin, origin);
    q.direction = make_vectors(direction, direction, direction);
    return q;
}

// How far outside of the side the ray's point is, and what that may be off by.
typedef struct {
    real outside, bound, radius, z;
} beside;

beside find_beside(const pencil *q, frustum f, real distance) {
    const vectors x = along(q->ray.origin, q->ray.direction, distance);
    beside b;
    b.z = x.z;
    b.radius = fma(f.slope, x.z, f.radius);
    b.outside = sqrt(fma(x.x, x.x, x.y * x.y)) - fabs(b.radius);
    b.bound = (length_of(blur_at(q, distance)) + GAMMA(4) * length_of(x)) * (R(1) + fabs(f.slope)) +
              GAMMA(6) * (f.radius + fabs(f.slope * x.z));
    return b;
}

// Whether the infinite double cone is met at all: the discriminant of intersect_double_cone as a difference of lengths,
// or the origin is inside, or the ray is steeper than the side.
real meets_double_cone(const pencil *q, frustum f) {
    const vectors o = q->ray.origin, d = q->ray.direction;
    const real change = f.slope * d.z, radius = fma(f.slope, o.z, f.radius);
    const real s = difference_of_products(radius, d.x, o.x, change),
               t = difference_of_products(radius, d.y, o.y, change);
    const real w = difference_of_products(o.x, d.y, o.y, d.x), wide = sqrt(fma(s, s, t * t));
    const beside here = find_beside(q, f, R(0));
    const real of_change = fabs(f.slope) * q->direction.x + GAMMA(3) * fabs(change),
               speed = sqrt(fma(d.x, d.x, d.y * d.y));
    const real bound = R(2) * (speed + fabs(change)) * here.bound +
                       (fabs(o.x) + fabs(o.y)) * (q->direction.x + of_change) + R(2) * fabs(radius) * q->direction.x +
                       GAMMA(8) * (wide + fabs(w));
    const real steep = in_bounds(fabs(change) - speed, of_change + R(2) * q->direction.x + GAMMA(4) * speed);
    return max(max(in_bounds(wide - fabs(w), bound), in_bounds(-here.outside, here.bound)), steep);
}

// A ray that is nearly parallel to the side is known to pass the whole cone, or its side, from where it is at both ends.
void mind_ends(const pencil *q, frustum f, passage *side, passage *cap, uint sides, uint caps) {
    const vectors o = q->ray.origin, d = q->ray.direction;
    const real low = -o.z / d.z, high = (f.height - o.z) / d.z;
    if (!(fabs(low) < R(INFINITY) && fabs(high) < R(INFINITY)))
        return;
    const beside a = find_beside(q, f, low), b = find_beside(q, f, high);
    const real stretch = R(1) + sqrt(fma(d.x, d.x, d.y * d.y)) / fabs(d.z), bound = max(a.bound, b.bound) * stretch;
    const real apart = distance_to_edge(along(o, d, low), along(o, d, high)), widest = max(a.radius, b.radius);
    const real past = in_bounds(apart - widest, bound), within = in_bounds(min(-a.outside, -b.outside), bound);
    for (uint k = 0; k < sides; k++)
        side[k].there = min(side[k].there, past > R(0) ? -past : (within > R(0) ? -within : R(INFINITY)));
    for (uint k = 0; k < caps; k++)
        cap[k].there = min(cap[k].there, past > R(0) ? -past : R(INFINITY));
}

uint pass_cone(const pencil *p, frustum f, uint flags, passage *ways) {
    const pencil q = lay_along(p, f);
    const vectors o = q.ray.origin, d = q.ray.direction;
    const real change = f.slope * d.z, met = meets_double_cone(&q, f);
    const chord k = intersect_double_cone(o, d, fma(f.slope, o.z, f.radius), change);
    uint sides = 0;
    for (int last = 0; last < 2; last++) {
        const real distance = last ? k.last : k.first;
        if (!(fabs(distance) < R(INFINITY)))
            continue;
        const beside here = find_beside(&q, f, distance);
        const real x = fma(d.x, distance, o.x), y = fma(d.y, distance, o.y), across = sqrt(fma(x, x, y * y));
        const real apart = fma(x, d.x, y * d.y) / across - copysign(change, here.radius); // grows where it leaves
        const real error = here.bound / fabs(apart);
        if (flags & (apart > R(0) ? FLAG_BACK_HIDDEN : FLAG_FRONT_HIDDEN))
            continue;
        const real of_z = q.origin.x + q.direction.x * fabs(distance) +
                          GAMMA(4) * (fabs(o.z) + fabs(d.z * distance) + f.height) + fabs(d.z) * error;
        ways[sides++] = make_passage(distance, error < R(INFINITY) ? error : R(INFINITY),
                                     min(met, in_bounds(min(here.z, f.height - here.z), of_z)));
    }
    uint caps = 0;
    const vectors up = make_vectors(R(0), R(0), R(1));
    for (int top = 0; top < 2 && (flags & FLAG_CAPPED); top++) {
        const uint hidden = (d.z > R(0)) == (top == 1) ? FLAG_BACK_HIDDEN : FLAG_FRONT_HIDDEN;
        const real z = top ? f.height : R(0), radius = top ? fma(f.slope, f.height, f.radius) : f.radius;
        if (!(flags & hidden))
            ways[sides + caps++] = pass_disc(&q, make_vectors(R(0), R(0), z), up, max(radius, R(0)), 0);
    }
    mind_ends(&q, f, ways, ways + sides, sides, caps);
    return sides + caps;
}
#endif

// Every passage of the ray's line through a primitive; how many there are.
uint find_passages(const scene *s, const pencil *p, uint4 primitive, passage ways[MOST_PASSAGES]) {
    const uint i = primitive.y, flags = primitive.w;
    switch (primitive.x) {
#if HAS_SPHERE
    case KIND_SPHERE:
        return pass_sphere(p, splat_xyz(s->spheres[i].centre_radius), s->spheres[i].centre_radius.w, flags, ways);
#endif
#if HAS_PLANE
    case KIND_PLANE:
        ways[0] = pass_plane(p, splat_xyz(s->planes[i].point), splat_xyz(s->planes[i].normal), flags);
        return 1;
#endif
#if HAS_DISC
    case KIND_DISC:
        ways[0] = pass_disc(p, splat_xyz(s->discs[i].centre_radius), splat_xyz(s->discs[i].normal),
                            s->discs[i].centre_radius.w, flags);
        return 1;
#endif
#if HAS_BOX
    case KIND_BOX:
        return pass_box(p, splat_xyz(s->boxes[i].bounds.low), splat_xyz(s->boxes[i].bounds.high), flags, ways);
#endif
#if HAS_TRIANGLE
    case KIND_TRIANGLE: {
        const uint4 corners = s->triangles[i];
        ways[0] = pass_triangle(p, splat_xyz(s->vertices[corners.x]), splat_xyz(s->vertices[corners.y]),
                                splat_xyz(s->vertices[corners.z]), flags);
        return 1;
    }
#endif
#if HAS_POLYGON
    case KIND_POLYGON:
        ways[0] = pass_polygon(s, p, i, flags);
        return 1;
#endif
#if HAS_CONE
    case KIND_CONE: {
        const cone c = s->cones[i];
        return pass_cone(p,
                         make_frustum(splat_quads(c.base_radius), splat_quads(c.u_height), splat_quads(c.v_slope),
                                      splat_quads(c.axis)),
                         flags, ways);
    }
#endif
    default:
        return 0;
    }
}
#endif
