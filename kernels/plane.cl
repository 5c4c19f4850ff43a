// plane.cl

// n.(p - o) / n.d, parallel rays aside.
crossing intersect_plane(ray r, vectors point, vectors normal, uint flags) {
    const reals slope = dot3(normal, r.direction);
    crossing c;
    c.distance = dot3(normal, sub(point, r.origin)) / slope;
    c.found = (slope != splat(0)) & (c.distance < splat(INFINITY));
    c.u = c.v = splat(0);
#if HAS_ONE_SIDED
    c.found &= mask(!(flags & FLAG_FRONT_HIDDEN)) | (slope > splat(0));
    c.found &= mask(!(flags & FLAG_BACK_HIDDEN)) | (slope < splat(0));
#endif
    return c;
}

// The point at the distance, put back onto the plane: what rounding moved it away grows with the distance, the residual
// n.(p - point) tells by how much.
surface surface_plane(ray r, reals distance, vectors point, vectors normal) {
    surface s;
    const vectors p = along(r.origin, r.direction, distance);
    s.point = along(p, normal, -dot3(normal, sub(p, point)));
    s.error = scale(add(add(absolute(s.point), absolute(p)), absolute(point)), splat(GAMMA(5)));
    s.normal = s.shading = normal;
    return s;
}
