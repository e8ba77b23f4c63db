/* Surfaces under a rectangle light, by quadrature over the light of the BSDF that worker/shade
 * evaluates (its own tests judge the models): frames, densities and the weights between light and
 * BSDF samples must be right for the picture to agree. Then coverage, Fresnel's mirrors. */
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/golden/analytic.h"
#include "tests/golden/analytic_formula.h"
#include "worker/scene/material/material.h"

static const double light_c[3] = {-0.8, 1.5, 0.3}, light_u[3] = {0.7, 0, 0},
                    light_v[3] = {0, 0, 0.5};
static const double eye[3] = {1.0, 1.6, 0.2}, origin[3] = {0, 0, 0};

/* What the floor does with light, and how its frame is turned from the tangent. */
struct floor {
    struct bsdf bsdf;
    float turn[2]; /* cosine, sine */
};

/* The stage's material, as workers make it. */
static struct floor floor_of(struct stage *s, uint32_t material)
{
    struct material_table *table = NULL;
    struct material_uv uv = {0};
    struct floor f;
    if (material_table_create(fixture_scene(s->f), &table)) abort();
    material_bsdf(&table->materials[material], &uv, false, &f.bsdf);
    material_tangent_angle(&table->materials[material], &uv, f.turn);
    material_table_destroy(&table);
    return f;
}

/* World to the floor's shading frame: z up; the tangent along +x, so that the bitangent is -z; both
 * turned. */
static void to_frame(const struct floor *f, const double w[3], float out[3])
{
    double unit[3] = {w[0], w[1], w[2]}, c = (double)f->turn[0], s = (double)f->turn[1];
    formula_normalise(unit);
    out[0] = (float)(c * unit[0] - s * unit[2]);
    out[1] = (float)(-s * unit[0] - c * unit[2]);
    out[2] = (float)unit[1];
}

/* Radiance towards the eye from the origin of the floor. */
static void reflected(const struct floor *floor, double radiance, double out[3])
{
    const struct bsdf *b = &floor->bsdf;
    enum { STEPS = 400 };
    float wo[3], wi[3];
    struct bsdf_value value;
    to_frame(floor, eye, wo);
    out[0] = out[1] = out[2] = 0;
    for (int i = 0; i < STEPS; i++)
        for (int j = 0; j < STEPS; j++) {
            double a = (2.0 * i + 1) / STEPS - 1, c = (2.0 * j + 1) / STEPS - 1, w[3];
            for (int k = 0; k < 3; k++) w[k] = light_c[k] + a * light_u[k] + c * light_v[k];
            double d2 = formula_dot(w, w), cosine = w[1] / sqrt(d2);
            to_frame(floor, w, wi);
            bsdf_evaluate(b, wo, wi, &value);
            for (int k = 0; k < 3; k++) {
                double f = (double)b->albedo[k] * (double)value.diffuse + (double)value.specular[k];
                out[k] += f * cosine * cosine / d2; /* the light faces straight down */
            }
        }
    for (int k = 0; k < 3; k++) out[k] *= radiance * 4 * 0.7 * 0.5 / ((double)STEPS * STEPS);
}

/* The floor with tangents along +x, that anisotropic models refer to. */
static void add_floor(struct stage *s, uint32_t material)
{
    stage_panel(s, material, origin, (double[]){0.5, 0, 0}, (double[]){0, 0, -0.5});
    struct scene_mesh *mesh = &s->f->meshes[s->f->mesh_count - 1];
    mesh->flags |= MESH_HAS_NORMALS | MESH_HAS_TANGENTS;
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        float *n = s->f->normals + 3 * (size_t)(mesh->first_normal + i);
        float *t = s->f->tangents + 4 * (size_t)(mesh->first_tangent + i);
        n[0] = n[2] = 0, n[1] = 1;
        t[0] = 1, t[1] = t[2] = 0, t[3] = 1;
    }
}

static void surface(const char *name, const struct scene_material *settings, bool as_mesh)
{
    const double radiance = 5;
    double expected[3];
    char whole[128];
    uint32_t index;
    struct stage *s = stage_new();
    struct scene_material *m = stage_material(s, &index);
    struct scene_material plain = *m;
    *m = *settings;
    memcpy(&m->base_color_texture, &plain.base_color_texture, /* and all behind it */
           sizeof *m - offsetof(struct scene_material, base_color_texture));
    add_floor(s, index);
    struct floor floor = floor_of(s, index);
    reflected(&floor, radiance, expected);
    if (as_mesh)
        stage_glow(s, light_c, light_u, light_v, radiance);
    else
        stage_rectangle(s, light_c, light_u, light_v, radiance);
    stage_look(s, eye, origin, POINT);
    struct picture *p = stage_trace(s);
    snprintf(whole, sizeof whole, "%s under %s", name, as_mesh ? "triangles" : "a rectangle");
    picture_expect(p, whole, PLANE_PATH_RADIANCE, expected, 1e-4);
    picture_free(&p);
    stage_free(&s);
}

#define GLTF                                                                                       \
    .base_color = {0.8f, 0.5f, 0.2f, 1}, .normal_scale = 1, .ior = 1.5f, .specular = 1,            \
    .specular_color = {1, 1, 1}, .attenuation = {1, 1, 1}
#define OTHER                                                                                      \
    .base_color = {0.4f, 0.3f, 0.2f, 1}, .normal_scale = 1, .ior = 1.5f,                           \
    .specular_color = {1, 1, 1}, .attenuation = {1, 1, 1}, .model_specular = {0.5f, 0.4f, 0.3f}

static void surfaces(void)
{
    static const struct {
        const char *name;
        struct scene_material material;
    } all[] = {
        {"Lambert", {OTHER, .roughness = 1}},
        {"rough metal", {GLTF, .metallic = 1, .roughness = 0.6f}},
        {"smooth metal", {GLTF, .metallic = 1, .roughness = 0.15f}},
        {"plastic", {GLTF, .roughness = 0.3f}},
        {"half metal", {GLTF, .metallic = 0.5f, .roughness = 0.4f}},
        {"anisotropic metal",
         {GLTF, .metallic = 1, .roughness = 0.4f, .anisotropy = 0.8f, .anisotropy_rad = 0.5f}},
        {"a coat", {GLTF, .roughness = 0.6f, .clearcoat = 0.8f, .clearcoat_roughness = 0.4f}},
        {"velvet",
         {GLTF, .roughness = 0.8f, .sheen_color = {0.3f, 0.2f, 0.9f}, .sheen_roughness = 0.4f}},
        {"a leaf",
         {GLTF, .roughness = 0.6f, .diffuse_transmission = 0.5f,
          .diffuse_transmission_color = {1, 1, 1}}},
        {"a soap film",
         {GLTF, .roughness = 0.4f, .iridescence = 1, .iridescence_ior = 1.6f,
          .iridescence_nm = {0, 350}}},
        {"Phong", {OTHER, .model = MODEL_PHONG, .exponent_u = 50}},
        {"Blinn-Phong", {OTHER, .model = MODEL_BLINN_PHONG, .exponent_u = 200}},
        {"Beckmann", {OTHER, .model = MODEL_BECKMANN, .alpha_u = 0.2f, .alpha_v = 0.2f}},
        {"a Beckmann conductor",
         {OTHER, .model = MODEL_BECKMANN, .alpha_u = 0.1f, .alpha_v = 0.1f,
          .eta = {0.200438f, 0.924033f, 1.10221f}, .k = {3.91295f, 2.45285f, 2.14219f}}},
        {"Ashikhmin-Shirley",
         {OTHER, .model = MODEL_ASHIKHMIN_SHIRLEY, .exponent_u = 10, .exponent_v = 400}},
        {"a measured surface",
         {OTHER, .model = MODEL_MEASURED, .alpha_u = 0.15f, .second_specular = {0.1f, 0.05f, 0.2f},
          .second_alpha = 0.5f, .grazing = {0.3f, 0.6f}}},
        {"Kelemen", {OTHER, .model = MODEL_KELEMEN, .alpha_u = 0.2f, .alpha_v = 0.2f}},
        {"Ward", {OTHER, .model = MODEL_WARD, .alpha_u = 0.4f, .alpha_v = 0.1f}},
    };
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        surface(all[i].name, &all[i].material, false);
        surface(all[i].name, &all[i].material, true);
    }
}

/* Smooth surfaces show the environment times Schlick's Fresnel. */
static void fresnel(bool metallic)
{
    const double f0[3] = {metallic ? 0.9 : 0.04, metallic ? 0.5 : 0.04, metallic ? 0.2 : 0.04};
    double expected[3];
    uint32_t index;
    struct stage *s = stage_new();
    struct scene_material *m = stage_material(s, &index);
    m->metallic = metallic;
    m->roughness = 0;
    m->specular = 1;
    for (int c = 0; c < 3; c++) m->base_color[c] = metallic ? (float)f0[c] : 0.0f;
    stage_panel(s, index, origin, (double[]){1, 0, 0}, (double[]){0, 0, -1});
    stage_constant_environment(s, 1, 1, 1);
    stage_look(s, (double[]){4, 1, 0}, origin, POINT);
    for (int c = 0; c < 3; c++) expected[c] = formula_schlick(f0[c], 1 / sqrt(17));
    struct picture *p = stage_trace(s);
    picture_expect(p, metallic ? "a polished metal, aslant" : "polished black glass, aslant",
                   PLANE_PATH_RADIANCE, expected, 1e-4);
    picture_free(&p);
    stage_free(&s);
}

/* A quarter of a sheet is there: three quarters of what is behind shine through. */
static uint32_t gauze(struct stage *s, double rho)
{
    uint32_t index = stage_lambert(s, rho, rho, rho);
    s->f->materials[index].alpha_mode = ALPHA_BLEND;
    s->f->materials[index].base_color[3] = 0.25f;
    return index;
}

static void coverage(void)
{
    const double rho = 0.8, pi = 3.14159265358979323846;
    const double u[3] = {1, 0, 0}, v[3] = {0, 0, -1};
    struct stage *s = stage_new();
    stage_panel(s, gauze(s, 0), (double[]){0, 1, 0}, u, v);
    stage_panel(s, stage_emitter(s, 4, 4, 4), origin, u, v);
    s->plan.paths.emitter_power = 1;
    stage_look(s, (double[]){0.2, 3, 0.1}, origin, 0.05);
    struct picture *p = stage_trace(s);
    picture_expect_grey(p, "an emitter behind a sheet of alpha 0.25", PLANE_PATH_RADIANCE, 3, 0);
    picture_free(&p);
    stage_free(&s);

    s = stage_new();
    stage_panel(s, gauze(s, rho), origin, u, v);
    stage_constant_environment(s, 1, 1, 1);
    stage_look(s, (double[]){0.2, 3, 0.1}, origin, 0.05);
    p = stage_trace(s);
    picture_expect_grey(p, "a sheet of alpha 0.25 under constant light", PLANE_PATH_RADIANCE,
                        0.75 + 0.25 * rho, 0);
    picture_free(&p);
    stage_free(&s);

    s = stage_new();
    /* Off its diagonal, where rays may meet both triangles. */
    stage_panel(s, gauze(s, 0), (double[]){0.7, 1, 0.2}, (double[]){4, 0, 0}, (double[]){0, 0, -4});
    stage_panel(s, stage_lambert(s, rho, rho, rho), origin, u, v);
    stage_point(s, (double[]){0, 2, 0}, 5);
    stage_look(s, (double[]){0.1, 0.9, 0.5}, origin, POINT);
    p = stage_trace(s);
    picture_expect_grey(p, "light through a sheet of alpha 0.25", PLANE_PATH_RADIANCE,
                        0.75 * rho / pi * 5 / 4, 0);
    picture_free(&p);
    stage_free(&s);
}

/* Paper that reflects 0.3 of light and lets 0.4, 0.2, 0.1 through. */
static uint32_t paper(struct stage *s)
{
    static const float color[3] = {0.8f, 0.4f, 0.2f};
    uint32_t index;
    struct scene_material *m = stage_material(s, &index);
    m->diffuse_transmission = 0.5f;
    for (int k = 0; k < 3; k++)
        m->base_color[k] = 0.6f, m->diffuse_transmission_color[k] = color[k];
    return index;
}

static const double pi = 3.14159265358979323846;

/* Looks at the paper from above, and expects what it lets through of this irradiance below. */
static void expect_through(struct stage *s, const char *name, double irradiance, double besides)
{
    const double expected[3] = {besides + 0.4 * irradiance / pi, besides + 0.2 * irradiance / pi,
                                besides + 0.1 * irradiance / pi};
    stage_panel(s, paper(s), origin, (double[]){0.5, 0, 0}, (double[]){0, 0, -0.5});
    stage_look(s, (double[]){0.3, 1.5, 0.1}, origin, POINT);
    struct picture *p = stage_trace(s);
    picture_expect(p, name, PLANE_PATH_RADIANCE, expected, 1e-4);
    picture_free(&p);
    stage_free(&s);
}

/* Lights behind paper: without extent, with a light sample, by scattering, or both. */
static void translucence(void)
{
    enum { STEPS = 400 };
    const double below[3] = {-0.4, -1.1, 0.3}, u[3] = {0, 0, 0.5}, v[3] = {0.7, 0, 0};
    double irradiance = 0;
    for (int i = 0; i < STEPS; i++)
        for (int j = 0; j < STEPS; j++) {
            const double a = (2.0 * i + 1) / STEPS - 1, b = (2.0 * j + 1) / STEPS - 1;
            double w[3];
            for (int k = 0; k < 3; k++) w[k] = below[k] + a * u[k] + b * v[k];
            const double d2 = formula_dot(w, w);
            irradiance += 5 * w[1] * w[1] / (d2 * d2) * 4 * 0.5 * 0.7 / ((double)STEPS * STEPS);
        }
    struct stage *s = stage_new();
    stage_point(s, (double[]){0, -2, 0}, 5);
    expect_through(s, "a point behind paper", 5.0 / 4, 0);
    s = stage_new();
    stage_rectangle(s, below, u, v, 5);
    expect_through(s, "a rectangle behind paper", irradiance, 0);
    s = stage_new();
    stage_glow(s, below, u, v, 5);
    expect_through(s, "triangles behind paper", irradiance, 0);
    s = stage_new();
    stage_rectangle(s, below, u, v, 5);
    stage_point(s, (double[]){0, -2, 0}, 5);
    stage_constant_environment(s, 1, 1, 1);
    expect_through(s, "several lights behind paper and before it", irradiance + 5.0 / 4 + pi, 0.3);
}

void analytic_surfaces(void)
{
    translucence();
    surfaces();
    fresnel(false);
    fresnel(true);
    coverage();
}
