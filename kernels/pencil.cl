// pencil.cl - a ray with all that rounding may have made of it, and quantities in bounds of their rounding errors. Only for the
// margin (margin.cl), where there is one ray and one lane.
#if MARGIN

#define LIMIT R(16) // more than this is certain

// A ray and how far rounding may have moved it: `origin` and `direction` are what their coordinates may be off by.
typedef struct {
    ray ray;
    vectors origin, direction;
    integer source, source_inside; // the primitive that it leaves, -1 for none; in an instance, the one inside
} pencil;

// Where a surface is passed, at a distance that is known to within `error`. there: how sure it is that the primitive's edges
// and silhouettes let the ray through there, in bounds; negative where they do not.
typedef struct {
    real distance, error, there;
} passage;

#define MOST_PASSAGES 4

// A quantity in bounds. What has no bound is not known at all.
real in_bounds(real quantity, real bound) {
    if (bound > R(0))
        return bound < R(INFINITY) ? quantity / bound : R(0);
    return quantity > R(0) ? R(INFINITY) : (quantity < R(0) ? -R(INFINITY) : R(0));
}

real length_of(vectors a) {
    return sqrt(dot3(a, a));
}

// How far from where it should be the ray's point at this distance may be, per coordinate.
vectors blur_at(const pencil *p, real distance) {
    return along(p->origin, p->direction, fabs(distance));
}

// What a point that was packed may be off by.
vectors blur_of_point(vectors point) {
    return scale(absolute(point), GAMMA(1));
}

passage make_passage(real distance, real error, real there) {
    const bool known = fabs(distance) < R(INFINITY) && error < R(INFINITY);
    const passage c = {known ? distance : R(0), known ? error : R(INFINITY), there};
    return c;
}
#endif
