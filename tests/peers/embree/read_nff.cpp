// read_nff.cpp - Eric Haines' Neutral File Format.
#include "scene.hpp"

#include <charconv>
#include <fstream>
#include <stdexcept>
#include <string_view>

std::string read_file(const std::string &path) {
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    if (!in)
        throw std::runtime_error(path + " cannot be opened");
    std::string text(static_cast<size_t>(in.tellg()), '\0');
    in.seekg(0);
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    return text;
}

namespace {

class Words {
  public:
    explicit Words(std::string_view text) : at(text.data()), end(text.data() + text.size()) {}

    // Whether another word stands on this line.
    bool line_goes_on() {
        while (at < end && (*at == ' ' || *at == '\t' || *at == '\r'))
            at++;
        return at < end && *at != '\n' && *at != '#';
    }

    // Empty at the end.
    std::string_view next() {
        while (!line_goes_on() && at < end) {
            while (at < end && *at != '\n')
                at++;
            at += at < end;
        }
        const char *start = at;
        while (at<end &&static_cast<unsigned char>(*at)> ' ')
            at++;
        return {start, static_cast<size_t>(at - start)};
    }

    float number() {
        const std::string_view word = next();
        float value;
        const auto [stop, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (failure != std::errc() || stop != word.data() + word.size())
            throw std::runtime_error("'" + std::string(word) + "' is not a number");
        return value;
    }

    Point point() {
        const float x = number(), y = number();
        return {x, y, number()};
    }

  private:
    const char *at, *end;
};

// Kd is the share of the colour that is diffuse, Ks both the white highlight and the mirror's share, T the transmitted one.
Material read_fill(Words &words) {
    const Point colour = words.point();
    const float kd = words.number(), ks = words.number(), shine = words.number(), t = words.number();
    const float ior = words.number();
    return {colour * kd, ks, shine, t, ior == 0 ? 1 : ior, 0};
}

// A light without colour is marked by a negative one until their number is known.
Light read_light(Words &words) {
    const Point position = words.point();
    return {position, words.line_goes_on() ? words.point() : Point{-1, -1, -1}};
}

void add_corner(Mesh &mesh, Point corner, const std::vector<Point> &normals, unsigned k) {
    mesh.vertices.push_back(corner);
    if (!normals.empty())
        mesh.normals.push_back(normals[k]);
}

void read_polygon(Words &words, Scene &scene, bool smooth) {
    std::vector<Point> corners, normals;
    for (int left = static_cast<int>(words.number()); left > 0; left--) {
        corners.push_back(words.point());
        if (smooth)
            normals.push_back(words.point());
    }
    Mesh &mesh = smooth ? scene.smooth : scene.flat;
    const auto first = static_cast<unsigned>(mesh.vertices.size());
    for (unsigned k = 0; k < corners.size(); k++)
        add_corner(mesh, corners[k], normals, k);
    for (const Triangle &t : triangulate(corners)) {
        mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
        mesh.materials.push_back(static_cast<int>(scene.materials.size()) - 1);
    }
}

float read_radius(Words &words) {
    const float radius = words.number();
    if (radius < 0)
        throw std::runtime_error("negative radii, surfaces seen from within only, are not supported");
    return radius;
}

void read_shape(Words &words, Scene &scene, std::string_view key) {
    const int material = static_cast<int>(scene.materials.size()) - 1;
    if (material < 0)
        throw std::runtime_error("a shape comes before the first fill");
    if (key == "s") {
        const Point centre = words.point();
        scene.spheres.push_back({centre, read_radius(words)});
        scene.sphere_materials.push_back(material);
    } else if (key == "c") {
        Cone cone;
        cone.base = words.point();
        cone.base_radius = read_radius(words);
        cone.top = words.point();
        cone.top_radius = read_radius(words);
        scene.cones.push_back(cone);
        scene.cone_materials.push_back(material);
    } else if (key == "p" || key == "pp") {
        read_polygon(words, scene, key == "pp");
    } else {
        throw std::runtime_error("'" + std::string(key) + "' is no NFF entity");
    }
}

void share_light(std::vector<Light> &lights) {
    const float share = 1 / std::sqrt(static_cast<float>(lights.size()));
    for (Light &light : lights)
        if (light.colour.x < 0)
            light.colour = {share, share, share};
}

} // namespace

Scene read_nff(const std::string &path) {
    const std::string text = read_file(path);
    Words words(text);
    Scene scene;
    for (std::string_view key = words.next(); !key.empty(); key = words.next()) {
        if (key == "v")
            continue;
        if (key == "from")
            scene.from = words.point();
        else if (key == "at")
            scene.at = words.point();
        else if (key == "up")
            scene.up = words.point();
        else if (key == "angle")
            scene.angle = words.number();
        else if (key == "hither")
            words.number();
        else if (key == "resolution")
            words.number(), words.number();
        else if (key == "b")
            scene.background = words.point();
        else if (key == "l")
            scene.lights.push_back(read_light(words));
        else if (key == "f")
            scene.materials.push_back(read_fill(words));
        else
            read_shape(words, scene, key);
    }
    share_light(scene.lights);
    return scene;
}
