// phong.cl - local illumination (16.20): Phong's model for reflection and for transmission, with a shadow feeler per light.

// A point to shade. v, r and t as in the model; normal is n_g and shading n, both turned to v's side.
typedef struct {
    vectors point, error, normal, shading, v, r;
    refraction t;
#if MARGIN
    hit source; // the surface
    doubt doubt;
#endif
#if HAS_TERMINATOR
    vectors lift; // towards lights on v's side, feelers start so much farther out
#endif
} shade_point;

// The material's coefficients at each lane.
typedef struct {
    vectors diffuse, specular, diffuse_transmission, specular_transmission;
    reals shininess;
} coefficients;

typedef struct {
    vectors colour;
    ints feelers; // sent
} illumination;

coefficients find_coefficients(const scene *s, ints material) {
    coefficients c;
    c.diffuse = GATHER(s->materials, material, diffuse).xyz;
    const quads specular = GATHER(s->materials, material, specular_shininess);
    c.specular = specular.xyz;
    c.shininess = specular.w;
#if HAS_DIFFUSE_TRANSMISSION
    c.diffuse_transmission = GATHER(s->materials, material, diffuse_transmission).xyz;
#endif
#if HAS_SPECULAR_TRANSMISSION
    c.specular_transmission = GATHER(s->materials, material, specular_transmission).xyz;
#endif
    return c;
}

// A light for every ray; or in a fan, a light in each lane.
typedef struct {
    vectors position, diffuse, specular;
    ints is_near; // at a point, else in a direction
} lamps;

INLINE lamps load_lamps(global const light *lights, uint count) {
    lamps l = {splat_xyz(lights->position), splat_xyz(lights->diffuse), splat_xyz(lights->specular),
               mask(lights->position.w != R(0))};
#if FANS
    for (uint k = 1; k < count; k++) {
        const light one = lights[k];
        REAL_LANE(l.position.x, k) = one.position.x;
        REAL_LANE(l.position.y, k) = one.position.y;
        REAL_LANE(l.position.z, k) = one.position.z;
        REAL_LANE(l.diffuse.x, k) = one.diffuse.x;
        REAL_LANE(l.diffuse.y, k) = one.diffuse.y;
        REAL_LANE(l.diffuse.z, k) = one.diffuse.z;
        REAL_LANE(l.specular.x, k) = one.specular.x;
        REAL_LANE(l.specular.y, k) = one.specular.y;
        REAL_LANE(l.specular.z, k) = one.specular.z;
        INT_LANE(l.is_near, k) = one.position.w != R(0) ? TRUE : 0;
    }
#endif
    return l;
}

// The segment or, of length 1, the direction to each light.
vectors reach(const lamps *l, vectors from) {
    return choose(l->is_near, sub(l->position, from), l->position);
}

// A feeler ends this much short of its light, relative to its length: a light may lie on a surface.
#ifndef FEELER_SHORT
#define FEELER_SHORT (R(1) - R(64) * UNIT)
#endif

typedef struct {
    vectors share;
    ints sent;
} visibility; // share: of the light that arrives, 0 or 1 unless filtered

#if HAS_FILTERED_SHADOWS
// Extension: what a feeler crosses lets its rho_tg through, once per surface, nearest first.
vectors filter_feeler(const scene *s, vectors origin, vectors direction, reals limit, ints active) {
    vectors share = where(active, splat_xyz((real4)(1)));
    for (ray r = make_ray(origin, direction); any_ray(active);) {
        const hit h = traverse(s, &r, active, limit, false);
        active &= h.primitive >= 0;
        const identity id = identify(s, active, &h);
        const vectors passes = GATHER(s->materials, active ? id.material : whole(0), transmission).xyz;
        share = choose(active, mul(share, passes), share);
        NOTE(if (active) note_crossing(s->notes, CROSSING_FILTER, &h, id.material, 0));
        NOTE(if (active) note_share(s->notes, share));
        active &= largest(share) > splat(0);
        r = step_beyond(r, &h, active);
    }
    return share;
}
#endif

#if RECORD && !HAS_FILTERED_SHADOWS
// any_hit is content with whichever blocker comes first: this finds the nearest.
void note_blocker(const scene *s, const ray *feeler, ints active, reals limit) {
    const hit h = traverse(s, feeler, active, limit, false);
    if (h.primitive < 0)
        return;
    const identity id = identify(s, active, &h);
    note_crossing(s->notes, CROSSING_BLOCKER, &h, id.material, 0);
}
#endif

#if HAS_TERMINATOR
ints is_lifted(const shade_point *p) {
    return dot3(p->lift, p->normal) > splat(0);
}
#endif

// What arrives at a point from its lights.
INLINE visibility send_feelers(const scene *s, const shade_point *p, const lamps *l, ints front, ints active) {
    visibility v;
    v.sent = active;
    v.share = where(active, splat_xyz((real4)(1)));
#if HAS_SHADOWS
    if (!any_lane(active))
        return v;
    vectors point = p->point, error = p->error;
#if HAS_TERMINATOR
    const ints lifted = front & is_lifted(p);
    point = choose(lifted, add(point, p->lift), point);
    error = choose(lifted, add(error, scale(add(absolute(point), absolute(p->lift)), splat(GAMMA(8)))), error);
#endif
    const vectors origin = spawn(point, error, choose(front, p->normal, negate(p->normal)));
    const vectors segment = reach(l, origin);
    const reals length = sqrt(dot3(segment, segment));
    const vectors direction = scale(segment, splat(1) / length);
    const reals limit = l->is_near ? length * FEELER_SHORT : splat(INFINITY);
    active &= length > splat(0);
    WEIGH_FEELER(s, p, l, active, origin, direction, length, limit);
    NOTE(note_feeler(s->notes, origin, direction, length));
#if HAS_FILTERED_SHADOWS
    v.share = filter_feeler(s, origin, direction, limit, active);
#else
    const ray feeler = make_ray(origin, direction);
    v.share = where(active & !any_hit(s, &feeler, active, limit), v.share);
    NOTE(note_blocker(s, &feeler, active, limit));
#endif
#endif
    return v;
}

ints is_positive(vectors a) {
    return largest(a) > splat(0);
}

// The two terms of one light at each lane: reflection's where it is on the viewer's side, transmission's where it is not.
INLINE illumination illuminate(const scene *s, const shade_point *p, const coefficients *c, const lamps *l,
                               ints active) {
    const vectors segment = reach(l, p->point);
    const reals squared = dot3(segment, segment);
    const vectors direction = scale(segment, splat(1) / sqrt(squared)); // L_i, L_ti
    const reals cosine = dot3(direction, p->shading);
    reals side = dot3(direction, p->normal);
    active &= squared > splat(0); // a light at Q itself contributes nothing
#if HAS_TERMINATOR
    side = (is_lifted(p) & (side <= splat(0))) ? cosine : side; // a flat triangle's own horizon does not count
#endif
    WEIGH_LIGHT(s, p, c, l, cosine, side, squared);
    const ints front = active & (cosine > splat(0)) & (side > splat(0));
    ints sends = mask(false);
    vectors diffuse = where(sends, l->diffuse), specular = diffuse;
    reals shine = splat(0);
#if HAS_DIFFUSE
    diffuse = where(front, mul(c->diffuse, l->diffuse));
#endif
#if HAS_SPECULAR
    specular = where(front, mul(c->specular, l->specular));
    shine = front ? dot3(p->r, direction) : shine;
#endif
#if HAS_DIFFUSE_TRANSMISSION || HAS_SPECULAR_TRANSMISSION
    const ints back = active & (cosine < splat(0)) & (side < splat(0));
#endif
#if HAS_DIFFUSE_TRANSMISSION
    diffuse = choose(back, mul(c->diffuse_transmission, l->diffuse), diffuse);
#endif
#if HAS_SPECULAR_TRANSMISSION
    specular = choose(back & p->t.found, mul(c->specular_transmission, l->specular), specular);
    shine = back & p->t.found ? dot3(p->t.direction, direction) : shine;
#endif
    const ints shines = is_positive(specular) & (shine > splat(0));
    sends = is_positive(diffuse) | shines;
    const visibility v = send_feelers(s, p, l, front, sends);
    illumination i;
    i.feelers = count_where(whole(0), HAS_SHADOWS ? v.sent : mask(false));
    vectors sum = scale(diffuse, fabs(cosine));
#if HAS_SPECULAR || HAS_SPECULAR_TRANSMISSION
    if (any_lane(shines & is_positive(v.share))) {
        const reals highlight = power(min(shines ? shine : splat(0), splat(1)), c->shininess);
        sum = add(sum, scale(specular, shines ? highlight : splat(0)));
    }
#endif
    i.colour = mul(where(sends, sum), v.share);
    NOTE(note_light(s->notes, direction, sqrt(squared), active, cosine, side));
    NOTE(note_terms(s->notes, diffuse, specular, shine, shines ? power(min(shine, R(1)), c->shininess) : R(0)));
    NOTE(note_arrival(s->notes, sends, v.share, i.colour));
    return i;
}

// I_local of (16.20) at each active lane, 0 elsewhere.
illumination illuminate_locally(const scene *s, const shade_point *p, vectors ambient_light, ints material,
                                ints active) {
    const coefficients c = find_coefficients(s, material);
    illumination sum;
    sum.feelers = whole(0);
    const vectors ambient = mul(GATHER(s->materials, material, ambient).xyz, ambient_light);
    sum.colour = where(active, add(ambient, GATHER(s->materials, material, emission).xyz));
    NOTE(note_own(s->notes, ambient, GATHER(s->materials, material, emission).xyz));
    const uint step = FANS ? LANES : 1;
    for (uint i = 0; i < s->count.x; i += step) {
        const uint count = min(s->count.x - i, step);
        const lamps l = load_lamps(s->lights + i, count);
        NOTE(begin_light(s->notes, i));
#if FANS
        const illumination all = illuminate(s, p, &c, &l, mask_of_bits((1u << count) - 1));
        for (uint k = 0; k < count; k++)
            sum.colour = add(sum.colour, lane_of(all.colour, k));
        sum.feelers += whole((integer)popcount(lane_bits(all.feelers != 0)));
#else
        const illumination one = illuminate(s, p, &c, &l, active);
        sum.colour = add(sum.colour, one.colour);
        sum.feelers += one.feelers;
#endif
    }
    NOTE(end_lights(s->notes));
    return sum;
}
