/* Films against Airy's formula, averaged over the wave numbers that an eye sees. */
#include <math.h>

#include "tests/unit/unit.h"
#include "worker/shade/film.h"

static double schlick(double f0, double cosine)
{
    return f0 + (1 - f0) * pow(1 - cosine, 5);
}

static double f0_of(double from, double to)
{
    return pow((to - from) / (to + from), 2);
}

/* Airy's reflectance of a film of an index between air and a base, for a phase difference. */
static double airy(double outer, double inner, bool denser, double phase)
{
    const double both = (denser ? 2 : -2) * sqrt(outer * inner) * cos(phase);
    return (outer + inner + both) / (1 + outer * inner + both);
}

/* A mean over a Gaussian of wave numbers whose variance is twice the named one: the response that
 * Belcour and Barla's closed form has. */
static double mean(double outer, double inner, bool denser, double path_m, double at,
                   double variance)
{
    enum { N = 2000 };
    double sum = 0, weights = 0;
    for (int i = 0; i < N; i++) {
        const double z = ((i + 0.5) / N * 2 - 1) * 5, w = exp(-0.5 * z * z);
        sum += w * airy(outer, inner, denser, 2 * M_PI * path_m * (at + sqrt(2 * variance) * z));
        weights += w;
    }
    return sum / weights;
}

static void expected(double ior, double nm, double f0, double cosine, double out[3])
{
    static const double rec709[3][3] = {{3.2404542, -1.5371385, -0.4985314},
                                        {-0.9692660, 1.8760108, 0.0415560},
                                        {0.0556434, -0.2040259, 1.0572252}};
    const double within = sqrt(1 - (1 - cosine * cosine) / (ior * ior));
    const double base = (1 + sqrt(f0)) / (1 - sqrt(f0)), path_m = 2 * ior * nm * 1e-9 * within;
    const double outer = schlick(f0_of(1, ior), cosine), inner = schlick(f0_of(ior, base), within);
    const bool denser = base >= ior;
    const double xyz[3] = {0.846590 * mean(outer, inner, denser, path_m, 1.6810e6, 4.3278e9) +
                               0.153868 * mean(outer, inner, denser, path_m, 2.2399e6, 4.5282e9),
                           1.000222 * mean(outer, inner, denser, path_m, 1.7953e6, 9.3046e9),
                           1.001122 * mean(outer, inner, denser, path_m, 2.2084e6, 6.6121e9)};
    for (int k = 0; k < 3; k++) {
        /* The mean of all orders has no colour; our sum adds it as it is. */
        const double grey = outer + pow(1 - outer, 2) * inner / (1 - outer * inner);
        out[k] = grey;
        for (int j = 0; j < 3; j++)
            out[k] += rec709[k][j] * (xyz[j] - grey * (j == 0   ? 1.000458
                                                       : j == 1 ? 1.000222
                                                                : 1.001122));
        out[k] = fmin(fmax(out[k], 0), 1);
    }
}

TEST(films_are_airys)
{
    static const double iors[] = {1.3, 1.8, 2.4}, nms[] = {100, 250, 400, 1000},
                        f0s[] = {0.02, 0.04, 0.17}, cosines[] = {1, 0.7, 0.3};
    for (int i = 0; i < 108; i++) {
        const double ior = iors[i % 3], nm = nms[i / 3 % 4], f0 = f0s[i / 12 % 3],
                     cosine = cosines[i / 36];
        const struct bsdf b = {.film = 1, .film_ior = (float)ior, .film_nm = (float)nm};
        const float base[3] = {(float)f0, (float)f0, (float)f0};
        float got[3];
        double want[3];
        film_fresnel(&b, base, (float)pow(1 - cosine, 5), got);
        expected(ior, nm, f0, cosine, want);
        for (int k = 0; k < 3; k++) /* what is reflected thrice and more is left out */
            if (fabs((double)got[k] - want[k]) > 0.012)
                fail_msg("ior %g, %g nm, f0 %g, cosine %g: %g is not %g", ior, nm, f0, cosine,
                         (double)got[k], want[k]);
    }
}

/* But for what Schlick's fit reflects aslant where nothing is. */
TEST(no_film_is_left_of_a_thin_one)
{
    const float f0[3] = {0.04f, 0.5f, 0.9f};
    const struct bsdf b = {.film = 1, .film_ior = 1.8f, .film_nm = 0};
    for (int i = 0; i <= 10; i++) {
        const double cosine = i / 10.0;
        float got[3];
        film_fresnel(&b, f0, (float)pow(1 - cosine, 5), got);
        for (int k = 0; k < 3; k++)
            assert_true(fabs((double)got[k] - schlick((double)f0[k], cosine)) <
                        1e-4 + 2 * pow(1 - cosine, 2.5));
    }
}

TEST(factors_mix)
{
    const float f0[3] = {0.04f, 0.04f, 0.04f};
    struct bsdf b = {.film = 1, .film_ior = 1.8f, .film_nm = 300};
    float whole[3], half[3];
    film_fresnel(&b, f0, 0.1f, whole);
    b.film = 0.25f;
    film_fresnel(&b, f0, 0.1f, half);
    for (int k = 0; k < 3; k++) {
        const double bare = 0.04 + 0.96 * 0.1;
        assert_true(fabs((double)half[k] - (bare + 0.25 * ((double)whole[k] - bare))) < 1e-6);
    }
    assert_true(fabsf(whole[0] - whole[2]) > 0.02f); /* it has a colour */
}

/* The mean over the half sphere, by a fine rule, of a smooth surface. */
TEST(means_are_integrals)
{
    for (int i = 0; i < 8; i++) {
        struct bsdf b = {.model = BSDF_GLTF,
                         .specular_f0 = {0.04f, 0.04f, 0.04f},
                         .film = 1,
                         .film_ior = i % 2 ? 1.3f : 2.0f,
                         .film_nm = 100 + 200 * (float)(i / 2)};
        double sum = 0;
        for (int k = 0; k < 1000; k++) {
            const double square = (k + 0.5) / 1000;
            float f[3];
            film_fresnel(&b, b.specular_f0, (float)pow(1 - sqrt(square), 5), f);
            sum += (double)fmaxf(f[0], fmaxf(f[1], f[2])) / 1000;
        }
        film_prepare(&b);
        if (fabs((double)b.film_mean - sum) > 0.01)
            fail_msg("%g nm: %g is not %g", (double)b.film_nm, (double)b.film_mean, sum);
    }
}

TEST(numbers_are_finite_everywhere)
{
    static const float iors[] = {1, 1.3f, 1000}, nms[] = {0, 1e-3f, 500, 1e6f}, f0s[] = {0, 1};
    for (int i = 0; i < 24; i++) {
        const struct bsdf b = {.film = 1, .film_ior = iors[i % 3], .film_nm = nms[i / 3 % 4]};
        const float f0[3] = {f0s[i / 12], 0.5f, 1};
        for (int k = 0; k <= 4; k++) {
            float got[3];
            film_fresnel(&b, f0, 0.25f * (float)k, got);
            for (int c = 0; c < 3; c++) assert_true(got[c] >= 0 && got[c] <= 1);
        }
    }
}
