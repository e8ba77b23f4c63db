/* Widths of the axis-aligned filters of indirect light: by distance, by noise, within their halo.
 */
#include "tests/random.h"
#include "tests/unit/server/reconstruct/indirect/indirect_picture.h"
#include "tests/unit/unit.h"

/* Far reflectors: the cap; near ones: what they allow; mu multiplies both. */
TEST(widths)
{
    struct plan plan;
    struct patch *patch = plane_patch(&plan, 512, 512, 5.0f, BOUNCE_DISTANCE_NONE * 2.0f);
    const size_t centre = 256 * 512 + 256;
    const struct rect inner = {250, 250, 260, 260};
    const float pixel = plan_pixel_size(&plan, 5.0f);
    static const float near_px[] = {0.01f, 10.0f, 1000.0f};
    static const float expected_px[] = {4.761905f, 5.952381f, 7.5f}; /* 8, 10 px * 2 / 2.8 / 1.2 */
    for (int k = 0; k < 3; k++) {
        for (size_t i = 0; i < 512 * 512; i++) patch->bounce_distance_min[i] = near_px[k] * pixel;
        struct picture picture;
        picture_init(&picture, patch);
        for (plan.mu = 0.5f; plan.mu < 3.0f; plan.mu *= 2.0f) {
            filter_blocks(&plan, patch, inner, 64, &picture);
            const float width = picture.width[centre] / plan.mu;
            assert_true(fabsf(width - expected_px[k]) < 1e-3f * expected_px[k]);
        }
        picture_fini(&picture);
    }
    patch_destroy(&patch);
}

/* Mean and least width of the blend over the columns x0 .. x1 - 1. */
static void blend_widths(const struct plan *plan, const struct patch *patch, int32_t x0, int32_t x1,
                         float *mean, float *least)
{
    struct picture picture;
    const struct rect inner = {60, 60, 140, 140};
    picture_init(&picture, patch);
    filter_blocks(plan, patch, inner, 64, &picture);
    *mean = 0.0f;
    *least = 1e30f;
    for (int32_t y = inner.y0; y < inner.y1; y++) {
        for (int32_t x = x0; x < x1; x++) {
            const float width = picture.width[index_of(patch, x, y)];
            *mean += width / (float)((x1 - x0) * (inner.y1 - inner.y0));
            *least = fminf(*least, width);
        }
    }
    picture_fini(&picture);
}

/* Where there is nothing but noise, independent or blue, the blend stands near its widest, twice
 * rule B's; where light changes, noise or none, near its finest, half of rule B's. Measured, over
 * rule B: 1.99 and 1.98 (least 1.71), 0.61 and 0.64. */
TEST(widths_follow_noise)
{
    struct plan plan;
    struct random r = {11};
    struct patch *patch = plane_patch(&plan, 200, 200, 5.0f, BOUNCE_DISTANCE_NONE * 2.0f);
    float mean, least;
    plan.indirect_filter = INDIRECT_FILTER_BLEND;
    plan.indirect_strata_per_axis = 8;
    const float rule = 7.0f / cbrtf(2.0f) * 200.0f / (float)LINES;
    for (int blue = 0; blue < 2; blue++) {
        for (size_t i = 0; i < 200 * 200; i++) {
            const float sign = (i % 200 + i / 200) % 2 ? 1.0f : -1.0f, u = random_unit(&r) - 0.5f;
            for (int k = 0; k < 3; k++)
                patch->indirect[k][i] = 1.0f + (blue ? 0.3f * sign + 0.1f * u : 0.6f * u);
        }
        blend_widths(&plan, patch, 60, 140, &mean, &least);
        print_message("noise: %.3f of rule B, least %.3f\n", (double)(mean / rule),
                      (double)(least / rule));
        assert_true(mean > 1.8f * rule && least > 1.5f * rule);
    }
    for (int noisy = 0; noisy < 2; noisy++) {
        for (size_t i = 0; i < 200 * 200; i++) {
            const float u = noisy ? 0.2f * (random_unit(&r) - 0.5f) : 0.0f;
            for (int k = 0; k < 3; k++) patch->indirect[k][i] = (i % 200 < 100 ? 0.2f : 1.0f) + u;
        }
        blend_widths(&plan, patch, 98, 102, &mean, &least);
        print_message("edge: %.3f of rule B, least %.3f\n", (double)(mean / rule),
                      (double)(least / rule));
        assert_true(mean < 0.7f * rule);
    }
    patch_destroy(&patch);
}

TEST(halo_is_bounded)
{
    struct plan plan;
    room_plan(&plan, LINES, INDIRECT_FILTER_NONE, 4);
    assert_int_equal(indirect_halo_px(&plan), 0);
    plan.indirect_filter = INDIRECT_FILTER_CONSTANT;
    /* Spikes: windows of 12 px in two steps, and 8 steps of 5 px between means over 5. */
    assert_int_equal(indirect_halo_px(&plan), 2 * 12 + 8 * 5 + 2 * 2);
    plan.indirect_filter = INDIRECT_FILTER_ADAPTIVE;
    assert_in_range(indirect_halo_px(&plan), 1, INDIRECT_REACH_MAX_PX);
    for (plan.height_px = 1; plan.height_px <= LIMIT_IMAGE_SIDE_PX; plan.height_px *= 2) {
        for (uint32_t l = 1; l <= LIMIT_STRATA_PER_AXIS; l += 5) {
            for (plan.mu = 1e-3f; plan.mu <= (float)LIMIT_FILTER_MU; plan.mu *= 10.0f) {
                plan.indirect_strata_per_axis = l;
                for (size_t f = 0; f < FILTERS; f++) {
                    plan.indirect_filter = filters[f];
                    assert_in_range(indirect_halo_px(&plan), 1, INDIRECT_HALO_MAX_PX);
                }
            }
        }
    }
}
