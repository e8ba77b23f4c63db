#pragma once
/* Frames as an estimate of the light needs them: small, in the scene's coordinates, and able to say
 * what is seen from elsewhere along a ray. */
#include "server/import/rgbd/depth_map.h"

#define LIGHT_VIEWS 8 /* frames of a sequence that are used, evenly chosen */

/* What files of 8 bits have where light was too much for them. */
#define LIGHT_CUT_LOW  0.98f
#define LIGHT_CUT_HIGH 1.001f

struct light_pixel {
    float z;         /* metres along the camera's axis; 0: not known */
    float color[3];  /* linear */
    float normal[3]; /* unit, in the scene, towards the camera; zero: not known */
    bool shines;
};

struct light_view {
    int32_t width, height;
    double fx, fy, cx, cy;
    struct affine to_scene; /* a rotation, times units_per_m, and translation */
    double units_per_m;
    float white[3];
    struct light_pixel *pixels; /* owned; rows from the top */
};

struct light_views {
    struct light_view list[LIGHT_VIEWS];
    uint32_t count;
};

/* What a ray met. */
struct light_hit {
    const struct light_view *view;
    const struct light_pixel *pixel; /* NULL: nothing is known to be there */
    double distance;                 /* scene units */
};

/* Reads some frames, which `place` puts into the scene. Faults as depth_map_read has them. The
 * caller destroys *out, in both cases. */
int light_views_read(const struct rgbd_document *d, struct files *files, const struct affine *place,
                     struct light_views *out, struct warnings *warnings, struct fault *fault);
void light_views_destroy(struct light_views *views);

/* Computes the way from the camera to what a pixel would show a metre away along the axis, and the
 * point that it shows, in the scene. */
void light_view_ray(const struct light_view *v, const struct light_pixel *pixel, double out[3]);
void light_view_point(const struct light_view *v, const struct light_pixel *pixel, double out[3]);

/* Follows a ray of the scene, whose direction is unit, through one view's depth. */
struct light_hit light_view_trace(const struct light_view *v, const double from[3],
                                  const double direction[3]);

/* Returns the pixel that looks into a direction of the scene, as if all were far away; NULL: none.
 */
const struct light_pixel *light_view_look(const struct light_view *v, const double direction[3]);
