#include "server/reconstruct/defocus.h"

#include <math.h>
#include <string.h>

#include "server/reconstruct/lighting.h"

static const char *const channels[] = {"R", "G", "B"};

/* A row of the plain average, summed in the order of the samples. */
static void average_row(const struct plan *plan, const struct patch *patch, uint32_t channel,
                        size_t first, size_t count, float *out)
{
    const uint32_t samples = plan->lens_strata_per_axis * plan->lens_strata_per_axis;
    const size_t area = (size_t)rect_area(patch->rect);
    const float share = 1.0f / (float)samples;
    memset(out, 0, count * sizeof *out);
    for (uint32_t i = 0; i < samples; i++) {
        const float *in = patch->lens_radiance + (i * 3 + channel) * area + first;
        for (size_t x = 0; x < count; x++) out[x] += in[x];
    }
    for (size_t x = 0; x < count; x++) out[x] = fminf(out[x] * share, LIGHTING_MAX);
}

static void put_average(const struct plan *plan, const struct patch *patch, struct rect block,
                        struct image *image)
{
    for (uint32_t c = 0; c < 3; c++) {
        const struct plane *out = image_plane(image, channels[c]);
        for (int32_t y = block.y0; out && y < block.y1; y++)
            average_row(plan, patch, c, patch_pixel(patch, block.x0, y), (size_t)rect_width(block),
                        plane_at(out, block.x0, y));
    }
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

static void fill(const struct plane *out, struct rect block, float value)
{
    for (int32_t y = block.y0; out && y < block.y1; y++)
        for (int32_t x = block.x0; x < block.x1; x++) *plane_at(out, x, y) = value;
}

int defocus_compose(const struct plan *plan, const struct patch *patch, struct rect block,
                    struct image *image, struct block_statistics *statistics)
{
    const uint32_t samples = plan->lens_strata_per_axis * plan->lens_strata_per_axis;
    put_average(plan, patch, block, image);
    put_coverage(patch, block, image, statistics);
    fill(image_plane(image, "samples.N"), block, (float)samples);
    fill(image_plane(image, "filter_width.W"), block, 0.0f);
    return 0;
}
