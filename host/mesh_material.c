/* mesh_material.c - materials of mesh files in the terms of the model.
 *
 * Wavefront MTL and its kin name the model's own terms. glTF describes a surface by base colour, metalness and roughness; the
 * mapping below keeps its look: a Phong lobe as wide as the roughness says, mirror rays only where it is smooth enough to
 * show an image, the rest diffuse.
 */
#include "mesh_file.h"

#include <assimp/material.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ILLUM_KEY "$mat.illum", 0, 0 /* MTL's illum, as assimp's OBJ reader names it */

/* Within low … high; not-a-number becomes low. */
static double clamped(double value, double low, double high) {
    return fmin(fmax(value, low), high);
}

static vec3 clamped3(vec3 v, double high) {
    return (vec3){clamped(v.x, 0, high), clamped(v.y, 0, high), clamped(v.z, 0, high)};
}

static vec3 grey(double value) {
    return (vec3){value, value, value};
}

static vec3 scaled(vec3 v, double s) {
    return (vec3){v.x * s, v.y * s, v.z * s};
}

/* a where t is 0, b where it is 1. */
static vec3 mixed(vec3 a, vec3 b, double t) {
    return (vec3){a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t};
}

/* 1 - v, clamped. */
static vec3 rest(vec3 v) {
    return clamped3((vec3){1 - v.x, 1 - v.y, 1 - v.z}, 1);
}

static vec3 smaller(vec3 a, vec3 b) {
    return (vec3){fmin(a.x, b.x), fmin(a.y, b.y), fmin(a.z, b.z)};
}

/* ---- values out of range ---- */

/* A material being read. */
typedef struct origin {
    const struct aiMaterial *file;
    bool mtl;
    char *clamped; /* the keys whose values were out of range: MESH_KEYS_SIZE bytes */
} origin;

/* `names` has MTL's key and, after a space, the one of other formats. */
static void note(const origin *from, const char *names) {
    size_t used = strlen(from->clamped), first = strcspn(names, " ");
    const char *name = from->mtl || !names[first] ? names : names + first + 1;
    int length = from->mtl ? (int)first : (int)strlen(name);
    snprintf(from->clamped + used, MESH_KEYS_SIZE - used, "%s%.*s", used ? ", " : "", length, name);
}

static double kept(const origin *from, const char *names, double value, double low, double high) {
    if (!(value >= low && value <= high))
        note(from, names);
    return clamped(value, low, high);
}

static vec3 kept3(const origin *from, const char *names, vec3 v, double high) {
    vec3 inside = clamped3(v, high);
    if (!(inside.x == v.x && inside.y == v.y && inside.z == v.z))
        note(from, names);
    return inside;
}

/* ---- properties ---- */

static double number(const struct aiMaterial *m, const char *key, unsigned type, unsigned index, double otherwise) {
    ai_real value;
    return aiGetMaterialFloat(m, key, type, index, &value) == AI_SUCCESS ? value : otherwise;
}

static vec3 colour(const struct aiMaterial *m, const char *key, unsigned type, unsigned index, vec3 otherwise) {
    struct aiColor4D value;
    return aiGetMaterialColor(m, key, type, index, &value) == AI_SUCCESS ? (vec3){value.r, value.g, value.b}
                                                                         : otherwise;
}

static bool has(const struct aiMaterial *m, const char *key, unsigned type, unsigned index) {
    const struct aiMaterialProperty *property;
    return aiGetMaterialProperty(m, key, type, index, &property) == AI_SUCCESS;
}

/* ---- Phong materials: MTL and others ---- */

/* MTL's illum: 3 … 9 reflect, 6 and 7 refract whatever `d` says. Kd, Ks and the highlight hold for every illum, since few files mean
 * the lower ones to the letter. */
static void set_phong(scene_material *m, const origin *from) {
    const struct aiMaterial *file = from->file;
    int illum = (int)kept(from, "illum", number(file, ILLUM_KEY, 2), 0, 10);
    double opacity = kept(from, "d opacity", number(file, AI_MATKEY_OPACITY, 1), 0, 1);
    vec3 filter = grey(1);
    if (from->mtl)
        filter = kept3(from, "Tf", colour(file, AI_MATKEY_COLOR_TRANSPARENT, grey(1)), 1);
    vec3 specular =
        scaled(colour(file, AI_MATKEY_COLOR_SPECULAR, grey(0)), number(file, AI_MATKEY_SHININESS_STRENGTH, 1));
    double shininess = number(file, AI_MATKEY_SHININESS, 0), ior = number(file, AI_MATKEY_REFRACTI, 1);
    specular = kept3(from, "Ks specular", specular, 1);
    m->ambient = kept3(from, "Ka ambient", colour(file, AI_MATKEY_COLOR_AMBIENT, grey(0)), 1);
    m->diffuse = scaled(kept3(from, "Kd diffuse", colour(file, AI_MATKEY_COLOR_DIFFUSE, grey(0)), 1), opacity);
    m->emission = kept3(from, "Ke emissive", colour(file, AI_MATKEY_COLOR_EMISSIVE, grey(0)), 1e6);
    /* 0 stands for none, in both. */
    m->specular = shininess > 0 ? specular : grey(0);
    m->shininess = shininess == 0 ? 1 : kept(from, "Ns shininess", shininess, 1e-3, 1e6);
    m->ior = ior == 0 ? 1 : kept(from, "Ni ior", ior, 0.1, 10);
    m->reflection = illum >= 3 && illum <= 9 ? specular : grey(0);
    m->transmission = opacity == 1 && (illum == 6 || illum == 7) ? filter : scaled(filter, 1 - opacity);
    m->transmission = smaller(m->transmission, rest(m->reflection));
}

/* ---- glTF ---- */

/* Karis 2013, "Specular BRDF Reference": a Phong lobe as wide as the microfacet lobe of this roughness. */
static double shininess_of(double roughness) {
    double alpha = fmax(roughness * roughness, 1e-2);
    return clamped(2 / (alpha * alpha) - 2, 1, 1e6);
}

static void set_metallic(scene_material *m, const origin *from) {
    const struct aiMaterial *file = from->file;
    vec3 base = kept3(from, "baseColorFactor", colour(file, AI_MATKEY_BASE_COLOR, grey(1)), 1);
    double metallic = kept(from, "metallicFactor", number(file, AI_MATKEY_METALLIC_FACTOR, 1), 0, 1);
    double roughness = kept(from, "roughnessFactor", number(file, AI_MATKEY_ROUGHNESS_FACTOR, 1), 0, 1);
    double through = kept(from, "transmissionFactor", number(file, AI_MATKEY_TRANSMISSION_FACTOR, 0), 0, 1);
    double opacity = kept(from, "alpha", number(file, AI_MATKEY_OPACITY, 1), 0, 1);
    double ior = kept(from, "ior", number(file, AI_MATKEY_REFRACTI, 1.5), 0.1, 10);
    double facing = (ior - 1) * (ior - 1) / ((ior + 1) * (ior + 1)); /* reflected along the normal */
    double sharp = clamped(1 - 2 * roughness, 0, 1) * clamped(1 - 2 * roughness, 0, 1);

    through *= 1 - metallic;
    vec3 specular = mixed(grey(facing), base, metallic);
    m->shininess = shininess_of(roughness);
    m->specular = clamped3(scaled(specular, fmax(1, (m->shininess + 2) / 8)), 1);
    m->reflection = clamped3(scaled(specular, sharp), 1);
    m->transmission = mixed(grey(1), scaled(base, through), opacity);
    m->transmission = smaller(m->transmission, rest(m->reflection));
    /* A metal too rough for mirror rays would be black without a diffuse part. */
    m->diffuse = scaled(base, opacity * (1 - through) * ((1 - metallic) + metallic * (1 - sharp)));
    m->ambient = m->diffuse;
    vec3 emission = colour(file, AI_MATKEY_COLOR_EMISSIVE, grey(0));
    emission = scaled(emission, number(file, AI_MATKEY_EMISSIVE_INTENSITY, 1));
    m->emission = kept3(from, "emissiveFactor", emission, 1e6);
    /* Without a volume glTF's surface is a thin sheet, which does not bend light. */
    m->ior = number(file, AI_MATKEY_VOLUME_THICKNESS_FACTOR, 0) > 0 ? ior : 1;
}

/* ---- the choice ---- */

/* Pale and matte with a soft highlight: shows a shape without colouring it. */
static void set_default(scene_material *m) {
    m->ambient = m->diffuse = (vec3){0.72, 0.70, 0.66};
    m->specular = grey(0.15);
    m->shininess = 30;
}

/* assimp makes up a material where the file has none: named so by most of its readers, nameless and white by the others. */
static bool is_made_up(const struct aiMaterial *source, const char *name) {
    vec3 white = colour(source, AI_MATKEY_COLOR_DIFFUSE, grey(1));
    if (*name)
        return strcmp(name, AI_DEFAULT_MATERIAL_NAME) == 0;
    return white.x == 1 && white.y == 1 && white.z == 1 && number(source, AI_MATKEY_ROUGHNESS_FACTOR, 1) == 1 &&
           number(source, AI_MATKEY_METALLIC_FACTOR, 1) == 1;
}

int mesh_material_set(scene_material *m, const struct aiMaterial *source, char clamped[MESH_KEYS_SIZE],
                      feeler_error *error) {
    struct aiString name = {0, {0}};
    if (source)
        aiGetMaterialString(source, AI_MATKEY_NAME, &name);
    m->ambient = m->diffuse = m->specular = m->emission = grey(0);
    m->diffuse_transmission = m->specular_transmission = m->reflection = m->transmission = grey(0);
    m->ior = m->shininess = 1;
    clamped[0] = '\0';
    origin from = {source, source && has(source, ILLUM_KEY), clamped};
    bool made_up = !source || is_made_up(source, name.data);
    if (made_up)
        set_default(m);
    else if (has(source, AI_MATKEY_METALLIC_FACTOR) && !from.mtl)
        set_metallic(m, &from);
    else
        set_phong(m, &from);
    if (!made_up && *name.data && !(m->name = strdup(name.data)))
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    return 0;
}
