/* The light field of indirect light in closed form: furnaces, a wall in the sun, corners. Half
 * floats round what comes by 2^-12 at most. */
#include <math.h>
#include <stdio.h>

#include "tests/golden/analytic.h"
#include "tests/golden/analytic_formula.h"

#define PI            3.14159265358979323846
#define HALF_ROUNDING 0x1p-12

/* sum of rho^k for k = 0 .. n */
static double series(double rho, int n)
{
    return (1 - pow(rho, n + 1)) / (1 - rho);
}

/* In a closed box whose walls emit 1 and reflect rho: what bounce rays meet themselves is direct
 * light, which counts without paths, and every further scattering adds a power of rho. */
static void closed_box(uint32_t bounces)
{
    const double rho[3] = {0.8, 0.5, 0.2};
    for (int beside = 0; beside < 2; beside++) {
        double expected[3];
        char name[96];
        struct stage *s = stage_new();
        uint32_t wall = stage_lambert(s, rho[0], rho[1], rho[2]);
        for (int c = 0; c < 3; c++) {
            s->f->materials[wall].emission[c] = 1;
            expected[c] = series(rho[c], (int)bounces) - beside;
        }
        stage_box(s, wall, (double[]){0, 0, 0}, (double[]){1, 1, 1}, true);
        s->plan.paths.emitter_power = 1;
        s->plan.bounces = bounces;
        s->plan.occlusion_distance = 0.01f;
        stage_look(s, (double[]){0.1, 0.2, 0.3}, (double[]){-0.9, 0.4, -0.5}, 0.2);
        struct picture *p = stage_trace_field(s, beside);
        snprintf(name, sizeof name, "a closed box that glows, field of %u bounces%s", bounces,
                 beside ? " beside paths" : "");
        picture_expect(p, name, PLANE_INDIRECT_MEAN, expected, HALF_ROUNDING);
        if (bounces == 1)
            picture_expect_grey(p, "... open at once, away from its edges",
                                PLANE_AMBIENT_VISIBILITY, 1, 0);
        picture_free(&p);
        stage_free(&s);
    }
}

/* White things under radiance 1 cannot be seen: what a wall hides from the floor of the sky it
 * sends there itself, after enough scatterings. */
static void white_corner(void)
{
    const double wall[3] = {-0.5, 1, 0}, u[3] = {0, 0, -1.5}, v[3] = {0, 1, 0};
    const double at[3] = {0, 0, 0.25}, up[3] = {0, 1, 0};
    for (int beside = 0; beside < 2; beside++) {
        struct stage *s = stage_new();
        uint32_t white = stage_lambert(s, 1, 1, 1);
        stage_constant_environment(s, 1, 1, 1);
        stage_panel(s, white, (double[]){1.5, 0, 0}, (double[]){2, 0, 0}, (double[]){0, 0, -2});
        stage_panel(s, white, wall, u, v);
        s->plan.bounces = 64;
        s->plan.occlusion_distance = 100;
        stage_look(s, (double[]){2, 2, 1}, at, POINT);
        double hidden = formula_rectangle(wall, u, v, at, up) / PI;
        struct picture *p = stage_trace_field(s, beside);
        picture_expect_grey(
            p, beside ? "a white wall beside paths" : "a white wall sends what it hides",
            PLANE_INDIRECT_MEAN, hidden, HALF_ROUNDING);
        picture_expect_grey(p, "... and hides what it covers", PLANE_AMBIENT_VISIBILITY, 1 - hidden,
                            HALF_ROUNDING);
        picture_free(&p);
        stage_free(&s);
    }
}

/* Light along the floor meets only the wall, which then lights the floor as a rectangle of radiance
 * rho E / pi. */
static void wall_in_the_sun(double scale)
{
    const double e = 6, rho[3] = {0.9, 0.5, 0.2};
    const double wall[3] = {0, 1, -1}, u[3] = {1.5, 0, 0}, v[3] = {0, 1, 0}; /* faces +z */
    const double at[3] = {0.5, 0, 0.25}, up[3] = {0, 1, 0};
    double expected[3];
    char name[96];
    struct stage *s = stage_new();
    s->scale = scale;
    s->plan.length_unit = exp2f(roundf(log2f((float)scale)));
    struct plan_light *light = fixture_light(&s->plan, LIGHT_DIRECTIONAL, 1);
    light->direction[0] = light->direction[1] = 0, light->direction[2] = -1;
    for (int c = 0; c < 3; c++) light->color[c] = (float)e;
    stage_panel(s, stage_lambert(s, rho[0], rho[1], rho[2]), wall, u, v);
    stage_panel(s, stage_lambert(s, 0.7, 0.7, 0.7), (double[]){0, 0, 0}, (double[]){1, 0, 0},
                (double[]){0, 0, -1});
    s->plan.bounces = 1;
    stage_look(s, (double[]){0.5, 1.5, 2}, at, POINT);
    for (int c = 0; c < 3; c++)
        expected[c] = rho[c] * e / PI / PI * formula_rectangle(wall, u, v, at, up);
    struct picture *p = stage_trace_field(s, false);
    snprintf(name, sizeof name, "a wall in the sun: its field on the floor, scale %g", scale);
    picture_expect(p, name, PLANE_INDIRECT_MEAN, expected, HALF_ROUNDING);
    picture_free(&p);
    stage_free(&s);
}

/* Ambient occlusion in a corner, by rays of its own and by those of indirect light. */
static void corner(double distance, double reach)
{
    char name[96];
    for (int bounces = 0; bounces < 2; bounces++) {
        struct stage *s = stage_new();
        uint32_t grey = stage_lambert(s, 0.5, 0.5, 0.5);
        stage_panel(s, grey, (double[]){0, 0, 0}, (double[]){8, 0, 0}, (double[]){0, 0, -8});
        stage_panel(s, grey, (double[]){-distance, 4, 0}, (double[]){0, 4, 0}, (double[]){0, 0, 8});
        s->plan.occlusion_distance = (float)reach;
        s->plan.bounces = (uint32_t)bounces;
        stage_look(s, (double[]){2, 2, 0.5}, (double[]){0, 0, 0}, POINT);
        struct picture *p = stage_trace_field(s, false);
        snprintf(name, sizeof name, "field: openness at %g from a wall, within %g%s", distance,
                 reach, bounces ? ", by bounce rays" : "");
        picture_expect_grey(p, name, PLANE_AMBIENT_VISIBILITY,
                            formula_corner_openness(distance, reach), HALF_ROUNDING);
        picture_free(&p);
        stage_free(&s);
    }
}

void analytic_fields(void)
{
    closed_box(1);
    closed_box(3);
    closed_box(16);
    white_corner();
    wall_in_the_sun(1);
    wall_in_the_sun(1e-4);
    wall_in_the_sun(1e5);
    corner(0.25, 1);
    corner(0.5, 1);
    corner(0.9, 1);
    corner(1.1, 1);
    corner(0.5, 4);
}
