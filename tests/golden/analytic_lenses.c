/* Cameras: the box over the pixel, the thin lens, orthographic views. The camera stands at the
 * origin and looks along -z. */
#include <complex.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/golden/analytic.h"

#define PI 3.14159265358979323846

enum { SIDE = STAGE_SIDE_PX, PIXELS = SIDE * SIDE };

static void look_ahead(struct stage *s, double half)
{
    stage_look(s, (double[]){0, 0, 0}, (double[]){0, 0, -1}, half);
}

/* Centre of a pixel in the camera's coordinates at distance 1, as right + i up. */
static double complex pixel_at(int i, double half)
{
    double a = (2 * (i % SIDE + 0.5) / SIDE - 1) * half,
           b = (1 - 2 * (i / SIDE + 0.5) / SIDE) * half;
    return a + b * I;
}

/* The edge of a glowing plate, a quarter into column 16, where the lens is focused: as sharp as
 * through a pinhole, whatever the aperture. */
static void edge(double aperture)
{
    const double half = 0.25, focus = 2, start = focus * half * 2 * 0.25 / SIDE;
    double left[PIXELS] = {0}, column[PIXELS] = {0}, right[PIXELS] = {0};
    struct stage *s = stage_new();
    stage_glow(s, (double[]){start + 4, 0, -focus}, (double[]){4, 0, 0}, (double[]){0, 4, 0}, 1);
    look_ahead(s, half);
    s->plan.camera.aperture_radius = (float)aperture;
    s->plan.camera.focus_distance = (float)focus;
    for (int i = 0; i < PIXELS; i++) {
        int x = i % SIDE;
        (x < 16 ? left : x == 16 ? column : right)[i] = x == 16 ? 1.0 / SIDE : 1.0 / (15 * SIDE);
    }
    struct picture *p = stage_trace(s);
    picture_expect_sum(p,
                       aperture > 0 ? "an edge in the focus plane: dark up to it"
                                    : "an edge through a pinhole: dark up to it",
                       left, 0, 0);
    picture_expect_sum(p, "... three quarters of the pixels on it", column, 0.75, 1e-5);
    picture_expect_sum(p, "... bright behind it", right, 1, 0);
    picture_free(&p);
    stage_free(&s);
}

/* The same edge under a tent: its integral on either side. */
static void tent(void)
{
    const double half = 0.25, start = 2 * half * 2 * 0.25 / SIDE;
    const double expected[3] = {0.03125, 0.71875, 1}; /* of columns 15, 16, 17 */
    static const char *const names[] = {"an edge under a tent: the column before it", "... on it",
                                        "... behind it"};
    struct stage *s = stage_new();
    stage_glow(s, (double[]){start + 4, 0, -2}, (double[]){4, 0, 0}, (double[]){0, 4, 0}, 1);
    look_ahead(s, half);
    s->plan.paths.pixel_filter = PIXEL_FILTER_TENT;
    struct picture *p = stage_trace(s);
    for (int column = 0; column < 3; column++) {
        double weights[PIXELS] = {0};
        for (int y = 0; y < SIDE; y++) weights[y * SIDE + 15 + column] = 1.0 / SIDE;
        picture_expect_sum(p, names[column], weights, expected[column], 0);
    }
    picture_free(&p);
    stage_free(&s);
}

/* A small square emitter out of focus: every point of the lens shows it somewhere else, so that its
 * picture is its own shape convolved with the aperture's, scaled by 1/focus - 1/distance. */
struct blur {
    const char *name;
    uint32_t blades;
    double rotation, distance, focus;
    double second; /* mean of |z|^2 over the aperture of radius 1 */
    double third;  /* size of the mean of z^3, whose angle is 3 rotations */
};

static void blurred(const struct blur *b)
{
    const double half = 0.1, aperture = 0.25, own = 0.025, radiance = 10;
    const double scale = aperture * (1 / b->focus - 1 / b->distance), side = own * b->distance;
    const double pixel = 2 * half / SIDE, energy = radiance * 4 * own * own;
    double complex turn = cexp(3 * I * b->rotation), third = pow(scale, 3) * b->third * turn;
    double ones[PIXELS], squares[PIXELS], real[PIXELS], imaginary[PIXELS];
    double second = scale * scale * b->second + 2 * own * own / 3 + pixel * pixel / 6;
    char name[128];
    struct stage *s = stage_new();
    stage_glow(s, (double[]){0, 0, -b->distance}, (double[]){side, 0, 0}, (double[]){0, side, 0},
               radiance);
    look_ahead(s, half);
    s->plan.camera.aperture_radius = (float)aperture;
    s->plan.camera.focus_distance = (float)b->focus;
    s->plan.camera.blade_count = b->blades;
    s->plan.camera.blade_rotation_rad = (float)b->rotation;
    for (int i = 0; i < PIXELS; i++) {
        double complex z = pixel_at(i, half);
        ones[i] = pixel * pixel;
        squares[i] = ones[i] * creal(z * conj(z));
        real[i] = ones[i] * creal(z * z * z);
        imaginary[i] = ones[i] * cimag(z * z * z);
    }
    struct picture *p = stage_trace(s);
    snprintf(name, sizeof name, "%s: its energy is the pinhole's", b->name);
    picture_expect_sum(p, name, ones, energy, 0);
    snprintf(name, sizeof name, "%s: its radius is A |1/f - 1/d|", b->name);
    picture_expect_sum(p, name, squares, energy * second, 1e-3 * energy * second);
    double slack = 1e-3 * energy * pow(fabs(scale), 3);
    snprintf(name, sizeof name, "%s: its corners' angle", b->name);
    picture_expect_sum(p, name, real, energy * creal(third), slack);
    picture_expect_sum(p, "... and across", imaginary, energy * cimag(third), slack);
    picture_free(&p);
    stage_free(&s);
}

/* Moments of a regular polygon with corners on the unit circle: |z|^2: (2 + cos(2 pi / n)) / 6;
 * z^3: of the triangle a b c the mean of all products of three, (a^3 + a^2 b + ... + c^3) / 10,
 * which is 1/10 for cube roots of 1. */
static void blurs(void)
{
    const double pentagon = (2 + cos(2 * PI / 5)) / 6;
    const struct blur all[] = {
        {"a round bokeh behind the focus", 0, 0, 4, 2, 0.5, 0},
        {"a round bokeh before the focus", 0, 0, 1.5, 2.25, 0.5, 0},
        {"a pentagon's bokeh", 5, 0.3, 4, 2, pentagon, 0},
        {"a triangle's bokeh behind the focus", 3, 0.3, 4, 2, 0.25, 0.1},
        {"a triangle's bokeh before the focus", 3, 0.3, 1.5, 2.25, 0.25, 0.1},
    };
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) blurred(&all[i]);
}

/* A glowing square of half side 0.45 in an orthographic view of half side 1, far or near. */
static void orthographic(double distance)
{
    double ones[PIXELS];
    struct stage *s = stage_new();
    for (int i = 0; i < PIXELS; i++) ones[i] = 1.0 / PIXELS;
    stage_glow(s, (double[]){0, 0, -distance}, (double[]){0.45, 0, 0}, (double[]){0, 0.45, 0}, 4);
    look_ahead(s, 1);
    s->plan.camera.type = CAMERA_ORTHOGRAPHIC;
    struct picture *p = stage_trace(s);
    picture_expect_sum(p, "an orthographic view does not shrink with distance", ones, 0.2025 * 4,
                       1e-5);
    picture_free(&p);
    stage_free(&s);
}

void analytic_lenses(void)
{
    edge(0);
    edge(0.5);
    tent();
    blurs();
    orthographic(1);
    orthographic(500);
}
