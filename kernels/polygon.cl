// polygon.cl - a planar polygon, convex or concave.

// Even-odd rule for the sheared corners and the point (0, 0), each crossing decided by the exact sign of an edge's
// difference of products (see triangle.cl): polygons that share an edge share its decision.
crossing intersect_polygon(ray r, global const real4 *corners, uint count, vectors point, vectors normal, uint flags) {
    crossing c = intersect_plane(r, point, normal, flags);
    ints inside = mask(false);
    vectors a = apply_shear(r, splat_xyz(corners[count - 1]));
    for (uint i = 0; i < count; i++) {
        const vectors b = apply_shear(r, splat_xyz(corners[i]));
        const reals unit = power_over(max(largest_across(a), largest_across(b)));
        const vectors p = scale_across(a, unit), q = scale_across(b, unit);
        const reals side = difference_of_products(p.x, q.y, p.y, q.x);
        const ints crosses = (a.y > splat(0)) != (b.y > splat(0));
        const ints right = ((side > splat(0)) & (b.y > a.y)) | ((side < splat(0)) & (b.y < a.y));
        inside ^= crosses & right;
        a = b;
    }
    c.found &= inside;
    return c;
}
