/* Environments: seen, lighting, turned. */
#include <math.h>
#include <stdio.h>

#include "tests/golden/analytic.h"
#include "tests/golden/analytic_formula.h"

#define PI 3.14159265358979323846

static uint32_t behind_the_camera(struct stage *s)
{
    uint32_t grey = stage_lambert(s, 0.5, 0.5, 0.5);
    stage_panel(s, grey, (double[]){0, 0, 50}, (double[]){0.1, 0, 0}, (double[]){0, 0.1, 0});
    return grey;
}

static void constant_seen(void)
{
    struct stage *s = stage_new();
    behind_the_camera(s);
    stage_constant_environment(s, 1, 2, 3);
    stage_look(s, (double[]){0, 0, 0}, (double[]){0.3, 0.4, -1}, 1);
    struct picture *p = stage_trace(s);
    picture_expect(p, "a constant environment is what the camera sees", PLANE_PATH_RADIANCE,
                   (double[]){1, 2, 3}, 0);
    picture_expect(p, "... without scattering", PLANE_PATH_EMISSION, (double[]){1, 2, 3}, 0);
    picture_expect_grey(p, "... and nothing is met", PLANE_PATH_COVERAGE, 0, 0);
    picture_free(&p);
    stage_free(&s);
}

static double upper_half(double u, double v)
{
    (void)u;
    return v < 0.5;
}

static double plus_x_half(double u, double v)
{
    (void)v;
    return u > 0.25 && u < 0.75;
}

/* The irradiance at normal of a half space of radiance 1 around `axis` is pi/2 (1 + normal.axis).
 * Bilinear lookups soften its edge by a texel, evenly to both sides: a second-order difference that
 * 512 rows make smaller than 1e-5. */
static void half_sky(const char *name, double (*map)(double, double), double rotation_rad,
                     const double normal[3], double expected, double allowance)
{
    const double rho = 0.5;
    double u[3], v[3], eye[3], hint[3] = {0.28, 0.6, 0.75};
    struct stage *s = stage_new();
    formula_cross(normal, hint, u);
    formula_normalise(u);
    formula_cross(normal, u, v);
    for (int i = 0; i < 3; i++) eye[i] = 2 * normal[i] + u[i];
    stage_panel(s, stage_lambert(s, rho, rho, rho), (double[]){0, 0, 0}, u, v);
    stage_environment_map(s, 1024, 512, map, rotation_rad);
    stage_look(s, eye, (double[]){0, 0, 0}, POINT);
    struct picture *p = stage_trace(s);
    picture_expect_grey(p, name, PLANE_PATH_RADIANCE, rho / PI * expected, allowance);
    picture_free(&p);
    stage_free(&s);
}

static void half_skies(void)
{
    /* Below the horizon the map fades from a half to nothing over half a texel. */
    const double fade = PI / 1024, glow = PI * fade * fade / 6;
    half_sky("the upper half of a map lights a floor with pi", upper_half, 0, (double[]){0, 1, 0},
             PI, 2e-5);
    half_sky("... a wall with pi / 2", upper_half, 0, (double[]){0.6, 0, 0.8}, PI / 2, 2e-5);
    half_sky("... a ceiling by its edge's blur", upper_half, 0, (double[]){0, -1, 0}, glow, 2e-3);
    half_sky("... a slope by its angle", upper_half, 0, (double[]){0.48, 0.6, 0.64}, PI / 2 * 1.6,
             2e-5);
    half_sky("the +x half of a map lights a wall along +x with pi", plus_x_half, 0,
             (double[]){1, 0, 0}, PI, 2e-5);
    half_sky("... turned by 60 degrees with 3/4 pi", plus_x_half, PI / 3, (double[]){1, 0, 0},
             PI * 0.75, 2e-5);
    half_sky("... along (cos 60, 0, sin 60) with pi", plus_x_half, PI / 3,
             (double[]){0.5, 0, sqrt(0.75)}, PI, 2e-5);
}

/* What the camera sees of a turned map: its middle column, which shows +x unturned. */
static double bright_centre(double u, double v)
{
    return fabs(u - 0.5) < 0.02 && fabs(v - 0.5) < 0.02 ? 7 : 1;
}

static void map_seen(void)
{
    struct stage *s = stage_new();
    behind_the_camera(s);
    stage_environment_map(s, 1024, 512, bright_centre, PI / 3);
    stage_look(s, (double[]){0, 0, 0}, (double[]){0.5, 0, sqrt(0.75)}, 0.02);
    struct picture *p = stage_trace(s);
    picture_expect_grey(p, "a turned map shows its middle along (cos, 0, sin)", PLANE_PATH_RADIANCE,
                        7, 0);
    picture_free(&p);
    stage_free(&s);
}

/* A map with a small sun of 60,000 times the sky: light that only importance sampling finds. */
static double sunny(double u, double v)
{
    double sun = fabs(u - 0.30) < 0.006 && fabs(v - 0.20) < 0.012 ? 60000 : 0;
    return sun + 0.5 + 0.5 * sin(2 * PI * u) * sin(PI * v) + (v > 0.5 ? 2 : 0);
}

enum { SUNNY_W = 512, SUNNY_H = 256, FINE = 4 };

static double sunny_texels[SUNNY_H][SUNNY_W];

static double texel(int x, int y)
{
    int row = y < 0 ? 0 : y >= SUNNY_H ? SUNNY_H - 1 : y;
    return sunny_texels[row][(x + SUNNY_W) % SUNNY_W];
}

/* Radiance of the bilinear map, as environment.h defines it. */
static double sunny_lookup(double u, double v)
{
    double x = u * SUNNY_W - 0.5, y = v * SUNNY_H - 0.5, fx = x - floor(x), fy = y - floor(y);
    int i = (int)floor(x), j = (int)floor(y);
    return (1 - fy) * ((1 - fx) * texel(i, j) + fx * texel(i + 1, j)) +
           fy * ((1 - fx) * texel(i, j + 1) + fx * texel(i + 1, j + 1));
}

/* Irradiance at a normal, FINE x FINE points a texel. */
static double sunny_irradiance(const double normal[3])
{
    double sum = 0;
    for (int y = 0; y < SUNNY_H; y++)
        for (int x = 0; x < SUNNY_W; x++)
            sunny_texels[y][x] = sunny((x + 0.5) / SUNNY_W, (y + 0.5) / SUNNY_H);
    for (int j = 0; j < SUNNY_H * FINE; j++) {
        double v = (j + 0.5) / (SUNNY_H * FINE), theta = PI * v;
        for (int i = 0; i < SUNNY_W * FINE; i++) {
            double u = (i + 0.5) / (SUNNY_W * FINE), phi = 2 * PI * (u - 0.5);
            double w[3] = {sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi)};
            double cosine = formula_dot(w, normal);
            if (cosine > 0) sum += cosine * sin(theta) * sunny_lookup(u, v);
        }
    }
    return sum * 2 * PI * PI / ((double)SUNNY_W * FINE * SUNNY_H * FINE);
}

static void sun(void)
{
    const double normal[3] = {0, 1, 0};
    struct stage *s = stage_new();
    stage_panel(s, stage_lambert(s, 0.5, 0.5, 0.5), (double[]){0, 0, 0}, (double[]){1, 0, 0},
                (double[]){0, 0, -1});
    stage_environment_map(s, SUNNY_W, SUNNY_H, sunny, 0);
    stage_look(s, (double[]){1, 2, 0}, (double[]){0, 0, 0}, POINT);
    struct picture *p = stage_trace(s);
    picture_expect_grey(p, "a map with a sun of 60,000 times its sky", PLANE_PATH_RADIANCE,
                        0.5 / PI * sunny_irradiance(normal), 1e-5);
    picture_free(&p);
    stage_free(&s);
}

void analytic_environments(void)
{
    constant_seen();
    half_skies();
    map_seen();
    sun();
}
