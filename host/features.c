/* features.c - what a scene needs of the kernels: what no object uses is not compiled. */
#include "packed.h"

#include <stdio.h>

const char *const feature_names[FEATURE_COUNT] = {
    "sphere",
    "plane",
    "disc",
    "box",
    "triangle",
    "polygon",
    "cone",
    "instance",
    "smooth",
    "one_sided",
    "diffuse",
    "specular",
    "diffuse_transmission",
    "specular_transmission",
    "reflection",
    "transmission",
    "priority",
    "fresnel",
    "total_reflection",
    "shadows",
    "filtered_shadows",
    "terminator",
    "lights",
    "tree",
};

void features_text(uint32_t features, char *text, size_t size) {
    size_t used = 0;
    text[0] = '\0';
    for (int i = 0; i < FEATURE_COUNT; i++)
        if (features >> i & 1)
            used += (size_t)snprintf(text + used, size - used, "%s%s", used ? " " : "", feature_names[i]);
}

bool is_black(vec3 colour) {
    return colour.x == 0 && colour.y == 0 && colour.z == 0;
}

const uint32_t all_features = (UINT32_C(1) << FEATURE_COUNT) - 1;

static uint32_t bit(feature feature, bool on) {
    return on ? UINT32_C(1) << feature : 0;
}

static uint32_t shape_features(const scene_object *object) {
    static const feature kinds[] = {
        [SHAPE_SPHERE] = FEATURE_SPHERE, [SHAPE_PLANE] = FEATURE_PLANE,       [SHAPE_DISC] = FEATURE_DISC,
        [SHAPE_BOX] = FEATURE_BOX,       [SHAPE_TRIANGLE] = FEATURE_TRIANGLE, [SHAPE_POLYGON] = FEATURE_POLYGON,
        [SHAPE_CONE] = FEATURE_CONE,     [SHAPE_MESH] = FEATURE_TRIANGLE,     [SHAPE_INSTANCE] = FEATURE_INSTANCE,
    };
    bool smooth = (object->shape == SHAPE_TRIANGLE && object->triangle.smooth) ||
                  (object->shape == SHAPE_MESH && object->mesh.normals);
    return bit(kinds[object->shape], true) | bit(FEATURE_SMOOTH, smooth) |
           bit(FEATURE_ONE_SIDED, object->sides != BOTH_SIDES);
}

static uint32_t material_features(const scene_material *m) {
    return bit(FEATURE_DIFFUSE, !is_black(m->diffuse)) | bit(FEATURE_SPECULAR, !is_black(m->specular)) |
           bit(FEATURE_DIFFUSE_TRANSMISSION, !is_black(m->diffuse_transmission)) |
           bit(FEATURE_SPECULAR_TRANSMISSION, !is_black(m->specular_transmission)) |
           bit(FEATURE_REFLECTION, !is_black(m->reflection)) | bit(FEATURE_TRANSMISSION, !is_black(m->transmission)) |
           bit(FEATURE_FRESNEL, m->fresnel && !(is_black(m->reflection) && is_black(m->transmission))) |
           bit(FEATURE_TOTAL_REFLECTION, m->total_reflection && !is_black(m->transmission)) |
           bit(FEATURE_PRIORITY, m->priority != 0 && !is_black(m->transmission));
}

static uint32_t objects_features(const feeler_scene *scene, const scene_object *objects, size_t count) {
    uint32_t features = 0;
    for (size_t i = 0; i < count; i++) {
        features |= shape_features(&objects[i]);
        if (objects[i].material >= 0)
            features |= material_features(&scene->materials[objects[i].material]);
    }
    return features;
}

static uint32_t scene_features(const feeler_scene *scene) {
    uint32_t features = objects_features(scene, scene->objects, scene->object_count);
    for (size_t i = 0; i < scene->group_count; i++)
        features |= objects_features(scene, scene->groups[i].objects, scene->groups[i].object_count);
    bool transmits = features & bit(FEATURE_TRANSMISSION, true);
    /* Total internal reflection can leave a reflection where the material itself asks for none. */
    features |= bit(FEATURE_REFLECTION, features & bit(FEATURE_TOTAL_REFLECTION, true));
    features |= bit(FEATURE_SHADOWS, scene->shadows && scene->light_count > 0);
    features |= bit(FEATURE_FILTERED_SHADOWS, scene->shadows && scene->filtered_shadows && transmits);
    features |= bit(FEATURE_TERMINATOR, features & bit(FEATURE_SHADOWS, true) && features & bit(FEATURE_SMOOTH, true) &&
                                            scene->smooth_terminator);
    features |= bit(FEATURE_LIGHTS, scene->light_count > 1);
    return features;
}

needs choose_needs(const feeler_scene *scene, const feeler_settings *s) {
    uint32_t settings =
        bit(FEATURE_SHADOWS, true) | bit(FEATURE_FILTERED_SHADOWS, true) | bit(FEATURE_TERMINATOR, true);
    needs n = {.features = scene_features(scene), .media = MOST_MEDIA, .width = WIDTH};
    if (s->general) /* whether there are shadows is a setting, not something that a scene might do without */
        n.features |= all_features & ~settings;
    n.features &= ~bit(FEATURE_TREE, true);
    n.features |= bit(FEATURE_TREE, !s->brute_force);
    if (!(n.features & bit(FEATURE_TRANSMISSION, true)))
        n.media = 1;
    if (s->lanes == MOST_WIDTH)
        n.width = MOST_WIDTH;
    return n;
}
