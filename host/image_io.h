// image_io.h - what image_read.cpp and image_write.cpp share, the only files that know OpenImageIO. This header is C++.
#ifndef FEELER_IMAGE_IO_H
#define FEELER_IMAGE_IO_H

extern "C" {
#include "image.h"
// Of error.c. The header that declares it is not C++.
int fail(feeler_error *error, int code, const char *format, ...) __attribute__((format(printf, 3, 4)));
}

#include <exception>
#include <new>

// Linear, alpha associated.
struct pixel {
    double rgb[3], alpha;
};

// What `work` returns. No exception leaves it: they are errors, "PATH: cannot VERB: why".
template <typename F> int without_exceptions(const char *path, const char *verb, feeler_error *error, F work) {
    try {
        return work();
    } catch (const std::bad_alloc &) {
        return fail(error, FEELER_OUT_OF_MEMORY, "%s: cannot %s: out of memory", path, verb);
    } catch (const std::exception &e) {
        return fail(error, FEELER_IO, "%s: cannot %s: %s", path, verb, e.what());
    } catch (...) {
        return fail(error, FEELER_IO, "%s: cannot %s", path, verb);
    }
}

#endif
