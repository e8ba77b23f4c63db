#include "tests/unit/worker/trace/field/field_room.h"

#include <stdlib.h>

static uint32_t add_material(struct scene_fixture *f, enum kind kind)
{
    uint32_t index = fixture_material(f, 0.8f, 0.5f, 0.3f);
    struct scene_material *m = &f->materials[index];
    switch (kind) {
    case DIELECTRIC:
        m->specular = 1.0f;
        m->roughness = 0.5f;
        break;
    case COATED: /* a sharp, strong layer, half a metal */
        m->specular = 1.0f;
        m->roughness = 0.25f;
        m->ior = 2.5f;
        m->metallic = 0.5f;
        break;
    case PHONG:
        m->model = MODEL_PHONG;
        m->model_specular[0] = m->model_specular[1] = m->model_specular[2] = 0.2f;
        m->exponent_u = m->exponent_v = 12.0f;
        break;
    case ASHIKHMIN:
        m->model = MODEL_ASHIKHMIN_SHIRLEY;
        m->model_specular[0] = m->model_specular[1] = m->model_specular[2] = 0.3f;
        m->exponent_u = 5.0f;
        m->exponent_v = 50.0f;
        break;
    case BRUSHED:
        m->specular = m->metallic = 1.0f;
        m->roughness = 0.3f;
        m->anisotropy = 0.7f;
        break;
    case BECKMANN:
        m->model = MODEL_BECKMANN;
        m->model_specular[0] = m->model_specular[1] = m->model_specular[2] = 0.2f;
        m->alpha_u = m->alpha_v = 0.3f;
        break;
    case WARD:
        m->model = MODEL_WARD;
        m->model_specular[0] = m->model_specular[1] = m->model_specular[2] = 0.2f;
        m->alpha_u = 0.1f;
        m->alpha_v = 0.4f;
        break;
    case KELEMEN:
        m->model = MODEL_KELEMEN;
        m->model_specular[0] = m->model_specular[1] = m->model_specular[2] = 0.3f;
        m->alpha_u = m->alpha_v = 0.2f;
        break;
    case BLINN:
        m->model = MODEL_BLINN_PHONG;
        m->model_specular[0] = m->model_specular[1] = m->model_specular[2] = 0.3f;
        m->exponent_u = m->exponent_v = 60.0f;
        break;
    case METAL:
        m->specular = 1.0f;
        m->metallic = 1.0f;
        m->roughness = 0.4f;
        break;
    default:
        break;
    }
    return index;
}

struct plan room(struct scene_fixture *f, enum kind kind, uint32_t shines)
{
    uint32_t floor = add_material(f, kind), red = fixture_material(f, 0.8f, 0.2f, 0.2f);
    uint32_t white = fixture_material(f, 0.9f, 0.9f, 0.9f), glossy = add_material(f, DIELECTRIC);
    fixture_panel(f, floor, (float[]){0, 0, 0}, (float[]){3, 0, 0}, (float[]){0, 0, -3});
    fixture_panel(f, red, (float[]){-1, 1, 0}, (float[]){0, 0, -2}, (float[]){0, 1, 0});
    fixture_panel(f, glossy, (float[]){0, 1, -1.5f}, (float[]){2, 0, 0}, (float[]){0, 1, 0});
    fixture_panel(f, white, (float[]){1, 1.2f, 0}, (float[]){0.5f, 0, 0}, (float[]){0, 0, 0.5f});
    struct plan p = fixture_plan(SIDE_PX, SIDE_PX, (float[]){0, 2, 2}, 1e-4f);
    fixture_look(&p, (float[]){0, -0.70710678f, -0.70710678f},
                 (float[]){0, 0.70710678f, -0.70710678f});
    if (shines & SHINES_RECT) {
        struct plan_light *light = fixture_ceiling_light(&p, 0.2f, 2.5f, 0, 0.5f, 1);
        light->color[0] = light->color[1] = light->color[2] = 6.0f;
    }
    if (shines & SHINES_POINT) fixture_light(&p, LIGHT_POINT, 1)->position[1] = 1.5f;
    if (shines & SHINES_MESH) {
        uint32_t glow = fixture_material(f, 0, 0, 0);
        f->materials[glow].emission[0] = f->materials[glow].emission[2] = 5.0f;
        fixture_panel(f, glow, (float[]){1.5f, 0.5f, 0.5f}, (float[]){0, 0, 0.3f},
                      (float[]){0, 0.3f, 0});
        p.paths.emitter_power = 0.5f;
    }
    if (shines & (SHINES_SKY | SHINES_MAP))
        p.environment = (struct plan_environment){
            .kind = shines & SHINES_MAP ? ENVIRONMENT_MAP : ENVIRONMENT_CONSTANT,
            .radiance = {0.5f, 0.6f, 0.7f},
            .power = 1.0f};
    p.light_planes = 0;
    p.planes = BIT(PATH_RADIANCE) | BIT(PATH_DIRECT) | BIT(PATH_INDIRECT) | BIT(PATH_EMISSION);
    p.paths.spp = 256;
    return p;
}

void add_field(struct plan *p, uint32_t l)
{
    p->planes |= BIT(DEPTH) | BIT(NORMAL) | BIT(ALBEDO) | BIT(ID) | BIT(INDIRECT_MEAN) |
                 BIT(BOUNCE_DISTANCE_MIN);
    p->indirect_strata_per_axis = l;
    p->paths.without_diffuse_indirect = p->paths.spp > 0;
}

static void add_plane(const struct samples *s, enum plane_id plane, double sum[3][AREA],
                      uint32_t spp)
{
    for (uint32_t c = 0; c < 3; c++)
        for (int i = 0; i < AREA; i++) sum[c][i] += (double)samples_f32(s, plane, c)[i] / spp;
}

struct sums *trace_sums(struct scene_fixture *f, const struct plan *p)
{
    static const float texels[3 * 32] = {[0] = 40, [1] = 30, [2] = 10, [40] = 2, [41] = 3};
    struct sums *out = calloc(1, sizeof *out);
    struct render_scene *scene;
    struct tile_tracer *tracer;
    struct environment_fixture map = {0};
    struct fault fault = {0};
    assert_non_null(out);
    if (p->environment.kind == ENVIRONMENT_MAP) environment_fixture_open(&map, 8, 4, texels);
    assert_int_equal(render_scene_create(fixture_scene(f), 1, NULL, &scene, &fault), 0);
    assert_int_equal(tile_tracer_create(&tracer), 0);
    for (uint32_t pass = 0; pass < plan_pass_count(p); pass++) {
        struct samples *s = NULL;
        assert_int_equal(
            tile_trace(tracer,
                       &(struct tile_job){.scene = scene,
                                          .environment = map.map,
                                          .plan = p,
                                          .rect = (struct rect){0, 0, SIDE_PX, SIDE_PX},
                                          .counters = &out->counters},
                       pass, &s),
            0);
        if (p->paths.spp > 0) {
            add_plane(s, PLANE_PATH_RADIANCE, out->radiance, p->paths.spp);
            add_plane(s, PLANE_PATH_DIRECT, out->direct, p->paths.spp);
            add_plane(s, PLANE_PATH_INDIRECT, out->indirect, p->paths.spp);
        }
        if (pass == 0)
            out->first = s;
        else
            samples_destroy(&s);
    }
    tile_tracer_destroy(&tracer);
    render_scene_destroy(&scene);
    if (map.map) environment_fixture_close(&map);
    return out;
}

void sums_free(struct sums **s)
{
    samples_destroy(&(*s)->first);
    free(*s);
    *s = NULL;
}

static void mean_of(const double *v, double *mean, double *error)
{
    double sum = 0, squares = 0;
    for (int i = 0; i < AREA; i++) sum += v[i];
    for (int i = 0; i < AREA; i++) squares += (v[i] - sum / AREA) * (v[i] - sum / AREA);
    *mean = sum / AREA;
    *error = sqrt(squares / (AREA - 1) / AREA);
}

void expect_same(const char *what, const double *a, const double *b, double most_error)
{
    double mean_a, mean_b, error_a, error_b;
    mean_of(a, &mean_a, &error_a);
    mean_of(b, &mean_b, &error_b);
    double error = sqrt(error_a * error_a + error_b * error_b);
    if (!(fabs(mean_a - mean_b) <= 4 * error + 1e-4 * mean_a) || !(error <= most_error * mean_a))
        fail_msg("%s: %.6g and %.6g, standard error %.2g", what, mean_a, mean_b, error);
}
