/* Groups of emitters: all triangles are in one, spheres and cones hold them, and what lies or faces
 * apart is told apart. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/random.h"
#include "tests/unit/unit.h"
#include "worker/scene/emitter_groups.h"

enum { MOST = 4096 };

static struct emitter_shape shapes[MOST];
static uint32_t order[MOST];
static struct emitter_groups groups;

/* A triangle around `at`, facing along the unit `normal`. */
static void put(uint32_t i, const float at[3], const float normal[3], float size, double power)
{
    const int least = fabsf(normal[0]) < 0.6f ? 0 : 1;
    float side[3] = {0}, up[3];
    side[least] = 1.0f;
    for (int k = 0; k < 3; k++) side[k] -= normal[least] * normal[k];
    for (int k = 0; k < 3; k++)
        up[k] = normal[(k + 1) % 3] * side[(k + 2) % 3] - normal[(k + 2) % 3] * side[(k + 1) % 3];
    for (int k = 0; k < 3; k++) {
        shapes[i].corner[0][k] = at[k];
        shapes[i].corner[1][k] = at[k] + size * side[k];
        shapes[i].corner[2][k] = at[k] + size * up[k];
        shapes[i].normal[k] = normal[k];
    }
    shapes[i].power = power;
    shapes[i].both_sides = 0;
}

static void random_normal(struct random *r, float out[3])
{
    float squared;
    do {
        squared = 0.0f;
        for (int k = 0; k < 3; k++) {
            out[k] = 2.0f * random_unit(r) - 1.0f;
            squared += out[k] * out[k];
        }
    } while (squared > 1.0f || squared < 0.01f);
    for (int k = 0; k < 3; k++) out[k] /= sqrtf(squared);
}

static void check_bounds(uint32_t count)
{
    static uint8_t seen[MOST];
    memset(seen, 0, sizeof seen);
    assert_int_equal(groups.first[0], 0);
    assert_int_equal(groups.first[groups.count], count);
    for (uint32_t g = 0; g < groups.count; g++) {
        double sum = 0.0;
        assert_true(groups.first[g] < groups.first[g + 1]);
        for (uint32_t i = groups.first[g]; i < groups.first[g + 1]; i++) {
            const struct emitter_shape *s = &shapes[order[i]];
            const float *n = s->normal;
            assert_int_equal(seen[order[i]]++, 0);
            sum += s->power;
            const float facing =
                n[0] * groups.axis_x[g] + n[1] * groups.axis_y[g] + n[2] * groups.axis_z[g];
            assert_true(facing >= groups.cosine[g] - 1e-6f);
            if (s->both_sides) assert_true(groups.cosine[g] == -1.0f);
            for (int c = 0; c < 3; c++) {
                const float *p = s->corner[c];
                const float far =
                    hypotf(hypotf(p[0] - groups.x[g], p[1] - groups.y[g]), p[2] - groups.z[g]);
                assert_true(far <= groups.radius[g] * 1.00001f);
            }
        }
        assert_true(fabs(sum - groups.sum[g]) <= 1e-9 * sum);
        assert_true(fabsf(hypotf(groups.cosine[g], groups.sine[g]) - 1.0f) < 1e-3f);
    }
}

TEST(groups_hold_what_they_say)
{
    struct random r = {1};
    static const uint32_t counts[] = {1, 2, 3, 31, 32, 33, 500, MOST};
    for (size_t n = 0; n < sizeof counts / sizeof *counts; n++) {
        for (uint32_t i = 0; i < counts[n]; i++) {
            float at[3] = {random_unit(&r), 9.0f * random_unit(&r), random_unit(&r)}, normal[3];
            random_normal(&r, normal);
            put(i, at, normal, 0.1f * random_unit(&r) + 0.001f, (double)random_unit(&r) + 1e-3);
            shapes[i].both_sides = random_bits(&r) % 50 == 0;
        }
        assert_int_equal(emitter_groups_find(shapes, counts[n], order, &groups), 0);
        assert_true(groups.count <= EMITTER_GROUPS && groups.count <= counts[n]);
        check_bounds(counts[n]);
    }
}

/* A sphere far away and as bright as one nearby: no group has both, and none has front and back. */
TEST(spheres_are_told_apart)
{
    struct random r = {2};
    for (uint32_t i = 0; i < 1000; i++) {
        float normal[3];
        random_normal(&r, normal);
        const float at[3] = {normal[0] + (i % 2 ? 50.0f : 0.0f), normal[1], normal[2]};
        put(i, at, normal, 0.05f, 1.0);
    }
    assert_int_equal(emitter_groups_find(shapes, 1000, order, &groups), 0);
    assert_int_equal(groups.count, EMITTER_GROUPS);
    check_bounds(1000);
    for (uint32_t g = 0; g < groups.count; g++) {
        assert_true(groups.radius[g] < 2.0f);
        assert_true(groups.cosine[g] > 0.0f);
    }
}

/* Copies that no key tells apart stay together; powers of 0 and extents of 0 are borne. */
TEST(what_cannot_be_told_apart_stays_together)
{
    const float at[3] = {1e20f, -1e20f, 0}, up[3] = {0, 1, 0};
    for (uint32_t i = 0; i < 100; i++) put(i, at, up, 0.0f, i % 2 ? 1.0 : 0.0);
    assert_int_equal(emitter_groups_find(shapes, 100, order, &groups), 0);
    assert_int_equal(groups.count, 1);
    assert_true(groups.sum[0] == 50.0);
    assert_true(isfinite(groups.radius[0]) && isfinite(groups.axis_y[0]));
}
