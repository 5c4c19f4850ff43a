// primitive.cl - the surface of what a ray has hit: which function serves which kind.

crossing intersect_unbounded(const scene *s, ray r, uint4 primitive) {
    const plane a = s->planes[primitive.y];
    return intersect_plane(r, splat_xyz(a.point), splat_xyz(a.normal), primitive.w);
}

INLINE surface choose_surface(ints m, surface a, surface b) {
    a.point = choose(m, a.point, b.point);
    a.error = choose(m, a.error, b.error);
    a.normal = choose(m, a.normal, b.normal);
    a.shading = choose(m, a.shading, b.shading);
#if HAS_TERMINATOR
    a.lift = choose(m, a.lift, b.lift);
#endif
    return a;
}

#if HAS_TRIANGLE
// A real4 of the triangles' corners, `word` telling which corner.
vectors gather_corner(const scene *s, global const real4 *from, ints index, int corner, ints wanted) {
    const integer some = INT_LANE(index, 0);
    if (!any_ray(wanted & (index != whole(some)))) // most often all rays are at the same triangle
        return splat_xyz(from[((global const uint *)(s->triangles + some))[corner]]);
    ints at = whole(0);
    for (int lane = 0; lane < RAYS; lane++)
        if (INT_LANE(wanted, lane))
            INT_LANE(at, lane) = ((global const uint *)(s->triangles + INT_LANE(index, lane)))[corner];
    return gather((global const real *)from, at, sizeof(real4) / sizeof(real)).xyz;
}

surface surface_of_triangles(const scene *s, const ray *r, const hit *h, ints index) {
    vectors v[3];
    for (int i = 0; i < 3; i++)
        v[i] = gather_corner(s, s->vertices, index, i, mask(true));
    return surface_triangle(*r, v[0], v[1], v[2], h->u, h->v);
}
#endif

#if HAS_SMOOTH
// A corner's normal. In an instance they are turned one by one, as those of a mesh that is moved itself.
vectors gather_normal(const scene *s, ints index, int corner, ints smooth, const placement *at, ints inside) {
    const vectors n = gather_corner(s, s->normals, index, corner, smooth);
#if HAS_INSTANCE
    return choose(inside, turn_normal(at, n), n);
#else
    return n;
#endif
}

// The interpolated normal, on the side of the triangle's own.
vectors shading_of_triangles(const scene *s, const hit *h, ints index, ints smooth, vectors normal, const placement *at,
                             ints inside) {
    vectors n[3];
    for (int i = 0; i < 3; i++)
        n[i] = gather_normal(s, index, i, smooth, at, inside);
    const vectors sum = interpolate(n[0], n[1], n[2], h->u, h->v);
    const ints usable = smooth & (dot3(sum, sum) > splat(0));
    vectors mean = normalise(sum);
    mean = choose(dot3(mean, normal) < splat(0), negate(mean), mean);
    return choose(usable, mean, normal);
}
#endif

#if HAS_TERMINATOR
// From a point up to the mean of its projections onto the corners' tangent planes, weighted as the corners are; planes below
// it count as at it (Hanika 2021, Hacking the Shadow Terminator). All is above on the side of `normal`, or 0.
vectors lift_of_triangles(const scene *s, const hit *h, ints index, ints smooth, vectors normal, const placement *at,
                          ints inside) {
    vectors v[3], n[3];
    for (int i = 0; i < 3; i++) {
        v[i] = gather_corner(s, s->vertices, index, i, smooth);
        n[i] = gather_normal(s, index, i, smooth, at, inside);
    }
    const ints below = dot3(interpolate(n[0], n[1], n[2], h->u, h->v), normal) < splat(0);
    const vectors a = sub(v[1], v[0]), b = sub(v[2], v[0]);
    const vectors first = negate(along(scale(a, h->u), b, h->v)); // from the point to the corners
    const vectors to[3] = {first, add(first, a), add(first, b)};
    const reals weight[3] = {splat(1) - h->u - h->v, h->u, h->v};
    vectors lift = where(mask(false), normal);
    for (int i = 0; i < 3; i++) {
#if HAS_INSTANCE
        const vectors way = choose(inside, apply(at->to_world, to[i]), to[i]);
#else
        const vectors way = to[i];
#endif
        const vectors up = choose(below, negate(n[i]), n[i]);
        lift = along(lift, up, weight[i] * max(dot3(way, up), splat(0)));
    }
    return where(smooth & (dot3(lift, normal) > splat(0)), lift);
}
#endif

// The index where m, else one of these: no lane asks for what is not there.
ints index_where(ints m, ints index) {
    return m ? index : whole(INT_LANE(index, lowest_bit(lane_bits(m))));
}

// The surface at each lane's hit in the space where it is met, kind by kind; lanes that are not active get a harmless one.
// `length`: the direction's.
INLINE surface find_own_surface(const scene *s, const ray *r, const hit *h, ints active, const identity *id,
                                reals length) {
    surface f;
    f.point = r->origin;
    f.error = where(mask(false), r->origin);
    f.normal = f.shading = make_vectors(splat(0), splat(0), splat(1));
#define LANES_OF(KIND) (active & (id->kind == whole(KIND)))
#define INDEX_OF(m) index_where(m, id->index)
    ints m;
#if HAS_SPHERE
    m = LANES_OF(KIND_SPHERE);
    if (any_ray(m)) {
        const quads q = GATHER(s->spheres, INDEX_OF(m), centre_radius);
        ray unit = *r;
        unit.direction = scale(r->direction, splat(1) / length);
        f = choose_surface(m, surface_sphere(unit, h->distance * length, q.xyz, q.w), f);
    }
#endif
#if HAS_PLANE
    m = LANES_OF(KIND_PLANE);
    if (any_ray(m)) {
        const quads point = GATHER(s->planes, INDEX_OF(m), point), normal = GATHER(s->planes, INDEX_OF(m), normal);
        f = choose_surface(m, surface_plane(*r, h->distance, point.xyz, normal.xyz), f);
    }
#endif
#if HAS_DISC
    m = LANES_OF(KIND_DISC);
    if (any_ray(m)) {
        const quads point = GATHER(s->discs, INDEX_OF(m), centre_radius),
                    normal = GATHER(s->discs, INDEX_OF(m), normal);
        f = choose_surface(m, surface_plane(*r, h->distance, point.xyz, normal.xyz), f);
    }
#endif
#if HAS_BOX
    m = LANES_OF(KIND_BOX);
    if (any_ray(m)) {
        const quads low = GATHER(s->boxes, INDEX_OF(m), bounds.low), high = GATHER(s->boxes, INDEX_OF(m), bounds.high);
        f = choose_surface(m, surface_box(*r, h->distance, low.xyz, high.xyz), f);
    }
#endif
#if HAS_TRIANGLE
    m = LANES_OF(KIND_TRIANGLE);
    if (any_ray(m))
        f = choose_surface(m, surface_of_triangles(s, r, h, INDEX_OF(m)), f);
#endif
#if HAS_POLYGON
    m = LANES_OF(KIND_POLYGON);
    if (any_ray(m)) {
        const quads point = GATHER(s->polygons, INDEX_OF(m), point), normal = GATHER(s->polygons, INDEX_OF(m), normal);
        f = choose_surface(m, surface_plane(*r, h->distance, point.xyz, normal.xyz), f);
    }
#endif
#if HAS_CONE
    m = LANES_OF(KIND_CONE);
    if (any_ray(m)) {
        const ints i = INDEX_OF(m);
        const frustum cone = make_frustum(GATHER(s->cones, i, base_radius), GATHER(s->cones, i, u_height),
                                          GATHER(s->cones, i, v_slope), GATHER(s->cones, i, axis));
        f = choose_surface(m, surface_cone(*r, h->distance, h->u, cone), f);
    }
#endif
    return f;
}

surface find_surface(const scene *s, const ray *r, const hit *h, ints active, const identity *id) {
    placement at;
    ray around = *r;
    hit met = *h;
    ints inside = mask(false);
    reals length = splat(1);
#if HAS_INSTANCE
    inside = active & (id->instance >= 0);
    if (any_ray(inside)) {
        at = find_placement(s, index_where(inside, id->instance));
        const ray moved = move_ray(&at, r);
        around.origin = choose(inside, moved.origin, r->origin);
        around.direction = choose(inside, moved.direction, r->direction);
        around.inverse = choose(inside, moved.inverse, r->inverse);
        met.distance = inside ? h->distance * at.unit : h->distance;
        length = inside & at.turned ? sqrt(dot3(around.direction, around.direction)) : length;
    }
#endif
    surface f = find_own_surface(s, &around, &met, active, id, length);
#if HAS_INSTANCE
    if (any_ray(inside))
        f = choose_surface(inside, place_surface(&at, f), f);
#endif
#if HAS_SMOOTH
    const ints smooth = LANES_OF(KIND_TRIANGLE) & ((id->flags & (integer)FLAG_SMOOTH) != 0);
    if (any_ray(smooth))
        f.shading =
            choose(smooth, shading_of_triangles(s, h, index_where(smooth, id->index), smooth, f.normal, &at, inside),
                   f.shading);
#endif
#if HAS_TERMINATOR
    f.lift = where(mask(false), f.normal);
    if (any_ray(smooth)) {
        const vectors facing = choose(dot3(f.normal, r->direction) < splat(0), f.normal, negate(f.normal));
        f.lift = lift_of_triangles(s, h, index_where(smooth, id->index), smooth, facing, &at, inside);
    }
#endif
    return f;
}
