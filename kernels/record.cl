// record.cl - notes of all that a pixel's rays do, for `feeler pixel`, which builds with -DRECORD=1 and one lane. Each NOTE in
// trace.cl and phong.cl is then taken; else nothing of this is compiled.
#ifndef RECORD
#define RECORD 0
#endif

#if !RECORD
#define NOTE(statement) ((void)0)
#else
#if LANES != 1
#error "notes are of one lane"
#endif
#define NOTE(statement) statement

// Where the notes go. What there is no room for is counted, and goes to the place behind the last.
typedef struct {
    global ray_note *rays;
    global ray_tags *ray_tags;
    global light_note *lights;
    global light_tags *light_tags;
    global crossing_note *crossings;
    global crossing_tags *crossing_tags;
    uint4 room, count; // rays, lights, crossings
    uint sample, ray, light;
} notebook;

real4 real4_of(vectors v, real w) {
    return (real4)(v.x, v.y, v.z, w);
}

uint inside_of(const hit *h) {
#if HAS_INSTANCE
    return h->inside;
#else
    return NOT_NOTED;
#endif
}

global ray_note *ray_at(const notebook *n) {
    return n->rays + min(n->ray, n->room.x);
}

global ray_tags *ray_tags_at(const notebook *n) {
    return n->ray_tags + min(n->ray, n->room.x);
}

global light_note *light_at(const notebook *n) {
    return n->lights + min(n->light, n->room.y);
}

global light_tags *light_tags_at(const notebook *n) {
    return n->light_tags + min(n->light, n->room.y);
}

// The next sample's tree; what its eye ray is sent by, and as.
uint2 note_tree(notebook *n) {
    n->sample++;
    return (uint2)(NOT_NOTED, RAY_EYE);
}

// A ray; returns its number.
uint note_ray(notebook *n, uint2 sent, uint level, vectors origin, vectors direction, vectors weight) {
    n->ray = n->count.x++;
    const uint4 none = (uint4)(NOT_NOTED);
    ray_note ray = {real4_of(origin, 0), real4_of(direction, 0), real4_of(weight, 0)};
    ray_tags tags = {{sent.x, n->sample, sent.y, level}, none, none, none, none, none};
    tags.met.w = 0;
    *ray_at(n) = ray;
    *ray_tags_at(n) = tags;
    return n->ray;
}

void note_hit(const notebook *n, const hit *h, uint material, ints entering) {
    ray_at(n)->origin.w = h->distance;
    ray_tags_at(n)->met = (uint4)(h->primitive, inside_of(h), material, entering ? NOTED_ENTERING : 0);
}

void add_crossing(notebook *n, uint kind, real distance, uint4 met) {
    const uint number = min(n->count.z++, n->room.z);
    n->crossings[number].share = (real4)(0, 0, 0, distance);
    n->crossing_tags[number].at = (uint4)(n->ray, n->light, kind, 0);
    n->crossing_tags[number].met = met;
}

void note_crossing(notebook *n, uint kind, const hit *h, uint material, ints entering) {
    add_crossing(n, kind, h->distance, (uint4)(h->primitive, inside_of(h), material, entering ? NOTED_ENTERING : 0));
}

// What the last crossing left of a feeler's light.
void note_share(const notebook *n, vectors share) {
    n->crossings[min(n->count.z - 1, n->room.z)].share.xyz = real4_of(share, 0).xyz;
}

// The hit that was noted is of a boundary that is not there.
void note_hidden(notebook *n) {
    global ray_tags *tags = ray_tags_at(n);
    add_crossing(n, CROSSING_HIDDEN, ray_at(n)->origin.w, tags->met);
    tags->met = (uint4)(NOT_NOTED, NOT_NOTED, NOT_NOTED, 0);
}

void note_background(const notebook *n, vectors colour) {
    ray_at(n)->background = real4_of(colour, 0);
}

void note_surface(const notebook *n, vectors point, vectors normal, vectors shading, vectors reflected) {
    global ray_note *ray = ray_at(n);
    ray->point = real4_of(point, 0);
    ray->normal = real4_of(normal, 0);
    ray->shading = real4_of(shading, 0);
    ray->reflected = real4_of(reflected, 0);
}

void note_transmitted(const notebook *n, ints found, vectors direction, real index_before, real index_behind) {
    global ray_note *ray = ray_at(n);
    ray->direction.w = index_before;
    ray->weight.w = index_behind;
    if (!found)
        return;
    ray->transmitted = real4_of(direction, 0);
    ray_tags_at(n)->met.w |= NOTED_REFRACTS;
}

uint4 four_media(const ints *material, int first) {
    uint four[4];
    for (int i = 0; i < 4; i++)
        four[i] = first + i < MEDIA ? (uint)material[first + i] : NOT_NOTED;
    return vload4(0, four);
}

void note_before(const notebook *n, const ints *material) {
    ray_tags_at(n)->before_outer = four_media(material, 0);
    ray_tags_at(n)->before_inner = four_media(material, 4);
}

void note_behind(const notebook *n, const ints *material) {
    ray_tags_at(n)->behind_outer = four_media(material, 0);
    ray_tags_at(n)->behind_inner = four_media(material, 4);
}

void note_own(const notebook *n, vectors ambient, vectors emission) {
    ray_at(n)->ambient = real4_of(ambient, 0);
    ray_at(n)->emission = real4_of(emission, 0);
}

void note_local(const notebook *n, vectors colour) {
    ray_at(n)->lit = real4_of(colour, 0);
}

void note_reflection(const notebook *n, vectors share, vectors weight, ints sent) {
    ray_at(n)->reflection_share = real4_of(share, 0);
    ray_at(n)->reflection = real4_of(weight, 0);
    ray_tags_at(n)->met.w |= sent ? NOTED_REFLECTION : 0;
}

void note_transmission(const notebook *n, vectors share, vectors weight, ints sent) {
    ray_at(n)->transmission_share = real4_of(share, 0);
    ray_at(n)->transmission = real4_of(weight, 0);
    ray_tags_at(n)->met.w |= sent ? NOTED_TRANSMISSION : 0;
}

// What follows, up to end_lights, is of this light.
void begin_light(notebook *n, uint light) {
    n->light = n->count.y++;
    const light_note nothing = {(real4)(0)};
    *light_at(n) = nothing;
    light_tags_at(n)->at = (uint4)(n->ray, light, LIGHT_NEITHER, 0);
}

void end_lights(notebook *n) {
    n->light = NOT_NOTED;
}

void note_feeler(const notebook *n, vectors origin, vectors direction, real length) {
    light_at(n)->feeler_origin = real4_of(origin, 0);
    light_at(n)->feeler = real4_of(direction, length);
    light_tags_at(n)->at.w |= NOTED_FEELER;
}

void note_light(const notebook *n, vectors direction, real distance, ints active, real cosine, real side) {
    if (!active) // at the point itself
        return;
    light_at(n)->direction = real4_of(direction, distance);
    light_at(n)->diffuse.w = cosine;
    light_tags_at(n)->at.z =
        cosine > 0 && side > 0 ? LIGHT_FRONT : (cosine < 0 && side < 0 ? LIGHT_BACK : LIGHT_NEITHER);
}

void note_terms(const notebook *n, vectors diffuse, vectors specular, real shine, real highlight) {
    global light_note *light = light_at(n);
    light->diffuse.xyz = real4_of(diffuse, 0).xyz;
    light->specular = real4_of(specular, highlight);
    light->share.w = shine;
}

void note_arrival(const notebook *n, ints counts, vectors share, vectors colour) {
    light_at(n)->share.xyz = real4_of(share, 0).xyz;
    light_at(n)->colour = real4_of(colour, 0);
    light_tags_at(n)->at.w |= counts ? NOTED_COUNTS : 0;
}
#endif
