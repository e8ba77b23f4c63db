/* Building the scenes of analytic cases. */
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/golden/analytic.h"
#include "tests/golden/analytic_formula.h"

#define PI 3.14159265358979323846

struct stage *stage_new(void)
{
    struct stage *s = calloc(1, sizeof *s);
    if (s) s->f = calloc(1, sizeof *s->f);
    if (!s || !s->f) abort();
    s->scale = 1;
    s->plan = fixture_plan(STAGE_SIDE_PX, STAGE_SIDE_PX, (float[]){0, 0, 0}, POINT);
    s->plan.planes = PLANES_PATH & ~PLANE_BIT(PATH_VISIBILITY);
    s->plan.light_planes = 0;
    return s;
}

void stage_free(struct stage **s)
{
    free((void *)(uintptr_t)(*s)->map.blob);
    free((*s)->f);
    free(*s);
    *s = NULL;
}

static void place(const struct stage *s, const double in[3], float out[3])
{
    for (int i = 0; i < 3; i++) out[i] = (float)(s->scale * in[i] + s->shift[i]);
}

static void stretch(const struct stage *s, const double in[3], float out[3])
{
    for (int i = 0; i < 3; i++) out[i] = (float)(s->scale * in[i]);
}

struct scene_material *stage_material(struct stage *s, uint32_t *index)
{
    *index = fixture_material(s->f, 1, 1, 1);
    struct scene_material *m = &s->f->materials[*index];
    const struct scene_material bare = *m;
    *m = (struct scene_material){.base_color = {1, 1, 1, 1},
                                 .roughness = 1,
                                 .normal_scale = 1,
                                 .alpha_cutoff = 0.5f,
                                 .ior = 1.5f,
                                 .specular_color = {1, 1, 1},
                                 .attenuation = {1, 1, 1},
                                 .iridescence_ior = 1.3f,
                                 .model_specular = {0, 0, 0}};
    memcpy(&m->base_color_texture, &bare.base_color_texture, /* and all behind it: no textures */
           sizeof *m - offsetof(struct scene_material, base_color_texture));
    return m;
}

static void set3(float out[3], double x, double y, double z)
{
    out[0] = (float)x, out[1] = (float)y, out[2] = (float)z;
}

uint32_t stage_lambert(struct stage *s, double r, double g, double b)
{
    uint32_t index;
    set3(stage_material(s, &index)->base_color, r, g, b);
    return index;
}

uint32_t stage_emitter(struct stage *s, double r, double g, double b)
{
    uint32_t index;
    struct scene_material *m = stage_material(s, &index);
    set3(m->base_color, 0, 0, 0);
    set3(m->emission, r, g, b);
    return index;
}

static void add_quad(struct stage *s, const double c[3], const double u[3], const double v[3])
{
    float centre[3], half_u[3], half_v[3];
    place(s, c, centre);
    stretch(s, u, half_u);
    stretch(s, v, half_v);
    fixture_quad(s->f, centre, half_u, half_v);
}

uint32_t stage_panel(struct stage *s, uint32_t material, const double c[3], const double u[3],
                     const double v[3])
{
    uint32_t mesh = fixture_mesh(s->f, material, 0);
    add_quad(s, c, u, v);
    return fixture_place(s->f, mesh);
}

void stage_box(struct stage *s, uint32_t material, const double c[3], const double h[3],
               bool inwards)
{
    uint32_t mesh = fixture_mesh(s->f, material, 0);
    for (int axis = 0; axis < 3; axis++)
        for (int side = -1; side <= 1; side += 2) {
            double centre[3] = {c[0], c[1], c[2]}, u[3] = {0}, v[3] = {0};
            int a = (axis + 1) % 3, b = (axis + 2) % 3;
            centre[axis] += side * h[axis];
            u[a] = h[a];
            v[b] = (inwards ? -side : side) * h[b]; /* u x v points along side * axis outwards */
            add_quad(s, centre, u, v);
        }
    fixture_place(s->f, mesh);
}

enum { SLICES = 64, STACKS = 32 };

static void sphere_corner(const double c[3], double radius, int stack, int slice, double out[3])
{
    double polar = PI * stack / STACKS, azimuth = 2 * PI * slice / SLICES;
    out[0] = c[0] + radius * sin(polar) * cos(azimuth);
    out[1] = c[1] + radius * cos(polar);
    out[2] = c[2] + radius * sin(polar) * sin(azimuth);
}

static double add_triangle(struct stage *s, uint32_t a, uint32_t b, uint32_t c, bool inwards)
{
    const float *p = s->f->positions + 3 * (size_t)s->f->meshes[s->f->mesh_count - 1].first_vertex;
    double u[3], v[3], n[3];
    for (uint32_t i = 0; i < 3; i++) {
        u[i] = ((double)p[3 * b + i] - (double)p[3 * a + i]) / s->scale;
        v[i] = ((double)p[3 * c + i] - (double)p[3 * a + i]) / s->scale;
    }
    formula_cross(u, v, n);
    fixture_triangle(s->f, a, inwards ? c : b, inwards ? b : c);
    return sqrt(formula_dot(n, n)) / 2;
}

double stage_sphere(struct stage *s, uint32_t material, const double c[3], double radius,
                    bool inwards)
{
    uint32_t mesh = fixture_mesh(s->f, material, 0);
    double area = 0;
    for (int i = 0; i <= STACKS; i++)
        for (int j = 0; j < (i % STACKS ? SLICES : 1); j++) {
            double corner[3];
            float at[3];
            sphere_corner(c, radius, i, j, corner);
            place(s, corner, at);
            fixture_vertex(s->f, at[0], at[1], at[2]);
        }
    /* Vertex of (stack, slice): the pole, then rings. */
    const uint32_t last = 1 + (STACKS - 1) * SLICES;
    for (uint32_t j = 0; j < SLICES; j++) {
        uint32_t k = (j + 1) % SLICES, end = 1 + (STACKS - 2) * SLICES;
        area += add_triangle(s, 0, 1 + k, 1 + j, inwards);
        area += add_triangle(s, last, end + j, end + k, inwards);
        for (uint32_t i = 0; i < STACKS - 2; i++) {
            uint32_t a = 1 + i * SLICES + j, b = 1 + i * SLICES + k;
            area += add_triangle(s, a, b, b + SLICES, inwards);
            area += add_triangle(s, a, b + SLICES, a + SLICES, inwards);
        }
    }
    fixture_place(s->f, mesh);
    return area;
}

struct plan_light *stage_rectangle(struct stage *s, const double c[3], const double u[3],
                                   const double v[3], double radiance)
{
    struct plan_light *light = fixture_light(&s->plan, LIGHT_RECTANGLE, 1);
    double front[3];
    place(s, c, light->position);
    stretch(s, u, light->half_u);
    stretch(s, v, light->half_v);
    formula_cross(u, v, front);
    formula_normalise(front);
    set3(light->direction, front[0], front[1], front[2]);
    set3(light->color, radiance, radiance, radiance);
    return light;
}

struct plan_light *stage_lamp(struct stage *s, const double c[3], const double u[3],
                              const double v[3], double radiance)
{
    uint32_t mesh =
        fixture_mesh(s->f, stage_emitter(s, radiance, radiance, radiance), MESH_IS_LIGHT);
    add_quad(s, c, u, v);
    fixture_place(s->f, mesh);
    return stage_rectangle(s, c, u, v, radiance);
}

void stage_glow(struct stage *s, const double c[3], const double u[3], const double v[3],
                double radiance)
{
    stage_panel(s, stage_emitter(s, radiance, radiance, radiance), c, u, v);
    s->plan.paths.emitter_power = 1;
}

struct plan_light *stage_point(struct stage *s, const double position[3], double intensity)
{
    struct plan_light *light = fixture_light(&s->plan, LIGHT_POINT, 1);
    double scaled = intensity * s->scale * s->scale;
    place(s, position, light->position);
    set3(light->color, scaled, scaled, scaled);
    return light;
}

void stage_constant_environment(struct stage *s, double r, double g, double b)
{
    s->plan.environment = (struct plan_environment){.kind = ENVIRONMENT_CONSTANT, .power = 1};
    set3(s->plan.environment.radiance, r, g, b);
}

void stage_environment_map(struct stage *s, uint32_t width, uint32_t height,
                           double (*radiance)(double u, double v), double rotation_rad)
{
    size_t texels = (size_t)width * height;
    size_t size = sizeof(struct environment_header) + 3 * texels * sizeof(float);
    struct environment_header *header = aligned_alloc(64, (size + 63) / 64 * 64);
    struct fault fault = {0};
    double sum = 0, weights = 0;
    if (!header) abort();
    *header = (struct environment_header){.magic = ENVIRONMENT_MAGIC,
                                          .version = ENVIRONMENT_VERSION,
                                          .width_px = width,
                                          .height_px = height};
    float *rgb = (float *)(header + 1), most = 0;
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            double v = (y + 0.5) / height, weight = sin(PI * v);
            float *texel = rgb + 3 * ((size_t)y * width + x);
            texel[0] = texel[1] = texel[2] = (float)radiance((x + 0.5) / width, v);
            sum += weight * (double)texel[0];
            weights += weight;
            most = fmaxf(most, texel[0]);
        }
    for (int c = 0; c < 3; c++) header->mean[c] = (float)(sum / weights), header->maximum[c] = most;
    if (environment_open(header, size, &s->map, &fault)) {
        printf("Bail out! environment: %s\n", fault.detail);
        exit(1);
    }
    s->plan.environment = (struct plan_environment){.kind = ENVIRONMENT_MAP,
                                                    .radiance = {1, 1, 1},
                                                    .rotation_rad = (float)rotation_rad,
                                                    .power = 1};
}

void stage_look(struct stage *s, const double eye[3], const double target[3], double half)
{
    double forward[3], right[3], up[3], hint[3] = {0, 1, 0};
    for (int i = 0; i < 3; i++) forward[i] = target[i] - eye[i];
    formula_normalise(forward);
    if (fabs(forward[1]) > 0.99) hint[1] = 0, hint[2] = -1;
    formula_cross(forward, hint, right);
    formula_normalise(right);
    formula_cross(right, forward, up);
    place(s, eye, s->plan.camera.eye);
    set3(s->plan.camera.forward, forward[0], forward[1], forward[2]);
    set3(s->plan.camera.right, right[0], right[1], right[2]);
    set3(s->plan.camera.up, up[0], up[1], up[2]);
    s->plan.camera.half_width = (float)half;
    s->plan.camera.half_height = (float)half;
}
