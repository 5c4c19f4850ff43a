// margin.cl - how far the least certain decision about a ray is from the other one, in bounds of its rounding error.
//
// After a ray's hit is known, everything that it comes near is asked once more (passage.cl). A primitive counts only if the
// ray meets its own box, wider by LIMIT bounds on every side; that is monotone in the box, so that a tree finds what brute
// force does. Nothing else depends on the order in which primitives are asked: margins have the same bits by either.
#if MARGIN

// The nearest hit, whether there is any before `limit`, or which ones there are.
enum { NEAREST, ANY, EACH };

typedef struct {
    int kind;
    real limit, error; // of ANY and EACH; NEAREST: the hit's distance, and what it may be off by
    integer winner, winner_inside;
    uint winner_passage;
    real margin;
} decision;

// An eye ray's direction: three packed vectors, two products, two sums (4 u, for both the frame's rows and the place in it
// have length 1), divided by their length.
#define BLUR_OF_DIRECTION GAMMA(9)

pencil make_pencil(ray r, vectors origin, real direction, const hit *source) {
    pencil p;
    p.ray = r;
    p.origin = origin;
    p.direction = make_vectors(direction, direction, direction);
    p.source = source->primitive;
    p.source_inside = -1;
#if HAS_INSTANCE
    p.source_inside = source->inside;
#endif
    return p;
}

// How sure it is that the passage is a hit. What the ray has just left is behind it by the way that it started (spawn): a
// passage of the same primitive within a few bounds is that one. What a ray that goes through surfaces has passed has been
// decided.
real sure_of(const pencil *p, const passage *c, bool own, bool wins) {
    if (own && !wins && c->distance < R(4) * c->error)
        return -R(INFINITY);
    if (p->ray.least > R(0))
        return c->distance > p->ray.least ? c->there : -R(INFINITY);
    return min(c->there, in_bounds(c->distance, c->error));
}

// A rival does not win because it is missed, or because it is farther away.
void weigh(decision *d, const pencil *p, const passage *c, bool own, bool wins) {
    const real met = sure_of(p, c, own, wins);
    if (d->kind == NEAREST) {
        const real farther = d->winner < 0 ? -R(INFINITY) : in_bounds(c->distance - d->limit, c->error + d->error);
        d->margin = min(d->margin, wins ? fabs(met) : max(max(-met, farther), R(0)));
        return;
    }
    const real blocks = min(met, d->limit < R(INFINITY) ? in_bounds(d->limit - c->distance, c->error) : R(INFINITY));
    d->margin = d->kind == ANY ? max(d->margin, blocks) : min(d->margin, fabs(blocks));
}

// `instance`: the number of the one that the primitive is in, or -1.
void weigh_primitive(const scene *s, decision *d, const pencil *p, integer number, integer instance) {
    passage ways[MOST_PASSAGES];
    const uint count = find_passages(s, p, s->primitives[number], ways);
    const integer outer = instance < 0 ? number : instance, inner = instance < 0 ? -1 : number;
    const bool own = p->source == outer && (inner < 0 || p->source_inside == inner);
    const bool holds = d->winner == outer && d->winner_inside == inner;
    for (uint k = 0; k < count; k++)
        weigh(d, p, &ways[k], own, holds && d->winner_passage == k);
}

// Whether something in this box could matter: LIMIT bounds of anything in it, and no farther than what has been found.
bool could_matter(const decision *d, const pencil *p, vectors low, vectors high) {
    const vectors farthest = add(absolute(p->ray.origin), greatest_xyz(absolute(low), absolute(high)));
    const real way = farthest.x + farthest.y + farthest.z, speed = length_of(p->ray.direction);
    const real blur = (p->origin.x + p->origin.y + p->origin.z) +
                      (p->direction.x + p->direction.y + p->direction.z) * (way / speed) + GAMMA(32) * way;
    const real pad = LIMIT * blur;
    const vectors wider = make_vectors(pad, pad, pad);
    const interval i = intersect_bounds(p->ray, sub(low, wider), add(high, wider));
    const real most = d->kind == NEAREST && d->winner >= 0 ? fma(LIMIT, d->error, d->limit) : d->limit;
    return i.near <= i.far && i.far >= R(0) && i.near <= most;
}

// What waits, and the instance's number in whose space it is, or -1.
typedef struct {
    uint2 link;
    integer space;
} place;

#if HAS_INSTANCE
// The pencil as the group sees it (move_ray). Distances there are the world's times a power of two.
pencil move_pencil(const placement *at, const pencil *p) {
    const rows back = absolute_rows(at->to_object);
    const vectors size = add(absolute(p->ray.origin), absolute(at->offset));
    const vectors sum = add(p->origin, scale(size, GAMMA(6)));
    const vectors slant = add(p->direction, scale(absolute(p->ray.direction), GAMMA(6)));
    pencil q = *p;
    q.ray = move_ray(at, &p->ray);
    q.ray.least = p->ray.least * at->unit;
    q.origin = choose(at->turned, apply(back, sum), sum);
    q.direction = choose(at->turned, scale(apply(back, slant), at->inverse_unit), p->direction);
    return q;
}

decision move_decision(const placement *at, const decision *d) {
    decision e = *d;
    e.limit = d->limit * at->unit;
    e.error = d->error * at->unit;
    return e;
}
#endif

void weigh_block(const scene *s, decision *d, const pencil *p, uint2 link, integer instance) {
    const uint kind = link.y >> TAG_KIND;
    global const real *block = s->blocks + (size_t)link.x * WIDTH;
    global const uint *numbers = s->block_numbers + (link.y & TAG_NUMBER) * WIDTH;
    for (uint k = 0; k < WIDTH; k++) {
        if (k > 0 && numbers[k] == numbers[k - 1])
            return; // only repetitions follow
        const boxes b = load_boxes(block, kind, k, APART);
        if (could_matter(d, p, b.low, b.high))
            weigh_primitive(s, d, p, numbers[k], instance);
    }
}

// Everything from a link on.
NOINLINE void weigh_below(const scene *s, decision *d, const pencil *p, uint2 first) {
    place waiting[2 * TREE_STACK];
    uint height = 0;
    waiting[height++] = (place){first, -1};
#if HAS_INSTANCE
    pencil moved = *p; // in the instance that was entered last: all that is in it lies on top
    decision inside = *d;
#endif
    while (height > 0) {
        const place here = waiting[--height];
        const pencil *q = p;
        decision *e = d;
#if HAS_INSTANCE
        if (here.space >= 0) {
            inside.margin = d->margin;
            q = &moved;
            e = &inside;
        } else if (is_instance(here.link)) {
            const integer number = instance_number(s, here.link);
            const uint index = s->primitives[number].y;
            const uint4 roots = s->instance_roots[index];
            if (!could_matter(d, p, splat_xyz(s->instances[index].bounds.low),
                              splat_xyz(s->instances[index].bounds.high)))
                continue;
            const placement at = find_placement(s, index);
            moved = move_pencil(&at, p);
            inside = move_decision(&at, d);
            if (HAS_TREE) {
                waiting[height++] = (place){first_link(s, roots.x), number};
                continue;
            }
            for (uint k = roots.x; k < roots.y; k++)
                weigh_block(s, &inside, &moved, first_link(s, k), number);
            d->margin = inside.margin;
            continue;
        }
#endif
        if (here.link.y == LINK_NODE) {
            global const real *rows = s->nodes + (size_t)here.link.x * NODE_ROWS * WIDTH;
            for (uint k = 0; k < WIDTH; k++) {
                const vectors low = load_rows(rows, k), high = load_rows(rows + 3 * WIDTH, k);
                if (low.x < R(INFINITY) && could_matter(e, q, low, high)) // else an empty place
                    waiting[height++] = (place){s->links[(size_t)here.link.x * WIDTH + k], here.space};
            }
        } else {
            weigh_block(s, e, q, here.link, here.space);
        }
        d->margin = e->margin;
    }
}

real weigh_all(const scene *s, decision *d, const pencil *p) {
#if HAS_PLANE
    for (uint i = 0; i < s->count.w; i++)
        weigh_primitive(s, d, p, s->block_numbers[s->count.y * WIDTH + i], -1);
#endif
#if HAS_TREE
    if (s->count.z > 0)
        weigh_below(s, d, p, first_link(s, 0));
#else
    for (uint k = 0; k < s->count.y; k++)
        weigh_below(s, d, p, first_link(s, k));
#endif
    return min(fabs(d->margin), LIMIT);
}

// Which passage of what was hit is the hit, and what its distance may be off by.
void know_winner(const scene *s, decision *d, const pencil *p, const hit *h) {
    passage ways[MOST_PASSAGES];
    uint4 primitive = s->primitives[h->primitive];
    pencil q = *p;
    real unit = R(1);
#if HAS_INSTANCE
    if (primitive.x == KIND_INSTANCE) {
        const placement at = find_placement(s, primitive.y);
        q = move_pencil(&at, p);
        unit = at.unit;
        primitive = s->primitives[h->inside];
        d->winner_inside = h->inside;
    }
#endif
    d->winner = h->primitive;
    d->limit = h->distance;
    d->error = R(INFINITY);
    const uint count = find_passages(s, &q, primitive, ways);
    real least = R(INFINITY);
    for (uint k = 0; k < count; k++) {
        const real off = fabs(ways[k].distance - h->distance * unit);
        if (off < least) {
            least = off;
            d->winner_passage = k;
            d->error = ways[k].error / unit;
        }
    }
}

real margin_of_hit(const scene *s, const pencil *p, const hit *h) {
    decision d = {NEAREST, R(INFINITY), R(0), -1, -1, 0, R(INFINITY)};
    if (h->primitive >= 0)
        know_winner(s, &d, p, h);
    return weigh_all(s, &d, p);
}

// Of a feeler that ends at `limit`: one surface that blocks it for certain is enough. A filtered one asks all of them.
real margin_of_feeler(const scene *s, const pencil *p, real limit) {
    decision d = {
        HAS_FILTERED_SHADOWS ? EACH : ANY, limit, R(0), -1, -1, 0, HAS_FILTERED_SHADOWS ? R(INFINITY) : -R(INFINITY)};
    return weigh_all(s, &d, p);
}

// What a normal's direction may be off by: rounding, and where the surface is curved, what moves the point along it.
real blur_of_own_normal(const scene *s, const pencil *p, uint4 primitive, real distance) {
    real radius = R(INFINITY), own = GAMMA(8);
#if HAS_SPHERE
    if (primitive.x == KIND_SPHERE)
        radius = s->spheres[primitive.y].centre_radius.w;
#endif
#if HAS_CONE
    if (primitive.x == KIND_CONE) {
        const cone c = s->cones[primitive.y];
        const vectors axis = splat_xyz(c.axis);
        const vectors from = sub(along(p->ray.origin, p->ray.direction, distance), splat_xyz(c.base_radius));
        radius = length_of(along(from, axis, -dot3(from, axis)));
    }
#endif
#if HAS_TRIANGLE
    if (primitive.x == KIND_TRIANGLE) {
        const uint4 corners = s->triangles[primitive.y];
        const vectors a = splat_xyz(s->vertices[corners.x]), u = sub(splat_xyz(s->vertices[corners.y]), a),
                      v = sub(splat_xyz(s->vertices[corners.z]), a);
        const real longest = max(max(length_of(u), length_of(v)), length_of(sub(v, u)));
        const real height = length_of(cross3(u, v)) / longest;
        own += GAMMA(4) * (length_of(a) + longest) / height;
        radius = (primitive.w & FLAG_SMOOTH) ? height / R(2) : radius;
    }
#endif
    const vectors way = scale(p->ray.direction, distance);
    return own + (length_of(blur_at(p, distance)) + GAMMA(5) * (length_of(p->ray.origin) + length_of(way))) / radius;
}

// What is known of a hit only roughly: where the point is on the surface, and which way its normal goes.
typedef struct {
    vectors point;
    real normal;
} doubt;

doubt doubt_surface(const scene *s, const pencil *p, const hit *h, const surface *f) {
    const real slope = max(fabs(dot3(p->ray.direction, f->normal)), UNIT);
    const vectors blur = blur_at(p, h->distance);
    doubt e;
    e.point = add(f->error, along(blur, absolute(p->ray.direction), splat(dot3(absolute(f->normal), blur) / slope)));
#if HAS_INSTANCE
    const uint4 outer = s->primitives[h->primitive];
    if (outer.x == KIND_INSTANCE) {
        const placement at = find_placement(s, outer.y);
        const pencil q = move_pencil(&at, p);
        const vectors ones = make_vectors(R(1), R(1), R(1));
        const real stretch =
            length_of(apply(absolute_rows(at.to_world), ones)) * length_of(apply(absolute_rows(at.to_object), ones));
        const real normal = blur_of_own_normal(s, &q, s->primitives[h->inside], h->distance * at.unit) / slope;
        e.normal = at.turned ? normal * stretch : normal;
        return e;
    }
#endif
    e.normal = blur_of_own_normal(s, p, s->primitives[h->primitive], h->distance) / slope;
    return e;
}

// What the direction may be off by of a ray that is reflected (16.9), v and n being off by so much.
real blur_of_reflection(real v, real n) {
    return v + R(2) * n + GAMMA(12);
}

// And of one that is refracted (16.17, 16.18): t_perp's root loses near the critical angle.
real blur_of_refraction(vectors t, vectors n, real eta, real v, real n_blur) {
    const real cosine = max(fabs(dot3(t, n)), UNIT), sine = sqrt(max(R(1) - cosine * cosine, R(0)));
    return eta * (v + R(2) * n_blur) * (R(1) + sine / cosine) + n_blur + GAMMA(16) * (R(1) + sine / cosine);
}

void lower_margin(const scene *s, real margin) {
    *s->margin = min(*s->margin, margin);
}

// Which side of the surface a light is on: both normals must agree on it. Each side matters only if the material shows it.
void weigh_light(const scene *s, real cosine, real side, real bound, bool front, bool back) {
    if (front)
        lower_margin(s, fabs(in_bounds(min(cosine, side), bound)));
    if (back)
        lower_margin(s, fabs(in_bounds(min(-cosine, -side), bound)));
}

// |t_par|^2 < 1 (16.17): v and n are off by `tilt` together.
void weigh_critical_angle(const scene *s, vectors v, vectors n, real eta, real tilt) {
    const vectors parallel = scale(along(negate(v), n, dot3(v, n)), eta);
    const real squared = dot3(parallel, parallel);
    lower_margin(s, fabs(in_bounds(R(1) - squared, squared * GAMMA(12) + R(2) * sqrt(squared) * eta * tilt)));
}

#define PENCIL_OF(p, r) make_pencil(*(r), (p)->blur, (p)->slant, &(p)->source)
#define WEIGH_HIT(s, p, r, h)                                                                                          \
    do {                                                                                                               \
        const pencil around = PENCIL_OF(p, r);                                                                         \
        lower_margin(s, margin_of_hit(s, &around, h));                                                                 \
    } while (0)
#define WEIGH_SURFACE(s, p, r, e)                                                                                      \
    do {                                                                                                               \
        const pencil around = PENCIL_OF(p, r);                                                                         \
        (e)->doubt = doubt_surface(s, &around, &(e)->h, &(e)->f);                                                      \
    } while (0)
#define WEIGH_REFRACTION(s, p, e, q)                                                                                   \
    do {                                                                                                               \
        if (is_positive(GATHER((s)->materials, (e)->id.material, transmission).xyz) ||                                 \
            is_positive(GATHER((s)->materials, (e)->id.material, specular_transmission).xyz))                          \
            weigh_critical_angle(s, (q)->v, (q)->shading, (e)->b.eta, (q)->doubt.normal + (p)->slant);                 \
    } while (0)
// What the way to a light may be off by, per unit of its length.
#define BLUR_OF_WAY(q, l, length)                                                                                      \
    ((l)->is_near                                                                                                      \
         ? length_of(add((q)->doubt.point, add(blur_of_point((q)->point), blur_of_point((l)->position)))) / (length)   \
         : R(0))
#define WEIGH_LIGHT(s, q, c, l, cosine, side, squared)                                                                 \
    weigh_light(s, cosine, side, GAMMA(8) + (q)->doubt.normal + BLUR_OF_WAY(q, l, sqrt(squared)),                      \
                is_positive(mul((c)->diffuse, (l)->diffuse)) || is_positive(mul((c)->specular, (l)->specular)),        \
                is_positive(mul(BACK_DIFFUSE(c), (l)->diffuse)) || is_positive(mul(BACK_SPECULAR(c), (l)->specular)))
#if HAS_DIFFUSE_TRANSMISSION
#define BACK_DIFFUSE(c) (c)->diffuse_transmission
#else
#define BACK_DIFFUSE(c) make_vectors(R(0), R(0), R(0))
#endif
#if HAS_SPECULAR_TRANSMISSION
#define BACK_SPECULAR(c) (c)->specular_transmission
#else
#define BACK_SPECULAR(c) make_vectors(R(0), R(0), R(0))
#endif
#define WEIGH_FEELER(s, q, l, active, origin, direction, length, limit)                                                \
    do {                                                                                                               \
        const pencil around = make_pencil(make_ray(origin, direction), (q)->doubt.point,                               \
                                          GAMMA(4) + BLUR_OF_WAY(q, l, length), &(q)->source);                         \
        if (active)                                                                                                    \
            lower_margin(s, margin_of_feeler(s, &around, limit));                                                      \
    } while (0)
#else
#define WEIGH_HIT(s, p, r, h) ((void)0)
#define WEIGH_SURFACE(s, p, r, e) ((void)0)
#define WEIGH_REFRACTION(s, p, e, q) ((void)0)
#define WEIGH_LIGHT(s, q, c, l, cosine, side, squared) ((void)0)
#define WEIGH_FEELER(s, q, l, active, origin, direction, length, limit) ((void)0)
#endif
