// sphere.cl

// Roots of |f + t d|^2 = r^2 without cancellation: the discriminant from the chord's distance (Hearn and Baker; Haines
// et al., Ray Tracing Gems ch. 7), the smaller root by division (Press et al., 5.6), |f|^2 - r^2 factored.
crossing intersect_sphere(ray r, vectors centre, reals radius, uint flags) {
    const vectors f = sub(r.origin, centre);
    const reals a = dot3(r.direction, r.direction);
    const reals b = -dot3(f, r.direction);
    const vectors chord = along(f, r.direction, b / a);
    // Roots are dear: a ray that passes by is known by the squares, unless it is at the edge or they are too small to tell.
    const reals near = dot3(chord, chord), far = dot3(f, f);
    const reals reach = max(radius * radius * (R(1) + R(8) * UNIT), splat(SMALLEST_NORMAL / UNIT));
    crossing none = {mask(false), splat(0), splat(0), splat(0)};
    if (!any_lane((near <= reach) | (far <= reach)))
        return none;
    const reals apart = sqrt(near), length = sqrt(far);
    const reals c = (length - radius) * (length + radius);
    const reals discriminant = a * ((radius - apart) * (radius + apart));
    const reals q = b + copysign(sqrt(max(discriminant, splat(0))), b);
    const reals s = c / q, t = q / a;
    return first_ahead(r, (discriminant >= splat(0)) | (c < splat(0)), min(s, t), max(s, t), flags);
}

// The normal from the chord: its middle's offset from the centre, at a right angle to the ray, and half its length along the
// ray. So it faces the origin where the ray enters, even where the distance cannot tell the sphere's points apart.
surface surface_sphere(ray r, reals distance, vectors centre, reals radius) {
    surface s;
    const vectors f = sub(r.origin, centre);
    const reals middle = -dot3(f, r.direction) / dot3(r.direction, r.direction);
    const vectors rough = along(f, r.direction, middle);
    const vectors across = along(rough, r.direction, -dot3(rough, r.direction));
    const reals apart = sqrt(dot3(across, across));
    const reals half_chord = sqrt(max((radius - apart) * (radius + apart), splat(0)));
    const vectors out = along(across, r.direction, distance < middle ? -half_chord : half_chord);
    // Divided by the radius first: the square of a tiny length would vanish.
    s.normal = normalise_or(scale(out, splat(1) / radius), negate(r.direction));
    s.shading = s.normal;
    const vectors p = scale(s.normal, radius);
    s.point = add(centre, p);
    s.error = add(scale(absolute(p), splat(GAMMA(5))), scale(absolute(s.point), splat(UNIT)));
    return s;
}
