// tree.cl - the nearest hit and whether there is any, through the tree or over every primitive.

hit try_primitive(const scene *s, ray r, ints active, hit best, uint number) {
    const ray facing = face_primitive(r, number);
    return nearer(facing, best, active, intersect_bounded(s, facing, s->primitives[number]), number);
}

// Lanes that still look: all for the nearest hit, those without one where any will do.
ints still_looking(ints active, hit best, bool any) {
    return any ? active & (best.primitive < 0) : active;
}

// The nearest hit before `limit`, for the active lanes. With `any`, whichever comes first: only whether there is one counts.
hit traverse(const scene *s, ray r, ints active, reals limit, bool any) {
    hit best;
    best.distance = limit;
    best.primitive = whole(-1);
    best.u = best.v = splat(0);
#if HAS_PLANE
    for (uint i = 0; i < s->count.w; i++) {
        const uint number = s->order[s->count.y + i];
        best =
            nearer(face_primitive(r, number), best, active, intersect_unbounded(s, r, s->primitives[number]), number);
    }
#endif
#if HAS_TREE
    for (uint i = 0; i < s->count.z;) {
        const bounds box = s->nodes[i].bounds;
        const uint4 link = s->links[i];
        const interval in = intersect_bounds(r, splat_xyz(box.low), splat_xyz(box.high));
        const ints want =
            still_looking(active, best, any) & (in.near <= in.far) & (in.far > splat(0)) & (in.near <= best.distance);
        const bool enter = any_lane(want);
        for (uint k = 0; enter && k < link.z; k++)
            best = try_primitive(s, r, want, best, s->order[link.y + k]);
        i = enter ? i + 1 : link.x;
    }
#else
    for (uint k = 0; k < s->count.y; k++)
        best = try_primitive(s, r, active, best, s->order[k]);
#endif
    return best;
}

hit closest_hit(const scene *s, ray r, ints active) {
    return traverse(s, r, active, splat(INFINITY), false);
}

ints any_hit(const scene *s, ray r, ints active, reals limit) {
    return active & (traverse(s, r, active, limit, true).primitive >= 0);
}
