/* Laws of the BSDFs that need no statistics: known values, what smooth surfaces do, and finite
 * numbers everywhere. tests/kernel/check_shade.c has the statistics. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "tests/random.h"
#include "tests/unit/unit.h"
#include "worker/shade/bsdf.h"
#include "worker/shade/coupling.h"
#include "worker/shade/direction.h"
#include "worker/shade/fresnel.h"
#include "worker/shade/ggx.h"

static const float half_u[2] = {0.5f, 0.5f};

static void assert_near(double got, double expected, double error)
{
    if (fabs(got - expected) > error) print_error("%.9g, not %.9g\n", got, expected);
    assert_true(fabs(got - expected) <= error);
}

static void direction(double theta_deg, double phi_deg, float out[3])
{
    const double t = theta_deg * M_PI / 180.0, p = phi_deg * M_PI / 180.0;
    out[0] = (float)(sin(t) * cos(p));
    out[1] = (float)(sin(t) * sin(p));
    out[2] = (float)cos(t);
}

static struct bsdf glass(float alpha, float ior)
{
    const float root = (ior - 1.0f) / (ior + 1.0f), f0 = root * root;
    return (struct bsdf){.model = BSDF_GLTF,
                         .alpha_u = alpha,
                         .alpha_v = alpha,
                         .base_color = {1.0f, 1.0f, 1.0f},
                         .transmission = 1.0f,
                         .specular = 1.0f,
                         .specular_f0 = {f0, f0, f0},
                         .ior = ior,
                         .inside = ior < 1.0f};
}

static struct bsdf paint(float alpha, float specular)
{
    return (struct bsdf){.model = BSDF_GLTF,
                         .albedo = {0.8f, 0.5f, 0.2f},
                         .alpha_u = alpha,
                         .alpha_v = alpha,
                         .base_color = {0.8f, 0.5f, 0.2f},
                         .specular = specular,
                         .specular_f0 = {0.04f, 0.04f, 0.04f},
                         .ior = 1.5f};
}

TEST(test_fresnel)
{
    float far;
    assert_near((double)fresnel_dielectric(1.0f, 1.5f, &far), 0.04, 1e-7);
    assert_near((double)far, 1.0, 1e-7);
    assert_near((double)fresnel_dielectric(0.0f, 1.5f, &far), 1.0, 1e-6);
    /* at Brewster's angle, tan = 1.5, half of what is polarised across: sin^2(i - t) / 2 */
    const double brewster = atan(1.5), difference = brewster - asin(sin(brewster) / 1.5);
    assert_near((double)fresnel_dielectric((float)cos(brewster), 1.5f, &far),
                0.5 * sin(difference) * sin(difference), 1e-6);
    /* total reflection from inside beyond asin(1 / 1.5) = 41.81 degrees, not before */
    assert_true(fresnel_dielectric((float)cos(42.0 * M_PI / 180.0), 1.0f / 1.5f, &far) == 1.0f);
    assert_true(far == 0.0f);
    assert_true(fresnel_dielectric((float)cos(41.5 * M_PI / 180.0), 1.0f / 1.5f, &far) < 0.9f);
    /* the same from both sides of the interface */
    const float inside = fresnel_dielectric(0.9f, 1.0f / 1.5f, &far);
    assert_near((double)fresnel_dielectric(far, 1.5f, &far), (double)inside, 1e-6);
    /* conductors: ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2) at normal incidence, 1 at grazing; without
     * absorption a dielectric */
    assert_near((double)fresnel_conductor(1.0f, 0.2f, 3.9f), 15.85 / 16.65, 1e-6);
    assert_near((double)fresnel_conductor(0.0f, 0.2f, 3.9f), 1.0, 1e-6);
    for (float c = 0.05f; c < 1.0f; c += 0.05f)
        assert_near((double)fresnel_conductor(c, 1.5f, 0.0f),
                    (double)fresnel_dielectric(c, 1.5f, &far), 2e-6);
}

TEST(test_pure_lambert)
{
    const struct bsdf g = paint(0.3f, 0.0f);
    struct bsdf l = {.model = BSDF_LAMBERT, .albedo = {0.8f, 0.5f, 0.2f}};
    for (int i = 0; i < 90; i += 7) {
        struct bsdf_value a, b;
        struct bsdf_sample s, t;
        float wo[3], wi[3];
        const float u[2] = {((float)i + 0.5f) / 90.0f, 0.3f};
        direction(i, 30, wo);
        direction(89 - i, 250, wi);
        bsdf_evaluate(&g, wo, wi, &a);
        bsdf_evaluate(&l, wo, wi, &b);
        assert_near((double)a.diffuse, 1.0 / M_PI, 1e-7);
        assert_memory_equal(&a, &b, sizeof a);
        assert_near((double)a.pdf, (double)wi[2] / M_PI, 1e-7);
        assert_true(bsdf_sample(&g, wo, 0.99f, u, &s) && bsdf_sample(&l, wo, 0.99f, u, &t));
        for (int k = 0; k < 3; k++) assert_true(s.wi[k] == t.wi[k] && s.specular[k] == 0.0f);
        assert_true(s.diffuse == t.diffuse && s.pdf == t.pdf && !s.dirac && !s.transmitted);
        wi[2] = -wi[2];
        bsdf_evaluate(&g, wo, wi, &a);
        assert_true(a.pdf == 0.0f && a.diffuse == 0.0f);
    }
}

TEST(test_mirror)
{
    const struct bsdf m = {.model = BSDF_MIRROR, .model_specular = {0.9f, 0.6f, 0.3f}};
    float wo[3];
    struct bsdf_sample s;
    direction(50, 20, wo);
    assert_true(bsdf_sample(&m, wo, 0.7f, half_u, &s));
    assert_true(s.dirac && !s.transmitted && s.pdf == 0.0f && s.diffuse == 0.0f);
    assert_true(s.wi[0] == -wo[0] && s.wi[1] == -wo[1] && s.wi[2] == wo[2]);
    for (int k = 0; k < 3; k++) assert_true(s.specular[k] == m.model_specular[k]);
    const struct bsdf black = {.model = BSDF_BLACK};
    assert_false(bsdf_sample(&black, wo, 0.7f, half_u, &s));
}

/* Choices over the unit interval: shares and directions of reflection and refraction. */
static void check_clear(const struct bsdf *b, const float wo[3], double reflected, double eta)
{
    enum { CHOICES = 4096 };
    int mirrored = 0;
    for (int i = 0; i < CHOICES; i++) {
        struct bsdf_sample s;
        assert_true(bsdf_sample(b, wo, ((float)i + 0.5f) / CHOICES, half_u, &s));
        assert_true(s.dirac);
        for (int k = 0; k < 3; k++) assert_near((double)s.specular[k], 1.0, 1e-5);
        mirrored += !s.transmitted;
        const double scale = s.transmitted ? -1.0 / eta : -1.0;
        for (int k = 0; k < 2; k++) assert_near((double)s.wi[k], scale * (double)wo[k], 1e-6);
        assert_true((s.wi[2] < 0.0f) == s.transmitted);
        assert_near(sqrt((double)direction_dot(s.wi, s.wi)), 1.0, 1e-6);
    }
    assert_near((double)mirrored / CHOICES, reflected, 1.0 / CHOICES);
}

TEST(test_clear_glass)
{
    float wo[3], far;
    const struct bsdf in = glass(0.0f, 1.5f), out = glass(0.0f, 1.0f / 1.5f);
    for (int deg = 0; deg < 90; deg += 10) {
        direction(deg, 70, wo);
        check_clear(&in, wo, (double)fresnel_dielectric(wo[2], 1.5f, &far), 1.5);
        check_clear(&out, wo, (double)fresnel_dielectric(wo[2], 1.0f / 1.5f, &far), 1.0 / 1.5);
    }
    /* a thin pane: Schlick, and straight on */
    struct bsdf pane = glass(0.0f, 1.5f);
    pane.thin = true;
    direction(60, 10, wo);
    check_clear(&pane, wo, 0.04 + 0.96 / 32.0, 1.0);
    /* an index of 1 is not there, however rough */
    const struct bsdf nothing = glass(0.5f, 1.0f);
    check_clear(&nothing, wo, 0.0, 1.0);
    /* colour tints what passes, by one factor a passage */
    struct bsdf green = glass(0.0f, 1.5f);
    green.base_color[0] = 0.25f;
    struct bsdf_sample s;
    assert_true(bsdf_sample(&green, wo, 0.999f, half_u, &s) && s.transmitted);
    assert_near((double)(s.specular[0] / s.specular[1]), 0.25, 1e-6);
}

TEST(test_index_zero_reflects_all)
{
    struct bsdf b = glass(0.0f, 0.0f);
    float wo[3];
    for (int k = 0; k < 3; k++) b.specular_f0[k] = 1.0f;
    direction(30, 0, wo);
    check_clear(&b, wo, 1.0, 1.0);
    b.ior = 1e6f; /* as good as */
    check_clear(&b, wo, 1.0, 1.0);
}

/* The metal of appendix B at one pair, by hand: wo = wi = normal. */
TEST(test_metal_by_hand)
{
    struct bsdf b = paint(0.5f, 1.0f);
    const float z[3] = {0.0f, 0.0f, 1.0f};
    struct bsdf_value v;
    b.metallic = 1.0f;
    for (int k = 0; k < 3; k++) b.albedo[k] = 0.0f;
    bsdf_evaluate(&b, z, z, &v);
    /* D = 1 / (pi alpha^2), G = 1, F = base colour */
    for (int k = 0; k < 3; k++)
        assert_near((double)v.specular[k], (double)b.base_color[k] / (M_PI * 0.25 * 4.0), 1e-6);
    assert_near((double)v.pdf, 1.0 / (M_PI * 0.25 * 4.0), 1e-6);
    /* and a dielectric: 0.04 D / 4 beside the diffuse lobe, near (1 - 0.04)^2 / (1 - mean) / pi */
    b = paint(0.5f, 1.0f);
    bsdf_evaluate(&b, z, z, &v);
    assert_near((double)v.specular[1], 0.04 / (M_PI * 0.25 * 4.0), 2e-5);
    assert_near((double)v.diffuse, 0.96 * 0.96 / (1.0 - 0.04 - 0.96 * 0.0134) / M_PI, 1e-3);
}

/* coupling.c against the mean over sampled facets. */
TEST(test_coupling)
{
    static const float alphas[] = {0.02f, 0.09f, 0.25f, 0.5f, 1.0f};
    struct random r = {3};
    for (int a = 0; a < 5; a++)
        for (int deg = 0; deg < 90; deg += 17) {
            const float alpha[2] = {alphas[a], alphas[a]};
            double sum = 0.0, weights = 0.0;
            float wo[3];
            direction(deg, 0, wo);
            for (int i = 0; i < 40000; i++) {
                const float u[2] = {random_unit(&r), random_unit(&r)};
                float h[3], wi[3];
                ggx_sample(wo, alpha, u, h);
                const float c = direction_dot(wo, h);
                direction_reflect(wo, h, c, wi);
                if (wi[2] < DIRECTION_GRAZING) continue;
                const float so = ggx_span(wo, alpha), si = ggx_span(wi, alpha);
                const float w = ggx_visibility(wo[2], so, wi[2], si) * wi[2] /
                                ggx_seen(wo[2], so); /* G2 / G1, to a constant */
                weights += (double)w;
                sum += (double)(w * fresnel_grazing(c));
            }
            assert_near((double)coupling_grazing(wo[2], alpha[0]), sum / weights, 0.012);
        }
    assert_near((double)coupling_grazing(0.3f, 0.0f), pow(0.7, 5.0), 2e-3);
    assert_near((double)coupling_average(0.0f), 1.0 / 21.0, 5e-4);
    assert_true(coupling_grazing(1.0f, 1.0f) > 0.0f && coupling_grazing(0.0f, 1.0f) < 0.06f);
}

static void check_finite(const struct bsdf *b, const float wo[3], struct random *r)
{
    struct bsdf_value v;
    struct bsdf_sample s;
    float wi[3];
    const float edge[4] = {0.0f, 0x1p-24f, 0.5f, 0x1.fffffep-1f};
    for (int i = 0; i < 96; i++) {
        float choice = random_unit(r), u[2] = {random_unit(r), random_unit(r)};
        if (i < 64) choice = edge[i & 3], u[0] = edge[i >> 2 & 3], u[1] = edge[i >> 4];
        if (bsdf_sample(b, wo, choice, u, &s)) {
            assert_near((double)direction_dot(s.wi, s.wi), 1.0, 1e-4);
            assert_true(isfinite(s.pdf) && isfinite(s.diffuse) && s.diffuse >= 0.0f);
            assert_true(s.dirac ? s.pdf == 0.0f : s.pdf > 0.0f);
            for (int k = 0; k < 3; k++)
                assert_true(isfinite(s.specular[k]) && s.specular[k] >= 0.0f);
        }
        direction(acos(2.0 * (double)random_unit(r) - 1.0) * 180.0 / M_PI,
                  360.0 * (double)random_unit(r), wi);
        if (i % 8 == 0) wi[2] = i % 16 ? 1e-6f : -1.1e-6f;
        bsdf_evaluate(b, wo, i % 3 ? wi : s.wi, &v);
        assert_true(isfinite(v.pdf) && v.pdf >= 0.0f && isfinite(v.diffuse) && v.diffuse >= 0.0f);
        for (int k = 0; k < 3; k++) assert_true(isfinite(v.specular[k]) && v.specular[k] >= 0.0f);
    }
}

static float pick(struct random *r, const float *values, uint32_t count)
{
    return values[random_bits(r) % count];
}

/* Returns the part of 1,000 even choices that are a smooth lobe's: a coat's or facets'. */
static double smooth_part(const struct bsdf *b)
{
    const float wo[3] = {0.0f, 0.0f, 1.0f}, u[2] = {0.3f, 0.6f};
    int smooth = 0;
    for (int i = 0; i < 1000; i++) {
        struct bsdf_sample s;
        smooth += bsdf_sample(b, wo, ((float)i + 0.5f) / 1000.0f, u, &s) && s.dirac;
    }
    return smooth / 1000.0;
}

/* White paint reflects .04, which the camera's paths look at half of the time. */
TEST(sharp_lobes_that_are_seen_are_sampled_often)
{
    const struct bsdf paint = {.model = BSDF_GLTF,
                               .albedo = {1.0f, 1.0f, 1.0f},
                               .base_color = {1.0f, 1.0f, 1.0f},
                               .specular = 1.0f,
                               .specular_f0 = {0.04f, 0.04f, 0.04f},
                               .ior = 1.5f};
    struct bsdf seen = paint, coated = paint;
    seen.seen = true;
    coated.alpha_u = coated.alpha_v = 0.5f;
    coated.coat = 1.0f;
    assert_true(fabs(smooth_part(&paint) - 0.04) < 0.002);
    assert_true(fabs(smooth_part(&seen) - 0.5) < 0.002);
    assert_true(smooth_part(&coated) < 0.05);
    coated.seen = true;
    assert_true(fabs(smooth_part(&coated) - 0.5) < 0.002);
    seen.specular = 0.0f;
    assert_true(smooth_part(&seen) == 0.0);
}

/* Returns the part of paths that clear glass reflects, and the mean of what it reflects. */
static double reflected_part(const struct bsdf *b, double *light)
{
    const float wo[3] = {0.6f, 0.0f, 0.8f}, u[2] = {0.5f, 0.5f};
    struct bsdf_sample s;
    int reflected = 0;
    *light = 0.0;
    for (int i = 0; i < 1000; i++) {
        if (!bsdf_sample(b, wo, ((float)i + 0.5f) / 1000.0f, u, &s) || s.transmitted) continue;
        reflected++;
        *light += (double)s.specular[1] / 1000.0;
    }
    return reflected / 1000.0;
}

TEST(both_turns_of_glass_that_is_seen_are_sampled)
{
    struct bsdf glass = {.model = BSDF_GLTF,
                         .base_color = {1.0f, 1.0f, 1.0f},
                         .transmission = 1.0f,
                         .specular = 1.0f,
                         .specular_f0 = {0.04f, 0.04f, 0.04f},
                         .ior = 1.5f};
    double plain, light;
    assert_true(reflected_part(&glass, &plain) < 0.06);
    glass.turn_least = 0.25f;
    assert_true(fabs(reflected_part(&glass, &light) - 0.25) < 0.002);
    assert_true(fabs(light - plain) < 0.002);
    glass.turn_least = 0.5f;
    assert_true(fabs(reflected_part(&glass, &light) - 0.5) < 0.002);
    assert_true(fabs(light - plain) < 0.002);
    glass.ior = 1.0f / 1.5f; /* from within, beyond the angle of total reflection */
    const float wo[3] = {0.8f, 0.0f, 0.6f}, u[2] = {0.5f, 0.5f};
    struct bsdf_sample s;
    assert_true(bsdf_sample(&glass, wo, 0.9f, u, &s) && !s.transmitted);
    assert_true(fabsf(s.specular[1] - 1.0f) < 1e-5f);
}

/* Every parameter at its extremes, every direction at the horizon and the pole. */
TEST(test_extremes)
{
    static const float shares[] = {0.0f, 1e-7f, 0.3f, 0.9999999f, 1.0f};
    static const float alphas[] = {0.0f, 0.99e-4f, 1e-4f, 1.01e-4f, 1e-3f, 0.1f, 0.5f, 1.0f};
    static const float exponents[] = {0.0f, 1e-3f, 1.0f, 77.0f, 1e5f};
    static const float iors[] = {0.0f,   1e-6f, 1.0f / 1.5f, 0.9989f, 0.9995f, 1.0f,
                                 1.002f, 1.33f, 1.5f,        2.4f,    1e6f};
    static const float etas[] = {0.0f, 1e-3f, 0.2f, 1.5f, 40.0f};
    static const double angles[] = {0.0, 1e-3, 30.0, 89.0, 89.99, 89.9999};
    struct random r = {11};
    for (int i = 0; i < 6000; i++) {
        struct bsdf b = {.model = (enum bsdf_model)(random_bits(&r) % BSDF_MODEL_COUNT)};
        if (i & 1) b.model = BSDF_GLTF;
        b.alpha_u = pick(&r, alphas, 8), b.alpha_v = pick(&r, alphas, 8);
        b.exponent_u = pick(&r, exponents, 5), b.exponent_v = pick(&r, exponents, 5);
        b.metallic = pick(&r, shares, 5), b.transmission = pick(&r, shares, 5);
        b.specular = pick(&r, shares, 5), b.ior = pick(&r, iors, 11);
        b.second_alpha = pick(&r, alphas, 8);
        b.grazing[0] = pick(&r, shares, 5), b.grazing[1] = pick(&r, shares, 5);
        for (int k = 0; k < 3; k++) b.second_specular[k] = pick(&r, shares, 5);
        b.turn_least = pick(&r, shares, 5) * 0.5f;
        b.seen = random_bits(&r) & 1, b.thin = random_bits(&r) & 1, b.inside = random_bits(&r) & 1;
        for (int k = 0; k < 3; k++) {
            b.albedo[k] = pick(&r, shares, 5), b.base_color[k] = pick(&r, shares, 5);
            b.specular_f0[k] = pick(&r, shares, 5), b.model_specular[k] = pick(&r, shares, 5);
            b.eta[k] = pick(&r, etas, 5), b.k[k] = pick(&r, etas, 5);
        }
        float wo[3];
        direction(angles[random_bits(&r) % 6], 360.0 * (double)random_unit(&r), wo);
        check_finite(&b, wo, &r);
    }
}
