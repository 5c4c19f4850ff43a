// vec.hpp - vectors of three numbers, or of three packets of numbers.
#pragma once

#include "lanes.hpp"

template <class T> struct Vec { T x, y, z; };

using Point = Vec<float>;

template <class T> inline Vec<T> operator+(Vec<T> a, Vec<T> b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T> inline Vec<T> operator-(Vec<T> a, Vec<T> b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T> inline Vec<T> operator-(Vec<T> a) {
    return {-a.x, -a.y, -a.z};
}
template <class T> inline Vec<T> operator*(Vec<T> a, T s) {
    return {a.x * s, a.y * s, a.z * s};
}
template <class T> inline T dot(Vec<T> a, Vec<T> b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T> inline Vec<T> cross(Vec<T> a, Vec<T> b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T> inline Vec<T> unit(Vec<T> a) {
    return a * (1 / square_root(dot(a, a)));
}
// The greatest of |x|, |y|, |z|.
template <class T> inline T extent(Vec<T> a) {
    return larger(larger(magnitude(a.x), magnitude(a.y)), magnitude(a.z));
}
template <class M, class T> inline Vec<T> choose(M mask, Vec<T> yes, Vec<T> no) {
    return {choose(mask, yes.x, no.x), choose(mask, yes.y, no.y), choose(mask, yes.z, no.z)};
}
template <class T> inline Vec<T> splat(Point p) {
    return {T{} + p.x, T{} + p.y, T{} + p.z};
}
