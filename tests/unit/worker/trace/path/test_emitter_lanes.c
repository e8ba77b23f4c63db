/* How much groups of emitters may light surfaces: never nothing where a point of theirs does, the
 * same bits on every instruction set, and finite anywhere. */
#include <math.h>
#include <string.h>

#include "tests/random.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"
#include "tests/unit/worker/trace/isa_fixture.h"
#include "worker/trace/path/path_kernels.h"

enum { COUNT = 200 };

static struct emitter_shape shapes[COUNT];
static uint32_t order[COUNT];
static struct emitter_groups groups;

static float random_signed(struct random *r)
{
    return 2.0f * random_unit(r) - 1.0f;
}

static void random_unit_vector(struct random *r, float out[3])
{
    float length = 0.0f;
    while (!(length > 0.1f)) {
        for (int k = 0; k < 3; k++) out[k] = random_signed(r);
        length = sqrtf(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
    }
    for (int k = 0; k < 3; k++) out[k] /= length;
}

/* Triangles of a few spheres, which face outwards. */
static void make_groups(struct random *r)
{
    for (uint32_t i = 0; i < COUNT; i++) {
        const float x = 4.0f * (float)(i % 5), radius = 0.2f + 0.3f * (float)(i % 5);
        float *n = shapes[i].normal;
        random_unit_vector(r, n);
        for (int c = 0; c < 3; c++)
            for (int k = 0; k < 3; k++)
                shapes[i].corner[c][k] =
                    radius * n[k] + (k == 0 ? x : 0.0f) + 0.02f * random_signed(r);
        shapes[i].power = 1.0;
    }
    assert_int_equal(emitter_groups_find(shapes, COUNT, order, &groups), 0);
}

static float light_of(const struct emitter_shape *s, const float at[3], const float normal[3])
{
    float receives = 0.0f, sends = 0.0f, squared = 0.0f;
    for (int k = 0; k < 3; k++) {
        const float way = s->corner[0][k] - at[k];
        receives += way * normal[k];
        sends -= way * s->normal[k];
        squared += way * way;
    }
    return receives > 0.0f && sends > 0.0f ? receives * sends / (squared * squared) : 0.0f;
}

TEST(no_group_that_lights_is_left_out)
{
    struct random r = {1};
    int lit = 0, dark = 0;
    make_groups(&r);
    for (int round = 0; round < 300; round++) {
        struct lanes3 origin, normal;
        struct group_light first, light;
        for (int i = 0; i < LANES; i++) {
            float n[3];
            random_unit_vector(&r, n);
            origin.x[i] = 12.0f * random_signed(&r), origin.y[i] = 2.0f * random_signed(&r);
            origin.z[i] = 2.0f * random_signed(&r);
            normal.x[i] = n[0], normal.y[i] = n[1], normal.z[i] = n[2];
        }
        KERNELS_FOR(path_kernels, all_isas[0])->group_light(&groups, &origin, &normal, &first);
        for (int k = 1; k < isa_count(); k++) {
            KERNELS_FOR(path_kernels, all_isas[k])->group_light(&groups, &origin, &normal, &light);
            for (uint32_t g = 0; g < groups.count; g++)
                assert_memory_equal(first.group[g], light.group[g], sizeof light.group[g]);
            assert_memory_equal(first.total, light.total, sizeof light.total);
        }
        for (uint32_t g = 0; g < groups.count; g++)
            for (int i = 0; i < LANES; i++) {
                const float at[3] = {origin.x[i], origin.y[i], origin.z[i]};
                const float n[3] = {normal.x[i], normal.y[i], normal.z[i]};
                float most = 0.0f;
                for (uint32_t k = groups.first[g]; k < groups.first[g + 1]; k++)
                    most = fmaxf(most, light_of(&shapes[order[k]], at, n));
                if (most > 1e-4f) assert_true(first.group[g][i] > 0.0f);
                lit += most > 1e-4f;
                dark += first.group[g][i] == 0.0f;
            }
    }
    assert_true(lit > 10000 && dark > 10000);
}

TEST(odd_places_give_finite_numbers)
{
    static const float odd[] = {0.0f, 1e-30f, 4.0f, 1e15f, -1e18f};
    struct random r = {2};
    struct lanes3 origin, normal = {.y = {0}};
    struct group_light light;
    make_groups(&r);
    groups.power[0] = INFINITY;
    for (int i = 0; i < LANES; i++) {
        origin.x[i] = odd[i % 5], origin.y[i] = odd[i / 5 % 5], origin.z[i] = 0.0f;
        normal.y[i] = 1.0f;
    }
    for (int k = 0; k < isa_count(); k++) {
        KERNELS_FOR(path_kernels, all_isas[k])->group_light(&groups, &origin, &normal, &light);
        for (int i = 0; i < LANES; i++) {
            assert_true(isfinite(light.total[i]) && light.total[i] >= 0.0f);
            for (uint32_t g = 0; g < groups.count; g++)
                assert_true(isfinite(light.group[g][i]) && light.group[g][i] >= 0.0f);
        }
    }
}
