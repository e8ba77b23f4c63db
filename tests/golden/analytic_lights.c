/* Lights over a plane in closed form, light choice, mirrors that show lights, one bounce. */
#include <math.h>
#include <stdio.h>

#include "tests/golden/analytic.h"
#include "tests/golden/analytic_formula.h"

#define PI 3.14159265358979323846

/* Where an irradiance is looked at: a point, the floor's normal there. */
struct receiver {
    const char *name;
    double point[3], normal[3];
};
static const struct receiver receivers[] = {
    {"below its centre", {0, 0, 0}, {0, 1, 0}},
    {"aside", {1.5, 0, -0.75}, {0, 1, 0}},
    {"far aside", {6, 0, 2}, {0, 1, 0}},
    {"on a tilted plane", {0.5, 0.25, 0.5}, {0.6, 0.8, 0}},
    {"cut by the receiver's horizon", {0.75, 0.5, 0.25}, {0.96, 0.28, 0}},
    {"close to its edge", {0.95, 1.75, 0}, {0, 1, 0}},
};
enum { RECEIVERS = sizeof receivers / sizeof receivers[0] };

static const double centre[3] = {0, 2, 0}, half_u[3] = {1, 0, 0}, half_v[3] = {0, 0, 0.5};

/* A square plane of half side `half` through the receiver, and the camera that looks at the point
 * from its front, off the normal. */
static void look_at_plane(struct stage *s, uint32_t material, const struct receiver *r, double half)
{
    double u[3], v[3], eye[3], hint[3] = {0, 0, 1};
    formula_cross(r->normal, hint, u);
    formula_normalise(u);
    formula_cross(u, r->normal, v); /* u x -v is the normal */
    for (int i = 0; i < 3; i++) {
        eye[i] = r->point[i] + 0.2 * (r->normal[i] - 0.25 * u[i] + 0.5 * v[i]);
        u[i] *= half, v[i] *= -half;
    }
    stage_panel(s, material, r->point, u, v);
    stage_look(s, eye, r->point, POINT);
}

enum light_kind { AS_LIGHT, AS_LAMP, AS_MESH, AS_GAUSSIAN };
static const char *const kind_names[] = {"a rectangle light", "the same with its geometry",
                                         "the same as triangles", "a Gaussian rectangle"};

static void rectangle_over_plane(enum light_kind kind, const struct receiver *r)
{
    const double rho[3] = {0.9, 0.5, 0.1}, radiance = 8;
    double expected[3], e;
    char name[128];
    struct stage *s = stage_new();
    if (kind == AS_MESH) stage_glow(s, centre, half_u, half_v, radiance);
    if (kind == AS_LIGHT) stage_rectangle(s, centre, half_u, half_v, radiance);
    if (kind == AS_LAMP) stage_lamp(s, centre, half_u, half_v, radiance);
    if (kind == AS_GAUSSIAN)
        stage_rectangle(s, centre, half_u, half_v, radiance)->profile = PROFILE_GAUSSIAN;
    look_at_plane(s, stage_lambert(s, rho[0], rho[1], rho[2]), r, 0.5);
    e = kind == AS_GAUSSIAN
            ? formula_gaussian_rectangle(centre, half_u, half_v, r->point, r->normal)
            : formula_rectangle(centre, half_u, half_v, r->point, r->normal);
    for (int c = 0; c < 3; c++) expected[c] = rho[c] / PI * radiance * e;
    struct picture *p = stage_trace(s);
    snprintf(name, sizeof name, "%s, %s", kind_names[kind], r->name);
    picture_expect(p, name, PLANE_PATH_RADIANCE, expected, 0);
    picture_free(&p);
    stage_free(&s);
}

static void rectangles(void)
{
    for (int i = 0; i < RECEIVERS; i++) rectangle_over_plane(AS_LIGHT, &receivers[i]);
    for (int i = 0; i < RECEIVERS; i++) rectangle_over_plane(AS_LAMP, &receivers[i]);
    for (int i = 0; i < RECEIVERS; i++) rectangle_over_plane(AS_MESH, &receivers[i]);
    rectangle_over_plane(AS_GAUSSIAN, &receivers[0]);
    rectangle_over_plane(AS_GAUSSIAN, &receivers[1]);
    rectangle_over_plane(AS_GAUSSIAN, &receivers[3]);
}

/* One-sided: nothing behind. */
static void behind_a_light(void)
{
    for (int kind = AS_LIGHT; kind <= AS_MESH; kind++) {
        char name[96];
        struct stage *s = stage_new();
        struct receiver r = {"", {0.2, 3, 0.1}, {0, -1, 0}};
        if (kind == AS_MESH) stage_glow(s, centre, half_u, half_v, 8);
        if (kind == AS_LIGHT) stage_rectangle(s, centre, half_u, half_v, 8);
        if (kind == AS_LAMP) stage_lamp(s, centre, half_u, half_v, 8);
        look_at_plane(s, stage_lambert(s, 1, 1, 1), &r, 0.5);
        struct picture *p = stage_trace(s);
        snprintf(name, sizeof name, "%s shines to one side", kind_names[kind]);
        picture_expect_grey(p, name, PLANE_PATH_RADIANCE, 0, 0);
        picture_free(&p);
        stage_free(&s);
    }
}

/* Point, spot and directional lights: no area, no noise. */
static void small_lights(void)
{
    const struct receiver floor = {"", {0.5, 0, -0.25}, {0, 1, 0}};
    const double d2 = 0.5 * 0.5 + 2 * 2 + 0.25 * 0.25, cosine = 2 / sqrt(d2), rho = 0.6;
    const double point = rho / PI * 5 * cosine / d2;
    for (int type = LIGHT_POINT; type <= LIGHT_DIRECTIONAL; type++) {
        static const char *const names[] = {"a point light gives I cos / d^2",
                                            "a spot light's edge dims by its cone",
                                            "a directional light gives E cos"};
        struct stage *s = stage_new();
        struct plan_light *light = stage_point(s, (double[]){0, 2, 0}, 5);
        light->type = (uint32_t)type;
        look_at_plane(s, stage_lambert(s, rho, rho, rho), &floor, 1);
        double expected = point;
        if (type == LIGHT_SPOT) {
            light->cos_inner = 0.995f, light->cos_outer = 0.9f;
            double cone = (cosine - 0.9) / (0.995 - 0.9);
            expected = point * cone * cone;
        }
        if (type == LIGHT_DIRECTIONAL) {
            light->direction[0] = 0.6f, light->direction[1] = -0.8f;
            expected = rho / PI * 5 * 0.8;
        }
        struct picture *p = stage_trace(s);
        picture_expect_grey(p, names[type], PLANE_PATH_RADIANCE, expected, 0);
        picture_free(&p);
        stage_free(&s);
    }
}

/* Whatever one light is chosen with, all of them together give the sum. */
static void all_lights_together(void)
{
    const struct receiver *r = &receivers[1];
    const double other[3] = {-3, 3, 1}, other_u[3] = {0.25, 0, 0}, other_v[3] = {0, 0, 0.25};
    struct stage *s = stage_new();
    double d2 = 0.5 * 0.5 + 1.5 * 1.5 + 0.75 * 0.75, e;
    stage_rectangle(s, centre, half_u, half_v, 8)->power = 4;
    stage_point(s, (double[]){1, 1.5, 0}, 2)->power = 0.5f;
    stage_glow(s, other, other_u, other_v, 40);
    s->plan.paths.emitter_power = 2;
    stage_constant_environment(s, 0.5, 0.5, 0.5);
    s->plan.environment.power = 3;
    look_at_plane(s, stage_lambert(s, 0.5, 0.5, 0.5), r, 0.25);
    e = 8 * formula_rectangle(centre, half_u, half_v, r->point, r->normal);
    e += 40 * formula_rectangle(other, other_u, other_v, r->point, r->normal);
    e += 2 * (1.5 / sqrt(d2)) / d2;
    /* The environment but for what the mesh emitter covers; the rectangle has no geometry. */
    e += 0.5 * (PI - formula_rectangle(other, other_u, other_v, r->point, r->normal));
    struct picture *p = stage_trace(s);
    picture_expect_grey(p, "a rectangle, a point, triangles and an environment add up",
                        PLANE_PATH_RADIANCE, 0.5 / PI * e, 0);
    picture_free(&p);
    stage_free(&s);
}

/* A mirror shows the light behind it, times its colour. */
static void light_in_a_mirror(bool as_mesh)
{
    uint32_t index;
    struct stage *s = stage_new();
    struct scene_material *m = stage_material(s, &index);
    m->model = MODEL_MIRROR;
    for (int c = 0; c < 3; c++) m->base_color[c] = 0, m->model_specular[c] = 0.9f - 0.2f * (float)c;
    stage_panel(s, index, (double[]){0, 0, 0}, (double[]){2, 0, 0}, (double[]){0, 0, -2});
    if (as_mesh)
        stage_glow(s, centre, half_u, half_v, 8);
    else
        stage_lamp(s, centre, half_u, half_v, 8);
    stage_look(s, (double[]){0.9, 3, 1.5}, (double[]){0.1, 0, 0.45}, 0.02);
    struct picture *p = stage_trace(s);
    picture_expect(p, as_mesh ? "a glowing mesh in a mirror" : "a rectangle light in a mirror",
                   PLANE_PATH_RADIANCE, (double[]){7.2, 5.6, 4.0}, 0);
    picture_free(&p);
    stage_free(&s);
}

/* The camera sees a light's geometry as bright as it is, and its back black. */
static void light_seen(bool as_mesh, bool from_behind)
{
    char name[96];
    struct stage *s = stage_new();
    if (as_mesh)
        stage_glow(s, centre, half_u, half_v, 8);
    else
        stage_lamp(s, centre, half_u, half_v, 8);
    stage_look(s, (double[]){0.3, from_behind ? 4 : -1, 0.4}, (double[]){0.1, 2, 0.1}, 0.02);
    struct picture *p = stage_trace(s);
    snprintf(name, sizeof name, "the %s of %s seen by the camera", from_behind ? "back" : "front",
             as_mesh ? "a glowing mesh" : "a rectangle light");
    picture_expect_grey(p, name, PLANE_PATH_EMISSION, from_behind ? 0 : 8, 0);
    picture_free(&p);
    stage_free(&s);
}

/* One bounce: light along the floor meets only the wall, which then lights the floor as a rectangle
 * of radiance rho E / pi. */
static void one_bounce(void)
{
    const double e = 6, rho_wall[3] = {0.9, 0.5, 0.2}, rho_floor = 0.7;
    const double wall[3] = {0, 1, -1}, u[3] = {1.5, 0, 0}, v[3] = {0, 1, 0}; /* faces +z */
    const double at[3] = {0.5, 0, 0.25}, up[3] = {0, 1, 0};
    double expected[3];
    struct stage *s = stage_new();
    struct plan_light *light = fixture_light(&s->plan, LIGHT_DIRECTIONAL, 1);
    light->direction[0] = light->direction[1] = 0, light->direction[2] = -1;
    for (int c = 0; c < 3; c++) light->color[c] = (float)e;
    stage_panel(s, stage_lambert(s, rho_wall[0], rho_wall[1], rho_wall[2]), wall, u, v);
    stage_panel(s, stage_lambert(s, rho_floor, rho_floor, rho_floor), (double[]){0, 0, 0},
                (double[]){1, 0, 0}, (double[]){0, 0, -1});
    s->plan.bounces = 1;
    stage_look(s, (double[]){0.5, 1.5, 2}, at, POINT);
    for (int c = 0; c < 3; c++)
        expected[c] = rho_floor / PI * rho_wall[c] * e / PI * formula_rectangle(wall, u, v, at, up);
    struct picture *p = stage_trace(s);
    picture_expect(p, "a wall in the sun lights the floor: one bounce", PLANE_PATH_RADIANCE,
                   expected, 0);
    picture_expect(p, "... all of it indirect", PLANE_PATH_INDIRECT, expected, 0);
    picture_free(&p);
    stage_free(&s);
}

/* Ambient occlusion in a corner. */
static void corner(double distance, double reach)
{
    char name[96];
    struct stage *s = stage_new();
    uint32_t grey = stage_lambert(s, 0.5, 0.5, 0.5);
    stage_panel(s, grey, (double[]){0, 0, 0}, (double[]){8, 0, 0}, (double[]){0, 0, -8});
    stage_panel(s, grey, (double[]){-distance, 4, 0}, (double[]){0, 4, 0}, (double[]){0, 0, 8});
    s->plan.planes |= PLANE_BIT(PATH_VISIBILITY);
    s->plan.occlusion_distance = (float)reach;
    stage_look(s, (double[]){2, 2, 0.5}, (double[]){0, 0, 0}, POINT);
    struct picture *p = stage_trace(s);
    snprintf(name, sizeof name, "openness at %g from a wall, rays of length %g", distance, reach);
    picture_expect_grey(p, name, PLANE_PATH_VISIBILITY, formula_corner_openness(distance, reach),
                        0);
    picture_free(&p);
    stage_free(&s);
}

void analytic_lights(void)
{
    rectangles();
    behind_a_light();
    small_lights();
    all_lights_together();
    light_in_a_mirror(false);
    light_in_a_mirror(true);
    for (int i = 0; i < 4; i++) light_seen(i & 1, i & 2);
    one_bounce();
    corner(0.25, 1);
    corner(0.5, 1);
    corner(0.9, 1);
    corner(1.1, 1);
    corner(0.5, 4);
}
