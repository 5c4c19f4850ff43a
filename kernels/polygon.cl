// polygon.cl - a planar polygon, convex or concave. Its corners are three rows, x, y and z, the last one in front again, and
// behind it as often as makes the row's length a multiple of WIDTH and one more.

uint corners_row(uint count) {
    return (count + WIDTH - 1) / WIDTH * WIDTH + 1;
}

// The corners k, k + 1, ..., or corner k for every ray, sheared.
INLINE vectors shear_corners(ray r, global const real *rows, uint length, uint k, bool together) {
    rows += k;
    return apply_shear(
        r, together ? make_vectors(load_row(rows, 0), load_row(rows + length, 0), load_row(rows + 2 * length, 0))
                    : make_vectors(splat(rows[0]), splat(rows[length]), splat(rows[2 * length])));
}

// Whether the sheared edge crosses the half line from (0, 0) along x, decided by the exact sign of a difference of products
// (see triangle.cl): polygons that share an edge share its decision.
INLINE ints edge_crosses(vectors a, vectors b) {
    const reals unit = power_over(max(largest_across(a), largest_across(b)));
    const vectors p = scale_across(a, unit), q = scale_across(b, unit);
    const reals side = difference_of_products(p.x, q.y, p.y, q.x);
    const ints right = ((side > splat(0)) & (b.y > a.y)) | ((side < splat(0)) & (b.y < a.y));
    return ((a.y > splat(0)) != (b.y > splat(0))) & right;
}

// Even-odd rule for the sheared corners and the point (0, 0): one ray against many edges, or many rays against one at a time.
INLINE ints is_inside(ray r, global const real *corners, uint count, bool together) {
    const uint length = corners_row(count);
    ints inside = mask(false);
    uint crossings = 0;
    vectors a = shear_corners(r, corners, length, 0, together);
    for (uint k = 0; k < count; k += together ? CHUNK : 1) {
        if (together && k > 0)
            a = shear_corners(r, corners, length, k, together);
        const vectors b = shear_corners(r, corners, length, k + 1, together);
        const ints crosses = edge_crosses(a, b);
        if (together)
            crossings += popcount(lane_bits(crosses) & ((1u << CHUNK) - 1));
        inside ^= crosses;
        a = b;
    }
    return together ? mask(crossings & 1) : inside;
}
