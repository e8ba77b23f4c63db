/* The sheared filter: against brute force, the plain average and axis-aligned filtering on a scene
 * of formulas; constants; cuts; degenerate lights, receivers and slopes. */
#include "tests/random.h"
#include "tests/unit/server/reconstruct/shadow/shadow_accuracy.h"
#include "tests/unit/unit.h"

#define SIDE 144
#define ZOOM 0.15f

static struct shadow_scene scene;

static void furnish_part(int32_t width, int32_t height, uint32_t profile, float aspect)
{
    scene_init(&scene, width, height, 1.0f, 3);
    scene_furnish(&scene);
    scene.plan.lights[0].profile = profile;
    for (int k = 0; k < 3; k++) scene.plan.lights[0].half_v[k] *= aspect;
    /* near enough for penumbrae of many pixels */
    scene_camera(&scene.plan, (float[]){0, -11.5f, 9}, (float[]){-0.2f, -1.2f, 0.2f}, ZOOM);
}

static void furnish(uint32_t profile, float aspect)
{
    furnish_part(SIDE, SIDE, profile, aspect);
}

struct errors {
    double plain, axis_aligned, sheared, brute, difference;
};

static struct errors measure(const struct shadow_truth *truth, uint32_t l, bool brute)
{
    struct patch *patch = accuracy_patch(&scene, l);
    struct errors r = {0};
    float *axis_aligned = accuracy_filter(&scene, patch, SHADOW_FILTER_AXIS_ALIGNED, 64, NULL);
    float *sheared = accuracy_filter(&scene, patch, SHADOW_FILTER_SHEARED, 64, NULL);
    r.plain = truth_rmse(truth, patch->lights[0].irradiance, truth->irradiance);
    r.axis_aligned = truth_rmse(truth, axis_aligned, truth->irradiance);
    r.sheared = truth_rmse(truth, sheared, truth->irradiance);
    print_message("%3u spp: plain %.5f, axis-aligned %.5f, sheared %.5f\n", l * l, r.plain,
                  r.axis_aligned, r.sheared);
    if (brute) {
        float *all = accuracy_brute(&scene, patch, truth, sheared);
        r.brute = truth_rmse(truth, all, truth->irradiance);
        r.difference = truth_rmse(truth, all, sheared);
        print_message("         brute force %.4f, sheared to brute force %.4f\n", r.brute,
                      r.difference);
        free(all);
    }
    free(sheared);
    free(axis_aligned);
    patch_destroy(&patch);
    return r;
}

/* How many times the sheared filter's error the others have at 9 samples, as measured on this
 * scene. Design asks for 5 and 1.8 on the median of the accuracy bench's scenes; here, with one
 * scene a light, the measured numbers are what a change must not lose a tenth of. */
struct factors {
    double plain, axis_aligned;
};
static const struct factors gaussian_measured = {7.22, 2.07};
static const struct factors uniform_measured = {6.82, 1.74};
static const struct factors long_measured = {4.85, 3.96}; /* penumbrae of a pixel across */
static const struct factors orthographic_measured = {3.83, 1.94};

static void check_factors(const struct errors *e, struct factors measured)
{
    assert_true(0.9 * measured.plain * e->sheared < e->plain);
    assert_true(0.9 * measured.axis_aligned * e->sheared < e->axis_aligned);
}

/* At most 5 % worse than brute force, and no farther from it than that is from the truth: it is
 * less accurate, as it fits no lines and does not look along edges. */
static void check_brute(const struct shadow_truth *truth, struct factors measured)
{
    const struct errors e = measure(truth, 3, true);
    assert_true(e.sheared < 1.05 * e.brute);
    assert_true(e.difference < e.brute);
    check_factors(&e, measured);
}

TEST(gaussian_light)
{
    struct shadow_truth truth;
    furnish(PROFILE_GAUSSIAN, 1.0f);
    truth_init(&truth, &scene);
    check_brute(&truth, gaussian_measured);
    truth_fini(&truth);
}

TEST(uniform_light)
{
    static const uint32_t strata[] = {2, 3, 4, 8, 16};
    struct shadow_truth truth;
    double last = 1.0;
    furnish(PROFILE_UNIFORM, 1.0f);
    truth_init(&truth, &scene);
    for (size_t i = 0; i < sizeof strata / sizeof *strata; i++) {
        const struct errors e = measure(&truth, strata[i], false);
        if (strata[i] == 3) check_factors(&e, uniform_measured);
        assert_true(e.sheared < last);
        last = e.sheared;
    }
    truth_fini(&truth);
}

TEST(long_light)
{
    struct shadow_truth truth;
    furnish(PROFILE_UNIFORM, 0.25f);
    truth_init(&truth, &scene);
    check_brute(&truth, long_measured);
    truth_fini(&truth);
}

/* With every bit the same, and slopes all over, h is exactly 1, and exactly 0. */
TEST(constants_stay)
{
    furnish_part(96, 80, PROFILE_UNIFORM, 1.0f);
    for (uint32_t l = 1; l <= 16; l += l < 5 ? 1 : 11) {
        struct patch *patch = accuracy_patch(&scene, l);
        struct patch_light *light = &patch->lights[0];
        const size_t area = (size_t)rect_area(patch->rect), bytes = area * ((l * l + 7) / 8);
        for (size_t i = 0; i < area; i++) light->slope_min[i] = light->slope_max[i] = 0.0f;
        memset(light->visibility, 0xff, bytes);
        float *unoccluded = accuracy_filter(&scene, patch, SHADOW_FILTER_SHEARED, 64, NULL);
        for (size_t i = 0; i < area; i++) {
            light->slope_min[i] = 0.05f + 0.01f * (float)(i % 37);
            light->slope_max[i] = light->slope_min[i] + 0.02f * (float)(i % 11);
        }
        for (uint32_t filter = 1; filter <= 2; filter++) {
            struct shadow_statistics statistics = {0};
            memset(light->visibility, 0xff, bytes);
            float *seen = accuracy_filter(&scene, patch, filter, 64, &statistics);
            memset(light->visibility, 0, bytes);
            float *dark = accuracy_filter(&scene, patch, filter, 64, NULL);
            assert_true(statistics.pixels_filtered > area / 2);
            for (size_t i = 0; i < area; i++) {
                assert_true(seen[i] == unoccluded[i]);
                assert_true(dark[i] == 0.0f);
            }
            free(seen);
            free(dark);
        }
        free(unoccluded);
        patch_destroy(&patch);
    }
}

/* Blockers anywhere, so that walks are as long as they get and lead anywhere. */
static void scatter(struct random *r, struct patch *patch)
{
    const size_t area = (size_t)rect_area(patch->rect);
    const struct patch_light *light = &patch->lights[0];
    for (size_t i = 0; i < area; i++) {
        const float least = 0.02f + 0.3f * random_unit(r);
        for (size_t b = 0; b < 2; b++) light->visibility[b * area + i] = (uint8_t)random_bits(r);
        light->visibility[area + i] &= 1; /* nine strata */
        light->slope_min[i] = least;
        light->slope_max[i] = least + 0.02f * random_unit(r);
    }
}

/* What passes keep of a pixel is there for as long as others read it: more is kept of a small
 * block than it needs, of a large one no more than that. */
TEST(stripes_keep_what_is_read)
{
    struct random r = {9};
    furnish(PROFILE_UNIFORM, 1.0f);
    struct patch *patch = accuracy_patch(&scene, 3);
    scatter(&r, patch);
    float *whole = accuracy_filter(&scene, patch, SHADOW_FILTER_SHEARED, SIDE, NULL);
    float *blocks = accuracy_filter(&scene, patch, SHADOW_FILTER_SHEARED, 5, NULL);
    assert_memory_equal(whole, blocks, sizeof(float) * SIDE * SIDE);
    free(blocks);
    free(whole);
    patch_destroy(&patch);
}

/* Any cut into blocks, with no more around them than the halo, gives the same bytes. */
TEST(cuts_do_not_show)
{
    furnish(PROFILE_UNIFORM, 1.0f);
    const struct rect all = {0, 0, SIDE, SIDE};
    struct patch *patch = accuracy_patch(&scene, 3);
    for (uint32_t filter = 1; filter <= 2; filter++) {
        float *whole = accuracy_filter(&scene, patch, filter, SIDE, NULL);
        float *blocks = accuracy_filter(&scene, patch, filter, 23, NULL);
        assert_memory_equal(whole, blocks, sizeof(float) * SIDE * SIDE);
        for (int32_t y = 0; y < SIDE; y += 48) {
            for (int32_t x = 0; x < SIDE; x += 48) {
                struct shadow_statistics statistics = {0};
                const struct rect inner = rect_intersect((struct rect){x, y, x + 48, y + 48}, all);
                struct patch *small = scene_patch(
                    &scene, rect_intersect(rect_grow(inner, shadow_halo_px(filter)), all));
                float *e = calloc((size_t)rect_area(small->rect), sizeof *e);
                scene.plan.shadow_filter = filter;
                assert_int_equal(shadow_filter(&scene.plan, 0, small, inner, e, NULL, &statistics),
                                 0);
                for (int32_t v = inner.y0; v < inner.y1; v++) {
                    const size_t row =
                        (size_t)(v - small->rect.y0) * (size_t)rect_width(small->rect);
                    assert_memory_equal(e + row + (size_t)(inner.x0 - small->rect.x0),
                                        whole + (size_t)v * SIDE + (size_t)inner.x0,
                                        sizeof(float) * (size_t)rect_width(inner));
                }
                free(e);
                patch_destroy(&small);
            }
        }
        free(blocks);
        free(whole);
    }
    patch_destroy(&patch);
}

static void check_finite(const struct patch *patch)
{
    for (uint32_t filter = 1; filter <= 2; filter++) {
        float *e = accuracy_filter(&scene, patch, filter, 64, NULL);
        for (size_t i = 0; i < (size_t)rect_area(patch->rect); i++)
            assert_true(e[i] >= 0.0f && e[i] <= 3.1417f);
        free(e);
    }
}

/* Tiny, huge, edge-on, behind, straddling, touching: whatever a plan can hold. */
TEST(hard_lights)
{
    static const float places[][3] = {
        {0, 0, 8}, {0, 0, 1e-3f}, {0, 0, 0}, {0, 0, -1}, {0, -8, 0.2f}};
    static const float ways[][3] = {{0, 0, -1}, {0, 1, 0}, {0.1f, 0.1f, 1}, {1, 0, -1e-3f}};
    static const float halves[] = {1e-12f, 1e-3f, 1, 30, 1e12f};
    for (size_t i = 0; i < 5 * 4 * 5; i++) {
        scene_init(&scene, 40, 30, 1.0f, 3);
        scene_furnish(&scene);
        const float half = halves[i % 5], *way = ways[i / 5 % 4];
        const float aspect = i % 2 ? 1.0f : 1e-3f;
        scene.plan.lights[0] =
            scene_light(places[i / 20], way, (float[]){0.3f, 0.5f, 0.2f}, half, half * aspect);
        scene.plan.lights[0].profile = i % 3 == 0 ? PROFILE_GAUSSIAN : PROFILE_UNIFORM;
        struct patch *patch = accuracy_patch(&scene, 2 + (uint32_t)(i % 3));
        check_finite(patch);
        patch_destroy(&patch);
    }
}

TEST(hard_slopes)
{
    static const float slopes[] = {0, 6e-5f, 1e-3f, 1, 1e4f, 65504.0f};
    furnish_part(56, 48, PROFILE_UNIFORM, 1.0f); /* every pair of slopes, many times over */
    struct patch *patch = accuracy_patch(&scene, 3);
    for (size_t k = 0; k < 36; k++) {
        for (size_t i = 0; i < (size_t)rect_area(patch->rect); i++) {
            patch->lights[0].slope_min[i] = slopes[(k + i / 7) % 6];
            patch->lights[0].slope_max[i] = slopes[(k / 6 + i) % 6];
        }
        check_finite(patch);
    }
    for (int k = 0; k < 2; k++) {
        scene.plan.mu = k ? 1e6f : 1e-6f;
        check_finite(patch);
    }
    patch_destroy(&patch);
}

TEST(narrow_pictures)
{
    static const int32_t sides[][2] = {{1, 1}, {1, 90}, {90, 1}, {2, 3}};
    for (size_t i = 0; i < 4; i++) {
        scene_init(&scene, sides[i][0], sides[i][1], 1.0f, 3);
        scene_furnish(&scene);
        struct patch *patch = accuracy_patch(&scene, 3);
        check_finite(patch);
        patch_destroy(&patch);
    }
}

TEST(orthographic_camera)
{
    struct shadow_truth truth;
    furnish(PROFILE_UNIFORM, 1.0f);
    scene.plan.camera.type = CAMERA_ORTHOGRAPHIC;
    scene.plan.camera.half_width = scene.plan.camera.half_height = 5.0f;
    truth_init(&truth, &scene);
    const struct errors e = measure(&truth, 3, false);
    check_factors(&e, orthographic_measured);
    truth_fini(&truth);
}

/* Bad requests are refused; an empty scene skips its blocks; counters add up. */
TEST(counters)
{
    struct shadow_statistics statistics = {0};
    scene_init(&scene, 96, 96, 1.0f, 3);
    struct patch *patch = accuracy_patch(&scene, 3);
    free(accuracy_filter(&scene, patch, SHADOW_FILTER_SHEARED, 32, &statistics));
    assert_int_equal(statistics.blocks_skipped, 9);
    assert_int_equal(statistics.pixels_filtered, 0);
    assert_int_equal(statistics.pixels_alone + statistics.pixels_unlit, 96 * 96);
    float e[1];
    assert_int_equal(
        shadow_filter(&scene.plan, 1, patch, (struct rect){0, 0, 1, 1}, e, NULL, &statistics),
        ERR_RANGE);
    assert_int_equal(
        shadow_filter(&scene.plan, 0, patch, (struct rect){95, 0, 97, 1}, e, NULL, &statistics),
        ERR_RANGE);
    patch_destroy(&patch);
}
