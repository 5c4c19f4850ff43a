// ray.cl - a ray, what it hits, and its interval in a box.

// The permutation and shear that lay a ray along +z (Woop, Benthin, Wald 2013, Watertight Ray/Triangle Intersection):
// `axis` is the direction's largest component, its two followers become x and y.
typedef struct {
    ints axis;
    reals x, y, z;
} shear;

// Whether there are rays that go on through surfaces.
#define STEPS (HAS_TRANSMISSION || HAS_FILTERED_SHADOWS)

// The direction has length 1. A ray that goes through surfaces steps from hit to hit: what comes next is farther than
// `least`, or as far and of a higher primitive number than the last; `again` says that the primitive at hand has one.
//
// In an instance (see instance.cl) the direction has another length, every hit counts as being in the ray's interval `in`
// in the instance's box, and `last` is a number among the primitives there.
typedef struct {
    vectors origin, direction, inverse;
    shear shear;
    reals least;
    ints last, again;
#if HAS_INSTANCE
    ints last_inside;
    reals in_near, in_far;
#endif
} ray;

// The nearest hit so far: primitive is -1 for none, u and v are the primitive's own (triangle: barycentric). Where the
// primitive is an instance, `inside` is the one that it has there.
typedef struct {
    reals distance;
    ints primitive;
    reals u, v;
#if HAS_INSTANCE
    ints inside;
#endif
} hit;

// Where a ray meets one primitive, if it does.
typedef struct {
    ints found;
    reals distance, u, v;
} crossing;

typedef struct {
    reals near, far;
} interval;

// The component `offset` places after the axis, cyclically.
reals component(vectors a, ints axis, int offset) {
    switch (offset) {
    case 0:
        return axis == 0 ? a.x : (axis == 1 ? a.y : a.z);
    case 1:
        return axis == 0 ? a.y : (axis == 1 ? a.z : a.x);
    default:
        return axis == 0 ? a.z : (axis == 1 ? a.x : a.y);
    }
}

// -0 counts as 0: a point on an edge counts as moved along +x and +y (triangle.cl), and boxes must agree.
reals reciprocal(reals d) {
    return splat(1) / (fabs(d) < LEAST_DIRECTION ? copysign(splat(LEAST_DIRECTION), d + splat(0)) : d);
}

// No hit that is as far as the limit.
hit no_hit(reals limit) {
    hit h;
    h.distance = limit;
    h.primitive = whole(-1);
    h.u = h.v = splat(0);
#if HAS_INSTANCE
    h.inside = whole(-1);
#endif
    return h;
}

INLINE ray make_ray(vectors origin, vectors direction) {
    ray r;
    r.origin = origin;
    r.direction = direction;
    r.least = splat(0);
    r.last = whole(-1);
    r.again = mask(false);
#if HAS_INSTANCE
    r.last_inside = whole(-1);
    r.in_near = splat(-INFINITY);
    r.in_far = splat(INFINITY);
#endif
    r.inverse = make_vectors(reciprocal(direction.x), reciprocal(direction.y), reciprocal(direction.z));
#if HAS_TRIANGLE || HAS_POLYGON
    const vectors size = absolute(direction);
    const ints one = 1, two = 2, zero = 0;
    r.shear.axis = ((size.x >= size.y) & (size.x >= size.z)) ? zero : (size.y >= size.z ? one : two);
    r.shear.z = splat(1) / component(direction, r.shear.axis, 0);
    r.shear.x = component(direction, r.shear.axis, 1) * r.shear.z;
    r.shear.y = component(direction, r.shear.axis, 2) * r.shear.z;
#endif
    return r;
}

// A point as the sheared ray sees it: the ray runs through (0, 0) along +z, and z is the distance along it.
vectors apply_shear(ray r, vectors point) {
    const vectors p = sub(point, r.origin);
    const reals z = component(p, r.shear.axis, 0);
    return make_vectors(fma(-r.shear.x, z, component(p, r.shear.axis, 1)),
                        fma(-r.shear.y, z, component(p, r.shear.axis, 2)), z * r.shear.z);
}

// Of a sheared point, across the ray: the larger coordinate's size, and both multiplied.
reals largest_across(vectors p) {
    return max(fabs(p.x), fabs(p.y));
}

vectors scale_across(vectors p, reals s) {
    return make_vectors(p.x * s, p.y * s, p.z);
}

// The end of an interval, moved out past what rounding may have taken (Ize 2013, Robust BVH Ray Traversal).
reals widen(reals far) {
    return far * (R(1) + R(2) * GAMMA(3));
}

// The ray's interval between a box's three pairs of planes.
interval intersect_slabs(ray r, vectors low, vectors high) {
    const vectors a = mul(sub(low, r.origin), r.inverse);
    const vectors b = mul(sub(high, r.origin), r.inverse);
    interval i;
    i.near = max(max(min(a.x, b.x), min(a.y, b.y)), min(a.z, b.z));
    i.far = min(min(max(a.x, b.x), max(a.y, b.y)), max(a.z, b.z));
    return i;
}

// The same, never too small. Tree and primitives ask this one function, which is monotone in the box: that is why the tree
// cannot change a picture.
interval intersect_bounds(ray r, vectors low, vectors high) {
    interval i = intersect_slabs(r, low, high);
    i.far = widen(i.far);
    return i;
}

// A crossing's distance clamped to the ray's interval in the primitive's box; none where that is empty. What is not ahead
// (or not a number) stays out: clamping must not bring it back.
crossing clamp_crossing(ray r, vectors low, vectors high, crossing c) {
    const interval i = intersect_bounds(r, low, high);
    c.found &= (c.distance > splat(0)) & (i.near <= i.far);
    c.distance = min(max(c.distance, i.near), i.far);
#if HAS_INSTANCE
    c.distance = min(max(c.distance, r.in_near), r.in_far);
#endif
    return c;
}

// A box that begins farther away holds nothing nearer than `distance`, and one that ends before the other holds nothing that
// is ahead. In an instance, where all is moved into one interval, boxes tell nothing beyond its ends.
reals farthest_near(const ray *r, reals distance) {
#if HAS_INSTANCE
    return r->in_far <= distance ? splat(FARTHEST) : distance;
#else
    return distance;
#endif
}

reals nearest_far(const ray *r) {
#if HAS_INSTANCE
    return r->in_near >= r->least ? splat(-FARTHEST) : r->least;
#else
    return r->least;
#endif
}

// The same ray with one primitive at hand.
ray face_primitive(ray r, ints number) {
#if STEPS
    r.again = (r.last >= 0) & (r.last < number);
#endif
    return r;
}

// Whether the ray has this distance still before it.
ints is_ahead(ray r, reals distance) {
#if STEPS
    return (distance > r.least) | (r.again & (distance == r.least));
#else
    return distance > splat(0);
#endif
}

#if STEPS
// The ray beyond a hit, for the active lanes.
ray step_beyond(ray r, const hit *h, ints active) {
    r.least = active ? h->distance : r.least;
    r.last = active ? h->primitive : r.last;
#if HAS_INSTANCE
    r.last_inside = active ? h->inside : r.last_inside;
#endif
    return r;
}
#endif

// Which of a convex solid's two crossings counts: the first ahead of the origin whose side is seen. A ray enters through
// the front and leaves through the back.
crossing first_ahead(ray r, ints found, reals enter, reals leave, uint flags) {
    const ints front = mask(!HAS_ONE_SIDED || !(flags & FLAG_FRONT_HIDDEN));
    const ints back = mask(!HAS_ONE_SIDED || !(flags & FLAG_BACK_HIDDEN));
    const ints entering = front & is_ahead(r, enter);
    crossing c;
    c.found = found & (entering | back);
    c.distance = entering ? enter : leave;
    c.u = c.v = splat(0);
    return c;
}

// Whether a crossing is nearer than the best hit; equal distances go to the lower primitive number.
ints is_nearer(ray r, hit best, ints active, crossing c, ints number) {
    return active & c.found & is_ahead(r, c.distance) &
           ((c.distance < best.distance) | ((c.distance == best.distance) & (number < best.primitive)));
}

hit choose_crossing(ints m, crossing c, ints number, hit other) {
    other.distance = m ? c.distance : other.distance;
    other.primitive = m ? number : other.primitive;
    other.u = m ? c.u : other.u;
    other.v = m ? c.v : other.v;
    return other;
}

// The surface at a hit: the point, its rounding error per coordinate, the outward geometric normal and the shading normal
// (both of length 1). `lift`: from the point up to the surface that its shading normals describe, on the ray's side.
typedef struct {
    vectors point, error, normal, shading;
#if HAS_TERMINATOR
    vectors lift;
#endif
} surface;
