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
    global const uint4 *polygon_ranges; // first corner, number of corners
    global const real4 *corners;
    global const cone *cones;
    global const node *nodes;
    global const uint4 *links;
    global const uint *order; // primitive numbers, leaf by leaf
    global const material *materials;
    global const light *lights;
    uint4 count; // lights, bounded primitives, nodes, planes
} scene;

bounds triangle_bounds(real4 a, real4 b, real4 c) {
    bounds box;
    box.low = min(min(a, b), c);
    box.high = max(max(a, b), c);
    return box;
}

crossing intersect_bounded(const scene *s, ray r, uint4 primitive) {
    const uint index = primitive.y, flags = primitive.w;
    crossing c;
    c.found = mask(false);
    c.distance = c.u = c.v = splat(0);
    bounds box;
    box.low = box.high = (real4)(0);
    switch (primitive.x) {
#if HAS_SPHERE
    case KIND_SPHERE: {
        const sphere a = s->spheres[index];
        c = intersect_sphere(r, splat_xyz(a.centre_radius), splat(a.centre_radius.w), flags);
        box = a.bounds;
        break;
    }
#endif
#if HAS_DISC
    case KIND_DISC: {
        const disc a = s->discs[index];
        c = intersect_disc(r, splat_xyz(a.centre_radius), splat_xyz(a.normal), splat(a.centre_radius.w), flags);
        box = a.bounds;
        break;
    }
#endif
#if HAS_BOX
    case KIND_BOX: {
        box = s->boxes[index].bounds;
        c = intersect_box(r, splat_xyz(box.low), splat_xyz(box.high), flags);
        break;
    }
#endif
#if HAS_TRIANGLE
    case KIND_TRIANGLE: {
        const uint4 t = s->triangles[index];
        const real4 v0 = s->vertices[t.x], v1 = s->vertices[t.y], v2 = s->vertices[t.z];
        c = intersect_triangle(r, splat_xyz(v0), splat_xyz(v1), splat_xyz(v2), flags);
        box = triangle_bounds(v0, v1, v2);
        break;
    }
#endif
#if HAS_POLYGON
    case KIND_POLYGON: {
        const polygon a = s->polygons[index];
        const uint4 range = s->polygon_ranges[index];
        c = intersect_polygon(r, s->corners + range.x, range.y, splat_xyz(a.point), splat_xyz(a.normal), flags);
        box = a.bounds;
        break;
    }
#endif
#if HAS_CONE
    case KIND_CONE: {
        const cone a = s->cones[index];
        const frustum f = make_frustum(splat_quads(a.base_radius), splat_quads(a.u_height), splat_quads(a.v_slope),
                                       splat_quads(a.axis));
        c = intersect_cone(r, f, flags);
        box = a.bounds;
        break;
    }
#endif
    }
    return any_lane(c.found) ? clamp_crossing(r, box, c) : c;
}

crossing intersect_unbounded(const scene *s, ray r, uint4 primitive) {
    const plane a = s->planes[primitive.y];
    return intersect_plane(r, splat_xyz(a.point), splat_xyz(a.normal), primitive.w);
}

surface choose_surface(ints m, surface a, surface b) {
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

identity identify(const scene *s, ints active, hit h) {
    identity id;
    for (int lane = 0; lane < LANES; lane++) {
        const uint4 p = s->primitives[INT_LANE(active, lane) ? INT_LANE(h.primitive, lane) : 0];
        INT_LANE(id.kind, lane) = p.x;
        INT_LANE(id.index, lane) = p.y;
        INT_LANE(id.material, lane) = p.z;
        INT_LANE(id.flags, lane) = p.w;
    }
    return id;
}

#if HAS_TRIANGLE
surface surface_of_triangles(const scene *s, hit h, ints index, ints smooth) {
    vectors v[3], n[3];
    for (int lane = 0; lane < LANES; lane++) {
        const uint4 t = s->triangles[INT_LANE(index, lane)];
        const uint corner[3] = {t.x, t.y, t.z};
        for (int i = 0; i < 3; i++) {
            const real4 p = s->vertices[corner[i]];
            REAL_LANE(v[i].x, lane) = p.x;
            REAL_LANE(v[i].y, lane) = p.y;
            REAL_LANE(v[i].z, lane) = p.z;
#if HAS_SMOOTH
            const real4 q = INT_LANE(smooth, lane) ? s->normals[corner[i]] : (real4)(0, 0, 1, 0);
            REAL_LANE(n[i].x, lane) = q.x;
            REAL_LANE(n[i].y, lane) = q.y;
            REAL_LANE(n[i].z, lane) = q.z;
#endif
        }
    }
    surface f = surface_triangle(v[0], v[1], v[2], h.u, h.v);
#if HAS_SMOOTH
    const vectors sum = interpolate(n[0], n[1], n[2], h.u, h.v);
    const ints usable = smooth & (dot3(sum, sum) > splat(0));
    vectors normal = normalise(sum);
    normal = choose(dot3(normal, f.normal) < splat(0), negate(normal), normal);
    f.shading = choose(usable, normal, f.normal);
#endif
    return f;
}
#endif

// The surface at each lane's hit, kind by kind; lanes that are not active get a harmless one.
surface find_surface(const scene *s, ray r, hit h, ints active, identity id) {
    surface f;
    f.point = r.origin;
    f.error = where(mask(false), r.origin);
    f.normal = f.shading = make_vectors(splat(0), splat(0), splat(1));
#define LANES_OF(KIND) (active & (id.kind == whole(KIND)))
#define INDEX_OF(m) ((m) ? id.index : whole(0))
    ints m;
#if HAS_SPHERE
    m = LANES_OF(KIND_SPHERE);
    if (any_lane(m)) {
        const quads q = GATHER(s->spheres, INDEX_OF(m), centre_radius);
        f = choose_surface(m, surface_sphere(r, h.distance, q.xyz, q.w), f);
    }
#endif
#if HAS_PLANE
    m = LANES_OF(KIND_PLANE);
    if (any_lane(m)) {
        const quads point = GATHER(s->planes, INDEX_OF(m), point), normal = GATHER(s->planes, INDEX_OF(m), normal);
        f = choose_surface(m, surface_plane(r, h.distance, point.xyz, normal.xyz), f);
    }
#endif
#if HAS_DISC
    m = LANES_OF(KIND_DISC);
    if (any_lane(m)) {
        const quads point = GATHER(s->discs, INDEX_OF(m), centre_radius),
                    normal = GATHER(s->discs, INDEX_OF(m), normal);
        f = choose_surface(m, surface_plane(r, h.distance, point.xyz, normal.xyz), f);
    }
#endif
#if HAS_BOX
    m = LANES_OF(KIND_BOX);
    if (any_lane(m)) {
        const quads low = GATHER(s->boxes, INDEX_OF(m), bounds.low), high = GATHER(s->boxes, INDEX_OF(m), bounds.high);
        f = choose_surface(m, surface_box(r, h.distance, low.xyz, high.xyz), f);
    }
#endif
#if HAS_TRIANGLE
    m = LANES_OF(KIND_TRIANGLE);
    if (any_lane(m))
        f = choose_surface(m, surface_of_triangles(s, h, INDEX_OF(m), m & ((id.flags & (integer)FLAG_SMOOTH) != 0)), f);
#endif
#if HAS_POLYGON
    m = LANES_OF(KIND_POLYGON);
    if (any_lane(m)) {
        const quads point = GATHER(s->polygons, INDEX_OF(m), point), normal = GATHER(s->polygons, INDEX_OF(m), normal);
        f = choose_surface(m, surface_plane(r, h.distance, point.xyz, normal.xyz), f);
    }
#endif
#if HAS_CONE
    m = LANES_OF(KIND_CONE);
    if (any_lane(m)) {
        const ints i = INDEX_OF(m);
        const frustum cone = make_frustum(GATHER(s->cones, i, base_radius), GATHER(s->cones, i, u_height),
                                          GATHER(s->cones, i, v_slope), GATHER(s->cones, i, axis));
        f = choose_surface(m, surface_cone(r, h.distance, h.u, cone), f);
    }
#endif
    return f;
}
