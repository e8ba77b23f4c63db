#pragma once
/* A block and its surroundings as filters that compare lobes read them: where pixels lie, and their
 * glossy lobes. */
#include "server/reconstruct/glossy/glossy_kernels.h"
#include "server/reconstruct/patch/patch.h"

#define GLOSSY_CHANNELS 4 /* light over reflectance, rgb; weight over reflectance */
#define GLOSSY_MEASURED (2 * GLOSSY_CHANNELS) /* of all rays; of half of them */

/* Returns whether the filter compares lobes as published, without what they see. */
bool glossy_is_published(uint32_t filter);

struct glossy_neighbourhood {
    struct rect rect; /* in image pixels: what the field knows */
    struct glossy_field field;
    enum glossy_shape shape; /* of its lobes, as the plan's filter compares them */
    bool published;          /* ... and without parallax */
    uint32_t channels;       /* GLOSSY_CHANNELS, or GLOSSY_MEASURED with halves */
    float *channel[GLOSSY_MEASURED], *between[GLOSSY_MEASURED];
    float *wide[GLOSSY_MEASURED]; /* with halves: for what is filtered once more */
    size_t area;                  /* numbers of an array */
    size_t origin;                /* where the rect's first pixel lies in it */
    float *own[22];               /* the field's arrays */
    int32_t *object;
    struct scratch *scratch; /* the patch's */
    void *memory;            /* owned; from there */
};

/* Loads all of `rect`, which lies in the patch's, with room for runs that look `reach` pixels
 * beyond it, and with halves if these are wanted.
 *
 * A lobe takes part where the surface is not seen at grazing angles, n.v >= 0.05. It is GGX's, as a
 * Gaussian of sigma = alpha / sqrt(2.26), at least that of alpha 0.002. The mirrored lobe is twice
 * as wide in the plane of incidence, and n.v times that across; an anisotropic one lies as its
 * facets are spread, for virtual hits by the root of their stretch. Lobes as published see as if
 * nothing were met: nearness 0. ERR_MEMORY. */
int glossy_neighbourhood_create(const struct plan *plan, const struct patch *patch,
                                struct rect rect, int32_t reach, bool halves,
                                struct glossy_neighbourhood *out);
void glossy_neighbourhood_fini(struct glossy_neighbourhood *around);

static inline size_t glossy_neighbourhood_index(const struct glossy_neighbourhood *around,
                                                int32_t x, int32_t y)
{
    return around->origin + (size_t)(y - around->rect.y0) * (size_t)around->field.stride +
           (size_t)(x - around->rect.x0);
}

/* Gives pixel i of the neighbourhood's arrays a rule of its own. All pixels of the neighbourhood
 * need one, or none.
 */
void glossy_neighbourhood_rule(struct glossy_neighbourhood *around, size_t i,
                               const struct glossy_rule *rule);
void glossy_neighbourhood_one_rule(struct glossy_neighbourhood *around); /* takes these back */

/* Returns the run of a row of `rect` from its first pixel on. It may pass the row's end by
 * SIMD_LANES - 1 pixels. */
struct glossy_run glossy_neighbourhood_run(const struct glossy_neighbourhood *around,
                                           struct rect rect, int32_t y, bool along_x,
                                           int32_t reach);
