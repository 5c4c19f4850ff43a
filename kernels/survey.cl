// survey.cl - what lies beside the picture: a program of its own (host/survey.c), one ray at a time, in one lane.
#if SURVEY

// The surface that the ray through the pixel's centre shows, as (16.20) would shade it: no place in between is anybody's.
typedef struct {
    real4 point_distance, normal_margin;
    int2 ids; // of the primitive, or of the instance that it is in; of the material. -1: nothing is hit
} sighting;

sighting look(const scene *s, global const view *camera, global const int *eye_media, const launch *frame, uint x,
              uint y) {
    const sites at = make_sites(x, y, 0);
    const uint4 once = {frame->frame.x, frame->frame.y, 1, frame->frame.w};
    packet p = make_packet(camera, eye_media, frame, at);
    p.direction = eye_directions(camera, at, once);
    const encounter e = meet_visible(s, &p);
    sighting seen = {(real4)(0), (real4)(0), (int2)(-1)};
    seen.point_distance.w = INFINITY;
    if (e.first.primitive < 0)
        return seen;
    const shade_point q = make_shade_point(&p, &e);
    seen.point_distance = (real4)(q.point.x, q.point.y, q.point.z, e.first.distance);
    seen.normal_margin = (real4)(q.shading.x, q.shading.y, q.shading.z, 0);
    seen.ids = (int2)(e.first.primitive, e.id.material);
    return seen;
}

#if MARGIN
// The least margin of all decisions about the rays of the pixel's samples.
real find_margin(scene s, global const view *camera, global const int *eye_media, const launch *frame, uint x, uint y) {
    real margin = LIMIT;
    s.margin = &margin;
    for (uint i = 0; i < frame->frame.z; i++) {
        const sites at = make_sites(x, y, i);
        packet p = make_packet(camera, eye_media, frame, at);
        p.direction = eye_directions(camera, at, frame->frame);
        trace(&s, camera, p, frame->frame.w);
    }
    return margin;
}
#endif

// One pixel per work-item: row by row of the tile.
kernel void survey(SCENE_PARAMETERS, global const view *views, global const int *eye_media, const launch frame,
                   global real4 *surfaces, global int2 *ids) {
    const uint x = frame.tile.x + get_global_id(0), y = frame.tile.y + get_global_id(1);
    if (x >= frame.tile.z || y >= frame.tile.w)
        return;
    scene s = SCENE_ARGUMENTS;
    const size_t at = (size_t)(y - frame.tile.y) * (frame.tile.z - frame.tile.x) + (x - frame.tile.x);
#if MARGIN
    real unused = LIMIT; // the centre's ray may be none of the samples'
    s.margin = &unused;
#endif
    sighting seen = look(&s, views, eye_media, &frame, x, y);
#if MARGIN
    seen.normal_margin.w = find_margin(s, views, eye_media, &frame, x, y);
#endif
    surfaces[2 * at] = seen.point_distance;
    surfaces[2 * at + 1] = seen.normal_margin;
    ids[at] = seen.ids;
}
#endif
