#pragma once
/* The light from around a place, by direction, as frames show it. */
#include "proto/scene/scene.h"
#include "server/import/rgbd/light_view.h"

struct light_sky {
    float texels[3 * SCENE_SKY_TEXELS]; /* as scene_map's sky */
    bool seen[SCENE_SKY_TEXELS];
    double mean[3]; /* of what is seen, by solid angle */
    double share;   /* of the sphere that is seen */
};

/* Computes the direction that a map of width x height texels shows at x, y of texels. */
void light_sky_direction(double x, double y, uint32_t width, uint32_t height, double out[3]);

/* Finds what is seen around a place: by the surfaces that rays from there meet, or where frames
 * have colours without depth, by those, as if far away. What shines and has depth is a lamp, so
 * white stands in its place. */
void light_sky_look(const struct light_views *views, const double place[3], struct light_sky *out);

#define LIGHT_BINS_U 16u
#define LIGHT_BINS_V 8u
#define LIGHT_BINS   (LIGHT_BINS_U * LIGHT_BINS_V)

/* Makes each texel that is not seen a mean of the bins around it, of so many even parts of the map.
 */
void light_sky_fill(struct light_sky *sky, const double radiance[3 * LIGHT_BINS]);
