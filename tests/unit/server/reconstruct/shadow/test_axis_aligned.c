/* The axis-aligned filter: error, refusal of sharper shadows, widths. */
#include "tests/unit/server/reconstruct/shadow/shadow_accuracy.h"
#include "tests/unit/unit.h"

#define SIDE 128

static struct shadow_scene scene;

TEST(error_falls)
{
    static const uint32_t strata[] = {2, 3, 4, 8};
    struct shadow_truth truth;
    scene_init(&scene, SIDE, SIDE, 1.0f, 3);
    scene_furnish(&scene);
    scene_camera(&scene.plan, (float[]){0, -11.5f, 9}, (float[]){-0.2f, -1.2f, 0.2f}, 0.2f);
    truth_init(&truth, &scene);
    double last = 1.0;
    for (size_t i = 0; i < 4; i++) {
        struct patch *patch = accuracy_patch(&scene, strata[i]);
        float *e = accuracy_filter(&scene, patch, SHADOW_FILTER_AXIS_ALIGNED, 64, NULL);
        const double error = truth_rmse(&truth, e, truth.irradiance);
        const double plain = truth_rmse(&truth, patch->lights[0].irradiance, truth.irradiance);
        print_message("%u spp: plain %.4f, axis-aligned %.4f\n", strata[i] * strata[i], plain,
                      error);
        assert_true(error < last && error < plain);
        if (strata[i] == 3) assert_true(2.2 * error < plain);
        last = error;
        free(e);
        patch_destroy(&patch);
    }
    truth_fini(&truth);
}

/* Left half: a far blocker covers half of every pixel's light; right half: a near one covers all.
 * The near one's shadow is sharp, and must not bleed into the far one's. */
TEST(sharp_shadows_stay_sharp)
{
    scene_init(&scene, 64, 64, 1.0f, 2);
    scene_camera(&scene.plan, (float[]){-1.2f, 0, 9}, (float[]){-1.2f, 0.6f, 0}, 0.2f);
    struct patch *patch = accuracy_patch(&scene, 2);
    for (size_t i = 0; i < 64 * 64; i++) {
        const bool near = i % 64 >= 32;
        patch->lights[0].visibility[i] = near ? 0 : 5; /* column 0 is seen */
        patch->lights[0].slope_min[i] = patch->lights[0].slope_max[i] = near ? 0.001f : 1.0f;
    }
    float width[64 * 64], e[64 * 64];
    struct shadow_statistics statistics = {0};
    scene.plan.shadow_filter = SHADOW_FILTER_AXIS_ALIGNED;
    assert_int_equal(shadow_filter(&scene.plan, 0, patch, patch->rect, e, width, &statistics), 0);
    assert_int_equal(statistics.pixels_filtered, 64 * 64);
    for (size_t i = 0; i < 64 * 64; i++) {
        if (i % 64 < 32)
            assert_true(e[i] > 0.02f && width[i] > 2.0f);
        else if (i % 64 > 33) /* widths are at least a third of a pixel: those look across */
            assert_true(e[i] == 0.0f && width[i] > 0.0f && width[i] < 1.0f);
    }
    patch_destroy(&patch);
}
