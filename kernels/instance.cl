// instance.cl - groups that are placed in the world, and rays as those in the group see them.
//
// A ray's origin is L^-1 (o - offset), L the linear part: with the difference first, what rounding takes is relative to the
// distance from the instance and not to its place in the world. Its direction L^-1 d is not made length 1 but divided by a
// power of two, so that distances are the world's times that power, exactly.

typedef struct {
    rows to_object, to_world;
    vectors offset;
    ints turned;              // unless the linear part is the identity
    reals unit, inverse_unit; // a distance in the group over that in the world, and the reverse
} placement;

placement find_placement(const scene *s, ints index) {
    const quads x = GATHER(s->instances, index, to_world_x), y = GATHER(s->instances, index, to_world_y),
                z = GATHER(s->instances, index, to_world_z);
    const quads u = GATHER(s->instances, index, to_object_x), v = GATHER(s->instances, index, to_object_y),
                w = GATHER(s->instances, index, to_object_z);
    placement at;
    at.to_world.x = x.xyz;
    at.to_world.y = y.xyz;
    at.to_world.z = z.xyz;
    at.offset = make_vectors(x.w, y.w, z.w);
    at.to_object.x = u.xyz;
    at.to_object.y = v.xyz;
    at.to_object.z = w.xyz;
    at.turned = u.w != splat(0);
    at.unit = v.w;
    at.inverse_unit = w.w;
    return at;
}

rows absolute_rows(rows m) {
    m.x = absolute(m.x);
    m.y = absolute(m.y);
    m.z = absolute(m.z);
    return m;
}

// A normal of the group in the world, by the inverse's transpose: outside stays outside where the transform mirrors.
vectors turn_normal(const placement *at, vectors n) {
    return choose(at->turned, normalise(apply_transposed(at->to_object, n)), n);
}

// The ray in the space of the group; its steps are still the world's.
ray move_ray(const placement *at, const ray *r) {
    const vectors origin = sub(r->origin, at->offset);
    const vectors direction = scale(apply(at->to_object, r->direction), at->inverse_unit);
    return make_ray(choose(at->turned, apply(at->to_object, origin), origin),
                    choose(at->turned, direction, r->direction));
}

// A surface of the group in the world. The error holds what the way here takes and what the way of the next ray back into
// the group will take (pbrt 4th ed., 6.8.5): each a product with a rounded matrix, and a sum with the offset.
surface place_surface(const placement *at, surface f) {
    const vectors turned = choose(at->turned, apply(at->to_world, f.point), f.point);
    const vectors size = absolute(f.point), zero = make_vectors(splat(0), splat(0), splat(0));
    const rows out = absolute_rows(at->to_world), back = absolute_rows(at->to_object);
    const vectors inside = add(f.error, scale(add(size, apply(back, apply(out, size))), splat(GAMMA(5))));
    f.error = choose(at->turned, apply(out, inside), f.error);
    f.point = add(turned, at->offset);
    const vectors sum = scale(add(absolute(f.point), absolute(turned)), splat(R(2) * UNIT));
    f.error.x += at->offset.x != splat(0) ? sum.x : zero.x;
    f.error.y += at->offset.y != splat(0) ? sum.y : zero.y;
    f.error.z += at->offset.z != splat(0) ? sum.z : zero.z;
    f.normal = f.shading = turn_normal(at, f.normal);
    return f;
}

#if HAS_INSTANCE
// Rays in an instance: those that meet its box, and what they have found so far.
typedef struct {
    ints active;
    ray ray;
    hit best;
    reals inverse_unit;
} visit;

// Larger than any primitive's number.
#define MOST_NUMBER 0x7fffffff

// Numbers compare as the instance's own does: what was found in something that comes later loses against all in here. All
// numbers in a group are above 0.
visit enter_instance(const scene *s, const ray *r, ints active, hit best, integer number) {
    const uint index = s->primitives[number].y;
    const placement at = find_placement(s, whole(index));
    const bounds b = s->instances[index].bounds;
    const interval in = intersect_bounds(*r, splat_xyz(b.low), splat_xyz(b.high));
    visit v;
    v.active = active & (in.near <= in.far) & (in.near <= best.distance) & (in.far >= r->least);
    v.ray = move_ray(&at, r);
    v.ray.least = r->least * at.unit;
    v.ray.in_near = in.near * at.unit;
    v.ray.in_far = in.far * at.unit;
    const ints passed = (r->last >= 0) & (r->last < number);
    v.ray.last = r->last == whole(number) ? r->last_inside : (passed ? whole(0) : whole(-1));
    v.best = no_hit(min(best.distance * at.unit, splat(FARTHEST)));
    v.best.primitive = best.primitive > number ? whole(MOST_NUMBER) : whole(-1);
    v.inverse_unit = at.inverse_unit;
    return v;
}

hit leave_instance(const visit *v, hit best, integer number) {
    const ints found = v->active & (v->best.primitive >= 0) & (v->best.primitive != whole(MOST_NUMBER));
    best.distance = found ? v->best.distance * v->inverse_unit : best.distance;
    best.primitive = found ? whole(number) : best.primitive;
    best.inside = found ? v->best.primitive : best.inside;
    best.u = found ? v->best.u : best.u;
    best.v = found ? v->best.v : best.v;
    return best;
}
#endif
