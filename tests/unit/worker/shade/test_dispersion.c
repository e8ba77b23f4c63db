/* Dispersed glass is, over the choice of a colour, glass of each colour's own index. */
#include <math.h>

#include "tests/random.h"
#include "tests/unit/unit.h"
#include "worker/shade/bsdf.h"
#include "worker/shade/direction.h"

static const float iors[3] = {1.4f, 1.5f, 1.6f};

/* f0 is that of each index, so that Fresnel's equations hold as they are. */
static struct bsdf glass(float ior, bool inside)
{
    struct bsdf b = {.model = BSDF_GLTF,
                     .alpha_u = 0.3f,
                     .alpha_v = 0.3f,
                     .base_color = {0.9f, 0.8f, 0.7f},
                     .transmission = 1,
                     .specular = 1,
                     .ior = inside ? 1 / ior : ior,
                     .inside = inside};
    for (int k = 0; k < 3; k++) b.specular_f0[k] = 0.04f;
    return b;
}

static struct bsdf prism(int color, bool inside)
{
    struct bsdf b = glass(iors[1], inside);
    b.dispersed = true;
    for (int k = 0; k < 3; k++) b.iors[k] = inside ? 1 / iors[k] : iors[k];
    bsdf_choose_color(&b, color, 3);
    return b;
}

static void random_pair(struct random *r, bool through, float wo[3], float wi[3])
{
    direction_normalize(random_unit(r) - 0.5f, random_unit(r) - 0.5f, 0.2f + random_unit(r), wo);
    direction_normalize(random_unit(r) - 0.5f, random_unit(r) - 0.5f, 0.2f + random_unit(r), wi);
    if (through) wi[2] = -wi[2];
}

TEST(colours_chosen_by_chance_are_glass_of_their_own_index)
{
    struct random r = {5};
    int lit = 0;
    for (int i = 0; i < 400; i++) {
        const bool inside = i % 2, through = i / 2 % 2;
        float wo[3], wi[3], mean[3] = {0};
        random_pair(&r, through, wo, wi);
        for (int color = 0; color < 3; color++) {
            const struct bsdf b = prism(color, inside);
            struct bsdf_value v;
            bsdf_evaluate(&b, wo, wi, &v);
            for (int k = 0; k < 3; k++) mean[k] += v.specular[k] / 3;
        }
        for (int k = 0; k < 3; k++) {
            const struct bsdf own = glass(iors[k], inside);
            struct bsdf_value v;
            bsdf_evaluate(&own, wo, wi, &v);
            if (fabsf(mean[k] - v.specular[k]) > 1e-5f + 1e-4f * v.specular[k])
                fail_msg("colour %d: %g is not %g", k, (double)mean[k], (double)v.specular[k]);
            lit += v.specular[k] > 0.01f;
        }
    }
    assert_true(lit > 300);
}

TEST(a_path_of_one_colour_keeps_its_weight)
{
    const float wo[3] = {0.6f, 0, 0.8f}, u[2] = {0.5f, 0.5f};
    struct bsdf b = prism(2, false);
    struct bsdf_sample s, once;
    b.alpha_u = b.alpha_v = 0;
    assert_true(bsdf_sample(&b, wo, 0.9f, u, &s) && s.dirac && s.transmitted);
    bsdf_choose_color(&b, 2, 1);
    assert_true(bsdf_sample(&b, wo, 0.9f, u, &once) && once.transmitted);
    assert_true(s.specular[0] == 0 && s.specular[1] == 0 && s.specular[2] > 0);
    assert_true(fabsf(s.specular[2] - 3 * once.specular[2]) < 1e-6f);
    assert_true(fabsf(s.wi[0] + 0.6f / 1.6f) < 1e-5f); /* Snell's law for blue */
}
