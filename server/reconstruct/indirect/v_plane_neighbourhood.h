#pragma once
/* A block and its surroundings as the sheared filter of indirect light reads them: which pixels
 * were measured, and the samples row by row. */
#include "server/reconstruct/indirect/v_plane_kernels.h"
#include "server/reconstruct/patch/patch.h"
#include "server/reconstruct/patch/surface.h"

#define V_PLANE_HALO_PX (2 * V_PLANE_REACH_PX + V_PLANE_SLOPES_PX)

struct v_plane_neighbourhood {
    const struct plan *plan;   /* borrowed */
    const struct patch *patch; /* borrowed */
    const struct v_plane_kernels *kernels;
    struct rect rect;  /* of the field, in image pixels; it may pass the patch's and the image's */
    struct rect inner; /* the filtered pixels; rect is it grown by V_PLANE_HALO_PX */
    struct surface_view view;
    struct v_plane_field field; /* its arrays are those below; ratios are not set */
    struct v_plane_source *sources;
    struct v_plane_walk *walks[2]; /* zero; v_plane_slopes.h sets them */
    struct v_plane_strata strata;  /* of one row */
    float *jitter[2];              /* of the same row */
    void *memory;                  /* owned */
};

static inline size_t v_plane_index(const struct v_plane_neighbourhood *p, int32_t x, int32_t y)
{
    return (size_t)(y - p->rect.y0) * (size_t)p->field.width + (size_t)(x - p->rect.x0);
}

static inline bool v_plane_is_source(const struct v_plane_source *s)
{
    return s->pixel > 0.0f;
}

/* Loads the neighbourhood of `inner`. ERR_MEMORY. */
int v_plane_neighbourhood_create(const struct plan *plan, const struct patch *patch,
                                 struct rect inner, const struct v_plane_kernels *kernels,
                                 struct v_plane_neighbourhood *out);
void v_plane_neighbourhood_fini(struct v_plane_neighbourhood *around);

/* Computes the strata and sample planes of `count` pixels from (x, y) on, which lie in one row of
 * the patch and of the field. */
void v_plane_neighbourhood_row(struct v_plane_neighbourhood *around, int32_t x, int32_t y,
                               uint32_t count, struct v_plane_planes *planes);
