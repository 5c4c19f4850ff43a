// media.cl - the media that a ray is in (Schmidt and Budge 2002, Simple Nested Dielectrics in Ray Traced Images): the
// materials of the solids entered and not yet left, outermost first. The one of highest priority counts, among equals the
// last entered. A full list takes no more.

typedef struct {
    ints material[MEDIA];
} media; // -1: no entry

media no_media(void) {
    media m;
    for (int i = 0; i < MEDIA; i++)
        m.material[i] = whole(-1);
    return m;
}

reals priority_of(const scene *s, ints material) {
#if HAS_PRIORITY
    return GATHER(s->materials, max(material, whole(0)), optics).xyz.y;
#else
    return splat(0);
#endif
}

// The medium that counts, or -1 outside everything.
ints dominant(const scene *s, const media *m) {
    ints best = whole(-1);
    reals highest = splat(-INFINITY);
    for (int i = 0; i < MEDIA; i++) {
        const reals priority = priority_of(s, m->material[i]);
        const ints wins = (m->material[i] >= 0) & (priority >= highest);
        best = wins ? m->material[i] : best;
        highest = wins ? priority : highest;
    }
    return best;
}

INLINE media enter_medium(media m, ints material) {
    ints placed = mask(false);
    for (int i = 0; i < MEDIA; i++) {
        const ints here = !placed & (m.material[i] < 0);
        m.material[i] = here ? material : m.material[i];
        placed |= here;
    }
    return m;
}

ints contains_medium(const media *m, ints material) {
    ints found = mask(false);
    for (int i = 0; i < MEDIA; i++)
        found |= m->material[i] == material;
    return found;
}

// Removes the latest entry of the material, if there is one.
INLINE media leave_medium(media m, ints material) {
    ints last = whole(MEDIA);
    for (int i = 0; i < MEDIA; i++)
        last = m.material[i] == material ? whole(i) : last;
    for (int i = 0; i < MEDIA; i++) {
        const ints next = i + 1 < MEDIA ? m.material[i + 1 < MEDIA ? i + 1 : i] : whole(-1);
        m.material[i] = whole(i) >= last ? next : m.material[i];
    }
    return m;
}

INLINE media choose_media(ints mask, media a, media b) {
    for (int i = 0; i < MEDIA; i++)
        a.material[i] = mask ? a.material[i] : b.material[i];
    return a;
}

reals index_of(const scene *s, ints material) {
    const reals index = GATHER(s->materials, max(material, whole(0)), optics).xyz.x;
    return material < 0 ? splat(1) : index;
}

// What a ray passes at a surface of a transmitting material: the media before (the one that counts) and behind,
// eta = eta_v / eta_t, and whether the boundary is there at all: a medium of higher priority may hide it.
typedef struct {
    reals eta;
    ints here, visible;
    media behind;
} boundary;

// Leaving what was never entered (an open surface, met from its back) is as leaving it for the medium that counts.
boundary cross_boundary(const scene *s, const media *in, ints material, ints entering) {
    const ints known = entering | contains_medium(in, material);
    const ints full = entering & (in->material[MEDIA - 1] >= 0); // the list takes no more, but the surface bends
    boundary b;
    b.behind = choose_media(entering, enter_medium(*in, material), leave_medium(*in, material));
    b.here = known ? dominant(s, in) : material;
    const ints there = full ? material : dominant(s, &b.behind);
    b.visible = !known | full | (entering ? there == material : b.here == material);
    b.eta = index_of(s, b.here) / index_of(s, there);
    return b;
}

// The same boundary when it is also one of another material's, at the same place.
INLINE boundary merge_boundary(const scene *s, boundary b, ints material, ints entering) {
    b.behind = choose_media(entering, enter_medium(b.behind, material), leave_medium(b.behind, material));
    const ints there = dominant(s, &b.behind);
    b.visible = b.here != there;
    b.eta = index_of(s, b.here) / index_of(s, there);
    return b;
}

// An opaque surface bounds no medium: it is seen from the one that counts, and nothing changes behind it.
INLINE boundary meet_opaque(const scene *s, const media *in, ints material, ints entering) {
    const reals around = index_of(s, dominant(s, in)), own = index_of(s, material);
    boundary b;
    b.eta = entering ? around / own : own / around;
    b.here = material;
    b.behind = *in;
    b.visible = mask(true);
    return b;
}

INLINE boundary choose_boundary(ints m, boundary a, boundary b) {
    a.eta = m ? a.eta : b.eta;
    a.here = m ? a.here : b.here;
    a.visible = m ? a.visible : b.visible;
    a.behind = choose_media(m, a.behind, b.behind);
    return a;
}
