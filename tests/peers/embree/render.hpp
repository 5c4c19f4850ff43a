// render.hpp
#pragma once

#include "trace.hpp"

struct Picture {
    int size;
    std::vector<Point> pixels; // rows from the top
    Counts counts;
    double seconds; // of tracing, shading included
};

enum class Mode { single, packet, coherent };

// A picture of size x size pixels, `samples` (1 or 16) in the centres of a pixel's cells. Packets need 16.
Picture render(const Scene &scene, const Geometry &geometry, int size, int samples, Mode mode);
