// triangle.cl - Woop, Benthin, Wald 2013, with edges by Kahan's difference of products: their signs are exact for the
// sheared corners, so that neighbours never both miss and no second pass in double is needed.

// Whether (0, 0) is to the left of the edge from p to q, whose difference of products is e. On the edge, the point counts as
// moved a little along x and still less along y: of two triangles that share an edge or a corner exactly one is met, as a
// solid's inside needs it (Edelsbrunner and Muecke 1990, Simulation of Simplicity).
ints is_left(vectors p, vectors q, reals e) {
    return (e > splat(0)) | ((e == splat(0)) & ((p.y > q.y) | ((p.y == q.y) & (q.x > p.x))));
}

// The normal of a counter-clockwise triangle, of some length. Edges are divided by their largest component first: their
// product must not leave the range of numbers. Where the first corner is so far from the others that both edges to it are
// one, the third edge still tells.
vectors triangle_normal(vectors v0, vectors v1, vectors v2) {
    const vectors a = sub(v1, v0), b = sub(v2, v0);
    const vectors along_a = scale(a, splat(1) / largest(absolute(a)));
    vectors n = cross3(along_a, scale(b, splat(1) / largest(absolute(b))));
    const ints lost = dot3(n, n) == splat(0);
    if (any_lane(lost)) {
        const vectors c = sub(v2, v1);
        n = choose(lost, cross3(along_a, scale(c, splat(1) / largest(absolute(c)))), n);
    }
    return n;
}

// Whether the triangle's plane is ahead of the origin, by the corner that tells best. The distance, in which the corners'
// distances cancel, cannot say so for a ray that starts on a triangle far larger than the distance.
ints is_before(vectors origin, vectors direction, vectors v0, vectors v1, vectors v2) {
    const vectors n = normalise(triangle_normal(v0, v1, v2)), size = absolute(n);
    const vectors a = sub(v0, origin), b = sub(v1, origin), c = sub(v2, origin);
    const reals of_a = dot3(size, absolute(a)), of_b = dot3(size, absolute(b)), of_c = dot3(size, absolute(c));
    const vectors best = choose((of_a <= of_b) & (of_a <= of_c), a, choose(of_b <= of_c, b, c));
    return (dot3(n, best) > splat(0)) == (dot3(n, direction) > splat(0));
}

crossing intersect_triangle(ray r, vectors v0, vectors v1, vectors v2, uint flags) {
    vectors a = apply_shear(r, v0), b = apply_shear(r, v1), c = apply_shear(r, v2);
    const reals unit = power_over(max(largest_across(a), max(largest_across(b), largest_across(c))));
    a = scale_across(a, unit);
    b = scale_across(b, unit);
    c = scale_across(c, unit);
    const reals e0 = difference_of_products(c.x, b.y, c.y, b.x);
    const reals e1 = difference_of_products(a.x, c.y, a.y, c.x);
    const reals e2 = difference_of_products(b.x, a.y, b.y, a.x);
    const reals sum = e0 + e1 + e2;
    const ints s0 = is_left(c, b, e0), s1 = is_left(a, c, e1), s2 = is_left(b, a, e2);
    crossing x;
    x.found = ((s0 & s1 & s2) | !(s0 | s1 | s2)) & (sum != splat(0));
    x.distance = x.u = x.v = splat(0);
    if (!any_lane(x.found))
        return x;
    x.u = e1 / sum; // weights first: no product of three lengths, which would overflow where the scene is large
    x.v = e2 / sum;
    x.distance = fma(e0 / sum, a.z, fma(x.u, b.z, x.v * c.z));
#if HAS_ONE_SIDED
    // Counter-clockwise corners are seen from the front; the shear mirrors where it turns an odd permutation or flips z.
    const ints front = (sum > splat(0)) == (r.shear.z > splat(0));
    x.found &= mask(!(flags & FLAG_FRONT_HIDDEN)) | !front;
    x.found &= mask(!(flags & FLAG_BACK_HIDDEN)) | front;
#endif
    return x;
}

vectors interpolate(vectors a, vectors b, vectors c, reals u, reals v) {
    const reals w = splat(1) - u - v;
    return make_vectors(fma(w, a.x, fma(u, b.x, v * c.x)), fma(w, a.y, fma(u, b.y, v * c.y)),
                        fma(w, a.z, fma(u, b.z, v * c.z)));
}

// The point from the weights of the corners, which is nearer to the triangle than the ray's (pbrt 4th ed., 6.8.5). Rounding
// may leave no area to corners that have some: then it is seen as facing the ray.
surface surface_triangle(ray r, vectors v0, vectors v1, vectors v2, reals u, reals v) {
    surface s;
    const reals w = splat(1) - u - v;
    s.point = interpolate(v0, v1, v2, u, v);
    s.error = add(add(absolute(scale(v0, w)), absolute(scale(v1, u))), absolute(scale(v2, v)));
    s.error = scale(s.error, splat(GAMMA(9))); // 7 as in pbrt, 2 more for w
    s.normal = s.shading = normalise_or(triangle_normal(v0, v1, v2), negate(r.direction));
    return s;
}
