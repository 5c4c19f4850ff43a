// block.cl - a leaf's primitives, all of one kind, against the ray or rays.
//
// One ray meets as many primitives at a time as there are lanes; many rays meet one primitive after another.
#if RAYS == 1
#define STEP LANES
#else
#define STEP 1
#endif

// The entries k ... of one of a block's fields, or entry k for every ray.
reals load_field(global const real *block, uint field, uint k) {
#if RAYS == 1
    return *(global const reals *)(block + field * WIDTH + k);
#else
    return splat(block[field * WIDTH + k]);
#endif
}

vectors load_fields(global const real *block, uint field, uint k) {
    return make_vectors(load_field(block, field, k), load_field(block, field + 1, k), load_field(block, field + 2, k));
}

ints load_numbers(global const uint *numbers, uint k) {
#if RAYS == 1
    ints n;
    for (int lane = 0; lane < LANES; lane++)
        INT_LANE(n, lane) = numbers[k + lane];
    return n;
#else
    return whole(numbers[k]);
#endif
}

#if RAYS == 1
// The nearest of the lanes' crossings, in every lane; equal distances go to the lowest primitive number.
hit nearest_lane(hit best) {
    hit one = best;
    for (int lane = 1; lane < LANES; lane++) {
        const real distance = REAL_LANE(best.distance, lane);
        const integer number = INT_LANE(best.primitive, lane);
        const bool better = distance < REAL_LANE(one.distance, 0) ||
                            (distance == REAL_LANE(one.distance, 0) && number < INT_LANE(one.primitive, 0));
        if (better) {
            REAL_LANE(one.distance, 0) = distance;
            INT_LANE(one.primitive, 0) = number;
            REAL_LANE(one.u, 0) = REAL_LANE(best.u, lane);
            REAL_LANE(one.v, 0) = REAL_LANE(best.v, lane);
        }
    }
    one.distance = splat(REAL_LANE(one.distance, 0));
    one.primitive = whole(INT_LANE(one.primitive, 0));
    one.u = splat(REAL_LANE(one.u, 0));
    one.v = splat(REAL_LANE(one.v, 0));
    return one;
}
#endif

// Takes crossings into account; their bounds come last, because few are found.
hit take_crossings(ray r, ints active, hit best, crossing c, vectors low, vectors high, ints numbers) {
    c.found &= active & (c.distance > splat(0));
    if (!any_lane(c.found))
        return best;
    c = clamp_crossing(r, low, high, c);
    const hit found = nearer(r, best, active, c, numbers);
#if RAYS == 1
    return any_lane(found.primitive != best.primitive) ? nearest_lane(found) : best;
#else
    return found;
#endif
}

#if HAS_SPHERE
hit try_spheres(const ray *around, ints active, hit best, global const real *block, global const uint *numbers,
                uint flags) {
    for (uint k = 0; k < WIDTH; k += STEP) {
        if (STEP == 1 && k > 0 && numbers[k] == numbers[k - 1])
            break;
        const ints number = load_numbers(numbers, k);
        const ray r = face_primitive(*around, number);
        const crossing c = intersect_sphere(r, load_fields(block, 0, k), load_field(block, 3, k), flags);
        best = take_crossings(r, active, best, c, load_fields(block, 4, k), load_fields(block, 7, k), number);
    }
    return best;
}
#endif

#if HAS_DISC
hit try_discs(const ray *around, ints active, hit best, global const real *block, global const uint *numbers,
              uint flags) {
    for (uint k = 0; k < WIDTH; k += STEP) {
        if (STEP == 1 && k > 0 && numbers[k] == numbers[k - 1])
            break;
        const ints number = load_numbers(numbers, k);
        const ray r = face_primitive(*around, number);
        const crossing c =
            intersect_disc(r, load_fields(block, 0, k), load_fields(block, 4, k), load_field(block, 3, k), flags);
        best = take_crossings(r, active, best, c, load_fields(block, 7, k), load_fields(block, 10, k), number);
    }
    return best;
}
#endif

#if HAS_BOX
hit try_boxes(const ray *around, ints active, hit best, global const real *block, global const uint *numbers,
              uint flags) {
    for (uint k = 0; k < WIDTH; k += STEP) {
        if (STEP == 1 && k > 0 && numbers[k] == numbers[k - 1])
            break;
        const ints number = load_numbers(numbers, k);
        const ray r = face_primitive(*around, number);
        const vectors low = load_fields(block, 0, k), high = load_fields(block, 3, k);
        best = take_crossings(r, active, best, intersect_box(r, low, high, flags), low, high, number);
    }
    return best;
}
#endif

#if HAS_TRIANGLE
hit try_triangles(const ray *around, ints active, hit best, global const real *block, global const uint *numbers,
                  uint flags) {
    for (uint k = 0; k < WIDTH; k += STEP) {
        if (STEP == 1 && k > 0 && numbers[k] == numbers[k - 1])
            break;
        const ints number = load_numbers(numbers, k);
        const ray r = face_primitive(*around, number);
        const vectors a = load_fields(block, 0, k), b = load_fields(block, 3, k), c = load_fields(block, 6, k);
        const crossing x = intersect_triangle(r, a, b, c, flags);
        const vectors low = least_xyz(least_xyz(a, b), c), high = greatest_xyz(greatest_xyz(a, b), c);
        best = take_crossings(r, active, best, x, low, high, number);
    }
    return best;
}
#endif

#if HAS_CONE
hit try_cones(const ray *around, ints active, hit best, global const real *block, global const uint *numbers,
              uint flags) {
    for (uint k = 0; k < WIDTH; k += STEP) {
        if (STEP == 1 && k > 0 && numbers[k] == numbers[k - 1])
            break;
        const ints number = load_numbers(numbers, k);
        const ray r = face_primitive(*around, number);
        frustum f;
        f.base = load_fields(block, 0, k);
        f.u = load_fields(block, 3, k);
        f.v = load_fields(block, 6, k);
        f.axis = load_fields(block, 9, k);
        f.radius = load_field(block, 12, k);
        f.height = load_field(block, 13, k);
        f.slope = load_field(block, 14, k);
        best = take_crossings(r, active, best, intersect_cone(r, f, flags), load_fields(block, 15, k),
                              load_fields(block, 18, k), number);
    }
    return best;
}
#endif

#if HAS_POLYGON
// Polygons have too many corners to go side by side: one after another, where its bounds are met.
hit try_polygons(const scene *s, const ray *around, ints active, hit best, global const real *block,
                 global const uint *numbers, uint flags) {
    for (uint k = 0; k < WIDTH; k++) {
        if (k > 0 && numbers[k] == numbers[k - 1])
            break;
        const ints number = whole(numbers[k]);
        const ray r = face_primitive(*around, number);
        const vectors low = make_vectors(splat(block[k]), splat(block[WIDTH + k]), splat(block[2 * WIDTH + k]));
        const vectors high =
            make_vectors(splat(block[3 * WIDTH + k]), splat(block[4 * WIDTH + k]), splat(block[5 * WIDTH + k]));
        const interval i = intersect_bounds(r, low, high);
        const ints met = active & (i.near <= i.far) & (i.far > splat(0)) & (i.near <= best.distance);
        if (!any_ray(met))
            continue;
        const uint index = s->primitives[numbers[k]].y;
        const uint4 range = s->polygon_ranges[index];
        const polygon p = s->polygons[index];
        const crossing c =
            intersect_polygon(r, s->corners + range.x, range.y, splat_xyz(p.point), splat_xyz(p.normal), flags);
        best = nearer(r, best, met, clamp_crossing(r, low, high, c), number);
    }
    return best;
}
#endif

hit try_block(const scene *s, const ray *r, ints active, hit best, uint place, uint tag) {
    global const real *block = s->blocks + (size_t)place * WIDTH;
    global const uint *numbers = s->block_numbers + (tag & TAG_NUMBER) * WIDTH;
    const uint flags = (tag >> TAG_FLAGS) & 31;
    switch (tag >> TAG_KIND) {
#if HAS_SPHERE
    case KIND_SPHERE:
        return try_spheres(r, active, best, block, numbers, flags);
#endif
#if HAS_DISC
    case KIND_DISC:
        return try_discs(r, active, best, block, numbers, flags);
#endif
#if HAS_BOX
    case KIND_BOX:
        return try_boxes(r, active, best, block, numbers, flags);
#endif
#if HAS_TRIANGLE
    case KIND_TRIANGLE:
        return try_triangles(r, active, best, block, numbers, flags);
#endif
#if HAS_POLYGON
    case KIND_POLYGON:
        return try_polygons(s, r, active, best, block, numbers, flags);
#endif
#if HAS_CONE
    case KIND_CONE:
        return try_cones(r, active, best, block, numbers, flags);
#endif
    default:
        return best;
    }
}
