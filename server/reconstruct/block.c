#include "server/reconstruct/block.h"

#include <string.h>

#include "proto/runtime/clock.h"
#include "proto/samples.h"
#include "server/reconstruct/compose/compose.h"
#include "server/reconstruct/compose/defocus.h"
#include "server/reconstruct/compose/mattes.h"
#include "server/reconstruct/compose/mixed_paths.h"
#include "server/reconstruct/compose/path_error.h"
#include "server/reconstruct/compose/paths.h"
#include "server/reconstruct/indirect/v_plane_filter.h"
#include "server/reconstruct/lens/lens_light.h"
#include "server/reconstruct/patch/half_fill.h"

/* Small blocks let the picture form bit by bit and many threads work at it. With a filter's halo
 * they repeat work: of the sheared filter's time, blocks of 64 cost 1.25 times and blocks of 256
 * 0.85 times as much as those of 128; of memory, 1.6 times as much for 256. Those are for pictures
 * that are still cut into BLOCKS_ENOUGH; for filters of the lens, whose halo is as wide as half a
 * block of those, for pictures that are still cut into BLOCKS_ENOUGH_WIDE: of fewer, each would
 * wait for nearly all of the picture's tiles, and be filtered after the last. The residual filter
 * repeats most, .27 CPU s instead of .45 on 400 x 400 pixels, and takes .1 s a block: it has large
 * blocks wherever the picture has the pixels of one. */
#define SIDE_PX                64
#define SIDE_FILTERED_PX       128
#define SIDE_FILTERED_LARGE_PX 256
#define BLOCKS_ENOUGH          64
#define BLOCKS_ENOUGH_WIDE     8
#define BLOCKS_ENOUGH_RESIDUAL 1

/* Of bounce rays of pixel centres, which a light field beside paths consists of. */
#define PLANES_BESIDE (PLANES_BOUNCE_LIGHT | PLANE_BIT(AMBIENT_VISIBILITY))

static bool is_filtered(const struct plan *plan)
{
    return plan->shadow_filter != SHADOW_FILTER_NONE ||
           plan->indirect_filter != INDIRECT_FILTER_NONE ||
           plan->glossy_filter != GLOSSY_FILTER_NONE ||
           plan->residual_filter == RESIDUAL_FILTER_HALVES || plan->lens_filter != LENS_FILTER_NONE;
}

/* Pixels beside a block whose lighting the resolve, or mixed pixels of paths, borrow. */
static int32_t ring_px(const struct plan *plan)
{
    bool resolved = plan->paths.spp == 0 || plan->paths.without_diffuse_direct ||
                    (plan->planes & PLANES_BOUNCE_LIGHT);
    int32_t ring = resolved && plan->sub_samples > 0 ? PATCH_RING_PX : 0;
    return ring > 0 ? ring : mixed_paths_ring_px(plan);
}

/* What pixels take that have no rays. */
static int32_t fill_px(const struct plan *plan)
{
    return plan->field_halved ? HALF_FILL_REACH_PX : 0;
}

/* The light of the ring is filtered as that of the block is. */
int32_t block_halo_px(const struct plan *plan)
{
    int32_t shadow = shadow_halo_px(plan->shadow_filter), indirect = indirect_halo_px(plan);
    int32_t sheared = v_plane_halo_px(plan), glossy = glossy_halo_px(plan);
    int32_t lens = lens_halo_px(plan), paths = path_error_halo_px(plan);
    if (indirect < sheared) indirect = sheared;
    if (indirect < glossy) indirect = glossy;
    if (indirect < shadow) indirect = shadow;
    if (indirect < paths) indirect = paths;
    const int32_t residual = residual_halo_px(plan) + lens_light_reach_px(plan);
    if (indirect < residual) indirect = residual;
    indirect += lens_relight_ring_px(plan);
    return ring_px(plan) + (indirect > lens ? indirect : lens) + fill_px(plan);
}

int32_t block_core_px(const struct plan *plan)
{
    const int32_t halo = block_halo_px(plan);
    if (plan->shadow_filter == SHADOW_FILTER_NONE && plan->lens_filter == LENS_FILTER_NONE &&
        !patch_has_far_indirect(plan) && !patch_has_far_lobes(plan) && !patch_has_far_paths(plan))
        return halo;
    const int32_t core = lens_relight_ring_px(plan) + PATCH_RING_PX + fill_px(plan);
    return core < halo ? core : halo;
}

/* Returns the bytes of the largest patch of blocks with this side. */
static uint64_t bytes_of(const struct plan *plan, int32_t side_px)
{
    const int32_t side = side_px + 2 * block_halo_px(plan);
    const size_t width = (size_t)(side < plan->width_px ? side : plan->width_px);
    const size_t height = (size_t)(side < plan->height_px ? side : plan->height_px);
    return patch_bytes(plan, width * height);
}

uint64_t block_patch_bytes_min(const struct plan *plan)
{
    return bytes_of(plan, SIDE_PX);
}

int32_t block_side_px(const struct plan *plan)
{
    const int64_t large = (int64_t)SIDE_FILTERED_LARGE_PX * SIDE_FILTERED_LARGE_PX;
    const int64_t enough = plan->lens_filter != LENS_FILTER_NONE ? BLOCKS_ENOUGH_WIDE
                           : plan->residual_filter == RESIDUAL_FILTER_HALVES
                               ? BLOCKS_ENOUGH_RESIDUAL
                               : BLOCKS_ENOUGH;
    const bool many = (int64_t)plan->width_px * plan->height_px >= enough * large;
    int32_t side = many ? SIDE_FILTERED_LARGE_PX : SIDE_FILTERED_PX;
    if (!is_filtered(plan)) return SIDE_PX;
    while (side > SIDE_PX && bytes_of(plan, side) > LIMIT_PATCH_BYTES) side /= 2;
    return side;
}

static bool contains(struct rect outer, struct rect inner)
{
    return inner.x0 >= outer.x0 && inner.y0 >= outer.y0 && inner.x1 <= outer.x1 &&
           inner.y1 <= outer.y1 && !rect_is_empty(inner);
}

static void tell(const struct lighting_statistics *cost, struct block_statistics *statistics)
{
    statistics->shadow = cost->shadow;
    statistics->indirect = cost->indirect;
    statistics->glossy = cost->glossy;
    statistics->glossy_cpu_us = cost->glossy_cpu_us;
    statistics->shadow_cpu_us = cost->shadow_cpu_us;
    statistics->indirect_cpu_us = cost->indirect_cpu_us;
}

static int reconstruct_light_field(const struct plan *plan, const struct patch *patch,
                                   struct rect block, struct image *image,
                                   struct block_variance *variance,
                                   struct block_statistics *statistics)
{
    struct lighting lighting;
    struct lighting_statistics cost = {.shadow_cpu_us = 0};
    struct resolver resolver;
    struct rect lit = rect_intersect(rect_grow(block, ring_px(plan)), patch->core);
    int error = lighting_create(plan, patch, lit, variance->memory != NULL, &lighting, &cost);
    if (error) return error;
    tell(&cost, statistics);
    resolver_init(&resolver, plan, patch, &lighting);
    resolver.errors = variance->memory != NULL;
    if (plan->paths.spp > 0 && !plan->paths.without_diffuse_direct)
        compose_beside_paths(&resolver, block, image, variance, statistics);
    else
        compose_light_field(&resolver, block, image, variance, statistics);
    lighting_fini(&lighting);
    return 0;
}

/* Reconstructs what the lens sees. Fields of pixel centres light its samples if the plan has these.
 *  */
static int reconstruct_lens(const struct plan *plan, struct patch *patch, struct rect block,
                            struct image *image, struct block_statistics *statistics)
{
    struct lighting lighting;
    struct lighting_statistics cost = {.shadow_cpu_us = 0};
    const int32_t ring = lens_relight_ring_px(plan);
    const struct rect lit = rect_intersect(rect_grow(block, ring), patch->core);
    if (plan->lens_relight == LENS_RELIGHT_OWN)
        return defocus_compose(plan, patch, block, image, statistics);
    int error = lighting_create(plan, patch, lit, false, &lighting, &cost);
    if (error) return error;
    tell(&cost, statistics);
    error = defocus_compose_lit(plan, patch, block, &lighting, lit, image, statistics);
    lighting_fini(&lighting);
    return error;
}

/* Lens samples are paths, too. */
static int clean_lens(const struct plan *plan, struct patch *patch, struct rect block,
                      struct block_statistics *statistics)
{
    const uint64_t start_us = thread_cpu_us();
    const int error = lens_light_filter(plan, patch, block, &statistics->residual);
    statistics->residual_cpu_us += thread_cpu_us() - start_us;
    return error;
}

static int reconstruct(const struct plan *plan, struct patch *patch, struct rect block,
                       struct image *image, struct block_variance *variance,
                       struct block_statistics *statistics)
{
    const bool paths = plan->paths.spp > 0, lens = plan->lens_strata_per_axis > 0;
    int error = 0;
    half_fill(plan, patch);
    if (paths && variance->memory) error = path_error_find(patch, variance);
    if (error) return error;
    if (paths)
        error = plan_lens_has_paths(plan)
                    ? clean_lens(plan, patch, block, statistics)
                    : paths_compose(plan, patch, block, image, variance, statistics);
    if (error) return error;
    if (lens)
        error = reconstruct_lens(plan, patch, block, image, statistics);
    else if (!paths || (plan->planes & PLANES_BESIDE) || plan->paths.without_diffuse_direct)
        error = reconstruct_light_field(plan, patch, block, image, variance, statistics);
    if (error) return error;
    compose_centre(plan, patch, block, image);
    mattes_compose(patch, block, image);
    if (variance->memory) compose_error(variance, image);
    return 0;
}

static void measure_pixels(const struct block_variance *variance, const struct image *image,
                           const struct block_measure *out)
{
    static const char *const names[] = {"R", "G", "B"};
    static const float weights[] = {0.2126f, 0.7152f, 0.0722f};
    const struct rect r = variance->rect;
    const size_t area = (size_t)rect_area(r);
    memset(out->luminance, 0, area * sizeof *out->luminance);
    for (int s = 0; s < ERROR_SOURCE_COUNT; s++)
        for (size_t i = 0; i < area; i++)
            out->variance[s][i] = (variance->by_source[s][0][i] + variance->by_source[s][1][i] +
                                   variance->by_source[s][2][i]) /
                                  3.0f;
    for (int c = 0; c < 3; c++) {
        const struct plane *plane = image_plane(image, names[c]);
        size_t i = 0;
        for (int32_t y = r.y0; y < r.y1; y++)
            for (int32_t x = r.x0; x < r.x1; x++, i++)
                out->luminance[i] += weights[c] * *plane_at(plane, x, y);
    }
}

static int run(const struct plan *plan, struct patch *patch, struct rect block, struct image *image,
               const struct block_measure *measure, struct block_statistics *statistics)
{
    struct rect whole = {0, 0, image->width_px, image->height_px};
    struct block_variance variance = {.memory = NULL};
    int error = 0;
    *statistics = (struct block_statistics){0};
    if (!contains(patch->core, block) || !contains(whole, block)) return ERR_RANGE;
    if (measure && !image_plane(image, "R")) return ERR_RANGE;
    if (measure || image_plane(image, "error.R")) error = block_variance_create(block, &variance);
    if (!error) error = reconstruct(plan, patch, block, image, &variance, statistics);
    if (!error && measure) measure_pixels(&variance, image, measure);
    block_variance_fini(&variance);
    return error;
}

int block_reconstruct(const struct plan *plan, struct patch *patch, struct rect block,
                      struct image *image, struct block_statistics *statistics)
{
    return run(plan, patch, block, image, NULL, statistics);
}

int block_reconstruct_measured(const struct plan *plan, struct patch *patch, struct rect block,
                               struct image *image, const struct block_measure *measure,
                               struct block_statistics *statistics)
{
    return run(plan, patch, block, image, measure, statistics);
}
