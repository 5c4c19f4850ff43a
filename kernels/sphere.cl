// sphere.cl

// Roots of |f + t d|^2 = r^2 without cancellation: the discriminant from the chord's distance (Hearn and Baker; Haines
// et al., Ray Tracing Gems ch. 7), the smaller root by division (Press et al., 5.6), |f|^2 - r^2 factored.
crossing intersect_sphere(ray r, vectors centre, reals radius, uint flags) {
    const vectors f = sub(r.origin, centre);
    const reals a = dot3(r.direction, r.direction);
    const reals b = -dot3(f, r.direction);
    const vectors chord = along(f, r.direction, b / a);
    const reals apart = sqrt(dot3(chord, chord)), length = sqrt(dot3(f, f));
    const reals c = (length - radius) * (length + radius);
    const reals discriminant = a * ((radius - apart) * (radius + apart));
    const reals q = b + copysign(sqrt(max(discriminant, splat(0))), b);
    const reals s = c / q, t = q / a;
    return first_ahead(r, (discriminant >= splat(0)) | (c < splat(0)), min(s, t), max(s, t), flags);
}

surface surface_sphere(ray r, reals distance, vectors centre, reals radius) {
    surface s;
    // Where float cannot tell the sphere's points apart any more, the side that is seen. Divided by the radius first: the
    // square of a tiny length would vanish.
    const vectors out = scale(along(sub(r.origin, centre), r.direction, distance), splat(1) / radius);
    s.normal = normalise_or(out, negate(r.direction));
    s.shading = s.normal;
    const vectors p = scale(s.normal, radius);
    s.point = add(centre, p);
    s.error = add(scale(absolute(p), splat(GAMMA(5))), scale(absolute(s.point), splat(UNIT)));
    return s;
}
