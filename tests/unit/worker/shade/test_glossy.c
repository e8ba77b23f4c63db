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
                    if (!glossy_sample_ggx(&b, wo, u, wi, weight)) continue;
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
                    if (!glossy_sample_ggx(&b, wo, u, wi, weight)) continue;
                    for (int c = 0; c < 3; c++) sum[c] += (double)weight[c] / (SIDE * SIDE);
                }
                glossy_reflectance(&b, wo, reflectance);
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
    assert_true(glossy_has(&b));
    b.alpha_v = 0.0099f;
    assert_false(glossy_has(&b));
    b = surface(0.2f, 0.0f);
    b.transmission = 0.1f;
    assert_false(glossy_has(&b));
    b = surface(0.2f, 0.0f);
    b.specular = 0.0f;
    assert_false(glossy_has(&b));
    b.metallic = 0.1f;
    assert_true(glossy_has(&b));
    b.exponent_u = b.exponent_v = 1000.0f;
    b.second_alpha = 0.3f;
    for (int model = 0; model < BSDF_MODEL_COUNT; model++) {
        const bool facets = model == BSDF_BLINN_PHONG || model == BSDF_BECKMANN ||
                            model == BSDF_WARD || model == BSDF_KELEMEN ||
                            model == BSDF_ASHIKHMIN_SHIRLEY || model == BSDF_MEASURED;
        b.model = (enum bsdf_model)model;
        assert_int_equal(glossy_has(&b), facets || model == BSDF_GLTF);
    }
    b.model = BSDF_ASHIKHMIN_SHIRLEY;
    b.exponent_v = 1e5f;
    assert_false(glossy_has(&b));
}

/* Surfaces whose lobe knows no table of its own. */
static struct bsdf other(enum bsdf_model model, float along, float across)
{
    struct bsdf b = surface(along, 1.0f);
    b.model = model;
    b.alpha_v = across;
    b.exponent_u = 2 / (along * along) - 2, b.exponent_v = 2 / (across * across) - 2;
    b.model_specular[0] = 0.8f, b.model_specular[1] = 0.5f, b.model_specular[2] = 0.04f;
    b.second_specular[0] = 0.1f, b.second_alpha = 0.5f;
    b.grazing[0] = 0.7f, b.grazing[1] = 0.3f;
    if (model == BSDF_BECKMANN && along == across)
        b.eta[0] = 0.2f, b.eta[1] = 0.92f, b.eta[2] = 1.1f, b.k[0] = 3.9f, b.k[1] = 2.45f,
        b.k[2] = 2.14f;
    return b;
}

/* Those that are alike along and across. */
static bool is_round(enum bsdf_model model)
{
    return model == BSDF_KELEMEN || model == BSDF_MEASURED || model == BSDF_BLINN_PHONG;
}

static const enum bsdf_model models[] = {BSDF_GLTF,       BSDF_BECKMANN,          BSDF_WARD,
                                         BSDF_KELEMEN,    BSDF_ASHIKHMIN_SHIRLEY, BSDF_MEASURED,
                                         BSDF_BLINN_PHONG};

/* The lobe alone: what the BSDF's other lobe is makes no difference to its samples. */
TEST(others_are_sampled_alone)
{
    for (int m = 0; m < 7; m++)
        for (int k = 0; k < 64; k++) {
            struct bsdf b = other(models[m], 0.3f, 0.1f);
            const float u[2] = {((float)(k % 8) + 0.5f) / 8, ((float)k / 8 + 0.5f) / 9};
            float wo[3], wi[3], weight[3], bare[3];
            struct bsdf_value value;
            looking(0.5f, wo);
            if (!glossy_sample(&b, wo, u, wi, weight)) continue;
            bsdf_evaluate(&b, wo, wi, &value);
            for (int c = 0; c < 3; c++)
                assert_true(fabsf(weight[c] * value.pdf - value.specular[c] * wi[2]) <=
                            1e-5f * value.specular[c]);
            b.albedo[0] = b.albedo[1] = 0.5f;
            assert_true(glossy_sample(&b, wo, u, wi, bare));
            if (models[m] == BSDF_GLTF) continue; /* of metal: none under it */
            for (int c = 0; c < 3; c++) assert_true(bare[c] == weight[c]);
        }
}

TEST(reflectance_of_others_is_the_mean_weight)
{
    enum { SIDE = 128 };
    static const float widths[] = {0.05f, 0.23f, 0.8f};
    for (int m = 0; m < 7; m++)
        for (int w = 0; w < 9; w++)
            for (int k = 0; k < 8; k++) {
                const bool round = is_round(models[m]);
                const struct bsdf b =
                    other(models[m], widths[w % 3], widths[round ? w % 3 : w / 3]);
                const float cosine = cosines[1 + k % 4], turn = 0.3f + 0.9f * (float)(k / 4);
                const float sine = sqrtf(1.0f - cosine * cosine);
                const float wo[3] = {sine * cosf(turn), sine * sinf(turn), cosine};
                double sum[3] = {0};
                float wi[3], weight[3], reflectance[3];
                for (int i = 0; i < SIDE * SIDE; i++) {
                    const float u[2] = {((float)(i % SIDE) + 0.5f) / SIDE,
                                        ((float)(i / SIDE) + 0.5f) / SIDE};
                    if (!glossy_sample(&b, wo, u, wi, weight)) continue;
                    for (int c = 0; c < 3; c++) sum[c] += (double)weight[c] / (SIDE * SIDE);
                }
                glossy_reflectance(&b, wo, reflectance);
                for (int c = 0; c < 3; c++)
                    if (fabs((double)reflectance[c] - sum[c]) >
                        (models[m] == BSDF_BLINN_PHONG ? 0.06 : 0.03) * sum[c] + 1e-3)
                        fail_msg("model %d, widths %g %g, cosine %g: %g instead of %g",
                                 (int)models[m], (double)widths[w % 3], (double)widths[w / 3],
                                 (double)cosine, (double)reflectance[c], sum[c]);
            }
}

/* GGX facets of the alphas that filters are told fall off near the normal as the model's do. */
TEST(alphas_are_as_sharp)
{
    for (int m = 0; m < 7; m++) {
        const struct bsdf b = other(models[m], 0.1f, is_round(models[m]) ? 0.1f : 0.05f);
        float alpha[2];
        glossy_alphas(&b, alpha);
        for (int axis = 0; axis < 2; axis++) {
            /* seen from above, f of a half vector is D / 4 and things that hardly change */
            const float wo[3] = {0, 0, 1}, x = 0.4f * alpha[axis];
            float h[3] = {0, 0, 0}, wi[3];
            struct bsdf_value top, side;
            h[axis] = sinf(x), h[2] = cosf(x);
            for (int k = 0; k < 3; k++) wi[k] = 2 * h[2] * h[k] - wo[k];
            bsdf_evaluate(&b, wo, wo, &top);
            bsdf_evaluate(&b, wo, wi, &side);
            const double fall = (double)(side.specular[0] / top.specular[0]);
            if (fabs(fall - exp(-1.13 * 0.16)) >
                (models[m] == BSDF_GLTF || models[m] == BSDF_MEASURED ? 0.1 : 0.02))
                fail_msg("model %d, axis %d: falls to %g", (int)models[m], axis, fall);
        }
    }
}

/* Nothing comes of looking along the surface. */
TEST(grazing_looks_see_nothing)
{
    const struct bsdf b = surface(0.2f, 1.0f);
    const float wo[3] = {1, 0, 0}, u[2] = {0.5f, 0.5f};
    float wi[3], weight[3];
    assert_false(glossy_sample_ggx(&b, wo, u, wi, weight));
    assert_false(glossy_sample(&b, wo, u, wi, weight));
}
