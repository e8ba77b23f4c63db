/* Trees of emitters: all triangles are in one leaf, spheres and cones hold them, what lies or faces
 * apart is told apart, and a million triangles take bounded time and memory. */
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/scene/emitter_shapes.h"
#include "worker/scene/emitter_tree.h"

enum { MOST = 4096 };

static struct emitter_shape shapes[MOST];
static uint32_t order[MOST];

static void check_bounds(const struct emitter_shape *all, const struct emitter_groups *o,
                         uint32_t g, uint32_t first, uint32_t end)
{
    double power = 0.0;
    for (uint32_t i = first; i < end; i++) {
        const struct emitter_shape *s = &all[i];
        const float *n = s->normal;
        power += s->power;
        const float facing = n[0] * o->axis_x[g] + n[1] * o->axis_y[g] + n[2] * o->axis_z[g];
        assert_true(facing >= o->cosine[g] - 1e-6f);
        if (s->both_sides) assert_true(o->cosine[g] == -1.0f);
        for (int c = 0; c < 3; c++) {
            const float *p = s->corner[c];
            const float far = hypotf(hypotf(p[0] - o->x[g], p[1] - o->y[g]), p[2] - o->z[g]);
            assert_true(far <= o->radius[g] * 1.00001f);
        }
    }
    assert_true(fabs(power - (double)o->power[g]) <= 1e-6 * power);
    assert_true(fabsf(hypotf(o->cosine[g], o->sine[g]) - 1.0f) < 1e-3f);
}

/* What is in the root's groups, node by node; each is hung where it says. */
static void check_tree(const struct emitter_tree *t, const struct emitter_shape *all,
                       uint32_t count)
{
    uint32_t *seen = calloc(count, sizeof *seen), groups = 0;
    for (uint32_t n = 0; n < t->node_count; n++) {
        const struct emitter_node *node = &t->nodes[n];
        assert_in_range(node->groups.count, 1, EMITTER_GROUPS);
        groups += n < t->root_nodes ? node->groups.count : 0;
        if (n + 1 < t->root_nodes) assert_int_equal(node->groups.count, EMITTER_GROUPS);
        for (uint32_t g = 0; g < node->groups.count; g++) {
            const uint32_t below = node->groups.below[g], at = below & ~EMITTER_LEAF;
            const bool leaf = (below & EMITTER_LEAF) != 0;
            assert_true(leaf ? at < t->leaf_count : at >= t->root_nodes && at < t->node_count);
            const struct emitter_place place = leaf ? t->leaves[at].place : t->nodes[at].place;
            assert_true(place.node == n && place.group == g && node->first[g] < node->first[g + 1]);
            check_bounds(all, &node->groups, g, node->first[g], node->first[g + 1]);
        }
    }
    assert_int_equal(groups, t->root_groups);
    for (uint32_t k = 0; k < t->leaf_count; k++)
        for (uint32_t i = 0; i < t->leaves[k].count; i++) seen[t->leaves[k].first + i]++;
    for (uint32_t i = 0; i < count; i++) assert_int_equal(seen[i], 1);
    free(seen);
}

TEST(trees_hold_what_they_say)
{
    struct random r = {1};
    static const uint32_t counts[] = {1, 2, 3, 31, 64, 65, 500, MOST};
    static struct emitter_shape before[MOST];
    for (size_t n = 0; n < sizeof counts / sizeof *counts; n++) {
        struct emitter_tree t;
        for (uint32_t i = 0; i < counts[n]; i++) {
            float at[3] = {random_unit(&r), 9.0f * random_unit(&r), random_unit(&r)}, normal[3];
            random_normal(&r, normal);
            shapes[i] = shape_at(at, normal, 0.1f * random_unit(&r) + 0.001f,
                                 (double)random_unit(&r) + 1e-3);
            shapes[i].both_sides = random_bits(&r) % 50 == 0;
        }
        memcpy(before, shapes, sizeof before);
        assert_int_equal(emitter_tree_init(&t, shapes, counts[n], order), 0);
        assert_true(t.root_groups <= EMITTER_GROUPS_MAX && t.root_groups <= counts[n]);
        check_tree(&t, shapes, counts[n]);
        for (uint32_t i = 0; i < counts[n]; i++)
            assert_memory_equal(&shapes[i], &before[order[i]], sizeof *shapes);
        emitter_tree_fini(&t);
    }
}

/* A sphere far away and as bright as one nearby: no group has both, and none has front and back. */
TEST(spheres_are_told_apart)
{
    struct random r = {2};
    struct emitter_tree t;
    for (uint32_t i = 0; i < 1000; i++) {
        float normal[3];
        random_normal(&r, normal);
        const float at[3] = {normal[0] + (i % 2 ? 50.0f : 0.0f), normal[1], normal[2]};
        shapes[i] = shape_at(at, normal, 0.05f, 1.0);
    }
    assert_int_equal(emitter_tree_init(&t, shapes, 1000, order), 0);
    assert_int_equal(t.root_groups, EMITTER_GROUPS_MAX);
    check_tree(&t, shapes, 1000);
    for (uint32_t n = 0; n < t.root_nodes; n++)
        for (uint32_t g = 0; g < t.nodes[n].groups.count; g++) {
            assert_true(t.nodes[n].groups.radius[g] < 2.0f);
            assert_true(t.nodes[n].groups.cosine[g] > 0.0f);
        }
    emitter_tree_fini(&t);
}

/* Copies that nothing tells apart stay together; powers of 0, extents of 0 and of more than a float
 * has squares for are borne. */
TEST(what_cannot_be_told_apart_stays_together)
{
    const float at[3] = {1e20f, -1e20f, 0}, up[3] = {0, 1, 0};
    struct emitter_tree t;
    for (uint32_t i = 0; i < 100; i++) shapes[i] = shape_at(at, up, 0.0f, i % 2 ? 1.0 : 0.0);
    assert_int_equal(emitter_tree_init(&t, shapes, 100, order), 0);
    assert_int_equal(t.leaf_count, 1);
    assert_true(t.leaves[0].power == 50.0);
    assert_true(isfinite(t.nodes[0].groups.radius[0]) && isfinite(t.nodes[0].groups.axis_y[0]));
    emitter_tree_fini(&t);
    for (uint32_t i = 0; i < 100; i++) {
        const float far[3] = {i % 2 ? 1e30f : -1e30f, (float)i * 1e28f, 0};
        shapes[i] = shape_at(far, up, 1e20f, 0.0);
    }
    assert_int_equal(emitter_tree_init(&t, shapes, 100, order), 0);
    assert_int_equal(t.leaf_count, 1); /* without power there is nothing to tell apart */
    emitter_tree_fini(&t);
}

/* Hills of a million triangles, and as many in one place. */
TEST(a_million_take_bounded_time_and_memory)
{
    enum { COUNT = 1000000 };
    struct emitter_shape *many = malloc(COUNT * sizeof *many);
    uint32_t *places = malloc(COUNT * sizeof *places);
    assert_true(many && places);
    for (int alike = 0; alike < 2; alike++) {
        struct random r = {3};
        struct emitter_tree t;
        for (uint32_t i = 0; i < COUNT; i++) {
            const float x = (float)(i % 1000), z = (float)(i / 1000); /* NOLINT */
            const float at[3] = {alike ? 0.0f : x, 0.0f, alike ? 0.0f : z};
            float normal[3];
            random_normal(&r, normal);
            many[i] = shape_at(at, alike ? (float[]){0, 1, 0} : normal, 0.5f, 1.0);
        }
        const clock_t start = clock();
        assert_int_equal(emitter_tree_init(&t, many, COUNT, places), 0);
        const double took_s = (double)(clock() - start) / CLOCKS_PER_SEC;
        const size_t bytes = t.node_count * sizeof *t.nodes + t.leaf_count * sizeof *t.leaves;
        print_message("%u nodes, %u leaves, %zu bytes, %.2f CPU s\n", t.node_count, t.leaf_count,
                      bytes, took_s);
        assert_true(bytes < (size_t)64 * COUNT);
        assert_true(took_s < 60.0); /* a second, or a few under sanitizers */
        assert_true(alike ? t.leaf_count == 1 : t.leaf_count > 10000);
        emitter_tree_fini(&t);
    }
    free(many);
    free(places);
}
