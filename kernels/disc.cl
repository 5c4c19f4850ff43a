// disc.cl

crossing intersect_disc(ray r, vectors centre, vectors normal, reals radius, uint flags) {
    crossing c = intersect_plane(r, centre, normal, flags);
    const vectors p = along(sub(r.origin, centre), r.direction, c.distance);
    c.found &= dot3(p, p) <= radius * radius;
    return c;
}
