// features.cl - what a scene may need. Packing defines each as 1 or 0 by build option; what is 0 is not compiled. Without
// an option everything is there: the general kernel, whose pictures have the same bits.
#ifndef HAS_SPHERE
#define HAS_SPHERE 1
#endif
#ifndef HAS_PLANE
#define HAS_PLANE 1
#endif
#ifndef HAS_DISC
#define HAS_DISC 1
#endif
#ifndef HAS_BOX
#define HAS_BOX 1
#endif
#ifndef HAS_TRIANGLE
#define HAS_TRIANGLE 1
#endif
#ifndef HAS_POLYGON
#define HAS_POLYGON 1
#endif
#ifndef HAS_CONE
#define HAS_CONE 1
#endif
#ifndef HAS_INSTANCE /* groups that are placed in the world */
#define HAS_INSTANCE 1
#endif
#ifndef HAS_SMOOTH /* interpolated normals */
#define HAS_SMOOTH 1
#endif
#ifndef HAS_ONE_SIDED
#define HAS_ONE_SIDED 1
#endif
#ifndef HAS_DIFFUSE
#define HAS_DIFFUSE 1
#endif
#ifndef HAS_SPECULAR
#define HAS_SPECULAR 1
#endif
#ifndef HAS_DIFFUSE_TRANSMISSION
#define HAS_DIFFUSE_TRANSMISSION 1
#endif
#ifndef HAS_SPECULAR_TRANSMISSION
#define HAS_SPECULAR_TRANSMISSION 1
#endif
#ifndef HAS_REFLECTION
#define HAS_REFLECTION 1
#endif
#ifndef HAS_TRANSMISSION
#define HAS_TRANSMISSION 1
#endif
#ifndef HAS_PRIORITY /* media that differ in priority */
#define HAS_PRIORITY 1
#endif
#ifndef HAS_FRESNEL
#define HAS_FRESNEL 1
#endif
#ifndef HAS_TOTAL_REFLECTION /* total internal reflection carries rho_tg too */
#define HAS_TOTAL_REFLECTION 1
#endif
#ifndef HAS_SHADOWS
#define HAS_SHADOWS 1
#endif
#ifndef HAS_FILTERED_SHADOWS
#define HAS_FILTERED_SHADOWS 1
#endif
#ifndef HAS_TERMINATOR /* feelers that start above flat triangles with smooth normals */
#define HAS_TERMINATOR HAS_SMOOTH
#endif
#ifndef HAS_LIGHTS /* more than one */
#define HAS_LIGHTS 1
#endif
#ifndef HAS_TREE /* 0: every primitive is tried */
#define HAS_TREE 1
#endif
#ifndef SURVEY /* 1: what lies beside the picture, instead of it */
#define SURVEY 0
#endif
#ifndef MARGIN /* 1: of it, the margin too */
#define MARGIN 0
#endif
#ifndef STACK /* rays that may wait: the greatest depth, or more */
#define STACK 16
#endif
#ifndef MEDIA /* media that a ray may be in at once */
#define MEDIA 8
#endif
