// lanes.hpp - numbers of rays that travel together: a float and an int for one ray, vectors of them for a packet.
//
// A mask is made by a comparison and only combined with &, | and !, so that it may be 1 (one ray) or -1 (a lane).
#pragma once

#include <cmath>
#include <type_traits>

template <int N> struct Lanes {
    typedef float reals __attribute__((vector_size(4 * N)));
    typedef int ints __attribute__((vector_size(4 * N)));
};

template <> struct Lanes<1> {
    using reals = float;
    using ints = int;
};

template <int N> using Reals = typename Lanes<N>::reals;
template <int N> using Ints = typename Lanes<N>::ints;

template <class T> constexpr bool is_real = std::is_same_v<T, Reals<1>> || std::is_same_v<T, Reals<16>>;

// The lanes of a value as an array.
template <class T> inline auto as_array(T &value) {
    return reinterpret_cast<std::conditional_t<is_real<T>, float, int> *>(&value);
}
template <class T> inline auto as_array(const T &value) {
    return reinterpret_cast<std::conditional_t<is_real<T>, const float, const int> *>(&value);
}

template <class T> constexpr int lane_count = sizeof(T) / 4;

template <class T, class F> inline T each_lane(T value, F function) {
    for (int k = 0; k < lane_count<T>; k++)
        as_array(value)[k] = function(as_array(value)[k]);
    return value;
}

template <class T> inline T square_root(T value) {
    return each_lane(value, [](float x) { return std::sqrt(x); });
}

template <class T> inline T power(T base, T exponent) {
    for (int k = 0; k < lane_count<T>; k++)
        as_array(base)[k] = std::pow(as_array(base)[k], as_array(exponent)[k]);
    return base;
}

template <class M, class T> inline T choose(M mask, T yes, T no) {
    return mask ? yes : no;
}

template <class T> inline T larger(T a, T b) {
    return a > b ? a : b;
}

template <class T> inline T magnitude(T a) {
    return a < 0 ? -a : a;
}

template <class M> inline int count_lanes(M mask) {
    int count = 0;
    for (int k = 0; k < lane_count<M>; k++)
        count += as_array(mask)[k] != 0;
    return count;
}

template <class M> inline bool any_lane(M mask) {
    int all = 0;
    for (int k = 0; k < lane_count<M>; k++)
        all |= as_array(mask)[k];
    return all != 0;
}
