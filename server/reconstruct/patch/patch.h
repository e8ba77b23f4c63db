#pragma once
/* The samples of a block and its halo as arrays of numbers: what reconstruction reads.
 *
 * Planes become the fields that proto/plane.def names: what it gives an ARRAY has width * height
 * elements of the rect, row by row, for each component; a STACK has so many after each other. They
 * are NULL where the plan does not have the plane. Scales are taken out: radiance and distances are
 * those of the scene, of sub-samples, too. One allocation, owned by the patch, and one of what lone
 * sub-samples have.
 *
 * The halo is cut at the image's border. Under a filter, and where halves tell of errors, the far
 * halo, outside `core`, has only the arrays that the plan's filters read (enum patch_reach); the
 * others are not set there. Distances are at most 1e16, so that their squares are finite; normals
 * are 0 without surface. */
#include <stdbool.h>

#include "proto/samples.h"
#include "server/reconstruct/patch/lone_share.h"
#include "server/reconstruct/patch/scratch.h"

#define ARRAY(type, field, dimensions, ...) type *field dimensions;
#define STACK(type, field, ...)             type *field;

struct patch_light {
#define LIGHT_PLANE(number, name, key, type, components, per, values, arrays, ...) arrays
#include "proto/plane.def"
};

/* Samples of each pixel that its sums over paths hold: tiles of a block may differ. */
struct patch_paths {
    float *spp;          /* at least 1 */
    float *split_spp;    /* those in parts that path_split is made of */
    float *split_length; /* of such a part, in the mean over these samples */
};

/* Pixels around a block that belong to the core: whose lighting its sub-samples borrow. All that
 * these look at lies within, or pictures would hang on where blocks end. */
#define PATCH_RING_PX 2

struct patch {
    struct rect rect; /* in image pixels */
    struct rect core; /* within it: everything is there */
#define PLANE(number, name, key, type, components, per, values, merge, arrays, ...) arrays
#include "proto/plane.def"
    /* How many rays each pixel has so far, also in the far halo; NULL unless pixels may differ:
     * under a plan that has rounds. */
    float *bounces;
    float *glossy_rays;       /* of the lobe */
    float *lens_paths;        /* of lens_more: 0 or PLAN_LENS_SIDE squared */
    struct patch_paths paths; /* also without rounds */
    struct patch_light lights[LIMIT_LIGHTS];
    bool lens_drawn;         /* the picture has what the first sets show, filtered */
    uint8_t *lens_levels;    /* borrowed: for how much the pixels of a block that is composed need a
                                second set (lens_extra.h), row by row; NULL: nobody asks */
    struct lone_share lone;  /* of the core; entries owned */
    struct scratch *scratch; /* borrowed: of the patch, and for work on it; NULL: the heap */
    void *memory;            /* owned; taken from there */
};
#undef ARRAY
#undef STACK

/* Bytes of the arrays that the plan has for so many pixels. */
size_t patch_bytes(const struct plan *plan, size_t area);

/* Allocates all arrays that the plan has for `rect`, which is all core. They and what work on the
 * patch takes come from the scratch, which must outlive the patch; from the heap if it is NULL. */
int patch_create_in(struct scratch *scratch, const struct plan *plan, struct rect rect,
                    struct patch **out);
int patch_create(const struct plan *plan, struct rect rect, struct patch **out); /* in the heap */
void patch_destroy(struct patch **patch);

/* Whether halves, and what it takes to smooth them, tell of errors of indirect light. */
bool patch_knows_errors(const struct plan *plan);

/* Whether the far halo has indirect light. */
bool patch_has_far_indirect(const struct plan *plan);

/* The same of glossy lobes. */
bool patch_knows_glossy_errors(const struct plan *plan);
bool patch_has_far_lobes(const struct plan *plan);

/* Whether the far halo has what tells of errors of paths: spreads, halves, counts. */
bool patch_has_far_paths(const struct plan *plan);

/* What the far halo has, of enum patch_reach. */
uint32_t patch_far(const struct plan *plan);

/* True when pixel i's centre shows a surface, as far as the patch can tell. */
bool patch_has_surface(const struct patch *patch, size_t i);

/* Where the arrays have image pixel (x, y), which lies in the rect. */
static inline size_t patch_pixel(const struct patch *patch, int32_t x, int32_t y)
{
    return (size_t)(y - patch->rect.y0) * (size_t)rect_width(patch->rect) +
           (size_t)(x - patch->rect.x0);
}

/* Did bounce rays leave pixel i? The patch needs depth and reflector. */
static inline bool patch_is_measured(const struct patch *patch, size_t i)
{
    return patch->depth[i] > 0.0f && patch->reflector[i] > 0.0f;
}

/* Does pixel i show a surface with a glossy lobe? The patch needs glossy_alpha. */
static inline bool patch_is_glossy(const struct patch *patch, size_t i)
{
    return patch->glossy_alpha[i] > 0.0f && (!patch->depth || patch->depth[i] > 0.0f);
}

/* Of how many pixels of `rect`, which lies in the patch's: that bounce rays left; with a lobe. */
uint64_t patch_count_measured(const struct patch *patch, struct rect rect);
uint64_t patch_count_glossy(const struct patch *patch, struct rect rect);
