// pixel.cl - what the samples of the pixels add up to.
//
// The order of a sum is part of the picture: sample i goes to part i mod PARTS, then those parts are added that are half
// of all apart, and so on. That is the same for any number of lanes.
#define PARTS 16
#define PACKETS (ONE_PACKET ? 1 : PARTS / PER_PIXEL) // whose lanes are a pixel's parts

// Half of the lanes are added to the others until one is left for each pixel.
#if PIXELS == 1
#define ADD_HALVES(a, f) (a) = FOLD(a, f)
#else
#define ADD_HALVES(a, f)                                                                                               \
    for (uint gap = RAYS / 2; gap >= PIXELS; gap /= 2)                                                                 \
        for (uint i = 0; i < gap; i++)                                                                                 \
    ((private __typeof__(FOLD(a, f)) *)&(a))[i] += ((private __typeof__(FOLD(a, f)) *)&(a))[i + gap]
#endif

// Two trees as one.
INLINE tree_sum add_trees(tree_sum a, const tree_sum *b) {
    a.colour = add(a.colour, b->colour);
    a.discarded = add(a.discarded, b->discarded);
    a.hits += b->hits;
    a.reflection += b->reflection;
    a.transmission += b->transmission;
    a.shadow += b->shadow;
    a.deepest = max(a.deepest, b->deepest);
    return a;
}

// All samples' trees, for each pixel in the lane of its number.
INLINE tree_sum add_parts(tree_sum parts[PACKETS], uint packets) {
    for (uint gap = PACKETS / 2; gap > 0; gap /= 2)
        for (uint i = 0; i < gap && i + gap < packets; i++)
            parts[i] = add_trees(parts[i], &parts[i + gap]);
#if RAYS > 1
    ADD_HALVES(parts->colour.x, plus);
    ADD_HALVES(parts->colour.y, plus);
    ADD_HALVES(parts->colour.z, plus);
    if (any_lane(parts->hits != 0)) { // else nothing was sent or discarded
        ADD_HALVES(parts->discarded.x, plus);
        ADD_HALVES(parts->discarded.y, plus);
        ADD_HALVES(parts->discarded.z, plus);
        ADD_HALVES(parts->hits, count);
        ADD_HALVES(parts->reflection, count);
        ADD_HALVES(parts->transmission, count);
        ADD_HALVES(parts->shadow, count);
    }
#endif
    return parts[0];
}

// How deep a pixel's rays went.
uint deepest_level(const tree_sum *sum, uint pixel) {
    integer deepest = 0;
    for (uint lane = pixel; lane < RAYS; lane += PIXELS)
        deepest = max(deepest, INT_LANE(sum->deepest, lane));
    return deepest;
}
