/* Clear coats against closed forms; check_shade has their statistics. */
#include <math.h>

#include "tests/random.h"
#include "tests/unit/worker/shade/inside_case.h"

static const struct bsdf metal = {.model = BSDF_GLTF,
                                  .base_color = {1, 1, 1},
                                  .metallic = 1,
                                  .specular = 1,
                                  .specular_f0 = {0.04f, 0.04f, 0.04f},
                                  .ior = 1.5f};

static double schlick(double cosine)
{
    return 0.04 + 0.96 * pow(1 - cosine, 5);
}

/* The mean weight of many samples. */
static double reflected(const struct bsdf *b, const float wo[3])
{
    struct random r = {3};
    double sum = 0;
    for (int i = 0; i < 20000; i++) {
        struct bsdf_sample s;
        const float u[2] = {random_unit(&r), random_unit(&r)};
        if (bsdf_sample(b, wo, random_unit(&r), u, &s))
            sum += (double)(b->albedo[0] * s.diffuse + s.specular[0]);
    }
    return sum / 20000;
}

/* Leans the coat so far that it mirrors the normal's direction below the surface. */
static void direction_set_off(struct bsdf *b)
{
    b->coat_normal[0] = 0.8f;
    b->coat_normal[2] = 0.6f;
}

TEST(smooth_coats_reflect_by_fresnel)
{
    for (int k = 1; k <= 10; k++) {
        const float z = 0.1f * (float)k, wo[3] = {sqrtf(1 - z * z), 0, z};
        struct bsdf black = {.model = BSDF_GLTF, .ior = 1.5f, .coat = 0.75f};
        assert_true(fabs(reflected(&black, wo) - 0.75 * schlick((double)z)) < 0.02);
        struct bsdf coated = metal;
        coated.coat = 1;
        assert_true(fabs(reflected(&coated, wo) - 1) < 0.02); /* a mirror loses nothing */
    }
}

TEST(diffuse_surfaces_keep_what_passes)
{
    const float wo[3] = {0.6f, 0, 0.8f};
    struct bsdf white = {.model = BSDF_GLTF, .albedo = {1, 1, 1}, .ior = 1.5f, .coat = 1};
    assert_true(fabs(reflected(&white, wo) - 1) < 0.01);
    white.albedo[0] = 0.5f;
    assert_true(fabs(reflected(&white, wo) - (0.5 + 0.5 * schlick(0.8))) < 0.01);
}

TEST(a_coat_of_factor_0_is_none)
{
    const float wo[3] = {0.6f, 0, 0.8f}, wi[3] = {-0.28f, 0.1f, 0.9547f};
    struct bsdf plain = metal, bare;
    struct bsdf_value a, b;
    plain.alpha_u = plain.alpha_v = 0.3f;
    bare = plain;
    bare.coat_alpha = 0.5f;
    bsdf_evaluate(&plain, wo, wi, &a);
    bsdf_evaluate(&bare, wo, wi, &b);
    assert_memory_equal(&a, &b, sizeof a);
}

TEST(a_coat_mirrors_about_its_own_normal)
{
    const float wo[3] = {0, 0, 1}, u[2] = {0.5f, 0.5f};
    struct bsdf b = {.model = BSDF_GLTF,
                     .ior = 1.5f,
                     .coat = 1,
                     .coat_bent = true,
                     .coat_normal = {0.6f, 0, 0.8f}};
    struct bsdf_sample s;
    assert_true(bsdf_sample(&b, wo, 0, u, &s) && s.dirac);
    assert_true(fabs((double)s.wi[0] - 0.96) < 1e-5 && fabs((double)s.wi[2] - 0.28) < 1e-5);
    direction_set_off(&b);
    assert_false(bsdf_sample(&b, wo, 0, u, &s)); /* it mirrors into the surface */
}

TEST(a_coat_with_the_surfaces_normal_is_not_bent)
{
    const float wo[3] = {0.6f, 0, 0.8f}, wi[3] = {-0.28f, 0.1f, 0.9547f};
    struct bsdf plain = metal, bent;
    struct bsdf_value a, b;
    plain.alpha_u = plain.alpha_v = 0.3f;
    plain.coat = 1, plain.coat_alpha = 0.2f;
    bent = plain;
    bent.coat_bent = true;
    bent.coat_normal[2] = 1;
    bsdf_evaluate(&plain, wo, wi, &a);
    bsdf_evaluate(&bent, wo, wi, &b);
    assert_true(fabsf(a.specular[0] - b.specular[0]) < 1e-5f * a.specular[0]);
    assert_true(fabsf(a.pdf - b.pdf) < 1e-5f * a.pdf);
}

TEST(volumes_have_no_coat_inside)
{
    struct bsdf coated = inside_glass;
    coated.coat = 1;
    expect_as_inside_glass(&coated);
}
