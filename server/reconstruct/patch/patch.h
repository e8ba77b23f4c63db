#pragma once
/* The samples of a block and its halo as float arrays: what reconstruction reads.
 *
 * All arrays have width * height elements of the rect, row by row, and are NULL when the plan does
 * not have their plane. One allocation, owned by the patch, and one of what lone sub-samples have.
 * The halo is cut at the image's border. Under a filter, and where halves tell of errors, there are
 * in the far halo, outside `core`, only depth, normal and what the plan's filters read: of shadows
 * the lights' visibility and slopes; of indirect light id, indirect light, reflector and open
 * shares; of glossy lobes id, light and its half, alpha and how far they see; lens samples; and
 * what tells of errors of paths. The other arrays are not set there. Distances are at most 1e16, so
 * that their squares are finite; normals are 0 without surface. */
#include <stdbool.h>

#include "proto/plan.h"
#include "server/reconstruct/patch/lone_share.h"
#include "server/reconstruct/patch/scratch.h"

struct patch_light {
    float *irradiance;   /* E of plan.h */
    uint8_t *visibility; /* visibility_bytes planes of w*h bytes, as samples.h */
    float *slope_min, *slope_max;
};

/* Sums over the samples of each pixel, as in proto/samples.h. */
struct patch_paths {
    float *spp; /* samples in the sums so far: tiles of a block may differ; at least 1 */
    float *radiance[3], *spread[3];
    float *emission[3], *direct[3], *indirect[3];
    float *diffuse_direct[3], *diffuse_indirect[3];
    float *albedo[3];
    float *coverage, *open; /* samples that meet a surface; those whose occlusion ray is open */
    float *split;           /* squared differences of halves, summed over rgb and parts */
    float *split_spp;       /* samples in those parts */
    float *split_length;    /* of such a part, in the mean over these samples */
};

/* Pixels around a block that belong to the core: whose lighting its sub-samples borrow. All that
 * these look at lies within, or pictures would hang on where blocks end. */
#define PATCH_RING_PX 2

struct patch {
    struct rect rect; /* in image pixels */
    struct rect core; /* within it: everything is there */
    float *depth;     /* 0: no surface */
    float *normal[3];
    float *albedo[3];
    uint32_t *id;
    float *sub_depth[LIMIT_SUB_SAMPLES]; /* absolute distance along the sub-sample's ray; 0: none */
    float *sub_normal[LIMIT_SUB_SAMPLES][3];
    float *sub_albedo[LIMIT_SUB_SAMPLES][3];
    uint32_t *sub_id[LIMIT_SUB_SAMPLES]; /* low 16 bits */
    float *emission[3];                  /* radiance, scale taken out */
    float *indirect[3];                  /* mean radiance, scale taken out */
    float *indirect_even[3], *indirect_odd[3];
    float
        *reflector; /* scene units; from REFLECTOR_NONE * length_unit on: nothing met; 0: no rays */
    float *reflector_far;   /* scene units; the farthest that was met; 0: nothing */
    float *bounces;         /* bounce rays of the pixel so far, also in the far halo; NULL unless
                               pixels may differ: under a plan that has rounds */
    float *indirect_strata; /* l_i^2 * 4 planes */
    float *open;            /* share of the bounce rays that meet nothing near */
    float *glossy[3];       /* mean of weight times radiance, scale taken out, over reflectance */
    float *glossy_weight;   /* of weight alone, over reflectance */
    float *glossy_half[3];  /* the same two of half of the pixel's rays */
    float *glossy_half_weight;
    float *glossy_alpha;             /* 0: no glossy lobe */
    float *glossy_nearness;          /* mean of 1 / distance, scene units */
    float *glossy_near, *glossy_far; /* as reflector and reflector_far, of the lobe's rays */
    float *glossy_rays; /* of the lobe so far, as `bounces`: also in the far halo; NULL unless
                           pixels may differ */
    float *reflectance[3];
    float *sub_reflectance[LIMIT_SUB_SAMPLES][3];
    float *lens_radiance; /* l_u^2 * 3 planes: sample * 3 + channel, scale taken out */
    float *lens_slope;    /* l_u^2 planes; pixels per unit of the lens */
    uint16_t *lens_depth, *lens_normal; /* l_u^2 planes each, and so below: as in samples.h */
    uint32_t *lens_albedo, *lens_light;
    uint32_t *lens_lobe;  /* NULL where fields light no lobes of lens samples */
    float *lens_coverage; /* share of the lens samples that meet a surface */
    float *lens_more;  /* 4 planes: of second sets mean radiance, rgb, and its root mean square */
    float *lens_paths; /* how many paths these have; 0 or PLAN_LENS_SIDE squared */
    bool lens_drawn;   /* the picture has what the first sets show, filtered */
    uint8_t *lens_levels;   /* borrowed: for how much the pixels of a block that is composed need a
                               second set (lens_extra.h), row by row; NULL: nobody asks */
    struct lone_share lone; /* of the core; entries owned */
    struct patch_light lights[LIMIT_LIGHTS];
    struct patch_paths paths;
    struct scratch *scratch; /* borrowed: of the patch, and for work on it; NULL: the heap */
    void *memory;            /* owned; taken from there */
};

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
