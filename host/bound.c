/* bound.c - how much the rays that were not sent may have carried (MODEL, Depth and Cutoff). */
#include "bound.h"

#include "packed.h"

#include <math.h>

/* Greatest I_local of a material (16.20) per channel: each light gives the larger of its two sides' terms. */
static double greatest_local(double ambient, double reflected, double transmitted, double specular, double through,
                             double emission, const double *lights, size_t count, double ambient_light) {
    double sum = ambient * ambient_light + emission;
    for (size_t i = 0; i < count; i++)
        sum += fmax(reflected * lights[2 * i] + specular * lights[2 * i + 1],
                    transmitted * lights[2 * i] + through * lights[2 * i + 1]);
    return sum;
}

static double channel(vec3 v, int i) {
    return i == 0 ? v.x : i == 1 ? v.y : v.z;
}

/* The greatest I_local and rho_rg + rho_tg so far. */
typedef struct greatest {
    double local, share;
} greatest;

static void include_materials(greatest *g, const feeler_scene *scene, const scene_object *objects, size_t count, int k,
                              const double *lights, double ambient) {
    for (size_t i = 0; i < count; i++) {
        if (objects[i].material < 0)
            continue;
        const scene_material *m = &scene->materials[objects[i].material];
        g->local = fmax(g->local, greatest_local(channel(m->ambient, k), channel(m->diffuse, k),
                                                 channel(m->diffuse_transmission, k), channel(m->specular, k),
                                                 channel(m->specular_transmission, k), channel(m->emission, k), lights,
                                                 scene->light_count, ambient));
        g->share = fmax(g->share, channel(m->reflection, k) + channel(m->transmission, k));
    }
}

/* L of the model for one channel; infinite where rho_rg + rho_tg reaches 1. */
static double greatest_radiance(const feeler_scene *scene, int k, double *lights) {
    double ambient = channel(scene->ambient, k);
    greatest g = {0, 0};
    for (size_t i = 0; i < scene->light_count; i++) {
        lights[2 * i] = channel(scene->lights[i].diffuse, k);
        lights[2 * i + 1] = channel(scene->lights[i].specular, k);
        ambient += channel(scene->lights[i].ambient, k);
    }
    include_materials(&g, scene, scene->objects, scene->object_count, k, lights, ambient);
    for (size_t i = 0; i < scene->group_count; i++)
        include_materials(&g, scene, scene->groups[i].objects, scene->groups[i].object_count, k, lights, ambient);
    return g.share < 1 ? fmax(channel(scene->background, k), g.local / (1 - g.share)) : INFINITY;
}

double truncation_bound(const feeler_scene *scene, const double discarded[3], double *lights) {
    double bound = 0;
    for (int k = 0; k < 3; k++)
        if (discarded[k] > 0)
            bound = fmax(bound, discarded[k] * greatest_radiance(scene, k, lights));
    return bound;
}
