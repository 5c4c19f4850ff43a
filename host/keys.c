/* keys.c - every key of a scene: its type, its target, its range, its default. docs/scene-format.md follows this file. */
#include "schema.h"

#include <math.h>

#define NODE(name, slot)                                                                                               \
    { name, KEY_NODE, slot, 0, 0, {0}, 0, NULL }
#define NEEDED_NODE(name, slot)                                                                                        \
    { name, KEY_NODE, slot, 0, 0, {0}, KEY_REQUIRED, NULL }
#define POINT(name, type, member, flags, ...)                                                                          \
    { name, KEY_POINT, offsetof(type, member), -MAX_COORDINATE, MAX_COORDINATE, __VA_ARGS__, flags, NULL }
#define DIRECTION(name, type, member, flags, ...)                                                                      \
    { name, KEY_DIRECTION, offsetof(type, member), -MAX_COORDINATE, MAX_COORDINATE, __VA_ARGS__, flags, NULL }
#define COLOUR(name, type, member, high, grey)                                                                         \
    { name, KEY_COLOUR, offsetof(type, member), 0, high, {grey, grey, grey}, 0, NULL }
#define NUMBER(name, type, member, low, high, flags, standard)                                                         \
    { name, KEY_NUMBER, offsetof(type, member), low, high, {standard}, flags, NULL }
#define INTEGER(name, type, member, low, high, standard)                                                               \
    { name, KEY_INTEGER, offsetof(type, member), low, high, {standard}, 0, NULL }
#define BOOL(name, type, member, standard)                                                                             \
    { name, KEY_BOOL, offsetof(type, member), 0, 1, {standard}, 0, NULL }
#define RADIUS(name, member, flags) NUMBER(name, scene_object, member, 0, MAX_COORDINATE, flags, 0)
#define END                                                                                                            \
    { NULL, KEY_NODE, 0, 0, 0, {0}, 0, NULL }

/* Reflectances go to 1; what is emitted, to 1e6: with depth up to 256 no pixel can then become infinite. */
#define BRIGHTEST 1e6

const schema_key scene_keys[] = {NODE("camera", SCENE_CAMERA),
                                 NODE("image", SCENE_IMAGE),
                                 COLOUR("background", feeler_scene, background, BRIGHTEST, 0),
                                 COLOUR("ambient", feeler_scene, ambient, BRIGHTEST, 0),
                                 INTEGER("depth", feeler_scene, depth, 1, 256, 5),
                                 NUMBER("cutoff", feeler_scene, cutoff, 0, 1, 0, 0),
                                 BOOL("shadows", feeler_scene, shadows, 1),
                                 BOOL("filtered_shadows", feeler_scene, filtered_shadows, 0),
                                 BOOL("smooth_terminator", feeler_scene, smooth_terminator, 0),
                                 NODE("lights", SCENE_LIGHTS),
                                 NODE("materials", SCENE_MATERIALS),
                                 NODE("groups", SCENE_GROUPS),
                                 NODE("objects", SCENE_OBJECTS),
                                 NODE("include", SCENE_INCLUDE),
                                 END};

/* A file that another includes. */
const schema_key included_keys[] = {NODE("lights", SCENE_LIGHTS),   NODE("materials", SCENE_MATERIALS),
                                    NODE("groups", SCENE_GROUPS),   NODE("objects", SCENE_OBJECTS),
                                    NODE("include", SCENE_INCLUDE), END};

const schema_key camera_keys[] = {POINT("eye", scene_camera, eye, 0, {0, 0, 10}),
                                  POINT("look_at", scene_camera, look_at, 0, {0, 0, 0}),
                                  DIRECTION("up", scene_camera, up, 0, {0, 1, 0}),
                                  NUMBER("fov", scene_camera, fov, 0, 180, KEY_ABOVE_LOW | KEY_BELOW_HIGH, 45), END};

const schema_key image_keys[] = {NODE("size", IMAGE_SIZE), INTEGER("samples", feeler_scene, samples, 1, 4096, 1),
                                 NUMBER("jitter", feeler_scene, jitter, 0, 1, 0, 1), END};

const schema_key light_keys[] = {NODE("point", LIGHT_POINT),
                                 NODE("directional", LIGHT_DIRECTIONAL),
                                 NODE("colour", LIGHT_COLOUR),
                                 COLOUR("diffuse", scene_light, diffuse, BRIGHTEST, 1),
                                 COLOUR("specular", scene_light, specular, BRIGHTEST, 1),
                                 COLOUR("ambient", scene_light, ambient, BRIGHTEST, 0),
                                 END};

/* What `diffuse` and `specular` are by default. Its target is a vec3. */
const schema_key light_colour_key = {"colour", KEY_COLOUR, 0, 0, BRIGHTEST, {1, 1, 1}, 0, NULL};

const schema_key material_keys[] = {COLOUR("ambient", scene_material, ambient, 1, 0),
                                    COLOUR("diffuse", scene_material, diffuse, 1, 0),
                                    COLOUR("specular", scene_material, specular, 1, 0),
                                    COLOUR("diffuse_transmission", scene_material, diffuse_transmission, 1, 0),
                                    COLOUR("specular_transmission", scene_material, specular_transmission, 1, 0),
                                    COLOUR("emission", scene_material, emission, BRIGHTEST, 0),
                                    COLOUR("reflection", scene_material, reflection, 1, 0),
                                    COLOUR("transmission", scene_material, transmission, 1, 0),
                                    NUMBER("shininess", scene_material, shininess, 0, 1e6, KEY_ABOVE_LOW, 10),
                                    NUMBER("ior", scene_material, ior, 0.1, 10, 0, 1),
                                    NUMBER("priority", scene_material, priority, -1e6, 1e6, 0, 0),
                                    BOOL("total_reflection", scene_material, total_reflection, 0),
                                    BOOL("fresnel", scene_material, fresnel, 0),
                                    END};

static const char *const side_names[] = {"both", "front", "back", NULL};

const schema_key object_keys[] = {
    NODE("sphere", OBJECT_SPHERE),
    NODE("plane", OBJECT_PLANE),
    NODE("disc", OBJECT_DISC),
    NODE("box", OBJECT_BOX),
    NODE("triangle", OBJECT_TRIANGLE),
    NODE("polygon", OBJECT_POLYGON),
    NODE("cylinder", OBJECT_CYLINDER),
    NODE("cone", OBJECT_CONE),
    NODE("mesh", OBJECT_MESH),
    NODE("instance", OBJECT_INSTANCE),
    NODE("material", OBJECT_MATERIAL),
    {"sides", KEY_CHOICE, offsetof(scene_object, sides), 0, 2, {BOTH_SIDES}, 0, side_names},
    NODE("transform", OBJECT_TRANSFORM),
    END};

const schema_key sphere_keys[] = {POINT("centre", scene_object, sphere.centre, 0, {0, 0, 0}),
                                  RADIUS("radius", sphere.radius, KEY_REQUIRED | KEY_ABOVE_LOW), END};

const schema_key plane_keys[] = {POINT("point", scene_object, plane.point, 0, {0, 0, 0}),
                                 DIRECTION("normal", scene_object, plane.normal, KEY_REQUIRED, {0, 0, 0}), END};

const schema_key disc_keys[] = {POINT("centre", scene_object, disc.centre, 0, {0, 0, 0}),
                                DIRECTION("normal", scene_object, disc.normal, KEY_REQUIRED, {0, 0, 0}),
                                RADIUS("radius", disc.radius, KEY_REQUIRED | KEY_ABOVE_LOW), END};

const schema_key box_keys[] = {POINT("low", scene_object, box.low, KEY_REQUIRED, {0, 0, 0}),
                               POINT("high", scene_object, box.high, KEY_REQUIRED, {0, 0, 0}), END};

const schema_key triangle_keys[] = {NEEDED_NODE("corners", CORNERS), NODE("normals", CORNERS_NORMALS), END};

const schema_key polygon_keys[] = {NEEDED_NODE("corners", CORNERS), END};

const schema_key cylinder_keys[] = {POINT("base", scene_object, cone.base, KEY_REQUIRED, {0, 0, 0}),
                                    POINT("top", scene_object, cone.top, KEY_REQUIRED, {0, 0, 0}),
                                    RADIUS("radius", cone.base_radius, KEY_REQUIRED | KEY_ABOVE_LOW),
                                    BOOL("capped", scene_object, cone.capped, 1), END};

const schema_key cone_keys[] = {POINT("base", scene_object, cone.base, KEY_REQUIRED, {0, 0, 0}),
                                POINT("top", scene_object, cone.top, KEY_REQUIRED, {0, 0, 0}),
                                RADIUS("base_radius", cone.base_radius, KEY_REQUIRED),
                                RADIUS("top_radius", cone.top_radius, 0),
                                BOOL("capped", scene_object, cone.capped, 1),
                                END};

const schema_key mesh_keys[] = {NODE("file", MESH_FILE),           NODE("vertices", MESH_VERTICES),
                                NODE("triangles", MESH_TRIANGLES), NODE("normals", MESH_NORMALS),
                                NODE("smooth", MESH_SMOOTH),       END};

const schema_key transform_keys[] = {NODE("translate", TRANSFORM_TRANSLATE), NODE("rotate", TRANSFORM_ROTATE),
                                     NODE("rotate_x", TRANSFORM_ROTATE_X),   NODE("rotate_y", TRANSFORM_ROTATE_Y),
                                     NODE("rotate_z", TRANSFORM_ROTATE_Z),   NODE("scale", TRANSFORM_SCALE),
                                     NODE("matrix", TRANSFORM_MATRIX),       END};

const schema_key rotation_keys[] = {DIRECTION("axis", rotation, axis, KEY_REQUIRED, {0, 0, 0}),
                                    NUMBER("angle", rotation, angle, -INFINITY, INFINITY, KEY_REQUIRED, 0), END};
