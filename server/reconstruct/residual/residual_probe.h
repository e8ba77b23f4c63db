#pragma once
/* Pictures of noise that go through the residual filter's passes beside the light, under the same
 * weights. The noise that is left in them estimates the noise that is left in the light.
 *
 * A probe begins with the difference between a pixel's halves, as large as the error of their mean,
 * under a sign of its own at each pixel. It is one of many pictures that noise might have made, so
 * that the mean of a few probes' squares is the variance of filtered noise. Before the last pass
 * one more probe takes the difference between the halves as they are then. */
#include "server/reconstruct/patch/patch.h"
#include "server/reconstruct/residual/residual_field.h"

struct residual_probes {
    float *noise;            /* a plane: of the picture, what all probes begin with but for signs */
    struct scratch *scratch; /* borrowed */
    void *memory;            /* owned; taken from there */
};

/* Gives the field probes, before its first pass. ERR_MEMORY. */
int residual_probes_create(const struct patch *patch, struct residual_field *field,
                           struct residual_probes *out);
void residual_probes_fini(struct residual_probes *probes);

/* Makes probe RESIDUAL_SIGNED from the difference between the halves, before the last pass. */
void residual_probes_take_halves(struct residual_field *field);

/* Returns the sign of a probe at a pixel of the image: 1 or -1. */
float residual_probe_sign(int32_t x, int32_t y, uint32_t probe);

/* Returns what a component is multiplied by in the picture, as the mean over R, G and B. */
float residual_factor(const struct residual_features *f, enum residual_component component,
                      size_t at);

/* Return the part of probe k in the picture at a place of the field, after a pass and before that
 * pass. */
float residual_probe_after(const struct residual_field *field, uint32_t k, size_t at);
float residual_probe_before(const struct residual_field *field, uint32_t k, size_t at);
