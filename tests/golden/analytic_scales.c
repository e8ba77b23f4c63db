/* The same pictures at other scales and far from the origin. Scaling by powers of ten leaves
 * relative rounding as it is, so nothing is allowed for it. Moved 1e5 sizes away, coordinates are
 * multiples of 1/128 of the size, and hits and offsets are off by such steps: a few percent. */
#include <math.h>
#include <stdio.h>

#include "tests/golden/analytic.h"
#include "tests/golden/analytic_formula.h"

#define PI 3.14159265358979323846

struct where {
    const char *name;
    double scale, shift;
    double allowance;
};

static struct stage *stage_at(const struct where *w)
{
    struct stage *s = stage_new();
    s->scale = w->scale;
    s->shift[0] = w->shift;
    s->shift[1] = -w->shift;
    s->shift[2] = w->shift / 2;
    s->plan.length_unit = exp2f(roundf(log2f((float)w->scale)));
    return s;
}

static void finish(struct stage *s, const struct where *w, const char *what, enum plane_id plane,
                   double expected)
{
    char name[128];
    struct picture *p = stage_trace(s);
    snprintf(name, sizeof name, "%s, %s", what, w->name);
    picture_expect_grey(p, name, plane, expected, w->allowance);
    picture_free(&p);
    stage_free(&s);
}

/* Seen from straight above over a square of a quarter: the mean of the closed form over it. */
static void rectangle(const struct where *w)
{
    enum { STEPS = 64 };
    const double c[3] = {0, 2, 0}, u[3] = {1, 0, 0}, v[3] = {0, 0, 0.5}, up[3] = {0, 1, 0};
    double e = 0;
    struct stage *s = stage_at(w);
    stage_rectangle(s, c, u, v, 8);
    stage_panel(s, stage_lambert(s, 0.5, 0.5, 0.5), (double[]){1.5, 0, -0.75},
                (double[]){0.5, 0, 0}, (double[]){0, 0, -0.5});
    stage_look(s, (double[]){1.5, 1, -0.75}, (double[]){1.5, 0, -0.75}, 0.125);
    for (int i = 0; i < STEPS; i++)
        for (int j = 0; j < STEPS; j++) {
            double a = (2.0 * i + 1) / STEPS - 1, b = (2.0 * j + 1) / STEPS - 1;
            double at[3] = {1.5 + 0.125 * a, 0, -0.75 + 0.125 * b};
            e += formula_rectangle(c, u, v, at, up) / (STEPS * STEPS);
        }
    finish(s, w, "a rectangle light over a plane", PLANE_PATH_RADIANCE, 0.5 / PI * 8 * e);
}

static void point(const struct where *w)
{
    struct stage *s = stage_at(w);
    stage_point(s, (double[]){0, 2, 0}, 5);
    stage_panel(s, stage_lambert(s, 0.5, 0.5, 0.5), (double[]){0, 0, 0}, (double[]){1, 0, 0},
                (double[]){0, 0, -1});
    stage_look(s, (double[]){0, 1, 0}, (double[]){0, 0, 0}, 0.001);
    finish(s, w, "a point light over a plane", PLANE_PATH_RADIANCE, 0.5 / PI * 5 / 4);
}

static void furnace(const struct where *w)
{
    struct stage *s = stage_at(w);
    uint32_t wall = stage_lambert(s, 0.5, 0.5, 0.5);
    for (int c = 0; c < 3; c++) s->f->materials[wall].emission[c] = 1;
    stage_box(s, wall, (double[]){0, 0, 0}, (double[]){1, 1, 1}, true);
    s->plan.paths.emitter_power = 1;
    s->plan.bounces = 64;
    stage_look(s, (double[]){0.125, 0.25, 0.25}, (double[]){-0.9, 0.4, -0.5}, 0.9);
    finish(s, w, "a closed box of albedo 1/2 that emits 1", PLANE_PATH_RADIANCE, 2);
}

static void white_box(const struct where *w)
{
    struct stage *s = stage_at(w);
    stage_box(s, stage_lambert(s, 1, 1, 1), (double[]){0, 0, 0}, (double[]){1, 1, 1}, false);
    stage_constant_environment(s, 1, 1, 1);
    s->plan.bounces = 2;
    stage_look(s, (double[]){3, 3.5, 4}, (double[]){0, 0, 0}, 0.5);
    finish(s, w, "a white box in an environment of 1", PLANE_PATH_RADIANCE, 1);
}

static void glass_box(const struct where *w)
{
    uint32_t index;
    struct stage *s = stage_at(w);
    struct scene_material *m = stage_material(s, &index);
    m->roughness = 0, m->specular = 1, m->transmission = 1, m->thickness = 1;
    stage_box(s, index, (double[]){0, 0, 0}, (double[]){1, 1, 1}, false);
    stage_constant_environment(s, 1, 1, 1);
    s->plan.bounces = 64;
    stage_look(s, (double[]){3, 3.5, 4}, (double[]){0, 0, 0}, 0.5);
    finish(s, w, "a clear box of glass in an environment of 1", PLANE_PATH_RADIANCE, 1);
}

static void corner(const struct where *w)
{
    struct stage *s = stage_at(w);
    uint32_t grey = stage_lambert(s, 0.5, 0.5, 0.5);
    stage_panel(s, grey, (double[]){0, 0, 0}, (double[]){4, 0, 0}, (double[]){0, 0, -4});
    stage_panel(s, grey, (double[]){-0.5, 2, 0}, (double[]){0, 2, 0}, (double[]){0, 0, 4});
    s->plan.planes |= PLANE_BIT(PATH_VISIBILITY);
    s->plan.occlusion_distance = (float)w->scale;
    stage_look(s, (double[]){2, 2, 0.5}, (double[]){0, 0, 0}, POINT);
    finish(s, w, "openness in a corner", PLANE_PATH_VISIBILITY, formula_corner_openness(0.5, 1));
}

void analytic_scales(void)
{
    static const struct where all[] = {
        {"a ten-thousandth its size", 1e-4, 0, 0},
        {"ten thousand times its size", 1e4, 0, 0},
        {"1e5 sizes away", 1, 1e5, 0.03},
        {"a ten-thousandth its size, 1e5 sizes away", 0x1p-13, 0x1p-13 * 1e5, 0.03},
    };
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        rectangle(&all[i]);
        point(&all[i]);
        furnace(&all[i]);
        white_box(&all[i]);
        glass_box(&all[i]);
        corner(&all[i]);
    }
}
