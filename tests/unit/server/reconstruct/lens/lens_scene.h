#pragma once
/* Light fields of a lens made of formulas: layers of textures T(x + s u), one before the other, and
 * what a dense average over pixel and lens makes of them. */
#include <stdint.h>

#include "proto/lens_pattern.h"
#include "proto/samples.h"
#include "server/reconstruct/lens/lens.h"

enum lens_scene {
    LENS_PLANES, /* textured planes beside each other: before, in and behind the focus */
    LENS_FENCE,  /* a fence out of focus before a thing in focus and a far wall */
    LENS_LAMPS,  /* small bright lamps far behind the focus, and a ball before it */
    LENS_FLOOR,  /* one plane through the focus, away from the viewer */
    LENS_SCENES
};

static const char *const lens_scene_names[LENS_SCENES] = {"planes", "fence", "lamps", "floor"};

#define LENS_SIDE 96

struct lens_picture {
    struct plan plan;
    struct patch patch; /* arrays owned */
    float *out[4];      /* picture and width; owned by out[0] */
};

void lens_picture_create_seeded(enum lens_scene scene, uint32_t l, uint32_t blades, uint32_t seed,
                                struct lens_picture *out);

static inline void lens_picture_create(enum lens_scene scene, uint32_t l, uint32_t blades,
                                       struct lens_picture *out)
{
    lens_picture_create_seeded(scene, l, blades, 5, out);
}

void lens_picture_destroy(struct lens_picture *p);

/* The dense average of every second pixel of every second row: three planes, and after them 1 at
 * silhouettes and in focus, and -1 at the pixels left out. */
float *lens_reference(enum lens_scene scene, uint32_t blades);

struct lens_error {
    double all, away; /* over the mean; away from silhouettes and from what is in focus */
};

struct lens_error lens_error_of(const struct lens_picture *p, const float *reference);
int lens_run(struct lens_picture *p, uint32_t filter, struct lens_statistics *statistics);
