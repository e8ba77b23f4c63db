#pragma once
/* The slopes of the blockers of a pixel, and the filter that follows from them
 * (docs/reconstruction.md, Slopes and wedges, Shadow widths). */
#include "server/reconstruct/shadow/coverage.h"
#include "server/reconstruct/shadow/receiver.h"

/* How far around a pixel the search for slopes reads. */
#define WEDGE_FILL_PX 6

/* The range of 1/slope of each pixel of the receivers' rect; -1 without wedge. One allocation. */
struct wedges {
    float *most, *least;
    struct scratch *scratch; /* the patch's */
    void *memory;            /* owned; from there */
};

/* Returns whether pixel i of the patch has an occluded sample of its own. */
bool wedge_is_occluded(const struct receiver_light *light, const struct patch *patch, size_t i);

/* Finds the pixels' own ranges, and those of neighbours where no own sample is occluded. They are
 * right for pixels that lie WEDGE_FILL_PX within the receivers' rect, or up to the image's border.
 * ERR_MEMORY. */
int wedges_create(const struct receiver_light *light, const struct patch *patch,
                  const struct receivers *receivers, const struct shadow_kernels *kernels,
                  struct wedges *out);
void wedges_fini(struct wedges *wedges);

/* Returns m(N) mu, the scale of filter widths: m(N) = (9/N)^(1/3), N = strata^2 samples. */
float wedge_scale(const struct plan *plan, uint32_t strata);

/* What shearing needs beside a receiver. */
struct wedge_shear {
    const struct receiver_light *light;
    float scale;        /* wedge_scale */
    float width_max_px; /* the widest filter */
    float rho_max;      /* of the coverage table */
};

/* Sets eta, spread, walks, widths and weight rows of all lit receivers with a wedge. ERR_MEMORY. */
int wedges_shear(const struct receiver_light *light, const struct wedges *wedges,
                 const struct shadow_kernels *kernels, struct coverage *coverage,
                 struct receivers *receivers);
