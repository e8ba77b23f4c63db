#include "server/reconstruct/compose/defocus.h"

#include <math.h>
#include <string.h>

#include "proto/runtime/clock.h"
#include "server/reconstruct/lens/lens.h"
#include "server/reconstruct/lens/lens_second_set.h"
#include "server/reconstruct/lighting/lighting.h"

static const char *const channels[] = {"R", "G", "B"};

/* What lens_filter writes; arrays of the patch's size. */
struct defocused {
    float *rgb[3], *width_px;
    void *memory;
};

static int create(const struct patch *patch, struct defocused *out)
{
    const size_t area = (size_t)rect_area(patch->rect);
    float *at = out->memory = scratch_take(patch->scratch, area * 4 * sizeof *at);
    if (!at) return ERR_MEMORY;
    for (int c = 0; c < 3; c++, at += area) out->rgb[c] = at;
    out->width_px = at;
    return 0;
}

static int filter(const struct plan *plan, const struct patch *patch, struct rect block,
                  struct defocused *out, struct block_statistics *statistics)
{
    const uint64_t start_us = thread_cpu_us();
    struct lens_statistics lens = {0};
    int error = lens_filter(plan, patch, block, out->rgb, out->width_px, &lens);
    if (!error && patch->lens_paths) error = lens_second_set_mix(plan, patch, block, out->rgb);
    if (!error && patch->lens_levels)
        error = lens_second_set_levels(plan, patch, block, patch->lens_levels);
    if (plan->lens_filter == LENS_FILTER_NONE) return error;
    statistics->lens = lens;
    statistics->lens_cpu_us = thread_cpu_us() - start_us;
    return error;
}

static void put(const struct patch *patch, const float *in, struct rect block,
                const struct plane *out)
{
    for (int32_t y = block.y0; out && y < block.y1; y++) {
        const float *from = in + patch_pixel(patch, block.x0, y);
        float *to = plane_at(out, block.x0, y);
        for (int32_t x = 0; x < rect_width(block); x++) to[x] = fminf(from[x], LIGHTING_MAX);
    }
}

static void take(const struct patch *patch, const struct plane *in, struct rect block, float *out)
{
    const size_t bytes = (size_t)rect_width(block) * sizeof *out;
    for (int32_t y = block.y0; in && y < block.y1; y++)
        memcpy(out + patch_pixel(patch, block.x0, y), plane_at(in, block.x0, y), bytes);
}

/* Second sets come to a picture that has been filtered: to what is there. */
static int mix(const struct plan *plan, const struct patch *patch, struct rect block,
               struct defocused *seen, struct image *image, struct block_statistics *statistics)
{
    const uint64_t start_us = thread_cpu_us();
    for (int c = 0; c < 3; c++) take(patch, image_plane(image, channels[c]), block, seen->rgb[c]);
    const int error = lens_second_set_mix(plan, patch, block, seen->rgb);
    statistics->lens_cpu_us = thread_cpu_us() - start_us;
    return error;
}

static void put_coverage(const struct patch *patch, struct rect block, struct image *image,
                         struct block_statistics *statistics)
{
    const struct plane *out = image_plane(image, "A");
    for (int32_t y = block.y0; patch->lens_coverage && y < block.y1; y++) {
        const float *in = patch->lens_coverage + patch_pixel(patch, block.x0, y);
        for (int32_t x = 0; x < rect_width(block); x++) {
            statistics->pixels_background += in[x] > 0.0f ? 0 : 1;
            if (out) plane_at(out, block.x0, y)[x] = fminf(in[x], 1.0f);
        }
    }
}

/* Lens samples of each pixel, and paths of second sets. */
static void put_counts(const struct plan *plan, const struct patch *patch, struct rect block,
                       const struct plane *out)
{
    const float first = (float)(plan->lens_strata_per_axis * plan->lens_strata_per_axis);
    for (int32_t y = block.y0; out && y < block.y1; y++) {
        const size_t row = patch_pixel(patch, block.x0, y);
        float *to = plane_at(out, block.x0, y);
        for (int32_t x = 0; x < rect_width(block); x++)
            to[x] = first + (patch->lens_paths ? patch->lens_paths[row + (size_t)x] : 0.0f);
    }
}

int defocus_compose(const struct plan *plan, const struct patch *patch, struct rect block,
                    struct image *image, struct block_statistics *statistics)
{
    struct defocused seen = {0};
    int error = create(patch, &seen);
    if (!error && patch->lens_drawn)
        error = mix(plan, patch, block, &seen, image, statistics);
    else if (!error)
        error = filter(plan, patch, block, &seen, statistics);
    for (int c = 0; c < 3 && !error; c++)
        put(patch, seen.rgb[c], block, image_plane(image, channels[c]));
    if (!error && !patch->lens_drawn)
        put(patch, seen.width_px, block, image_plane(image, "filter_width.W"));
    scratch_give(patch->scratch, seen.memory);
    if (error) return error;
    put_coverage(patch, block, image, statistics);
    put_counts(plan, patch, block, image_plane(image, "samples.N"));
    return 0;
}

int defocus_compose_lit(const struct plan *plan, struct patch *patch, struct rect block,
                        const struct lighting *lighting, struct rect lit, struct image *image,
                        struct block_statistics *statistics)
{
    const struct rect seen = rect_intersect(rect_grow(block, lens_halo_px(plan)), patch->rect);
    const uint64_t start_us = thread_cpu_us();
    const int error = lens_relight_take(plan, patch, lighting, lit, seen, block,
                                        patch->lens_radiance, &statistics->lens_relight);
    statistics->lens_relight_cpu_us = thread_cpu_us() - start_us;
    return error ? error : defocus_compose(plan, patch, block, image, statistics);
}
