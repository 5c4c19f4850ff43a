// primitive.cl - the scene's primitives on the device, and which function serves which.

typedef struct {
    global const uint4 *primitives; // kind, index among its kind, material, flags
    global const sphere *spheres;
    global const plane *planes;
    global const disc *discs;
    global const box *boxes;
    global const uint4 *triangles; // three indices into vertices and normals
    global const real4 *vertices;
    global const real4 *normals;
    global const polygon *polygons;
    global const uint4 *polygon_ranges; // first row, number of corners
    global const real *corners;         // rows of WIDTH
    global const cone *cones;
    global const node *nodes;
    global const uint2 *links;
    global const real *blocks;
    global const uint *block_numbers; // WIDTH primitive numbers for each block, then the planes' numbers
    global const material *materials;
    global const light *lights;
    uint4 count; // lights, blocks, nodes, planes
} scene;

crossing intersect_unbounded(const scene *s, ray r, uint4 primitive) {
    const plane a = s->planes[primitive.y];
    return intersect_plane(r, splat_xyz(a.point), splat_xyz(a.normal), primitive.w);
}

INLINE surface choose_surface(ints m, surface a, surface b) {
    a.point = choose(m, a.point, b.point);
    a.error = choose(m, a.error, b.error);
    a.normal = choose(m, a.normal, b.normal);
    a.shading = choose(m, a.shading, b.shading);
    return a;
}

// The material and flags of the primitives hit.
typedef struct {
    ints kind, index, material, flags;
} identity;

identity identify(const scene *s, ints active, const hit *h) {
    identity id;
#if RAYS == 1
    const uint4 p = s->primitives[INT_LANE(active, 0) ? INT_LANE(h->primitive, 0) : 0];
    id.kind = whole(p.x);
    id.index = whole(p.y);
    id.material = whole(p.z);
    id.flags = whole(p.w);
#else
    const uint bits = lane_bits(active);
    const integer some = bits ? INT_LANE(h->primitive, lowest_bit(bits)) : 0;
    const ints number = active ? h->primitive : whole(some); // the same as another's where there is none
    if (!any_lane(number != whole(some))) {
        const uint4 p = s->primitives[some];
        id.kind = whole(p.x);
        id.index = whole(p.y);
        id.material = whole(p.z);
        id.flags = whole(p.w);
        return id;
    }
    for (int lane = 0; lane < LANES; lane++) {
        const uint4 p = s->primitives[INT_LANE(number, lane)];
        INT_LANE(id.kind, lane) = p.x;
        INT_LANE(id.index, lane) = p.y;
        INT_LANE(id.material, lane) = p.z;
        INT_LANE(id.flags, lane) = p.w;
    }
#endif
    return id;
}

#if HAS_TRIANGLE
// A real4 of the triangles' corners, `word` telling which corner.
vectors gather_corner(const scene *s, global const real4 *from, ints index, int corner, ints wanted) {
    ints at = whole(0);
    for (int lane = 0; lane < RAYS; lane++)
        if (INT_LANE(wanted, lane))
            INT_LANE(at, lane) = ((global const uint *)(s->triangles + INT_LANE(index, lane)))[corner];
    return gather((global const real *)from, at, sizeof(real4) / sizeof(real)).xyz;
}

surface surface_of_triangles(const scene *s, const hit *h, ints index, ints smooth) {
    vectors v[3];
    for (int i = 0; i < 3; i++)
        v[i] = gather_corner(s, s->vertices, index, i, mask(true));
    surface f = surface_triangle(v[0], v[1], v[2], h->u, h->v);
#if HAS_SMOOTH
    if (!any_ray(smooth))
        return f;
    const vectors sum =
        interpolate(gather_corner(s, s->normals, index, 0, smooth), gather_corner(s, s->normals, index, 1, smooth),
                    gather_corner(s, s->normals, index, 2, smooth), h->u, h->v);
    const ints usable = smooth & (dot3(sum, sum) > splat(0));
    vectors normal = normalise(sum);
    normal = choose(dot3(normal, f.normal) < splat(0), negate(normal), normal);
    f.shading = choose(usable, normal, f.normal);
#endif
    return f;
}
#endif

// The index where m, else one of these: no lane asks for what is not there.
ints index_where(ints m, ints index) {
    return m ? index : whole(INT_LANE(index, lowest_bit(lane_bits(m))));
}

// The surface at each lane's hit, kind by kind; lanes that are not active get a harmless one.
surface find_surface(const scene *s, const ray *r, const hit *h, ints active, const identity *id) {
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
        f = choose_surface(m, surface_sphere(*r, h->distance, q.xyz, q.w), f);
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
        f = choose_surface(m, surface_of_triangles(s, h, INDEX_OF(m), m & ((id->flags & (integer)FLAG_SMOOTH) != 0)),
                           f);
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
