/* Where light fields bring direct light of listed lights, as diffuse lobes send it on, and paths
 * all else: what both add up to, beside an environment and meshes that shine. */
#include <stdio.h>
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/trace/field/field_room.h"

#define PI 3.14159265358979323846

enum indirect { OF_PATHS, OF_FIELDS };

/* Leaves direct light of the plan's lights to fields, and indirect light of diffuse lobes, too. */
static void divide(struct plan *p, enum indirect indirect)
{
    if (indirect == OF_FIELDS) add_field(p, 8);
    p->paths.without_diffuse_direct = DIRECT_LEFT_LISTED;
    p->planes |= PLANES_CENTRE | BIT(ALBEDO);
    p->light_planes = 1u << LIGHT_PLANE_IRRADIANCE;
    for (uint32_t k = 0; k < p->light_count; k++)
        if (p->lights[k].type == LIGHT_RECTANGLE) p->lights[k].strata_per_axis = 8;
}

static double direct_at(const struct plan *p, const struct samples *s, uint32_t c, int i)
{
    double sum = 0;
    for (uint32_t k = 0; k < p->light_count; k++)
        sum += (double)samples_light_irradiance(s, k)[i] * (double)p->lights[k].color[c];
    return samples_u16(s, PLANE_ALBEDO, c)[i] / 65535.0 * sum / PI;
}

/* Adds what fields bring. */
static void add_fields(const struct plan *p, struct sums *s)
{
    for (uint32_t c = 0; c < 3; c++)
        for (int i = 0; i < AREA; i++) {
            s->radiance[c][i] += direct_at(p, s->first, c, i);
            if (p->planes & BIT(INDIRECT_MEAN))
                s->radiance[c][i] += field_at(s->first, c, i) / (double)p->radiance_scale;
        }
}

/* Scattered rays often meet such a lamp. */
static void widen(struct plan_light *lamp)
{
    for (int c = 0; c < 3; c++) lamp->half_u[c] *= 4, lamp->half_v[c] *= 4, lamp->color[c] /= 8;
}

/* Of all pictures together, whose noise is less than that of each. */
struct total {
    double whole[3], divided[3];
};

static void expect_whole(enum kind kind, uint32_t shines, enum indirect indirect, struct total *sum)
{
    struct scene_fixture *f = fixture_new();
    struct plan entire = room(f, kind, shines);
    entire.bounces = 2;
    entire.paths.spp = 64;
    if (shines & SHINES_RECT) widen(&entire.lights[0]);
    struct plan divided = entire;
    char what[64];
    divide(&divided, indirect);
    struct sums *a = trace_sums(f, &entire), *b = trace_sums(f, &divided);
    double before = 0, after = 0;
    for (int i = 0; i < AREA; i++) before += b->radiance[0][i];
    add_fields(&divided, b);
    for (int i = 0; i < AREA; i++) after += b->radiance[0][i];
    assert_true(kind == METAL || kind == BRUSHED ? after == before : after > 1.02 * before);
    snprintf(what, sizeof what, "kind %d, light %u, indirect %d", kind, shines, indirect);
    for (int c = 0; c < 3; c++) {
        expect_same(what, a->radiance[c], b->radiance[c], 0.02);
        for (int i = 0; i < AREA; i++) {
            sum->whole[c] += a->radiance[c][i];
            sum->divided[c] += b->radiance[c][i];
        }
    }
    sums_free(&a);
    sums_free(&b);
    free(f);
}

/* Every surface under all lights, and every other of these pairs with indirect light of fields. */
TEST(fields_and_paths_are_whole_paths)
{
    static const uint32_t lights[] = {
        SHINES_RECT | SHINES_SKY,  SHINES_RECT | SHINES_MAP,
        SHINES_RECT | SHINES_MESH, SHINES_POINT | SHINES_MAP,
        SHINES_POINT | SHINES_SKY, SHINES_RECT | SHINES_POINT | SHINES_MESH | SHINES_MAP};
    struct total sum = {{0}, {0}};
    for (int kind = 0; kind < KIND_COUNT; kind++)
        for (int k = 0; k < (int)(sizeof lights / sizeof lights[0]); k++)
            expect_whole((enum kind)kind, lights[k], (kind + k) % 2 ? OF_FIELDS : OF_PATHS, &sum);
    for (int c = 0; c < 3; c++) {
        const double off = sum.divided[c] / sum.whole[c] - 1;
        print_message("channel %d: %+.4f\n", c, off);
        assert_true(fabs(off) < 0.003);
    }
}

/* Lambert surfaces ask the environment alone: a constant one gets no shadow rays. */
TEST(paths_ask_no_light_that_fields_bring)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f, LAMBERT, SHINES_RECT | SHINES_SKY);
    divide(&p, OF_PATHS);
    struct sums *s = trace_sums(f, &p);
    assert_int_equal(s->counters.value[COUNTER_RAYS_SHADOW], AREA * 8 * 8);
    sums_free(&s);
    p.environment.kind = ENVIRONMENT_MAP;
    s = trace_sums(f, &p);
    assert_true(s->counters.value[COUNTER_RAYS_SHADOW] > AREA * (8 * 8 + p.paths.spp / 4));
    sums_free(&s);
    free(f);
}

static double emission_of(const struct samples *s, enum plane_id plane, uint32_t c)
{
    double sum = 0;
    for (int i = 0; i < AREA; i++) sum += (double)samples_f32(s, plane, c)[i];
    return sum / AREA;
}

/* The camera sees a panel that shines, one that a light stands for, and the sky between them. */
TEST(what_shines_is_seen_once)
{
    struct scene_fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    const uint32_t glow = fixture_material(f, 0, 0, 0);
    f->materials[glow].emission[0] = 3.0f;
    fixture_panel(f, glow, (float[]){-0.625f, 0, 0}, (float[]){0.25f, 0, 0},
                  (float[]){0, 0, -0.5f});
    fixture_panel(f, glow, (float[]){0.625f, 0, 0}, (float[]){0.25f, 0, 0}, (float[]){0, 0, -0.5f});
    f->meshes[1].flags |= MESH_IS_LIGHT;
    struct plan p = fixture_plan(SIDE_PX, SIDE_PX, (float[]){0, 1, 0}, 1.0f);
    fixture_look(&p, (float[]){0, -1, 0}, (float[]){0, 0, -1});
    fixture_light(&p, LIGHT_POINT, 1);
    p.environment = (struct plan_environment){
        .kind = ENVIRONMENT_CONSTANT, .radiance = {0.5f, 0.6f, 0.7f}, .power = 1.0f};
    p.light_planes = 0;
    p.planes = BIT(PATH_RADIANCE) | BIT(PATH_DIRECT) | BIT(PATH_INDIRECT) | BIT(PATH_EMISSION);
    p.paths.spp = 16;
    struct plan divided = p;
    divide(&divided, OF_PATHS);
    divided.planes |= BIT(EMISSION);
    struct sums *a = trace_sums(f, &p), *b = trace_sums(f, &divided);
    const double sky = emission_of(b->first, PLANE_PATH_EMISSION, 2) / 16;
    assert_true(fabs(emission_of(a->first, PLANE_PATH_EMISSION, 2) / 16 - sky) < 1e-6);
    assert_true(sky > 0.4 && sky < 0.6);
    const double whole = emission_of(a->first, PLANE_PATH_EMISSION, 0) / 16;
    double rest = 0;
    for (int i = 0; i < AREA; i++)
        rest += half_at(b->first, PLANE_EMISSION, 0, i) / (double)p.radiance_scale / AREA;
    const double paths = emission_of(b->first, PLANE_PATH_EMISSION, 0) / 16;
    assert_true(fabs(paths - sky * 5 / 7) < 1e-5 && rest > 0.5);
    if (fabs(rest + paths - whole) > 1e-3 * whole) fail_msg("%g and %g of %g", paths, rest, whole);
    sums_free(&a);
    sums_free(&b);
    free(f);
}
