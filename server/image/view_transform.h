#pragma once
/* From scene light to the light of a screen: image.view and image.exposure of a job. This is the
 * definition; web/picture/view_transform.js has the same formulas for the viewer, which tests
 * compare with it.
 *
 * Both ends are linear, with Rec. 709 primaries. Light below 0 and NaN count as 0, and the result
 * is clipped to [0, 1]; tonemap.h encodes it as sRGB. With v = light * 2^exposure:
 *
 *   linear  v.
 *   filmic  (2.51 x + 0.03) x / ((2.43 x + 0.59) x + 0.14) of x = 0.6 v, for each channel: K.
 *           Narkowicz, "ACES Filmic Tone Mapping Curve", 2015, exposed as ACES is: middle grey,
 *           0.18, becomes 0.14.
 *   agx     T. Sobotka's AgX as Blender 4 has it. In Rec. 2020 each channel leans towards grey
 *           (the inset), takes log2 over 16.5 stops and a sigmoid, and leans back (the outset); a
 *           power of 2.2 undoes the encoding in the sigmoid. Matrices and range are those of
 *           Filament's ToneMapper.cpp and of three.js; the sigmoid is the polynomial of B.
 *           Wrensch, "Minimal AgX Implementation", iolite-engine.com, 2023. 0.18 becomes 0.21. */
#include "proto/view_curve.h"

struct view_transform {
    enum view_curve curve;
    double scale; /* 2^exposure; what light is multiplied by */
    const struct view_kernels *kernels;
};

/* Pixels that are shown side by side. AgX takes half the time of one after the other with SSE4.2,
 * and a seventh with AVX-512. */
#define VIEW_PIXELS 64
struct view_pixels {
    double channel[3][VIEW_PIXELS];
};

/* The exposure is in stops; beyond the range of a float it is clipped. NaN is 0 stops. */
struct view_transform view_transform_of(enum view_curve curve, double exposure_ev);

/* Replaces light by what is shown of it. */
void view_transform_apply(const struct view_transform *view, struct view_pixels *pixels);
