/* Slope ranges, their fill, and the widths and shears that follow from them. */
#include "tests/unit/server/reconstruct/shadow/shadow_accuracy.h"
#include "tests/unit/unit.h"

#define SIDE   40
#define CENTRE (20 * SIDE + 20)

static struct shadow_scene scene;
static struct receiver_light light;
static struct receivers receivers;
static struct patch *patch;

/* A floor without occluders, slopes at its middle pixel only. */
static void start(float least, float most)
{
    scene_init(&scene, SIDE, SIDE, 1.0f, 3);
    /* from above, near enough for neighbours of six pixels to be compatible */
    scene_camera(&scene.plan, (float[]){0, -4, 9}, (float[]){0, 0, 0}, 0.2f);
    patch = accuracy_patch(&scene, 3);
    patch->lights[0].slope_min[CENTRE] = least;
    patch->lights[0].slope_max[CENTRE] = most;
    receiver_light_init(&light, &scene.plan, 0);
    assert_int_equal(
        receivers_create(&light, patch, KERNELS_BEST(shadow_kernels), patch->rect, &receivers), 0);
}

static void finish(void)
{
    receivers_fini(&receivers);
    patch_destroy(&patch);
}

TEST(fills_six_pixels)
{
    struct wedges wedges;
    start(0.5f, 2.0f);
    assert_int_equal(
        wedges_create(&light, patch, &receivers, KERNELS_BEST(shadow_kernels), &wedges), 0);
    for (int y = 2; y < SIDE - 2; y++) {
        for (int x = 2; x < SIDE - 2; x++) {
            const size_t i = (size_t)(y * SIDE + x);
            const bool near = abs(x - 20) <= 6 && abs(y - 20) <= 6;
            assert_true(near ? fabsf(wedges.most[i] - 2.0f) < 1e-5f &&
                                   fabsf(wedges.least[i] - 0.5f) < 1e-6f
                             : wedges.most[i] == -1.0f && wedges.least[i] == -1.0f);
        }
    }
    wedges_fini(&wedges);
    finish();
}

/* The middle pixel, sheared. */
struct middle {
    float eta, spread, pixel, width_px;
    float falloff[2], step[2][2];
    int32_t reach[2];
};

static struct middle middle_of(const struct shadow_pixels *p)
{
    struct middle m = {.eta = p->eta[CENTRE],
                       .spread = p->spread[CENTRE],
                       .pixel = receiver_pixel(p, CENTRE),
                       .width_px = p->width_px[CENTRE]};
    for (int axis = 0; axis < 2; axis++) {
        m.falloff[axis] = p->walk[axis].falloff[CENTRE];
        m.reach[axis] = p->walk[axis].reach[CENTRE];
        for (int k = 0; k < 2; k++) m.step[axis][k] = p->walk[axis].step[k][CENTRE];
    }
    return m;
}

static struct middle shear(float least, float most, float mu)
{
    struct wedges wedges;
    struct coverage coverage;
    start(least, most);
    scene.plan.mu = mu;
    assert_int_equal(
        wedges_create(&light, patch, &receivers, KERNELS_BEST(shadow_kernels), &wedges), 0);
    assert_int_equal(coverage_create(3, PROFILE_UNIFORM, mu, &coverage), 0);
    assert_int_equal(
        wedges_shear(&light, &wedges, KERNELS_BEST(shadow_kernels), &coverage, &receivers), 0);
    const struct middle m = middle_of(&receivers.pixels);
    coverage_fini(&coverage);
    wedges_fini(&wedges);
    finish();
    return m;
}

TEST(widths_and_shears)
{
    /* kappa in [20, 100]: sigma_y / 80, which is narrower than sigma_y / 60 */
    struct middle m = shear(0.01f, 0.05f, 1.0f);
    const float top = 1.0f / (0.25f * m.pixel);
    assert_true(top > 36.0f && top < 100.0f); /* the floor: kappa at most 4 L / pixel */
    assert_true(fabsf(m.eta - 0.5f * (top + 20.0f)) < 1e-3f);
    assert_true(fabsf(m.spread - 0.5f * (top - 20.0f)) < 1e-3f);
    const float wide = fmaxf(top - 20.0f, m.eta);
    assert_true(fabsf(sqrtf(0.5f / m.falloff[0]) - 0.577350f / wide) < 1e-5f);
    /* equal slopes: the penumbra's own width */
    m = shear(0.1f, 0.1f, 1.0f);
    assert_true(fabsf(m.eta - 10.0f) < 1e-2f && m.spread < 1e-2f);
    assert_true(fabsf(sqrtf(0.5f / m.falloff[1]) - 0.0577350f) < 1e-4f);
    /* far occluders: the cap in pixels, and mu */
    const float most = shear(10.0f, 10.0f, 1.0f).width_px;
    m = shear(10.0f, 10.0f, 0.5f);
    assert_true(most > 2.0f && most < 16.0f);
    assert_true(fabsf(m.width_px - 0.5f * most) < 1e-4f);
    const float both = sqrtf(sqrtf(0.5f / m.falloff[0])) * sqrtf(sqrtf(0.5f / m.falloff[1]));
    assert_true(fabsf(m.width_px * m.pixel / both - 1.0f) < 1e-6f); /* the geometric mean */
    assert_true(m.reach[0] <= SHADOW_REACH_PX);
    for (int k = 0; k < 2; k++)
        assert_true(fmaxf(fabsf(m.step[k][0]), fabsf(m.step[k][1])) == 1.0f);
}

TEST(coverage_is_even)
{
    struct coverage coverage;
    for (uint32_t l = 1; l <= 16; l++) {
        assert_int_equal(coverage_create(l, PROFILE_GAUSSIAN, 0.6f, &coverage), 0);
        const int32_t row = coverage_row(1.0f / coverage.rho_max, 0.3f, 0.2f);
        coverage_need(&coverage, row);
        coverage_need(&coverage, row);
        const float *w = coverage.weights + (size_t)row * (SHADOW_PHASES + 1) * coverage.window;
        const uint32_t r = coverage.scale;
        for (uint32_t p = 0; p <= SHADOW_PHASES; p++) {
            for (uint32_t k = 0; k < r; k++)
                assert_true(w[p * coverage.window + k] ==
                            w[(SHADOW_PHASES - p) * coverage.window + r - 1 - k]);
        }
        coverage_fini(&coverage);
    }
}
