/* types.h - the structs that host and device share. Compiles as C11 and as OpenCL C.
 *
 * Geometry and colours are whole real4, indices whole uint4, and the two never mix in a struct: the host packs in double
 * and narrows an array to float without knowing what is in it. Lengths are in the scene's unit, in world space moved to
 * the scene's own origin (pack.c).
 */
#ifndef FEELER_TYPES_H
#define FEELER_TYPES_H

#ifdef __OPENCL_VERSION__
#ifdef DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double real;
typedef double4 real4;
#else
typedef float real;
typedef float4 real4;
#endif
#else
#include <stdint.h>
typedef double real;
typedef struct {
    real x, y, z, w;
} real4;
typedef struct {
    uint32_t x, y, z, w;
} uint4;
#endif

/* A box that holds a primitive: a hit's distance is clamped to the ray's interval in it (MODEL, Arithmetic). */
typedef struct {
    real4 low, high;
} bounds;

typedef struct {
    real4 centre_radius;
    bounds bounds;
} sphere;
typedef struct {
    real4 point, normal;
} plane;
typedef struct {
    real4 centre_radius, normal;
    bounds bounds;
} disc;
typedef struct {
    bounds bounds;
} box;
/* Corners are in an array of their own (see polygon.cl and polygon_ranges). */
typedef struct {
    real4 point, normal;
    bounds bounds;
} polygon;
/* The axis runs from base (z = 0) to top (z = height) in the frame u, v, axis; radius(z) = radius + slope z. */
typedef struct {
    real4 base_radius, u_height, v_slope, axis;
    bounds bounds;
} cone;

/* A group that is placed in the world: world = linear * (a point of the group) + offset. The rows of `to_world` are the
 * linear part's with the offset as w, those of `to_object` its inverse's. Their w: 1 unless the linear part is the identity;
 * a power of two, about the group's size over the world's; and one over it. */
typedef struct {
    real4 to_world_x, to_world_y, to_world_z, to_object_x, to_object_y, to_object_z;
    bounds bounds; /* in the world */
} instance;

/* Children of a node, and primitives of a leaf: packets of 16 rays meet 16 at a time. */
#ifndef WIDTH
#define WIDTH 8
#endif
#define MOST_WIDTH 16

/* A node of the tree is its children's boxes side by side: NODE_ROWS rows of WIDTH numbers, low x, y, z, high x, y, z. Each
 * child has two words of `links`: a node's number and LINK_NODE, or the place of a leaf's block (in units of WIDTH reals)
 * and its tag. */
#define NODE_ROWS 6

/* A leaf's block holds one instance, or up to WIDTH primitives of one kind and with the same flags, number after number for
 * each field; empty places repeat the last primitive. The tag: its kind, its flags, and the block's own number. */
#define LINK_NODE 0xffffffffu
#define TAG_KIND 29
#define TAG_FLAGS 24
#define TAG_NUMBER 0xffffffu

/* Rows of a block: the primitives' bounds, unless they are plain from the rest, then their own fields. */
#define ROWS_SPHERE 10  /* bounds, centre, radius */
#define ROWS_DISC 13    /* bounds, centre, radius, normal */
#define ROWS_BOX 6      /* bounds */
#define ROWS_TRIANGLE 9 /* three corners */
#define ROWS_POLYGON 6  /* bounds */
#define ROWS_CONE 21    /* bounds, base, u, v, axis, radius, height, slope */

/* Symbols as in (16.20) and (16.12). optics: refractive index, priority, 1 if total reflection carries rho_tg too, 1 if
 * Fresnel weights. */
typedef struct {
    real4 ambient, diffuse, specular_shininess, diffuse_transmission, specular_transmission, emission, reflection,
        transmission, optics;
} material;

/* position.w: 1 for a point light, 0 for a directional one (then xyz is the unit vector towards it). */
typedef struct {
    real4 position, diffuse, specular;
} light;

/* Everything that changes with the view and not with the geometry. A pixel's direction is
 * forward + right * (2 x - width) + up * (height - 2 y), x and y in pixels from the top left corner. */
typedef struct {
    real4 eye, forward, right, up, background, ambient;
    real4 limits; /* cutoff, jitter, 1 if the background is transparent, 0 */
} view;

/* Which pixels a launch computes: all in pixels of the whole picture. */
typedef struct {
    uint4 tile;  /* x0, y0, x1, y1 */
    uint4 frame; /* width, height, samples, depth */
    uint4 count; /* lights, primitives in the tree, nodes, planes */
} launch;

/* A primitive: x its kind, y its index among its kind, z its material, w flags. */
#define KIND_SPHERE 0u
#define KIND_PLANE 1u
#define KIND_DISC 2u
#define KIND_BOX 3u
#define KIND_TRIANGLE 4u
#define KIND_POLYGON 5u
#define KIND_CONE 6u
#define KIND_INSTANCE 7u

/* An instance's material if those inside keep their own. */
#define OWN_MATERIAL 0xffffffffu

#define FLAG_BACK_HIDDEN 1u  /* only the front is seen */
#define FLAG_FRONT_HIDDEN 2u /* only the back is seen */
#define FLAG_SMOOTH 4u       /* a triangle that interpolates its corners' normals */
#define FLAG_SOLID 8u        /* bounds a solid: counts when the eye's media are found */
#define FLAG_CAPPED 16u      /* a cone with its ends closed */

/* What is noted of a pixel's rays (record.cl), reals and whole numbers side by side in two arrays. Points are in world space
 * moved to the scene's origin. */
#define NOT_NOTED 0xffffffffu /* a number of what is not there */

/* A ray. With .w: origin the distance of the hit, direction and weight the refractive indices before and behind; the
 * shares' (rho_rg, rho_tg as they apply here) and the normals' is 0. `lit` is I_local; `reflection` and `transmission` are
 * the weights that are sent on, or would be. */
typedef struct {
    real4 origin, direction, weight, point, normal, shading, reflected, transmitted, ambient, emission, lit, background,
        reflection_share, transmission_share, reflection, transmission;
} ray_note;

#define RAY_EYE 0u
#define RAY_REFLECTION 1u
#define RAY_TRANSMISSION 2u
#define NOTED_ENTERING 1u
#define NOTED_REFRACTS 2u     /* there is a direction of transmission */
#define NOTED_REFLECTION 4u   /* sent */
#define NOTED_TRANSMISSION 8u /* sent */

/* sent: the ray that sent it, sample, kind, level. met: primitive, the one inside of an instance, material, flags. Eight
 * media each before and behind, outermost first. */
typedef struct {
    uint4 sent, met, before_outer, before_inner, behind_outer, behind_inner;
} ray_tags;

/* What a light does at a ray's hit. direction.w: its distance. diffuse, specular: coefficient times light, and as w cosine and
 * highlight. share: what the feeler lets through, and r_v . L or t . L. feeler: its length. colour: the sum. */
typedef struct {
    real4 direction, diffuse, specular, share, feeler_origin, feeler, colour;
} light_note;

#define LIGHT_NEITHER 0u /* side */
#define LIGHT_FRONT 1u
#define LIGHT_BACK 2u
#define NOTED_COUNTS 1u /* its terms may contribute */
#define NOTED_FEELER 2u /* sent */

/* x the ray, y the light, z its side, w flags */
typedef struct {
    uint4 at;
} light_tags;

/* A surface on the way of a ray or a feeler. share.w: its distance; share: what a feeler has left behind it. */
typedef struct {
    real4 share;
} crossing_note;

#define CROSSING_HIDDEN 0u   /* a boundary that a medium of higher priority hides */
#define CROSSING_TOUCHING 1u /* at the same place as the ray's hit */
#define CROSSING_FILTER 2u   /* lets a part of the light through, or nothing */
#define CROSSING_BLOCKER 3u  /* the nearest that ends a feeler */

/* at: ray, number of the light's note, kind. met: as a ray's. */
typedef struct {
    uint4 at, met;
} crossing_tags;

#endif
