#include "tests/property/stage.h"

#include <math.h>
#include <stdlib.h>

#include "tests/property/dress.h"
#include "tests/property/sky.h"

double stage_scale(const struct change *change)
{
    return change->scale > 0 ? change->scale : 1;
}

double stage_gain(const struct change *change)
{
    return change->gain > 0 ? change->gain : 1;
}

void stage_turn(const struct change *change, const double in[3], double out[3])
{
    double x = change->mirrored ? -in[0] : in[0], y = in[1], z = in[2];
    for (int i = 0; i < change->turns; i++) {
        const double was = x;
        x = z;
        z = -was;
    }
    out[0] = x, out[1] = y, out[2] = z;
}

void stage_place(const struct change *change, const double in[3], double out[3])
{
    stage_turn(change, in, out);
    for (int i = 0; i < 3; i++) out[i] = out[i] * stage_scale(change) + change->shift[i];
}

void stage_frame(int facing, double u[3], double v[3])
{
    const int axis = facing % 3;
    for (int i = 0; i < 3; i++) u[i] = v[i] = 0;
    u[(axis + 1) % 3] = 1;
    v[(axis + 2) % 3] = facing < 3 ? 1 : -1;
}

static void to_floats(const double in[3], double scale, float out[3])
{
    for (int i = 0; i < 3; i++) out[i] = (float)(in[i] * scale);
}

/* A parallelogram by its middle and half sides, which are of the case. A mirror turns fronts about.
 */
static void add_quad(struct scene_fixture *f, const struct change *change,
                     const struct case_body *body, const double c[3], const double u[3],
                     const double v[3])
{
    double centre[3], half_u[3], half_v[3];
    float at[3], a[3], b[3];
    stage_place(change, c, centre);
    stage_turn(change, u, half_u);
    stage_turn(change, v, half_v);
    to_floats(centre, 1, at);
    to_floats(half_u, stage_scale(change), a);
    to_floats(half_v, stage_scale(change), b);
    const float *right = change->mirrored ? b : a, *down = change->mirrored ? a : b;
    fixture_quad(f, at, right, down);
    dress_quad(f, body, right, down);
}

static void add_triangle(struct scene_fixture *f, const struct change *change, double corner[3][3])
{
    uint32_t index[3];
    for (int i = 0; i < 3; i++) {
        double at[3];
        stage_place(change, corner[i], at);
        index[i] = fixture_vertex(f, (float)at[0], (float)at[1], (float)at[2]);
    }
    fixture_triangle(f, index[0], index[change->mirrored ? 2 : 1], index[change->mirrored ? 1 : 2]);
}

static void add_panel(struct scene_fixture *f, const struct change *change,
                      const struct case_body *b)
{
    double u[3], v[3];
    stage_frame(b->facing, u, v);
    for (int i = 0; i < 3; i++) u[i] *= b->size[i], v[i] *= b->size[i];
    add_quad(f, change, b, b->centre, u, v);
}

static void add_box(struct scene_fixture *f, const struct change *change, const struct case_body *b,
                    bool inwards)
{
    for (int facing = 0; facing < 6; facing++) {
        double u[3], v[3], c[3] = {b->centre[0], b->centre[1], b->centre[2]};
        stage_frame(inwards ? (facing + 3) % 6 : facing, u, v);
        c[facing % 3] += (facing < 3 ? 1 : -1) * b->size[facing % 3];
        for (int i = 0; i < 3; i++) u[i] *= b->size[i], v[i] *= b->size[i];
        add_quad(f, change, b, c, u, v);
    }
}

static void add_needle(struct scene_fixture *f, const struct change *change,
                       const struct case_body *b)
{
    double u[3], v[3], corner[3][3];
    stage_frame(b->facing, u, v);
    for (int i = 0; i < 3; i++) {
        corner[0][i] = b->centre[i];
        corner[1][i] = b->centre[i] + 4 * b->size[i] * u[i];
        corner[2][i] = corner[1][i] + CASE_GRID / 64 * v[i];
    }
    add_triangle(f, change, corner);
}

/* Three corners in a line, and three in one place. */
static void add_point(struct scene_fixture *f, const struct change *change,
                      const struct case_body *b)
{
    double u[3], v[3], corner[3][3];
    stage_frame(b->facing, u, v);
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) corner[k][i] = b->centre[i] + k * b->size[i] * u[i];
    add_triangle(f, change, corner);
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) corner[k][i] = b->centre[i];
    add_triangle(f, change, corner);
}

static void set_model(struct scene_material *m, uint32_t model, const struct case_body *b)
{
    /* Exponents from 0 to 100,000. */
    const float exponent = (float)(b->sharpness > 0 ? pow(10, 5 * b->sharpness) : 0);
    m->model = model;
    /* Mirrors have none, as importers have it. */
    m->base_color[0] = m->base_color[1] = m->base_color[2] = model == MODEL_MIRROR ? 0 : 0.2f;
    to_floats(b->albedo, 0.8, m->model_specular);
    /* The same both ways: without tangents nothing says which is which. */
    m->exponent_u = m->exponent_v = exponent;
    m->alpha_u = m->alpha_v = (float)(0.001 + 0.999 * (1 - b->sharpness));
}

static void set_surface(struct scene_material *m, const struct case_body *b,
                        const struct change *change)
{
    static const uint32_t models[SURFACES] = {[SURFACE_MIRROR] = MODEL_MIRROR,
                                              [SURFACE_PHONG] = MODEL_PHONG,
                                              [SURFACE_BLINN] = MODEL_BLINN_PHONG,
                                              [SURFACE_ASHIKHMIN] = MODEL_ASHIKHMIN_SHIRLEY,
                                              [SURFACE_BECKMANN] = MODEL_BECKMANN};
    to_floats(b->albedo, b->surface == SURFACE_BLACK || b->surface == SURFACE_EMITTER ? 0 : 1,
              m->base_color);
    m->specular = 0;
    if (b->surface == SURFACE_EMITTER && !change->no_emitters)
        to_floats(b->albedo, 4 * stage_gain(change), m->emission);
    if (b->surface == SURFACE_FURNACE) to_floats((double[]){1, 1, 1}, 1, m->emission);
    if (b->surface == SURFACE_GLOSSY || b->surface == SURFACE_METAL ||
        b->surface == SURFACE_GLASS) {
        m->specular = 1;
        m->roughness = (float)(1 - b->sharpness);
        m->metallic = b->surface == SURFACE_METAL;
        m->transmission = b->surface == SURFACE_GLASS;
    } else if (models[b->surface]) {
        set_model(m, models[b->surface], b);
    }
}

static void add_body(struct scene_fixture *f, const struct change *change,
                     const struct case_body *b)
{
    const uint32_t material = fixture_material(f, 1, 1, 1);
    set_surface(&f->materials[material], b, change);
    dress_material(f, material, b, change->no_emitters ? 0 : stage_gain(change));
    const uint32_t mesh =
        fixture_mesh(f, material, dress_has_normals(b) ? MESH_HAS_NORMALS | MESH_HAS_TANGENTS : 0);
    switch (b->shape) {
    case BODY_PANEL:
        add_panel(f, change, b);
        break;
    case BODY_BOX:
        add_box(f, change, b, false);
        break;
    case BODY_ROOM:
        add_box(f, change, b, true);
        break;
    case BODY_NEEDLE:
        add_needle(f, change, b);
        break;
    default:
        add_point(f, change, b);
    }
    fixture_place(f, mesh);
}

static void set_bounds(struct scene_fixture *f)
{
    for (int i = 0; i < 3; i++) f->info.bounds_min[i] = INFINITY, f->info.bounds_max[i] = -INFINITY;
    for (uint32_t k = 0; k < 3 * f->vertex_count; k++) {
        f->info.bounds_min[k % 3] = fminf(f->info.bounds_min[k % 3], f->positions[k]);
        f->info.bounds_max[k % 3] = fmaxf(f->info.bounds_max[k % 3], f->positions[k]);
    }
    f->info.placed_triangles = f->triangle_count;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        out[i] = a[j] * b[k] - a[k] * b[j];
    }
}

/* As high as the field of view is at the target. */
static void set_camera(const struct property_case *c, const struct change *change,
                       struct scene_camera *out)
{
    double ahead[3], eye[3], forward[3], right[3], up[3];
    for (int i = 0; i < 3; i++) ahead[i] = c->target[i] - c->eye[i];
    const double distance = sqrt(dot(ahead, ahead));
    stage_place(change, c->eye, eye);
    stage_turn(change, ahead, forward);
    cross(forward, (double[]){0, 1, 0}, right);
    cross(right, forward, up);
    *out = (struct scene_camera){.type = CAMERA_ORTHOGRAPHIC};
    out->half_height = (float)(distance * tan(c->yfov_deg * M_PI / 360) * stage_scale(change));
    out->half_width = out->half_height;
    to_floats(eye, 1, out->eye);
    to_floats(forward, 1 / distance, out->forward);
    to_floats(right, 1 / sqrt(dot(right, right)), out->right);
    to_floats(up, 1 / sqrt(dot(up, up)), out->up);
}

void stage_build(const struct property_case *c, const struct change *change, struct stage *out)
{
    struct scene_fixture *f = calloc(1, sizeof *f);
    if (!f) abort();
    for (int i = 0; i < c->body_count; i++) add_body(f, change, &c->bodies[i]);
    set_bounds(f);
    fixture_scene(f);
    f->scene.count[SCENE_TRIANGLES] = f->triangle_count;
    f->scene.count[SCENE_POSITIONS] = f->vertex_count;
    f->scene.count[SCENE_NAMES] = 1;
    *out = (struct stage){.fixture = f, .scene = &f->scene};
    if (sky_has_map(c, change)) sky_build(c, change, &out->map);
    if (!c->orthographic) return;
    set_camera(c, change, &out->camera);
    f->scene.cameras = &out->camera;
    f->scene.count[SCENE_CAMERAS] = 1;
}

void stage_free(struct stage *stage)
{
    free(stage->fixture);
    free((void *)(uintptr_t)stage->map.blob);
}
