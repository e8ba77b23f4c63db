/* A replayed sample is the traced one, bit by bit, and its steps add up to it. */
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"
#include "worker/replay/replay.h"
#include "worker/replay/sample_replay.h"
#include "worker/scene/light_table.h"

enum { SIDE_PX = 12, SPP = 80 }; /* passes of 16, 16, 32 and 16 */

/* A coloured floor, a rough metal wall, glossy box top, a thin glass pane, two lights and a mesh
 * that shines. */
static struct plan room(struct scene_fixture *f)
{
    struct plan p = floor_plan(f, 3.0f, SIDE_PX);
    f->materials[0].base_color[1] = 0.25f;
    const uint32_t metal = fixture_glossy(f, (float[]){0.9f, 0.8f, 0.7f}, 0.3f, 1.0f);
    const uint32_t glossy = fixture_glossy(f, (float[]){0.2f, 0.6f, 0.2f}, 0.4f, 0.0f);
    uint32_t glass = fixture_material(f, 0.9f, 0.9f, 0.9f);
    f->materials[glass].transmission = 1.0f;
    f->materials[glass].specular = 1.0f;
    f->materials[glass].roughness = 0.0f;
    fixture_panel(f, metal, (float[]){-2, 1, 0}, (float[]){0, 0, -1}, (float[]){0, 1, 0});
    fixture_panel(f, glossy, (float[]){1, 0.5f, 0}, (float[]){0.5f, 0, 0}, (float[]){0, 0, -0.5f});
    fixture_panel(f, glass, (float[]){0, 1, 1}, (float[]){0.6f, 0, 0}, (float[]){0, 0, -0.6f});
    fixture_ceiling_light(&p, 0, 3, 0, 0.5f, 1);
    fixture_ceiling_light(&p, 1, 3, 0, 0.25f, 1);
    p.lights[0].color[1] = 0.5f;
    p.light_planes = 0;
    p.planes = PLANES_PATH;
    p.occlusion_distance = 1;
    p.environment.kind = ENVIRONMENT_CONSTANT;
    p.environment.radiance[0] = p.environment.radiance[2] = 0.25f;
    p.environment.power = 1;
    p.bounces = 6;
    p.paths.spp = SPP;
    p.camera.aperture_radius = 0.1f;
    p.camera.focus_distance = 3.5f;
    return p;
}

static struct path_record *replay(const struct traced *t, const struct plan *p, int32_t x,
                                  int32_t y, uint32_t sample)
{
    struct fault fault = {0};
    struct path_record *record = malloc(sizeof *record);
    assert_non_null(record);
    const int e = sample_replay(t->scene, NULL, p, x, y, sample, record, &fault);
    if (e) print_message("%s: %s\n", fault.pointer, fault.detail);
    assert_int_equal(e, 0);
    return record;
}

static void assert_same(const float a[3], const float b[3])
{
    for (int k = 0; k < 3; k++)
        if (a[k] != b[k])
            print_message("component %d: %.9g is not %.9g\n", k, (double)a[k], (double)b[k]);
    assert_memory_equal(a, b, 3 * sizeof *a);
}

/* Every pixel's sum over a pass, grown sample by sample. */
static uint32_t sums_are_those_of_tiles(const struct plan *p, struct traced *t)
{
    uint32_t edges = 0;
    for (uint32_t pass = 0; pass < plan_pass_count(p); pass++) {
        struct samples *s = NULL;
        const struct plan_pass range = plan_scheduled_pass(p, pass);
        assert_int_equal(
            trace_tile(t,
                       (struct tile_job){.plan = p, .rect = (struct rect){0, 0, SIDE_PX, SIDE_PX}},
                       pass, &s),
            0);
        for (int32_t i = 0; i < SIDE_PX * SIDE_PX; i += 5) {
            float sum[3] = {0, 0, 0}, traced[3];
            uint32_t more = 0; /* at edges */
            for (uint32_t k = 0; k < range.count << more; k++) {
                const uint32_t n = (range.first << more) + k;
                struct path_record *r = replay(t, p, i % SIDE_PX, i / SIDE_PX, n);
                for (int c = 0; c < 3; c++) sum[c] += r->radiance[c];
                if (r->last + 1 > p->paths.spp && more == 0) {
                    assert_int_equal(r->last + 1, p->paths.spp << p->paths.edge_digits);
                    more = p->paths.edge_digits, k = UINT32_MAX;
                    memset(sum, 0, sizeof sum);
                }
                free(r);
            }
            for (int c = 0; c < 3; c++) sum[c] /= (float)(1u << more);
            if (more > 0) edges++;
            for (uint32_t c = 0; c < 3; c++) traced[c] = samples_f32(s, PLANE_PATH_RADIANCE, c)[i];
            assert_same(sum, traced);
        }
        samples_destroy(&s);
    }
    return edges;
}

/* Pixels at edges have more paths in every pass, and their sums are those of fewer. */
TEST(so_they_are_at_edges)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f);
    p.camera.aperture_radius = 0;
    p.paths.spp = 20; /* two passes */
    p.paths.edge_digits = 1;
    p.planes |= PLANES_CENTRE | PLANE_BIT(MIXED);
    struct traced t = trace_all(f, &p);
    const uint32_t edges = sums_are_those_of_tiles(&p, &t);
    if (edges < 4 || edges % 2 != 0) fail_msg("%u pixels at edges in two passes", edges);
    traced_fini(&t);
    free(f);
}

TEST(replays_are_what_tiles_trace)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f);
    struct traced t = trace_all(f, &p);
    sums_are_those_of_tiles(&p, &t);
    traced_fini(&t);
    free(f);
}

/* Paths that leave indirect light to light fields. */
TEST(so_they_are_beside_light_fields)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f);
    p.paths.without_diffuse_indirect = 1;
    p.camera.aperture_radius = 0;
    p.paths.spp = 32;
    struct traced t = trace_all(f, &p);
    sums_are_those_of_tiles(&p, &t);
    p.paths.without_glossy_indirect = 1;
    sums_are_those_of_tiles(&p, &t);
    traced_fini(&t);
    free(f);
}

/* Paths that leave diffuse lobes to light fields. What becomes of them at their first surface: they
 * end at the matt floor, and go on from other lobes, surely or by chance. */
TEST(so_they_are_without_diffuse_lobes)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f);
    struct replay_sheet sheet = {.plan = &p};
    uint32_t left = 0, thinned = 0, stayed = 0;
    p.paths.without_diffuse_indirect = p.paths.without_diffuse_direct = 1;
    p.environment.kind = ENVIRONMENT_NONE;
    p.camera.aperture_radius = 0;
    p.paths.spp = 32;
    struct traced t = trace_all(f, &p);
    sums_are_those_of_tiles(&p, &t);
    for (int32_t i = 0; i < SIDE_PX * SIDE_PX; i++) {
        struct path_record *r = replay(&t, &p, i % SIDE_PX, i / SIDE_PX, 0);
        const struct path_record_vertex *v = &r->vertices[0];
        sheet.record = r;
        assert_int_equal(v->left, v->active && v->lambert);
        left += v->left, thinned += v->thinned, stayed += v->stays > 0 && !v->thinned;
        if (v->left)
            assert_string_equal(replay_end(&sheet), "light fields bring all that would come");
        if (v->thinned)
            assert_string_equal(replay_end(&sheet), "roulette of what light fields leave");
        free(r);
    }
    assert_true(left > 0 && thinned > 0 && stayed > 0);
    traced_fini(&t);
    free(f);
}

static void add(const float value[3], float to[3])
{
    for (int k = 0; k < 3; k++) to[k] += value[k];
}

/* What the steps tell, added up in their order into emission, direct and indirect light. */
static void add_up(const struct path_record *r)
{
    float emission[3] = {0}, direct[3] = {0}, indirect[3] = {0}, sum[3];
    for (uint32_t d = 0; d < r->count; d++) {
        const struct path_record_vertex *v = &r->vertices[d];
        for (uint32_t k = 0; k < v->met_count; k++)
            add(v->met[k].value, d == 0 ? emission : d == 1 ? direct : indirect);
        for (uint32_t k = 0; k < v->light_count; k++)
            add(v->lights[k].value, d == 0 ? direct : indirect);
        if (d > 0) assert_true(r->vertices[d - 1].scatter.goes_on);
        if (v->scatter.goes_on) assert_true(d + 1 < r->count);
    }
    for (int k = 0; k < 3; k++) sum[k] = emission[k] + direct[k] + indirect[k];
    assert_same(emission, r->emission);
    assert_same(direct, r->direct);
    assert_same(indirect, r->indirect);
    assert_same(sum, r->radiance);
}

/* Paths that leave direct light of listed lights, as diffuse lobes send it on, to light fields. */
TEST(so_they_are_without_listed_lights)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f);
    p.paths.without_diffuse_direct = DIRECT_LEFT_LISTED;
    p.camera.aperture_radius = 0;
    p.paths.spp = 32;
    for (uint32_t indirect = 0; indirect < 2; indirect++) {
        p.paths.without_diffuse_indirect = indirect;
        struct traced t = trace_all(f, &p);
        sums_are_those_of_tiles(&p, &t);
        for (int32_t i = 0; i < SIDE_PX * SIDE_PX; i++) {
            struct path_record *r = replay(&t, &p, i % SIDE_PX, i / SIDE_PX, 0);
            add_up(r);
            free(r);
        }
        traced_fini(&t);
    }
    free(f);
}

/* Each vertex follows from the one before it. */
static void hang_together(const struct path_record *r)
{
    for (uint32_t d = 0; d + 1 < r->count; d++) {
        const struct path_record_vertex *v = &r->vertices[d], *next = &r->vertices[d + 1];
        const struct path_record_scatter *s = &v->scatter;
        assert_same(s->direction, next->direction);
        assert_true(s->pdf == next->pdf);
        for (int k = 0; k < 3; k++) {
            float all = s->diffuse[k] + s->specular[k], t = v->throughput[k];
            if (v->is_kept) t = v->kept[k];
            t *= s->weight[k];
            if (s->roulette) t /= s->survival;
            assert_true(fabsf(all - s->weight[k]) <= 1e-5f * all);
            assert_true(next->throughput[k] == t);
        }
        if (s->roulette) assert_true(s->chance < s->survival);
    }
}

TEST(steps_add_up)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f);
    struct traced t = trace_all(f, &p);
    uint32_t long_ones = 0, dirac = 0, blocked = 0, seen = 0, ended = 0;
    for (int32_t i = 0; i < SIDE_PX * SIDE_PX; i++) {
        struct path_record *r = replay(&t, &p, i % SIDE_PX, i / SIDE_PX, (uint32_t)i % SPP);
        add_up(r);
        hang_together(r);
        long_ones += r->count > 3;
        for (uint32_t d = 0; d < r->count; d++) {
            const struct path_record_vertex *v = &r->vertices[d];
            dirac += v->scatter.dirac;
            for (uint32_t k = 0; k < v->light_count; k++) {
                const struct path_record_light *l = &v->lights[k];
                blocked += l->blocked && l->blocker > 0;
                assert_true(!l->blocked || l->blocked_at < l->distance);
                seen += l->traced && !l->blocked;
            }
            ended += v->scatter.roulette && !v->scatter.goes_on;
        }
        free(r);
    }
    /* The scene has all of it. */
    assert_true(long_ones > 0 && dirac > 0 && blocked > 0 && seen > 0 && ended > 0);
    traced_fini(&t);
    free(f);
}

/* Paths that are sent to a lamp behind glass: some weigh far less than their lobes' would. */
TEST(steps_to_lamps_behind_glass_add_up)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f);
    const uint32_t lamp = fixture_material(f, 0, 0, 0), pane = 3;
    f->materials[lamp].emission[1] = 30.0f;
    fixture_panel(f, lamp, (float[]){0, 2, -1}, (float[]){0.1f, 0, 0}, (float[]){0, 0, 0.1f});
    fixture_panel(f, pane, (float[]){0, 1.9f, -1}, (float[]){1, 0, 0}, (float[]){0, 0, -1});
    p.paths.emitter_power = 1.0f;
    struct traced t = trace_all(f, &p);
    uint32_t sent = 0;
    sums_are_those_of_tiles(&p, &t);
    for (int32_t i = 0; i < SIDE_PX * SIDE_PX; i++) {
        struct path_record *r = replay(&t, &p, i % SIDE_PX, i / SIDE_PX, (uint32_t)i % SPP);
        add_up(r);
        hang_together(r);
        for (uint32_t d = 0; d < r->count; d++)
            sent += r->vertices[d].scatter.on && r->vertices[d].scatter.weight[1] < 0.01f;
        free(r);
    }
    assert_true(sent > 0);
    traced_fini(&t);
    free(f);
}

/* Surfaces that no light faces choose none, of which there is nothing to tell. */
TEST(no_light_is_no_sample)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f);
    for (uint32_t k = 0; k < p.light_count; k++) p.lights[k].direction[1] = 1; /* up */
    struct traced t = trace_all(f, &p);
    uint32_t without = 0;
    for (int32_t i = 0; i < SIDE_PX * SIDE_PX; i++) {
        struct path_record *r = replay(&t, &p, i % SIDE_PX, i / SIDE_PX, 0);
        add_up(r);
        for (uint32_t d = 0; d < r->count; d++) {
            const struct path_record_vertex *v = &r->vertices[d];
            without += v->active && v->light_count == 0;
            for (uint32_t k = 0; k < v->light_count; k++)
                assert_true(v->lights[k].light < p.light_count ||
                            v->lights[k].light == LIGHT_CHOICE_EMITTERS);
        }
        free(r);
    }
    assert_true(without > 0);
    traced_fini(&t);
    free(f);
}

/* Every lens sample of some pixels, as it travels. */
static void lens_samples_are_those_of_tiles(const struct plan *p, struct traced *t)
{
    const uint32_t count = p->lens_strata_per_axis * p->lens_strata_per_axis;
    uint32_t left = 0, lit = 0;
    for (int32_t i = 0; i < SIDE_PX * SIDE_PX; i += 3)
        for (uint32_t k = 0; k < count; k++) {
            float traced[3];
            struct path_record *r = replay(t, p, i % SIDE_PX, i / SIDE_PX, k);
            for (uint32_t c = 0; c < 3; c++)
                traced[c] = samples_f32(t->samples, PLANE_LENS_RADIANCE, k * 3 + c)[i];
            assert_same(r->stored, traced);
            assert_int_equal(r->kind, PATH_RECORD_LENS);
            left += r->vertices[0].left;
            lit += r->stored[0] > 0.0f;
            free(r);
        }
    assert_true(p->lens_relight == LENS_RELIGHT_DIFFUSE ? left > 0 : lit > 0);
}

TEST(so_are_lens_samples)
{
    for (uint32_t light = LENS_RELIGHT_OWN; light <= LENS_RELIGHT_DIFFUSE; light++) {
        struct scene_fixture *f = fixture_new();
        struct plan p = light == LENS_RELIGHT_DIFFUSE ? floor_plan(f, 3.0f, SIDE_PX) : room(f);
        if (light == LENS_RELIGHT_DIFFUSE) {
            fixture_panel(f, 0, (float[]){-1, 1, 0}, (float[]){0, 0, -1}, (float[]){0, 1, 0});
            fixture_ceiling_light(&p, 0, 3, 0, 0.5f, 1);
            p.camera.aperture_radius = 0.1f;
            p.camera.focus_distance = 3.5f;
            p.bounces = 1;
        }
        p.paths.spp = 0;
        p.occlusion_distance = 0;
        p.lens_strata_per_axis = 3;
        p.planes = PLANES_LENS & ~PLANES_LENS_SURFACE;
        p.light_planes = 0;
        p.radiance_scale = 4;
        p.length_unit = 8;
        p.lens_relight = light;
        if (light != LENS_RELIGHT_OWN) {
            p.planes =
                PLANES_LENS | PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(INDIRECT_MEAN);
            p.indirect_strata_per_axis = 1;
        }
        if (light == LENS_RELIGHT_DIFFUSE) p.light_planes = 1u << LIGHT_PLANE_IRRADIANCE;
        struct traced t = trace_all(f, &p);
        lens_samples_are_those_of_tiles(&p, &t);
        traced_fini(&t);
        free(f);
    }
}

TEST(refuses_what_is_not_there)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f);
    struct traced t = trace_all(f, &p);
    struct fault fault = {0};
    struct path_record *r = malloc(sizeof *r);
    assert_non_null(r);
    assert_int_equal(sample_replay(t.scene, NULL, &p, SIDE_PX, 0, 0, r, &fault), ERR_RANGE);
    assert_int_equal(sample_replay(t.scene, NULL, &p, 0, -1, 0, r, &fault), ERR_RANGE);
    assert_int_equal(sample_replay(t.scene, NULL, &p, 0, 0, SPP, r, &fault), ERR_RANGE);
    assert_non_null(strstr(fault.detail, "0 to 79"));
    p.paths.spp = 0;
    assert_int_equal(sample_replay(t.scene, NULL, &p, 0, 0, 0, r, &fault), ERR_UNSUPPORTED);
    free(r);
    traced_fini(&t);
    free(f);
}
