/* Furnaces: what stands in even light looks as bright as its albedo says, and white things cannot
 * be seen. */
#include <math.h>
#include <stdio.h>

#include "tests/golden/analytic.h"
#include "tests/golden/analytic_formula.h"

/* Something convex of albedo rho under radiance 1 from everywhere shows rho: what it scatters it
 * never meets again. */
static void convex(void)
{
    struct stage *s = stage_new();
    stage_constant_environment(s, 1, 2, 3);
    stage_box(s, stage_lambert(s, 0.8, 0.5, 0.2), (double[]){0, 0, 0}, (double[]){1, 1, 1}, false);
    s->plan.bounces = 4;
    stage_look(s, (double[]){3, 4, 5}, (double[]){0, 0, 0}, 0.05);
    struct picture *p = stage_trace(s);
    picture_expect(p, "a box of albedo rho under constant light is rho", PLANE_PATH_RADIANCE,
                   (double[]){0.8, 1.0, 0.6}, 0);
    picture_expect(p, "... and all of it is direct light", PLANE_PATH_DIRECT,
                   (double[]){0.8, 1.0, 0.6}, 0);
    picture_expect(p, "... which without albedo is the environment", PLANE_PATH_DIFFUSE_DIRECT,
                   (double[]){1, 2, 3}, 0);
    picture_free(&p);
    stage_free(&s);
}

/* sum of rho^k for k = 0 .. n */
static double series(double rho, int n)
{
    return (1 - pow(rho, n + 1)) / (1 - rho);
}

/* In a closed box whose walls emit 1 and reflect rho every further scattering adds a power of it.
 */
static void closed_box(uint32_t bounces, const char *name)
{
    const double rho[3] = {0.8, 0.5, 0.2};
    double all[3], indirect[3], demodulated[3];
    struct stage *s = stage_new();
    uint32_t wall = stage_lambert(s, rho[0], rho[1], rho[2]);
    for (int c = 0; c < 3; c++) {
        s->f->materials[wall].emission[c] = 1;
        all[c] = series(rho[c], (int)bounces + 1);
        indirect[c] = all[c] - 1 - rho[c];
        demodulated[c] = indirect[c] / rho[c];
    }
    stage_box(s, wall, (double[]){0, 0, 0}, (double[]){1, 1, 1}, true);
    s->plan.paths.emitter_power = 1;
    s->plan.bounces = bounces;
    stage_look(s, (double[]){0.1, 0.2, 0.3}, (double[]){-0.9, 0.4, -0.5}, 0.9);
    struct picture *p = stage_trace(s);
    picture_expect(p, name, PLANE_PATH_RADIANCE, all, 0);
    if (bounces > 1) {
        picture_expect(p, "... of which 1 is emitted", PLANE_PATH_EMISSION, (double[]){1, 1, 1}, 0);
        picture_expect(p, "... rho is direct", PLANE_PATH_DIRECT, rho, 0);
        picture_expect(p, "... and the rest indirect", PLANE_PATH_INDIRECT, indirect, 0);
        picture_expect(p, "... without albedo: the rest over rho", PLANE_PATH_DIFFUSE_INDIRECT,
                       demodulated, 0);
        picture_expect(p, "... albedo is rho", PLANE_PATH_ALBEDO, rho, 0);
        picture_expect_grey(p, "... every ray meets a wall", PLANE_PATH_COVERAGE, 1, 0);
    }
    picture_free(&p);
    stage_free(&s);
}

static void expect_invisible(struct stage *s, const char *name, uint32_t bounces, double half)
{
    stage_constant_environment(s, 1, 1, 1);
    s->plan.bounces = bounces;
    stage_look(s, (double[]){3, 3.5, 4}, (double[]){0, 0, 0}, half);
    struct picture *p = stage_trace(s);
    picture_expect_grey(p, name, PLANE_PATH_RADIANCE, 1, 0);
    picture_free(&p);
    stage_free(&s);
}

static void white_bodies(void)
{
    const double o[3] = {0, 0, 0}, h[3] = {1, 1, 1};
    struct stage *s = stage_new();
    stage_box(s, stage_lambert(s, 1, 1, 1), o, h, false);
    expect_invisible(s, "a white box is invisible", 0, 0.5);
    s = stage_new();
    stage_sphere(s, stage_lambert(s, 1, 1, 1), o, 1.2, false);
    expect_invisible(s, "a white sphere of 3,968 triangles is invisible", 2, 0.5);
    s = stage_new();
    uint32_t white = stage_lambert(s, 1, 1, 1);
    stage_panel(s, white, (double[]){0, 0, -1}, (double[]){1, 0, 0}, (double[]){0, 1, 0});
    stage_panel(s, white, (double[]){-1, 0, 0}, (double[]){0, 1, 0}, (double[]){0, 0, 1});
    stage_panel(s, white, (double[]){0, -1, 0}, (double[]){0, 0, 1}, (double[]){1, 0, 0});
    expect_invisible(s, "a white corner of three plates is invisible after 64 bounces", 64, 0.5);
}

static uint32_t glass(struct stage *s, double thickness)
{
    uint32_t index;
    struct scene_material *m = stage_material(s, &index);
    m->roughness = 0;
    m->specular = 1;
    m->transmission = 1;
    m->thickness = (float)thickness;
    return index;
}

static void glass_bodies(void)
{
    const double o[3] = {0, 0, 0}, h[3] = {1, 1, 1};
    struct stage *s = stage_new();
    stage_box(s, glass(s, 1), o, h, false);
    expect_invisible(s, "a clear box of glass is invisible", 64, 0.5);
    s = stage_new();
    /* Its middle: light that enters aslant is caught for long where facets turn it beyond the
     * critical angle, and 64 bounces do not see all of it out. */
    stage_sphere(s, glass(s, 1), o, 1.2, false);
    expect_invisible(s, "a clear sphere of glass is invisible", 64, 0.08);
    s = stage_new();
    stage_panel(s, glass(s, 0), o, (double[]){1, 0, -1}, (double[]){0, 1, 0});
    expect_invisible(s, "a thin pane of glass is invisible", 2, 0.5);
}

/* Coloured glass: what a slab leaves over, seen along its normal, where Schlick's Fresnel and the
 * exact one agree. */
static void coloured_slab(void)
{
    const double inner[3] = {0.81, 0.49, 0.09};
    double expected[3];
    struct stage *s = stage_new();
    uint32_t material = glass(s, 1);
    for (int c = 0; c < 3; c++) {
        /* half the slab's thickness, so that the law of Beer and Lambert is at work */
        s->f->materials[material].attenuation[c] = (float)sqrt(inner[c]);
        expected[c] = formula_slab(0.04, inner[c]);
    }
    s->f->materials[material].attenuation_distance = 0.25f;
    stage_box(s, material, (double[]){0, 0, 0}, (double[]){4, 0.25, 4}, false);
    stage_constant_environment(s, 1, 1, 1);
    s->plan.bounces = 32;
    stage_look(s, (double[]){0.3, 3, 0.2}, (double[]){0.3, 0, 0.2}, POINT);
    struct picture *p = stage_trace(s);
    picture_expect(p, "a slab of coloured glass absorbs as Beer and Lambert say",
                   PLANE_PATH_RADIANCE, expected, 0);
    picture_free(&p);
    stage_free(&s);
}

/* Dispersion turns each colour by its own angle, so that each has another way through grey glass;
 * and what is reflected by the exact equations, less what glTF's f0 makes of them. */
static void dispersed_slab(void)
{
    const double cosine = 0.5, grey = 0.3;
    double expected[3];
    struct stage *s = stage_new();
    uint32_t material = glass(s, 1);
    for (int c = 0; c < 3; c++) {
        const double n = 1.5 + (c - 1) * 0.5 * 0.025 * 8, f0 = pow((n - 1) / (n + 1), 2);
        const double within = sqrt(1 - (1 - cosine * cosine) / (n * n));
        const double along = (n * cosine - within) / (n * cosine + within);
        const double across = (cosine - n * within) / (cosine + n * within);
        const double exact = (along * along + across * across) / 2;
        s->f->materials[material].attenuation[c] = (float)sqrt(grey);
        expected[c] = formula_slab(0.04 + 0.96 * (exact - f0) / (1 - f0), pow(grey, 1 / within));
    }
    s->f->materials[material].attenuation_distance = 0.25f;
    s->f->materials[material].dispersion = 8;
    stage_box(s, material, (double[]){0, 0, 0}, (double[]){40, 0.25, 40}, false);
    stage_constant_environment(s, 1, 1, 1);
    s->plan.bounces = 32;
    stage_look(s, (double[]){0.3 + 3 * sqrt(3), 3.25, 0.2}, (double[]){0.3, 0.25, 0.2}, POINT);
    struct picture *p = stage_trace(s);
    picture_expect(p, "a slab of grey glass disperses", PLANE_PATH_RADIANCE, expected, 0);
    picture_free(&p);
    stage_free(&s);
}

/* Known losses: facets that shadow each other lose light, and glTF's model
 * does not give it back. */
static void metals(void)
{
    static const double alpha[] = {0.0025, 0.09, 0.25, 0.64};
    for (int i = 0; i < 4; i++) {
        uint32_t index;
        char name[96];
        struct stage *s = stage_new();
        struct scene_material *m = stage_material(s, &index);
        m->metallic = 1;
        m->specular = 1;
        m->roughness = (float)sqrt(alpha[i]);
        stage_panel(s, index, (double[]){0, 0, 0}, (double[]){2, 0, 0}, (double[]){0, 0, -2});
        stage_constant_environment(s, 1, 1, 1);
        stage_look(s, (double[]){3, 2, 0}, (double[]){0, 0, 0}, POINT);
        struct picture *p = stage_trace(s);
        snprintf(name, sizeof name, "a white metal of alpha %g loses what its facets hide",
                 alpha[i]);
        picture_expect_grey(p, name, PLANE_PATH_RADIANCE,
                            formula_ggx_albedo(2 / sqrt(13), alpha[i]), 1e-4);
        picture_free(&p);
        stage_free(&s);
    }
}

/* An integrating sphere: a light in the middle, walls of albedo rho. In any closed body the mean
 * irradiance is what enters over (1 - rho) area, exactly; on facets of 5.6 degrees the camera's
 * mean over directions differs from the one over areas by less than 1 - cos^2 of half their
 * diagonal. */
static void integrating_sphere(void)
{
    const double intensity = 2, rho = 0.75;
    struct stage *s = stage_new();
    double area = stage_sphere(s, stage_lambert(s, rho, rho, rho), (double[]){0, 0, 0}, 1.5, true);
    stage_point(s, (double[]){0, 0, 0}, intensity);
    s->plan.bounces = 64;
    stage_look(s, (double[]){0, 0, 0}, (double[]){0.3, 0.2, -1}, 1);
    struct picture *p = stage_trace(s);
    picture_expect_grey(p, "an integrating sphere shows I rho / pi R^2 (1 - rho)",
                        PLANE_PATH_RADIANCE, 4 * intensity * rho / area / (1 - rho), 4e-3);
    picture_free(&p);
    stage_free(&s);
}

void analytic_furnaces(void)
{
    convex();
    closed_box(0, "a closed box of albedo rho that emits 1 shows 1 + rho without bounces");
    closed_box(1, "... 1 + rho + rho^2 with one");
    closed_box(64, "... 1 / (1 - rho) with 64");
    white_bodies();
    glass_bodies();
    coloured_slab();
    dispersed_slab();
    metals();
    integrating_sphere();
}
