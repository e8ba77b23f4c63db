#pragma once
/* Lamps that frames show: stretches of pixels that shine, as rectangles. */
#include "server/import/rgbd/light_view.h"

#define LIGHT_LAMPS 8

/* A rectangle that emits to the side of its normal, half_u x half_v. */
struct light_lamp {
    double center[3], normal[3], half_u[3], half_v[3]; /* scene units; normal is unit */
    double area, depth_m;                              /* depth_m: how far its frame saw it */
    double radiance[3];                                /* as frames show it, which may be cut */
    bool is_cut;                                       /* as bright as its file can tell */
};

/* Finds the lamps of all views, those of the most light first. A lamp that several views show is
 * there once. Returns their number, LIGHT_LAMPS at most; below 0 ERR_MEMORY has happened. */
int light_lamps_find(const struct light_views *views, struct light_lamp out[LIGHT_LAMPS]);

/* Returns the light that a surface of unit normal gets from a lamp of radiance 1 that nothing
 * hides. */
double light_lamp_falls(const struct light_lamp *lamp, const double point[3],
                        const double normal[3]);
