// trace.cl - the ray tree of a pixel's samples (16.3, 16.12), depth first, with an explicit stack.

// Rays of one depth, a sample to a lane.
typedef struct {
    vectors origin, direction, weight;
    ints active;
    uint depth;
#if HAS_TRANSMISSION
    media in;
#endif
#if MARGIN
    hit source;   // what it leaves
    vectors blur; // what its start may be off by
    real slant;   // and its direction
#endif
#if RECORD
    uint2 sent; // by which ray, and as what
#endif
} packet;

// What a tree adds up to for each lane: colour, unsent weight, rays by kind, and the deepest level.
typedef struct {
    vectors colour, discarded;
    ints hits, reflection, transmission, shadow, deepest; // hits: of eye rays
} tree_sum;

// Whether anything asks for the direction of transmission.
#define BENDS (HAS_TRANSMISSION || HAS_SPECULAR_TRANSMISSION || HAS_FRESNEL)

// What a packet meets: hits, surfaces, and for transmission the boundary; `touched` where another medium's is at its place.
typedef struct {
    hit h;
    identity id;
    surface f;
    ints entering, touched;
#if BENDS
    boundary b;
#endif
#if SURVEY
    hit first; // h, before what touches it is met together with it
#endif
#if MARGIN
    doubt doubt;
#endif
} encounter;

// Which lanes' material lets rays through.
ints transmits(const scene *s, ints material) {
    return is_positive(GATHER(s->materials, material, transmission).xyz);
}

#if HAS_TRANSMISSION
// How far from a hit, per coordinate, another surface may be and still be at the same place: both points' errors, twice.
vectors blur_of(const surface *f) {
    return scale(add(f->error, scale(absolute(f->point), splat(GAMMA(12)))), splat(4));
}

// What lies where a medium ends is met together with its boundary: a ray that starts behind would not find it. Another
// medium's boundary makes one boundary with it; an opaque surface hides it.
void merge_touching(const scene *s, const packet *p, ray r, encounter *e, ints active) {
    const reals slope = max(fabs(dot3(e->f.normal, p->direction)), splat(R(0x1p-6)));
    const reals limit = (e->h.distance + dot3(absolute(e->f.normal), blur_of(&e->f)) / slope) * (R(1) + R(4) * UNIT);
    while (any_ray(active)) {
        r = step_beyond(r, &e->h, active);
        const hit h = traverse(s, &r, active, limit, false);
        active &= h.primitive >= 0;
        if (!any_ray(active))
            return;
        const identity id = identify(s, active, &h);
        const surface f = find_surface(s, &r, &h, active, &id);
        const ints medium = transmits(s, id.material);
        e->b.visible &= !active | medium;
        active &= medium;
        e->touched |= active;
        NOTE(if (active) note_crossing(s->notes, CROSSING_TOUCHING, &h, id.material, dot3(f.normal, p->direction) < 0));
        const boundary both = merge_boundary(s, e->b, id.material, dot3(f.normal, p->direction) < splat(0));
        e->b = choose_boundary(active, both, e->b);
        e->h.distance = active ? h.distance : e->h.distance;
        e->h.primitive = active ? h.primitive : e->h.primitive;
#if HAS_INSTANCE
        e->h.inside = active ? h.inside : e->h.inside;
#endif
    }
}
#endif

encounter meet(const scene *s, const packet *p, const ray *r, ints active) {
    encounter e;
    e.h = closest_hit(s, r, active);
    const ints found = active & (e.h.primitive >= 0);
#if SURVEY
    e.first = e.h;
#endif
    WEIGH_HIT(s, p, r, &e.h);
    if (!any_ray(found)) {
        e.id.kind = e.id.index = e.id.material = e.id.flags = whole(0); // what other lanes may be asked for with these
#if HAS_TRANSMISSION
        e.b.visible = mask(true);
#endif
        return e;
    }
    e.id = identify(s, found, &e.h);
    e.f = find_surface(s, r, &e.h, found, &e.id);
    e.entering = dot3(e.f.normal, p->direction) < splat(0);
    WEIGH_SURFACE(s, p, r, &e);
    NOTE(note_hit(s->notes, &e.h, e.id.material, e.entering));
#if HAS_TRANSMISSION
    const ints medium = found & transmits(s, e.id.material);
    e.b = cross_boundary(s, &p->in, e.id.material, e.entering);
    e.b = choose_boundary(medium, e.b, meet_opaque(s, &p->in, e.id.material, e.entering));
    e.touched = mask(false);
    merge_touching(s, p, *r, &e, medium);
#elif BENDS
    const reals index = index_of(s, e.id.material);
    e.b.eta = e.entering ? splat(1) / index : index;
#endif
    return e;
}

#if HAS_TRANSMISSION
INLINE encounter choose_encounter(ints m, encounter a, encounter b) {
    a.h.distance = m ? a.h.distance : b.h.distance;
    a.h.primitive = m ? a.h.primitive : b.h.primitive;
#if HAS_INSTANCE
    a.h.inside = m ? a.h.inside : b.h.inside;
#endif
#if SURVEY
    a.first = m ? a.first : b.first;
#endif
#if MARGIN
    a.doubt = m ? a.doubt : b.doubt;
#endif
    a.id.material = m ? a.id.material : b.id.material;
    a.f = choose_surface(m, a.f, b.f);
    a.entering = m ? a.entering : b.entering;
    a.touched = m ? a.touched : b.touched;
    a.b = choose_boundary(m, a.b, b.b);
    return a;
}
#endif

// The first visible surface: a boundary that a medium of higher priority hides is passed straight through, and only the
// list of media changes.
INLINE encounter meet_visible(const scene *s, packet *p) {
    ray r = make_ray(p->origin, p->direction);
    encounter e = meet(s, p, &r, p->active);
#if HAS_TRANSMISSION
    for (ints hidden = p->active & !e.b.visible; any_ray(hidden); hidden &= !e.b.visible) {
        NOTE(note_hidden(s->notes));
        r = step_beyond(r, &e.h, hidden);
        p->in = choose_media(hidden, e.b.behind, p->in);
        e = choose_encounter(hidden, meet(s, p, &r, hidden), e);
    }
#endif
    return e;
}

// The surface as the shading sees it: normals turned to v's side, reflection and transmission found.
INLINE shade_point make_shade_point(const packet *p, const encounter *e) {
    shade_point q;
    q.point = e->f.point;
    q.error = e->f.error;
    q.v = negate(p->direction);
#if MARGIN
    q.source = e->first;
    q.doubt = e->doubt;
#endif
    q.normal = choose(e->entering, e->f.normal, negate(e->f.normal));
#if HAS_TERMINATOR
    q.lift = e->f.lift;
#endif
    q.shading = q.normal;
#if HAS_SMOOTH
    const vectors turned = choose(e->entering, e->f.shading, negate(e->f.shading));
    const reals height = dot3(turned, q.v);
    q.shading = choose(height > splat(0), turned, normalise(along(turned, q.v, R(0x1p-10) - height)));
#endif
    q.r = keep_above(reflect(q.v, q.shading), q.normal);
#if BENDS
    q.t = refract(q.v, q.shading, e->b.eta);
    q.t.direction = keep_above(q.t.direction, negate(q.normal));
#else
    q.t.found = mask(false);
    q.t.direction = q.v;
#endif
    return q;
}

#if RECORD && BENDS
// Where transmission goes, the media on both sides, and the refractive indices that eta is made of: of an opaque surface's
// own and those of the medium around it.
void note_refraction(const scene *s, const packet *p, const encounter *e, const shade_point *q) {
    const ints own = e->id.material;
    ints front = -1, back = own;
#if HAS_TRANSMISSION
    front = dominant(s, &p->in);
    if (transmits(s, own)) {
        const ints full = e->entering & (p->in.material[MEDIA - 1] >= 0);
        front = e->b.here;
        back = full ? own : dominant(s, &e->b.behind);
    } else
#endif
        if (!e->entering) {
        back = front;
        front = own;
    }
    note_transmitted(s->notes, q->t.found, q->t.direction, index_of(s, front), index_of(s, back));
#if HAS_TRANSMISSION
    note_behind(s->notes, e->b.behind.material);
#endif
}
#endif

// The weights of what a surface sends on: rho_rg and rho_tg, with the extensions that the material asks for.
typedef struct {
    vectors reflection, transmission;
} shares;

INLINE shares find_shares(const scene *s, const shade_point *q, const encounter *e) {
    const ints material = e->id.material;
    shares w;
    w.reflection = GATHER(s->materials, material, reflection).xyz;
    w.transmission = where(mask(false), w.reflection);
#if HAS_TRANSMISSION
    const vectors passes = GATHER(s->materials, material, transmission).xyz;
    w.transmission = where(q->t.found, passes);
#endif
#if HAS_FRESNEL || HAS_TOTAL_REFLECTION
    const quads optics = GATHER(s->materials, material, optics);
#endif
#if HAS_FRESNEL
    const reals cos_v = dot3(q->v, q->shading), cos_t = -dot3(q->t.direction, q->shading);
    const ints weighted = q->t.found & (optics.w != splat(0));
    const reals reflected = fresnel(cos_v, cos_t, e->b.eta);
    w.reflection = choose(weighted, scale(w.reflection, reflected), w.reflection);
    w.transmission = choose(weighted, scale(w.transmission, splat(1) - reflected), w.transmission);
#endif
#if HAS_TRANSMISSION && HAS_TOTAL_REFLECTION
    const ints carries = !q->t.found & (optics.xyz.z != splat(0));
    w.reflection = choose(carries, add(w.reflection, passes), w.reflection);
#endif
    return w;
}

// The packet that goes on with the given shares; what the depth or the cutoff forbids is added to `sum->discarded`.
INLINE packet send_on(const packet *p, vectors origin, vectors share, vectors direction, ints active, real cutoff,
                      uint depth, tree_sum *sum) {
    packet next = *p;
    next.weight = mul(p->weight, share);
    next.direction = direction;
    next.depth = p->depth + 1;
    next.active = active & is_positive(next.weight);
    const ints stopped = next.active & (mask(p->depth >= depth) | (largest(next.weight) < cutoff));
    sum->discarded = add(sum->discarded, where(stopped, next.weight));
    next.active &= !stopped;
    next.origin = origin;
    return next;
}

// What a packet sends on from a surface; where nothing is transmitted, `transmitted` has no active lane.
typedef struct {
    packet reflected, transmitted;
} children;

INLINE children send_children(const scene *s, const packet *p, const encounter *e, const shade_point *q, ints found,
                              real cutoff, uint depth, tree_sum *sum) {
    children c;
    c.reflected = c.transmitted = *p;
    c.reflected.active = c.transmitted.active = mask(false);
#if BENDS
    WEIGH_REFRACTION(s, p, e, q);
#endif
#if HAS_REFLECTION || HAS_TRANSMISSION
    const shares share = find_shares(s, q, e);
    const vectors outside = spawn(q->point, q->error, q->normal);
    c.reflected = send_on(p, outside, share.reflection, q->r, found, cutoff, depth, sum);
    NOTE(c.reflected.sent.y = RAY_REFLECTION);
    NOTE(note_reflection(s->notes, share.reflection, c.reflected.weight, c.reflected.active));
#if HAS_TRANSMISSION
    const vectors inside = spawn(q->point, choose(e->touched, blur_of(&e->f), q->error), negate(q->normal));
    c.transmitted = send_on(p, inside, share.transmission, q->t.direction, found, cutoff, depth, sum);
    c.transmitted.in = e->b.behind;
    NOTE(c.transmitted.sent.y = RAY_TRANSMISSION);
    NOTE(note_transmission(s->notes, share.transmission, c.transmitted.weight, c.transmitted.active));
#endif
#endif
#if MARGIN
    c.reflected.source = c.transmitted.source = e->first;
    c.reflected.blur = c.transmitted.blur = q->doubt.point;
    c.reflected.slant = blur_of_reflection(p->slant, q->doubt.normal);
#if HAS_TRANSMISSION
    c.transmitted.slant = blur_of_refraction(q->t.direction, q->shading, e->b.eta, p->slant, q->doubt.normal);
#endif
#endif
    sum->reflection = count_where(sum->reflection, c.reflected.active);
    sum->transmission = count_where(sum->transmission, c.transmitted.active);
    return c;
}

// What eye rays that hit nothing see is left out where the background is to be transparent.
INLINE vectors see_background(global const view *camera, const packet *p, ints missed) {
    const bool shows = p->depth > 1 || camera->limits.z == R(0);
    return where(missed & mask(shows), mul(p->weight, splat_xyz(camera->background)));
}

INLINE tree_sum empty_sum() {
    tree_sum sum;
    sum.colour = sum.discarded = where(mask(false), splat_xyz((real4)(0)));
    sum.hits = sum.reflection = sum.transmission = sum.shadow = sum.deepest = whole(0);
    return sum;
}

// What eye rays that meet nothing add up to.
INLINE tree_sum see_nothing(global const view *camera, const packet *p) {
    tree_sum sum = empty_sum();
    sum.colour = see_background(camera, p, p->active);
    sum.deepest = p->active ? whole(1) : sum.deepest;
    return sum;
}

// A pixel's colour is the sum of weight * I_local over its rays. Reflection goes first, transmission waits: at most one
// packet waits at each depth.
INLINE tree_sum trace(const scene *s, global const view *camera, packet p, uint depth) {
    tree_sum sum = empty_sum();
#if HAS_REFLECTION && HAS_TRANSMISSION
    packet waiting[STACK];
    uint height = 0;
#endif
    NOTE(p.sent = note_tree(s->notes));
    for (;;) {
        NOTE(p.sent.x = note_ray(s->notes, p.sent, p.depth, p.origin, p.direction, p.weight));
        const encounter e = meet_visible(s, &p);
#if HAS_TRANSMISSION
        NOTE(note_before(s->notes, p.in.material));
#endif
        const ints found = p.active & (e.h.primitive >= 0);
        NOTE(note_background(s->notes, see_background(camera, &p, p.active & !found)));
        sum.colour = add(sum.colour, see_background(camera, &p, p.active & !found));
        sum.deepest = p.active ? max(sum.deepest, whole(p.depth)) : sum.deepest;
        if (p.depth == 1)
            sum.hits = count_where(whole(0), found);
        children next;
        next.reflected.active = next.transmitted.active = mask(false);
        if (any_ray(found)) {
            const shade_point q = make_shade_point(&p, &e);
            NOTE(note_surface(s->notes, q.point, q.normal, q.shading, q.r));
#if BENDS
            NOTE(note_refraction(s, &p, &e, &q));
#endif
            const illumination lit = illuminate_locally(s, &q, splat_xyz(camera->ambient), e.id.material, found);
            NOTE(note_local(s->notes, lit.colour));
            sum.colour = add(sum.colour, mul(where(found, p.weight), lit.colour));
            sum.shadow += lit.feelers;
            next = send_children(s, &p, &e, &q, found, camera->limits.x, depth, &sum);
        }
        if (any_ray(next.reflected.active)) {
            p = next.reflected;
#if HAS_REFLECTION && HAS_TRANSMISSION
            if (any_ray(next.transmitted.active))
                waiting[height++] = next.transmitted;
#endif
        } else if (any_ray(next.transmitted.active)) {
            p = next.transmitted;
#if HAS_REFLECTION && HAS_TRANSMISSION
        } else if (height > 0) {
            p = waiting[--height];
#endif
        } else {
            return sum;
        }
    }
}
