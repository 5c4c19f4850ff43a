// read_ply.cpp - binary PLY of triangles: x, y, z as floats, and faces of a uchar count and three ints.
#include "scene.hpp"

#include <cstring>
#include <sstream>
#include <stdexcept>

namespace {

const char *const header_lines[] = {
    "ply",
    "format binary_little_endian 1.0",
    "element vertex %",
    "property float x",
    "property float y",
    "property float z",
    "element face %",
    "property list uchar int vertex_indices",
    "end_header",
};

// The counts of vertices and faces.
std::pair<size_t, size_t> read_header(std::istream &in) {
    std::vector<size_t> counts;
    for (std::string wanted : header_lines) {
        std::string line;
        std::getline(in, line);
        if (wanted.back() == '%') {
            wanted.pop_back();
            counts.push_back(std::strtoull(line.substr(std::min(wanted.size(), line.size())).c_str(), nullptr, 10));
            line.resize(std::min(wanted.size(), line.size()));
        }
        if (line != wanted)
            throw std::runtime_error("PLY: '" + line + "' where '" + wanted + "' is expected");
    }
    return {counts[0], counts[1]};
}

} // namespace

Mesh read_ply(const std::string &path) {
    const std::string data = read_file(path);
    std::istringstream head(data.substr(0, 1024));
    const auto [vertices, faces] = read_header(head);
    const size_t start = static_cast<size_t>(head.tellg()), face_size = 1 + sizeof(Triangle);
    if (data.size() - start != vertices * sizeof(Point) + faces * face_size)
        throw std::runtime_error("PLY: the file's length is not what its header says");
    Mesh mesh;
    mesh.vertices.resize(vertices);
    mesh.triangles.resize(faces);
    std::memcpy(mesh.vertices.data(), &data[start], vertices * sizeof(Point));
    const char *face = &data[start + vertices * sizeof(Point)];
    for (Triangle &triangle : mesh.triangles) {
        if (*face != 3)
            throw std::runtime_error("PLY: a face has not three corners");
        std::memcpy(&triangle, face + 1, sizeof triangle);
        for (unsigned corner : triangle)
            if (corner >= vertices)
                throw std::runtime_error("PLY: a face's corner is out of range");
        face += face_size;
    }
    return mesh;
}
