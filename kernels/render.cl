// render.cl - the entry points.

#define SCENE_PARAMETERS                                                                                               \
    global const uint4 *primitives, global const sphere *spheres, global const plane *planes,                          \
        global const disc *discs, global const box *boxes, global const uint4 *triangles,                              \
        global const real4 *vertices, global const real4 *normals, global const polygon *polygons,                     \
        global const uint4 *polygon_ranges, global const real *corners, global const cone *cones,                     \
        global const node *nodes, global const uint2 *links, global const real *blocks,                                \
        global const uint *block_numbers, global const material *materials, global const light *lights

#define SCENE_ARGUMENTS                                                                                                \
    {                                                                                                                  \
        primitives, spheres, planes, discs, boxes, triangles, vertices, normals, polygons, polygon_ranges, corners,    \
            cones, nodes, links, blocks, block_numbers, materials, lights, frame.count                                 \
    }

// One pixel per work-item; writes RGBA, the mean unsent weight per channel, and the tally, row by row of the tile.
kernel void render(SCENE_PARAMETERS, global const view *views, global const int *eye_media, const launch frame,
                   global real4 *pixels, global real4 *discarded, global tally *tallies) {
    const uint x = frame.tile.x + get_global_id(0), y = frame.tile.y + get_global_id(1);
    if (x >= frame.tile.z || y >= frame.tile.w)
        return;
    const scene s = SCENE_ARGUMENTS;
    const view camera = views[0];
    const uint samples = frame.frame.z;
    real4 colour = (real4)(0), unsent = (real4)(0);
    tally t = {(uint4)(0), (uint4)(0)};
    for (uint first = 0; first < samples; first += RAYS) {
        packet p;
        p.origin = splat_xyz(camera.eye);
        p.direction = eye_directions(&camera, x, y, first, frame.frame);
        p.weight = splat_xyz((real4)(1));
        p.depth = 1;
        for (int lane = 0; lane < LANES; lane++)
            INT_LANE(p.active, lane) = RAYS == 1 || first + lane < samples ? TRUE : 0;
#if HAS_TRANSMISSION
        for (int i = 0; i < MEDIA; i++)
            p.in.material[i] = whole(eye_media[i]);
#endif
        tree_sum sum = trace(&s, &camera, p, frame.frame.w);
        for (int lane = 0; lane < RAYS && first + lane < samples; lane++) {
            colour += (real4)(REAL_LANE(sum.colour.x, lane), REAL_LANE(sum.colour.y, lane),
                              REAL_LANE(sum.colour.z, lane), INT_LANE(sum.hits, lane) ? R(1) : R(0));
            unsent += (real4)(REAL_LANE(sum.discarded.x, lane), REAL_LANE(sum.discarded.y, lane),
                              REAL_LANE(sum.discarded.z, lane), R(0));
            t.rays += (uint4)(INT_LANE(sum.reflection, lane), INT_LANE(sum.transmission, lane),
                              INT_LANE(sum.shadow, lane), INT_LANE(sum.hits, lane) ? 1 : 0);
        }
        t.extreme.x = max(t.extreme.x, sum.deepest);
    }
    const size_t at = (size_t)(y - frame.tile.y) * (frame.tile.z - frame.tile.x) + (x - frame.tile.x);
    pixels[at] = colour / R(samples);
    discarded[at] = unsent / R(samples);
    tallies[at] = t;
}

// The media that the eye is in, outermost first: along any ray from it, the solids that are left without having been
// entered. One work-item.
kernel void find_eye_media(SCENE_PARAMETERS, global const view *views, const launch frame, global int *eye_media) {
    const scene s = SCENE_ARGUMENTS;
    for (int i = 0; i < MEDIA; i++)
        eye_media[i] = -1;
#if HAS_TRANSMISSION
    const vectors direction = normalise(make_vectors(splat(R(0.5377)), splat(R(0.7331)), splat(R(0.4168))));
    media entered = no_media();
    for (ray r = make_ray(splat_xyz(views[0].eye), direction);;) {
        const hit h = closest_hit(&s, &r, mask(true));
        ints number = h.primitive;
        if (INT_LANE(number, 0) < 0)
            return;
        identity id = identify(&s, mask(true), &h);
        const surface f = find_surface(&s, &r, &h, mask(true), &id);
        ints outwards = dot3(direction, f.normal) > splat(0);
        ints passes = transmits(&s, id.material);
        if (INT_LANE(passes, 0) && (INT_LANE(id.flags, 0) & FLAG_SOLID)) {
            ints known = contains_medium(&entered, id.material);
            if (!INT_LANE(outwards, 0)) {
                entered = enter_medium(entered, id.material);
            } else if (INT_LANE(known, 0)) {
                entered = leave_medium(entered, id.material);
            } else {
                for (int i = MEDIA - 1; i > 0; i--)
                    eye_media[i] = eye_media[i - 1];
                eye_media[0] = INT_LANE(id.material, 0);
            }
        }
        r = step_beyond(r, &h, mask(true));
    }
#endif
}
