// box.cl - the axis-aligned box: its own bounds. It is met where its widened interval is not empty, but left where its planes
// are, so that boxes that share a plane agree on it.

crossing intersect_box(ray r, vectors low, vectors high, uint flags) {
    const interval i = intersect_slabs(r, low, high);
    return first_ahead(r, i.near <= widen(i.far), i.near, max(i.near, i.far), flags);
}

// The face hit is the one whose plane the ray meets nearest to the hit's distance; its coordinate is set exactly, the others
// are kept inside.
surface surface_box(ray r, reals distance, vectors low, vectors high) {
    const vectors zero = make_vectors(splat(0), splat(0), splat(0));
    const vectors p = along(r.origin, r.direction, distance);
    const vectors a = mul(sub(low, r.origin), r.inverse), b = mul(sub(high, r.origin), r.inverse);
    // How far each face's own distance is from the hit's.
    const vectors to_low = absolute(sub(a, make_vectors(distance, distance, distance)));
    const vectors to_high = absolute(sub(b, make_vectors(distance, distance, distance)));
    const vectors to_face = make_vectors(min(to_low.x, to_high.x), min(to_low.y, to_high.y), min(to_low.z, to_high.z));
    const ints is_x = (to_face.x <= to_face.y) & (to_face.x <= to_face.z);
    const ints is_y = !is_x & (to_face.y <= to_face.z);
    const ints is_z = !is_x & !is_y;
    const ints high_x = to_high.x < to_low.x, high_y = to_high.y < to_low.y, high_z = to_high.z < to_low.z;
    surface s;
    s.point.x = is_x ? (high_x ? high.x : low.x) : min(max(p.x, low.x), high.x);
    s.point.y = is_y ? (high_y ? high.y : low.y) : min(max(p.y, low.y), high.y);
    s.point.z = is_z ? (high_z ? high.z : low.z) : min(max(p.z, low.z), high.z);
    s.normal.x = is_x ? (high_x ? splat(1) : splat(-1)) : zero.x;
    s.normal.y = is_y ? (high_y ? splat(1) : splat(-1)) : zero.y;
    s.normal.z = is_z ? (high_z ? splat(1) : splat(-1)) : zero.z;
    s.shading = s.normal;
    s.error = zero; // along the normal the point is exact
    return s;
}
