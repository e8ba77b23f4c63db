#pragma once
/* A block and its surroundings as the filters of indirect light read them: which pixels were
 * measured, where they lie, and the distance of what they see. */
#include "server/reconstruct/indirect/indirect_kernels.h"
#include "server/reconstruct/patch/patch.h"

struct indirect_neighbourhood {
    struct rect rect;            /* in image pixels: what the field covers */
    struct indirect_field field; /* its arrays are those below */
    float *point[3], *normal[3];
    int32_t *object;
    float *falloff, *off;    /* not set yet */
    float *pixel;            /* world size of a pixel at the receiver; 0: nothing was measured */
    float *nearness;         /* 1 / z of the nearest reflector; 0: none, or nothing was measured */
    size_t area;             /* numbers of an array */
    size_t origin;           /* where the rect's first pixel lies in it */
    float *spare;            /* more such arrays, zeroed (indirect_neighbourhood_spare) */
    struct scratch *scratch; /* the patch's */
    void *memory;            /* owned; from there */
};

/* Loads all of `rect`, which lies in the patch's. Runs may look `reach` pixels beyond it. `spares`
 * more arrays are made. ERR_MEMORY. */
int indirect_neighbourhood_create(const struct plan *plan, const struct patch *patch,
                                  struct rect rect, int32_t reach, uint32_t spares,
                                  struct indirect_neighbourhood *out);
void indirect_neighbourhood_fini(struct indirect_neighbourhood *around);

static inline float *indirect_neighbourhood_spare(const struct indirect_neighbourhood *around,
                                                  uint32_t k)
{
    return around->spare + (size_t)k * around->area;
}

static inline size_t indirect_neighbourhood_index(const struct indirect_neighbourhood *around,
                                                  int32_t x, int32_t y)
{
    return around->origin + (size_t)(y - around->rect.y0) * (size_t)around->field.stride +
           (size_t)(x - around->rect.x0);
}

/* Returns the run of a row of `rect` from its first pixel on: along x, or along y with at most
 * `reach` rows before and after. It may pass the row's end by SIMD_LANES - 1 pixels. */
struct indirect_run indirect_neighbourhood_run(const struct indirect_neighbourhood *around,
                                               struct rect rect, int32_t y, bool along_x,
                                               int32_t reach);
