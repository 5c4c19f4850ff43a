// render.cl - the entry points.

#define SCENE_PARAMETERS                                                                                               \
    global const uint4 *primitives, global const sphere *spheres, global const plane *planes,                          \
        global const disc *discs, global const box *boxes, global const uint4 *triangles,                              \
        global const real4 *vertices, global const real4 *normals, global const polygon *polygons,                     \
        global const uint4 *polygon_ranges, global const real *corners, global const cone *cones,                      \
        global const instance *instances, global const uint4 *instance_roots, global const real *nodes,                \
        global const uint2 *links, global const real *blocks, global const uint *block_numbers,                        \
        global const material *materials, global const light *lights

#define SCENE_ARGUMENTS                                                                                                \
    {                                                                                                                  \
        primitives, spheres, planes, discs, boxes, triangles, vertices, normals, polygons, polygon_ranges, corners,    \
            cones, instances, instance_roots, nodes, links, blocks, block_numbers, materials, lights,                  \
            frame.count NO_COUNTS                                                                                      \
    }

// The eye rays through these sites, still without a direction.
INLINE packet make_packet(global const view *camera, global const int *eye_media, const launch *frame, sites at) {
    packet p;
    p.origin = splat_xyz(camera->eye);
    p.weight = splat_xyz((real4)(1));
    p.depth = 1;
#if MARGIN
    p.source = no_hit(splat(0));
    p.blur = blur_of_point(p.origin);
    p.slant = BLUR_OF_DIRECTION;
#endif
    p.active = AS_MASK((at.sample < frame->frame.z) & (at.x < frame->tile.z) & (at.y < frame->tile.w));
#if HAS_TRANSMISSION
    for (int i = 0; i < MEDIA; i++)
        p.in.material[i] = whole(eye_media[i]);
#endif
    return p;
}

// The trees of the rays through the pixels from (x, y) on, packet after packet.
INLINE tree_sum trace_pixels(const scene *s, global const view *camera, global const int *eye_media,
                             const launch *frame, uint x, uint y) {
    const bool nothing = !(RECORD | SEND_ALL) && sees_nothing(s, camera, frame->frame, x, y);
    tree_sum parts[PACKETS];
    uint packets = 0;
    do {
        const sites at = make_sites(x, y, packets * PER_PIXEL);
        packet p = make_packet(camera, eye_media, frame, at);
        tree_sum sum;
        if (nothing) {
            sum = see_nothing(camera, &p);
        } else {
            p.direction = eye_directions(camera, at, frame->frame);
            sum = trace(s, camera, p, frame->frame.w);
        }
      private
        tree_sum *part = &parts[packets % PACKETS];
        *part = packets < PACKETS ? sum : add_trees(*part, &sum);
        packets++;
    } while (packets * PER_PIXEL < (ONE_PACKET ? 1 : frame->frame.z));
    return add_parts(parts, packets);
}

real4 lane_colour(const vectors *v, uint lane, real w) {
    return (real4)(REAL_LANE(v->x, lane), REAL_LANE(v->y, lane), REAL_LANE(v->z, lane), w);
}

// Writes row by row of the tile: RGBA; over all samples how many rays there were (reflection, transmission, shadow, eye
// rays that hit); and where rays are sent on, the mean unsent weight per channel and the deepest level.
NOINLINE void render_pixels(const scene *s, global const view *camera, global const int *eye_media, const launch *frame,
                            uint x, uint y, global real4 *pixels, global uint4 *rays, global real4 *unsent) {
    const tree_sum sum = trace_pixels(s, camera, eye_media, frame, x, y);
    const real samples = R(frame->frame.z);
    for (uint i = 0; i < PIXELS; i++) {
        const uint px = x + i % PIXELS_X, py = y + i / PIXELS_X;
        if (px >= frame->tile.z || py >= frame->tile.w)
            continue;
        const size_t at = (size_t)(py - frame->tile.y) * (frame->tile.z - frame->tile.x) + (px - frame->tile.x);
        const uint hits = INT_LANE(sum.hits, i);
        pixels[at] = lane_colour(&sum.colour, i, R(hits)) / samples;
#if HAS_REFLECTION || HAS_TRANSMISSION // else nothing is sent on
        unsent[at] = lane_colour(&sum.discarded, i, R(0)) / samples;
        unsent[at].w = R(deepest_level(&sum, i));
#endif
        rays[at] = (uint4)(INT_LANE(sum.reflection, i), INT_LANE(sum.transmission, i), INT_LANE(sum.shadow, i), hits);
#if COUNTING
        rays[at] = vload4(COUNTING - 1, s->counts);
#endif
    }
}

#if RECORD
// One pixel, one work-item: what render_pixels writes, and notes of all that led to it. Of `room` rays, lights and crossings;
// `counts` is how many there were, and where that is more, some were not kept.
kernel void record_pixel(SCENE_PARAMETERS, global const view *views, global const int *eye_media, const launch frame,
                         global real4 *pixels, global uint4 *rays, global real4 *unsent, global ray_note *notes_of_rays,
                         global ray_tags *tags_of_rays, global light_note *notes_of_lights,
                         global light_tags *tags_of_lights, global crossing_note *notes_of_crossings,
                         global crossing_tags *tags_of_crossings, const uint4 room, global uint4 *counts) {
    notebook notes = {notes_of_rays,     tags_of_rays, notes_of_lights, tags_of_lights, notes_of_crossings,
                      tags_of_crossings, room};
    scene s = SCENE_ARGUMENTS;
    s.notes = &notes;
    notes.sample = -1;
    notes.light = NOT_NOTED;
    render_pixels(&s, views, eye_media, &frame, frame.tile.x, frame.tile.y, pixels, rays, unsent);
    *counts = notes.count;
}
#elif !SURVEY
// One pixel per work-item, or PIXELS.
kernel __attribute__((vec_type_hint(reals))) void render(SCENE_PARAMETERS, global const view *views,
                                                         global const int *eye_media, const launch frame,
                                                         global real4 *pixels, global uint4 *rays,
                                                         global real4 *unsent) {
    const uint x = frame.tile.x + get_global_id(0) * PIXELS_X, y = frame.tile.y + get_global_id(1) * PIXELS_Y;
    if (x >= frame.tile.z || y >= frame.tile.w)
        return;
    const scene s = SCENE_ARGUMENTS;
    render_pixels(&s, views, eye_media, &frame, x, y, pixels, rays, unsent);
}
#endif

#if !SURVEY
// The media that the eye is in, outermost first: along any ray from it, the solids that are left without having been
// entered. One work-item.
kernel __attribute__((vec_type_hint(reals))) void find_eye_media(SCENE_PARAMETERS, global const view *views,
                                                                 const launch frame, global int *eye_media) {
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
#endif
