/* The glossy lobe against the whole BSDF and against its integral. */
#include <math.h>

#include "proto/plan.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/trace/field/glossy_fixture.h"

static struct bsdf surface(float alpha, float metallic)
{
    return (struct bsdf){.model = BSDF_GLTF,
                         .albedo = {0.8f * (1 - metallic), 0.5f * (1 - metallic), 0},
                         .alpha_u = alpha,
                         .alpha_v = alpha,
                         .base_color = {0.8f, 0.5f, 0.0f},
                         .metallic = metallic,
                         .specular = 0.9f,
                         .specular_f0 = {0.04f, 0.3f, 0.1f},
                         .ior = 1.5f};
}

static void looking(float cosine, float wo[3])
{
    wo[0] = sqrtf(1.0f - cosine * cosine);
    wo[1] = 0.0f;
    wo[2] = cosine;
}

static const float alphas[] = {0.01f, 0.04f, 0.16f, 0.49f, 1.0f};
static const float cosines[] = {0.05f, 0.2f, 0.5f, 0.8f, 0.999f};
static const float metals[] = {0.0f, 0.4f, 1.0f};

/* f |cos| / pdf of the lobe: where it is the only one, the BSDF's own weight; elsewhere in its
 * proportions. */
TEST(weights_are_the_bsdfs)
{
    for (int a = 0; a < 5; a++)
        for (int z = 0; z < 5; z++)
            for (int m = 0; m < 3; m++)
                for (int k = 0; k < 64; k++) {
                    const struct bsdf b = surface(alphas[a], metals[m]);
                    const float u[2] = {((float)(k % 8) + 0.5f) / 8, ((float)k / 8 + 0.5f) / 9};
                    float wo[3], wi[3], weight[3];
                    struct bsdf_value value;
                    looking(cosines[z], wo);
                    if (!glossy_sample(&b, wo, u, wi, weight)) continue;
                    bsdf_evaluate(&b, wo, wi, &value);
                    for (int c = 0; c < 3; c++) {
                        const float ratio =
                            value.specular[c] * weight[0] - value.specular[0] * weight[c];
                        assert_true(fabsf(ratio) <= 1e-4f * value.specular[0] * weight[c] + 1e-9f);
                        if (metals[m] < 1.0f) continue;
                        const float whole = value.specular[c] * wi[2] / value.pdf;
                        assert_true(fabsf(weight[c] - whole) <= 2e-3f * whole + 1e-6f);
                    }
                }
}

TEST(reflectance_is_the_mean_weight)
{
    enum { SIDE = 256 };
    for (int a = 0; a < 5; a++)
        for (int z = 0; z < 5; z++)
            for (int m = 0; m < 3; m++) {
                const struct bsdf b = surface(alphas[a], metals[m]);
                double sum[3] = {0};
                float wo[3], wi[3], weight[3], reflectance[3];
                looking(cosines[z], wo);
                for (int k = 0; k < SIDE * SIDE; k++) {
                    const float u[2] = {((float)(k % SIDE) + 0.5f) / SIDE,
                                        ((float)(k / SIDE) + 0.5f) / SIDE};
                    if (!glossy_sample(&b, wo, u, wi, weight)) continue;
                    for (int c = 0; c < 3; c++) sum[c] += (double)weight[c] / (SIDE * SIDE);
                }
                glossy_reflectance(&b, cosines[z], reflectance);
                for (int c = 0; c < 3; c++)
                    if (fabs((double)reflectance[c] - sum[c]) >
                        (z == 0 ? 0.035 : 0.012) * sum[c] + 1e-3)
                        fail_msg("alpha %g, cosine %g, metal %g: %g instead of %g",
                                 (double)alphas[a], (double)cosines[z], (double)metals[m],
                                 (double)reflectance[c], sum[c]);
            }
}

TEST(who_has_one)
{
    struct bsdf b = surface(GLOSSY_ALPHA_MIN, 0.0f);
    assert_true(glossy_has(&b));
    b.alpha_u = b.alpha_v = 0.0099f;
    assert_false(glossy_has(&b));
    b = surface(0.2f, 0.0f);
    b.alpha_v = 0.3f;
    assert_false(glossy_has(&b));
    b = surface(0.2f, 0.0f);
    b.transmission = 0.1f;
    assert_false(glossy_has(&b));
    b = surface(0.2f, 0.0f);
    b.specular = 0.0f;
    assert_false(glossy_has(&b));
    b.metallic = 0.1f;
    assert_true(glossy_has(&b));
    for (int model = 0; model < BSDF_MODEL_COUNT; model++) {
        b.model = (enum bsdf_model)model;
        assert_int_equal(glossy_has(&b), model == BSDF_GLTF);
    }
}

/* Nothing comes of looking along the surface. */
TEST(grazing_looks_see_nothing)
{
    const struct bsdf b = surface(0.2f, 1.0f);
    const float wo[3] = {1, 0, 0}, u[2] = {0.5f, 0.5f};
    float wi[3], weight[3];
    assert_false(glossy_sample(&b, wo, u, wi, weight));
}
