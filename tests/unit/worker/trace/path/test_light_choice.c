/* Which light is chosen: never with probability 0 where it lights something, with the probability
 * that hits are weighted with, the same bits on every instruction set, and finite anywhere. */
#include <math.h>
#include <string.h>

#include "tests/random.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/scene/emitter_shapes.h"
#include "tests/unit/worker/tile_fixture.h"
#include "tests/unit/worker/trace/isa_fixture.h"
#include "worker/trace/light/light_kernels.h"
#include "worker/trace/path/path_kernels.h"

enum { COUNT = 3000, LIGHTS = 12 };

static struct emitter_shape shapes[COUNT];
static uint32_t order[COUNT];
static struct emitter_tree tree;
static struct plan plan;
static struct light_table table;

/* Triangles of a few spheres, which face outwards. */
static void make_tree(struct random *r)
{
    for (uint32_t i = 0; i < COUNT; i++) {
        const float x = 4.0f * (float)(i % 5), radius = 0.2f + 0.3f * (float)(i % 5);
        float n[3], at[3];
        random_normal(r, n);
        for (int k = 0; k < 3; k++) at[k] = radius * n[k] + (k == 0 ? x : 0.0f);
        shapes[i] = shape_at(at, n, 0.02f, 1.0);
    }
    assert_int_equal(emitter_tree_init(&tree, shapes, COUNT, order), 0);
}

/* Lights of all kinds around the spheres. */
static void make_table(struct random *r)
{
    static const uint32_t types[] = {LIGHT_POINT, LIGHT_SPOT, LIGHT_RECTANGLE, LIGHT_DIRECTIONAL};
    plan.light_count = 0;
    plan.paths.emitter_power = 1.0f;
    for (uint32_t k = 0; k < LIGHTS; k++) {
        struct plan_light *l = fixture_light(&plan, types[k % 4], 1);
        random_normal(r, l->direction);
        for (int i = 0; i < 3; i++) l->position[i] = (i ? 2.0f : 12.0f) * random_unit(r);
        if (l->type == LIGHT_RECTANGLE) {
            const struct emitter_shape s = shape_at(l->position, l->direction, 0.3f, 1.0);
            for (int i = 0; i < 3; i++) {
                l->half_u[i] = s.corner[1][i] - s.corner[0][i];
                l->half_v[i] = s.corner[2][i] - s.corner[0][i];
            }
        }
        l->color[0] = l->color[1] = l->color[2] = 1.0f + random_unit(r);
        l->cos_outer = l->type == LIGHT_SPOT ? 0.7f : -1.0f;
        l->cos_inner = 0.9f;
        l->range = k < 4 ? 6.0f : 0.0f;
    }
    light_table_init(&table, &plan, &tree);
}

static void make(struct random *r)
{
    make_tree(r);
    make_table(r);
}

static void random_surfaces(struct random *r, struct surface *s)
{
    memset(s, 0, sizeof *s);
    for (int i = 0; i < LANES; i++) {
        float n[3];
        random_normal(r, n);
        s->origin.x[i] = 24.0f * random_unit(r) - 4.0f;
        s->origin.y[i] = 6.0f * random_unit(r) - 3.0f;
        s->origin.z[i] = 6.0f * random_unit(r) - 3.0f;
        s->normal.x[i] = n[0], s->normal.y[i] = n[1], s->normal.z[i] = n[2];
    }
    s->position = s->origin;
    s->facet = s->normal;
}

static float light_of(const struct emitter_shape *s, const struct surface *at, int i)
{
    const float way[3] = {s->corner[0][0] - at->origin.x[i], s->corner[0][1] - at->origin.y[i],
                          s->corner[0][2] - at->origin.z[i]};
    const float receives =
        way[0] * at->normal.x[i] + way[1] * at->normal.y[i] + way[2] * at->normal.z[i];
    const float sends = -(way[0] * s->normal[0] + way[1] * s->normal[1] + way[2] * s->normal[2]);
    const float squared = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
    return receives > 0.0f && sends > 0.0f ? receives * sends / (squared * squared) : 0.0f;
}

/* What points of the plan's lights send weighs something, and the same on every instruction set. */
TEST(no_light_that_lights_is_left_out)
{
    static struct light_weights first, other;
    struct random r = {1};
    int lit = 0, dark = 0;
    make(&r);
    for (int round = 0; round < 300; round++) {
        struct surface s;
        struct lanes_mask all;
        random_surfaces(&r, &s);
        memset(&all, -1, sizeof all);
        KERNELS_FOR(path_kernels, all_isas[0])
            ->weigh_lights(&table, true, &s.origin, &s.normal, &first);
        for (int k = 1; k < isa_count(); k++) {
            KERNELS_FOR(path_kernels, all_isas[k])
                ->weigh_lights(&table, true, &s.origin, &s.normal, &other);
            assert_memory_equal(first.of, other.of, LIGHTS * sizeof *first.of);
            assert_memory_equal(first.of[LIGHT_CHOICE_EMITTERS], other.of[LIGHT_CHOICE_EMITTERS],
                                tree.root_groups * sizeof *first.of);
            assert_memory_equal(first.total, other.total, sizeof first.total);
        }
        for (uint32_t k = 0; k < LIGHTS; k++) {
            _Alignas(64) float u[LANES], v[LANES];
            struct light_packet p;
            for (int i = 0; i < LANES; i++) u[i] = random_unit(&r), v[i] = random_unit(&r);
            KERNELS_FOR(light_kernels, all_isas[0])
                ->sample_light(&table.lights[k], u, v, &s, &all, &p);
            for (int i = 0; i < LANES; i++) {
                const bool lights = p.skip[i] == LIGHT_TRACED && p.irradiance[i] > 1e-6f;
                if (lights) assert_true(first.of[k][i] > 0.0f);
                lit += lights;
                dark += first.of[k][i] == 0.0f;
            }
        }
    }
    assert_true(lit > 5000 && dark > 5000);
    emitter_tree_fini(&tree);
}

/* Each leaf's chance is positive where a triangle of it lights the surface, and chances within a
 * group add up to one. */
TEST(no_triangle_that_lights_is_left_out)
{
    struct random r = {2};
    int lit = 0;
    make(&r);
    for (int round = 0; round < 40; round++) {
        struct surface s;
        random_surfaces(&r, &s);
        const int i = round % LANES;
        struct path_context c = {
            .lights = &table, .kernels = KERNELS_FOR(path_kernels, all_isas[round % isa_count()])};
        double sums[EMITTER_GROUPS_MAX] = {0};
        for (uint32_t k = 0; k < tree.leaf_count; k++) {
            float weight, most = 0.0f;
            const float chance = light_choice_chance(&c, &s.origin, &s.normal, i, k, &weight);
            const struct emitter_leaf *leaf = &tree.leaves[k];
            for (uint32_t t = leaf->first; t < leaf->first + leaf->count; t++)
                most = fmaxf(most, light_of(&shapes[t], &s, i));
            if (most > 1e-4f) assert_true(chance > 0.0f && weight > 0.0f);
            lit += most > 1e-4f;
            struct emitter_place at = leaf->place;
            while (at.node >= tree.root_nodes) at = tree.nodes[at.node].place;
            sums[at.node * EMITTER_GROUPS + at.group] += (double)chance;
        }
        for (uint32_t g = 0; g < tree.root_groups; g++)
            assert_true(sums[g] == 0.0 || fabs(sums[g] - 1.0) < 1e-4);
    }
    assert_true(lit > 1000);
    emitter_tree_fini(&tree);
}

/* Choices come as often as their weights say, and those of leaves as often as hits on them are
 * weighted with. */
TEST(choices_come_as_often_as_they_say)
{
    enum { DRAWS = 4096 };
    static struct light_weights w;
    static struct light_choice choice;
    struct random r = {3};
    struct surface s;
    make(&r);
    random_surfaces(&r, &s);
    struct path_context c = {.lights = &table, .kernels = KERNELS_FOR(path_kernels, all_isas[0])};
    c.kernels->weigh_lights(&table, true, &s.origin, &s.normal, &w);
    double seen[LIGHT_CHOICES] = {0};
    for (int n = 0; n < DRAWS; n++) {
        _Alignas(64) float x[LANES];
        for (int i = 0; i < LANES; i++) x[i] = ((float)n + 0.5f) / DRAWS;
        c.kernels->choose_light(&table, &w, x, &choice);
        assert_true(choice.chosen[0] < LIGHT_CHOICES);
        assert_true(choice.weight[0] == w.of[choice.chosen[0]][0] && choice.weight[0] > 0.0f);
        seen[choice.chosen[0]] += 1.0 / DRAWS;
        if (choice.chosen[0] < LIGHT_CHOICE_EMITTERS) continue;
        float weight;
        const struct light_leaf leaf =
            light_choice_descend(&c, &s.origin, &s.normal, 0,
                                 choice.chosen[0] - LIGHT_CHOICE_EMITTERS, (double)random_unit(&r));
        if (!(leaf.chance > 0.0f)) continue;
        const float chance = light_choice_chance(&c, &s.origin, &s.normal, 0, leaf.leaf, &weight);
        assert_true(fabsf(chance - leaf.chance) <= 1e-5f * chance);
        assert_true(weight == choice.weight[0]);
    }
    for (uint32_t k = 0; k < LIGHT_CHOICES; k++) {
        if (k >= LIGHTS && k < LIGHT_CHOICE_EMITTERS) continue;
        const bool there = k < LIGHTS || k - LIGHT_CHOICE_EMITTERS < tree.root_groups;
        const double part = there ? (double)(w.of[k][0] / w.total[0]) : 0.0;
        assert_true(fabs(seen[k] - part) < 2.0 / DRAWS);
    }
    emitter_tree_fini(&tree);
}

/* Directional lights that outshine all others leave them a part, however faint these are. */
TEST(suns_leave_something)
{
    static struct light_weights w;
    static const float faint[] = {1.0f, 1e-6f, 1e-12f, 1e-30f};
    for (size_t n = 0; n < sizeof faint / sizeof *faint; n++) {
        struct lanes3 origin = {.y = {0}}, normal;
        memset(&origin, 0, sizeof origin), memset(&normal, 0, sizeof normal);
        for (int i = 0; i < LANES; i++) normal.y[i] = 1.0f;
        plan.light_count = 0;
        struct plan_light *sun = fixture_light(&plan, LIGHT_DIRECTIONAL, 1);
        struct plan_light *lamp = fixture_light(&plan, LIGHT_POINT, 1);
        sun->direction[0] = sun->direction[2] = 0.0f, sun->direction[1] = -1.0f;
        lamp->position[0] = lamp->position[2] = 0.0f, lamp->position[1] = 1.0f;
        for (int k = 0; k < 3; k++) sun->color[k] = 1e6f, lamp->color[k] = faint[n];
        light_table_init(&table, &plan, NULL);
        KERNELS_FOR(path_kernels, all_isas[0])->weigh_lights(&table, true, &origin, &normal, &w);
        assert_true(w.of[0][0] > 0.0f && w.of[1][0] > 0.0f);
        if (faint[n] > 1e-13f) assert_true(w.of[1][0] > 0.05f * w.total[0]);
    }
}

/* Surfaces inside groups, on lights and far away; groups of any power. */
TEST(odd_places_give_finite_numbers)
{
    static const float odd[] = {0.0f, 1e-30f, 4.0f, 1e15f, -1e18f};
    static struct light_weights w;
    struct random r = {4};
    make(&r);
    tree.nodes[0].groups.power[0] = INFINITY;
    for (int k = 0; k < isa_count(); k++) {
        const struct path_kernels *kernels = KERNELS_FOR(path_kernels, all_isas[k]);
        struct lanes3 origin, normal;
        memset(&normal, 0, sizeof normal); /* black ones, too */
        for (int i = 0; i < LANES; i++) {
            origin.x[i] = odd[i % 5], origin.y[i] = odd[i / 5 % 5], origin.z[i] = 0.0f;
            normal.y[i] = i % 3 ? 1.0f : 0.0f;
        }
        const float *on = plan.lights[0].position; /* of a point */
        origin.x[3] = on[0], origin.y[3] = on[1], origin.z[3] = on[2];
        kernels->weigh_lights(&table, true, &origin, &normal, &w);
        for (int i = 0; i < LANES; i++) {
            assert_true(isfinite(w.total[i]) && w.total[i] >= 0.0f);
            for (uint32_t l = 0; l < LIGHTS; l++) assert_true(w.of[l][i] >= 0.0f);
            for (uint32_t n = 0; n < tree.node_count; n++) {
                _Alignas(64) float weight[EMITTER_GROUPS];
                const float sum =
                    kernels->weigh_node(&tree.nodes[n].groups, &origin, &normal, i, weight);
                assert_true(isfinite(sum) && sum >= 0.0f);
            }
        }
    }
    emitter_tree_fini(&tree);
}
