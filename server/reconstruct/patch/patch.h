#pragma once
/* The samples of a block and its halo, as the arrays that reconstruction reads.
 *
 * Planes become the fields that proto/plane.def names. An ARRAY has width * height elements of the
 * rect, row by row, for each component; a STACK has them one component after the other. A field is
 * NULL if the plan lacks the plane. Scales are taken out: radiance and distances are those of the
 * scene, in sub-samples, too. The patch owns one allocation, and one more for each of lone
 * sub-samples and mixed pixels.
 *
 * The halo is cut at the image's border. Under a filter, and where halves measure errors, the far
 * halo outside of `core` has only the arrays that the plan's filters read (enum patch_reach); the
 * others are not set there. Distances are at most 1e16, so that their squares are finite. Normals
 * are 0 without a surface. */
#include <stdbool.h>

#include "proto/samples.h"
#include "server/reconstruct/patch/lone_share.h"
#include "server/reconstruct/patch/mixed_share.h"
#include "server/reconstruct/patch/scratch.h"

struct residual_window;

#define ARRAY(type, field, dimensions, ...) type *field dimensions;
#define STACK(type, field, ...)             type *field;

struct patch_light {
#define LIGHT_PLANE(number, name, key, type, components, per, values, arrays, ...) arrays
#include "proto/plane.def"
};

/* What a pixel without rays of its own has of pixels beside it (half_fill.h). */
enum patch_lent { PATCH_LENT_BOUNCES = 1, PATCH_LENT_LOBE = 2 };

/* Samples in each pixel's sums over paths. Tiles of a block may differ. */
struct patch_paths {
    float *spp;          /* at least 1 */
    float *split_spp;    /* those in the parts of path_half_difference2 */
    float *split_length; /* mean length of such a part over these samples */
};

/* Pixels around a block that belong to the core, since the block's sub-samples use their
 * lighting. All that sub-samples read lies within; otherwise pictures would depend on the
 * borders of blocks. */
#define PATCH_RING_PX 2

struct patch {
    struct rect rect; /* in image pixels */
    struct rect core; /* within it; every array is set there */
    float pixel_rad;  /* the angle that a pixel is wide; 0: none, the camera is orthographic */
#define PLANE(number, name, key, type, components, per, values, merge, arrays, ...) arrays
#include "proto/plane.def"
    /* Each pixel's number of rays so far, also in the far halo. NULL unless the plan has rounds,
     * under which pixels may differ. */
    float *bounces;
    float *glossy_rays;       /* of the lobe */
    uint8_t *lent;            /* of fields at half resolution: bits of enum patch_lent; else NULL */
    float *lens_paths;        /* of lens_second_set: 0 or PLAN_LENS_EXTRA_STRATA squared */
    struct patch_paths paths; /* also without rounds */
    struct patch_light lights[LIMIT_LIGHTS];
    bool lens_drawn;      /* whether the picture holds the filtered first sets */
    uint8_t *lens_levels; /* borrowed: how much each pixel of the composed block needs a second set
                             (lens_second_set.h), row by row; NULL: not wanted */
    const struct residual_window *window; /* borrowed: samples of other frames (residual_window.h);
                                             NULL: none */
    struct lone_share lone;               /* of the core; entries owned */
    struct mixed_share mixed;             /* the same */
    struct scratch *scratch; /* borrowed: of the patch, and for work on it; NULL: the heap */
    void *memory;            /* owned; taken from there */
};
#undef ARRAY
#undef STACK

/* Returns the bytes of the plan's arrays for `area` pixels. */
size_t patch_bytes(const struct plan *plan, size_t area);

/* Allocates all arrays that the plan has for `rect`, which becomes the core, too. The patch and
 * work on it take memory from the scratch, which must outlive it, or from the heap if it is
 * NULL. */
int patch_create_in(struct scratch *scratch, const struct plan *plan, struct rect rect,
                    struct patch **out);
int patch_create(const struct plan *plan, struct rect rect, struct patch **out); /* in the heap */
void patch_destroy(struct patch **patch);

/* Returns whether errors of indirect light are known, from halves and what smooths them. */
bool patch_knows_errors(const struct plan *plan);

/* Returns whether the far halo has indirect light. */
bool patch_has_far_indirect(const struct plan *plan);

/* Do the same for glossy lobes. */
bool patch_knows_glossy_errors(const struct plan *plan);
bool patch_has_far_lobes(const struct plan *plan);

/* Returns whether the far halo has what errors of paths follow from: spreads, halves, counts. */
bool patch_has_far_paths(const struct plan *plan);

/* Returns what the far halo has, as bits of enum patch_reach. */
uint32_t patch_far(const struct plan *plan);

/* Returns whether pixel i's centre shows a surface, as far as the patch knows. */
bool patch_has_surface(const struct patch *patch, size_t i);

/* Returns the index of image pixel (x, y), which lies in the rect. */
static inline size_t patch_pixel(const struct patch *patch, int32_t x, int32_t y)
{
    return (size_t)(y - patch->rect.y0) * (size_t)rect_width(patch->rect) +
           (size_t)(x - patch->rect.x0);
}

/* Returns whether bounce rays left pixel i. The patch needs depth and bounce_distance_min. */
static inline bool patch_is_measured(const struct patch *patch, size_t i)
{
    return patch->depth[i] > 0.0f && patch->bounce_distance_min[i] > 0.0f;
}

/* Returns whether pixel i shows a surface with a glossy lobe. The patch needs glossy_alpha. */
static inline bool patch_is_glossy(const struct patch *patch, size_t i)
{
    return patch->glossy_alpha[i] > 0.0f && (!patch->depth || patch->depth[i] > 0.0f);
}

/* Count the pixels of `rect`, which lies in the patch's, that bounce rays left, and those with a
 * lobe. */
uint64_t patch_count_measured(const struct patch *patch, struct rect rect);
uint64_t patch_count_glossy(const struct patch *patch, struct rect rect);
