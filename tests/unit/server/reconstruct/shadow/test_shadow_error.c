/* What shadow filters say of their own error: near what it is, less with more samples, and the same
 * wherever blocks end. Limits are what this scene needs and a good deal more. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/reconstruct/shadow/shadow_error.h"
#include "tests/unit/server/reconstruct/shadow/shadow_accuracy.h"
#include "tests/unit/unit.h"

#define SIDE 128
#define AREA (SIDE * SIDE)

static struct shadow_scene scene;

static void furnish(void)
{
    scene_init(&scene, SIDE, SIDE, 1.0f, 3);
    scene_furnish(&scene);
    scene_camera(&scene.plan, (float[]){0, -11.5f, 9}, (float[]){-0.2f, -1.2f, 0.2f}, 0.2f);
}

/* Roots of mean squares over penumbrae, and the share of their pixels that are within two. */
struct calibration {
    double off, said, within;
};

static struct calibration calibrate(const struct shadow_truth *truth, const struct patch *patch)
{
    static float e[AREA], variance[AREA];
    struct shadow_statistics statistics = {0};
    struct calibration c = {0};
    const double share = 1.0 / (double)truth->penumbra;
    memset(variance, 0, sizeof variance);
    assert_int_equal(shadow_filter(&scene.plan, 0, patch, patch->rect, e, NULL, &statistics), 0);
    assert_int_equal(shadow_error_add(&scene.plan, 0, patch, patch->rect, e, variance), 0);
    for (size_t i = 0; i < AREA; i++) {
        const double off = (double)(e[i] - truth->irradiance[i]), known = (double)variance[i];
        assert_true(isfinite(variance[i]) && variance[i] >= 0.0f);
        if (!truth_in_penumbra(truth, i)) continue;
        c.off += share * off * off;
        c.said += share * known;
        c.within += share * (off * off <= 4.0 * known);
    }
    c.off = sqrt(c.off), c.said = sqrt(c.said);
    return c;
}

TEST(errors_of_shadows_are_known)
{
    static const enum shadow_filter filters[] = {SHADOW_FILTER_SHEARED, SHADOW_FILTER_AXIS_ALIGNED};
    static const uint32_t strata[] = {2, 3, 4};
    struct shadow_truth truth;
    furnish();
    truth_init(&truth, &scene);
    for (size_t f = 0; f < 2; f++) {
        double before = INFINITY;
        for (size_t k = 0; k < 3; k++) {
            struct patch *patch = accuracy_patch(&scene, strata[k]);
            scene.plan.shadow_filter = filters[f];
            const struct calibration c = calibrate(&truth, patch);
            print_message("filter %zu, %u: off %.4f said %.4f within %.3f\n", f, strata[k], c.off,
                          c.said, c.within);
            assert_true(c.said > 0.7 * c.off && c.said < 3.0 * c.off);
            assert_true(c.within > 0.85 && c.within < 0.995);
            assert_true(c.said < before);
            before = c.said;
            patch_destroy(&patch);
        }
    }
    truth_fini(&truth);
}

TEST(light_without_shadow_has_no_error)
{
    static float e[AREA], variance[AREA];
    struct shadow_statistics statistics = {0};
    scene_init(&scene, SIDE, SIDE, 1.0f, 3);
    scene_camera(&scene.plan, (float[]){0, -11.5f, 9}, (float[]){-0.2f, -1.2f, 0.2f}, 0.2f);
    struct patch *patch = accuracy_patch(&scene, 3);
    scene.plan.shadow_filter = SHADOW_FILTER_SHEARED;
    memset(variance, 0, sizeof variance);
    assert_int_equal(shadow_filter(&scene.plan, 0, patch, patch->rect, e, NULL, &statistics), 0);
    assert_int_equal(shadow_error_add(&scene.plan, 0, patch, patch->rect, e, variance), 0);
    for (size_t i = 0; i < AREA; i++) assert_true(variance[i] == 0.0f);
    patch_destroy(&patch);
}

/* Of `block`, from a patch that ends with the filter's halo; at places of `whole`. */
static void of_block(struct rect block, struct rect whole, float *out)
{
    const struct rect near =
        rect_intersect(rect_grow(block, shadow_halo_px(scene.plan.shadow_filter)), whole);
    const size_t area = (size_t)rect_area(near), width = (size_t)rect_width(block);
    struct shadow_statistics statistics = {0};
    struct patch *patch = scene_patch(&scene, near);
    float *e = calloc(2 * area, sizeof *e), *variance = e + area;
    assert_non_null(e);
    assert_int_equal(shadow_filter(&scene.plan, 0, patch, block, e, NULL, &statistics), 0);
    assert_int_equal(shadow_error_add(&scene.plan, 0, patch, block, e, variance), 0);
    for (int32_t y = block.y0; y < block.y1; y++)
        memcpy(out + y * SIDE + block.x0, variance + patch_pixel(patch, block.x0, y),
               width * sizeof *out);
    free(e);
    patch_destroy(&patch);
}

TEST(blocks_do_not_show)
{
    static const enum shadow_filter filters[] = {SHADOW_FILTER_SHEARED, SHADOW_FILTER_AXIS_ALIGNED};
    static float parts[AREA], all[AREA];
    const struct rect whole = {0, 0, SIDE, SIDE};
    furnish();
    for (size_t f = 0; f < 2; f++) {
        scene.plan.shadow_filter = filters[f];
        of_block(whole, whole, all);
        for (int32_t y = 0; y < SIDE; y += 43)
            for (int32_t x = 0; x < SIDE; x += 43)
                of_block(rect_intersect((struct rect){x, y, x + 43, y + 43}, whole), whole, parts);
        assert_memory_equal(parts, all, sizeof all);
    }
}
