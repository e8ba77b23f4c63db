/* Sheens against the extension's description in double precision; check_shade has their statistics.
 */
#include <math.h>

#include "tests/unit/worker/shade/inside_case.h"
#include "worker/shade/sheen.h"

static void direction(double theta, double phi, float out[3])
{
    out[0] = (float)(sin(theta) * cos(phi));
    out[1] = (float)(sin(theta) * sin(phi));
    out[2] = (float)cos(theta);
}

/* Lambda, by the table of Estevez and Kulla's paper. */
static double curve(double x, double alpha)
{
    static const double rough[5] = {21.5473, 3.82987, 0.19823, -1.97760, -4.32054};
    static const double sharp[5] = {25.3245, 3.32435, 0.16801, -1.27393, -4.85967};
    double p[5];
    for (int i = 0; i < 5; i++) p[i] = rough[i] + (sharp[i] - rough[i]) * pow(1 - alpha, 2);
    return p[0] / (1 + p[1] * pow(x, p[2])) + p[3] * x + p[4];
}

static double lambda(double z, double alpha)
{
    return z < 0.5 ? exp(curve(z, alpha)) : exp(2 * curve(0.5, alpha) - curve(1 - z, alpha));
}

static double lobe(const float wo[3], const float wi[3], double alpha)
{
    double h[3], squared = 0;
    for (int k = 0; k < 3; k++) h[k] = (double)wo[k] + (double)wi[k], squared += h[k] * h[k];
    const double sine = sqrt((h[0] * h[0] + h[1] * h[1]) / squared);
    const double d = (2 + 1 / alpha) * pow(sine, 1 / alpha) / (2 * M_PI);
    const double z = (double)wo[2], y = (double)wi[2];
    return d / ((1 + lambda(z, alpha) + lambda(y, alpha)) * 4 * z * y);
}

/* The lobe's albedo, by a midpoint rule that is finest at the horizon. */
static double albedo(const float wo[3], double alpha)
{
    enum { N = 150 };
    double sum = 0;
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) {
            const double t = (i + 0.5) / N, z = t * t * t, phi = 2 * M_PI * (j + 0.5) / N;
            float wi[3];
            direction(acos(z), phi, wi);
            sum += lobe(wo, wi, alpha) * z * 3 * t * t / N * 2 * M_PI / N;
        }
    return sum;
}

TEST(the_table_is_the_lobes_albedo)
{
    double mean = 0;
    int count = 0;
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 8; j++) {
            const double root = 0.13 + 0.15 * i, z = pow(0.05 + 0.125 * j, 2);
            float wo[3];
            direction(acos(z), 0, wo);
            const double expected = fmin(albedo(wo, root * root), 0.999);
            const double off =
                fabs((double)sheen_albedo((float)z, (float)(root * root)) - expected);
            if (off > 0.016) fail_msg("alpha %g, cosine %g: %g off", root * root, z, off);
            mean += off, count++;
        }
    assert_true(mean / count < 0.003);
}

/* On black the lobe is all there is; beside another surface it takes its own albedo away. */
TEST(sheens_are_as_the_extension_says)
{
    for (int i = 0; i < 60; i++) {
        const double alpha = 0.1 + 0.9 * ((i * 7) % 10) / 10.0;
        struct bsdf b = {.model = BSDF_GLTF,
                         .alpha_u = 0.3f,
                         .alpha_v = 0.3f,
                         .ior = 1.5f,
                         .sheen = {0.9f, 0.5f, 0.1f},
                         .sheen_alpha = (float)alpha};
        struct bsdf_value black, white, bare;
        float wo[3], wi[3];
        direction(0.02 + 1.4 * (i % 10) / 10, 0.3, wo);
        direction(0.05 + 1.4 * ((i / 10) % 10) / 10, 0.2 * i, wi);
        bsdf_evaluate(&b, wo, wi, &black);
        const double expected = lobe(wo, wi, alpha);
        const double e = fmax(albedo(wo, alpha), albedo(wi, alpha));
        assert_true(e < 1); /* where it is not, we divide by it */
        for (int c = 0; c < 3; c++)
            assert_true(fabs((double)black.specular[c] - (double)b.sheen[c] * expected) <=
                        2e-4 * expected + 1e-7);
        b.albedo[0] = b.albedo[1] = b.albedo[2] = 1;
        b.specular = 1, b.specular_f0[0] = b.specular_f0[1] = b.specular_f0[2] = 0.04f;
        bsdf_evaluate(&b, wo, wi, &white);
        b.sheen[0] = b.sheen[1] = b.sheen[2] = 0;
        bsdf_evaluate(&b, wo, wi, &bare);
        const double scale = 1 - (double)0.9f * e;
        assert_true(fabs((double)white.diffuse - scale * (double)bare.diffuse) < 0.006);
        assert_true(fabs((double)(white.specular[1] - black.specular[1]) -
                         scale * (double)bare.specular[1]) <
                    0.02 * (double)bare.specular[1] + 1e-6);
    }
}

TEST(volumes_have_no_sheen_inside)
{
    struct bsdf furry = inside_glass;
    furry.sheen[0] = furry.sheen[1] = furry.sheen[2] = 1;
    furry.sheen_alpha = 0.5f;
    expect_as_inside_glass(&furry);
}

TEST(numbers_are_finite_everywhere)
{
    static const float zs[] = {1, 0.9999999f, 0.5f, 1e-3f, 2e-6f}, alphas[] = {0, 1e-6f, 0.5f, 1};
    for (int i = 0; i < 100; i++) {
        const float z = zs[i % 5], y = zs[i / 5 % 5], alpha = alphas[i / 25];
        const float wo[3] = {sqrtf(1 - z * z), 0, z}, wi[3] = {-sqrtf(1 - y * y), 0, y};
        const struct bsdf b = {
            .model = BSDF_GLTF, .ior = 1.5f, .sheen = {1, 1, 1}, .sheen_alpha = alpha};
        struct bsdf_value v;
        bsdf_evaluate(&b, wo, wi, &v);
        assert_true(isfinite(v.specular[0]) && v.specular[0] >= 0 && isfinite(v.pdf));
    }
}
