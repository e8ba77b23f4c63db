/* Rows resolved at once: the bits of pixels resolved and normals read one by one. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "proto/octahedron.h"
#include "server/film/normals.h"
#include "server/reconstruct/resolve_run.h"

enum { WIDTH = 61, HEIGHT = 5, AREA = WIDTH * HEIGHT, SUBS = 3 };

static uint64_t state_of_random = 5;

static uint32_t random_bits(void)
{
    state_of_random =
        state_of_random * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(state_of_random >> 32);
}

static float random_unit(void)
{
    return (float)(random_bits() >> 8) * 0x1p-24f;
}

static bool one_in(uint32_t many)
{
    return random_bits() % many == 0;
}

/* Planes of a patch whose sub-samples show their pixel's surface, another one, or none. */
static float numbers[80][AREA];
static uint32_t ids[1 + SUBS][AREA];
static int planes_taken;

static float *take_plane(float least, float range)
{
    float *plane = numbers[planes_taken++];
    for (int i = 0; i < AREA; i++) plane[i] = least + range * random_unit();
    return plane;
}

static void take_rgb(float *out[3], float range)
{
    for (int c = 0; c < 3; c++) out[c] = take_plane(0.0f, range);
}

static void random_normal(float *const out[3], int i, const float *const like[3])
{
    float n[3], sum = 0.0f;
    for (int c = 0; c < 3; c++) n[c] = (like ? like[c][i] : 0.0f) + 0.1f * random_unit();
    if (!like || one_in(6)) n[random_bits() % 3] += 1.0f;
    for (int c = 0; c < 3; c++) sum += n[c] * n[c];
    for (int c = 0; c < 3; c++) out[c][i] = n[c] / sqrtf(sum);
}

static void make_patch(struct patch *p, bool glossy)
{
    memset(p, 0, sizeof *p);
    planes_taken = 0;
    p->rect = p->core = (struct rect){7, 3, 7 + WIDTH, 3 + HEIGHT};
    p->depth = take_plane(4.0f, 0.02f);
    p->id = ids[SUBS];
    take_rgb(p->normal, 1.0f);
    take_rgb(p->albedo, 1.0f);
    if (glossy) take_rgb(p->reflectance, 1.0f);
    for (uint32_t k = 0; k < SUBS; k++) {
        p->sub_depth[k] = take_plane(4.0f, 0.02f);
        p->sub_id[k] = ids[k];
        take_rgb(p->sub_normal[k], 1.0f);
        take_rgb(p->sub_albedo[k], 1.0f);
        if (glossy && k != 1) take_rgb(p->sub_reflectance[k], 1.0f);
    }
    for (int i = 0; i < AREA; i++) {
        p->id[i] = one_in(5) ? 0x20000u : 9;
        random_normal(p->normal, i, NULL);
        if (one_in(9)) p->depth[i] = 0.0f;
        for (uint32_t k = 0; k < SUBS; k++) {
            random_normal(p->sub_normal[k], i, (const float *const *)p->normal);
            p->sub_id[k][i] = one_in(12) ? 7 : surface_sub_id(p->id[i]);
            if (one_in(12)) p->sub_depth[k][i] = one_in(2) ? 0.0f : 5.0f;
        }
    }
}

static void make_lighting(struct lighting *l, bool glossy)
{
    memset(l, 0, sizeof *l);
    take_rgb(l->direct, 3.0f);
    take_rgb(l->indirect, 3.0f);
    take_rgb(l->total, 3.0f);
    if (glossy) take_rgb(l->glossy, 3.0f);
    for (int i = 0; i < AREA; i += 7) l->direct[0][i] = -0.0f, l->indirect[1][i] = -1e-30f;
}

static void make_plan(struct plan *plan, uint32_t camera)
{
    memset(plan, 0, sizeof *plan);
    plan->width_px = plan->height_px = 128;
    plan->sub_samples = SUBS;
    plan->length_unit = 1.0f;
    plan->camera = (struct plan_camera){.type = camera,
                                        .right = {1, 0, 0},
                                        .up = {0, 1, 0},
                                        .forward = {0, 0, -1},
                                        .half_width = 0.5f,
                                        .half_height = 0.5f};
}

static void assert_same(const struct resolved *one, const struct resolved_run *run, uint32_t k)
{
    for (int c = 0; c < 3; c++) {
        assert_memory_equal(&one->direct[c], &run->direct[c][k], sizeof(float));
        assert_memory_equal(&one->indirect[c], &run->indirect[c][k], sizeof(float));
        assert_memory_equal(&one->total[c], &run->total[c][k], sizeof(float));
        assert_memory_equal(&one->albedo[c], &run->albedo[c][k], sizeof(float));
    }
    assert_memory_equal(&one->coverage, &run->coverage[k], sizeof(float));
}

/* Of all pixels, in runs of any length; how many were plain. */
static uint32_t check_runs(const struct resolver *r)
{
    uint32_t plain = 0;
    for (size_t i = 0; i < AREA;) {
        const size_t left = WIDTH - i % WIDTH;
        const uint32_t count = 1 + random_bits() % (uint32_t)left;
        struct resolved_run run;
        memset(&run, 0x7f, sizeof run);
        resolve_run(r, i, count, &run);
        for (uint32_t k = 0; k < count; k++) {
            struct resolved one;
            resolve_pixel(r, i + k, &one);
            plain += run.plain[k] != 0;
            if (!run.plain[k]) resolved_run_set(&run, k, &one);
            assert_same(&one, &run, k);
        }
        i += count;
    }
    return plain;
}

static void runs_are_their_pixels(void **state)
{
    uint32_t plain = 0, rounds = 200;
    (void)state;
    for (uint32_t round = 0; round < rounds; round++) {
        struct patch patch;
        struct lighting lighting;
        struct resolver resolver;
        struct plan plan;
        make_plan(&plan, round & 1);
        make_patch(&patch, round & 2);
        make_lighting(&lighting, round & 4);
        if (round % 5 == 0) patch.id = NULL;
        resolver_init(&resolver, &plan, &patch, &lighting);
        assert_int_equal(resolver.subs, SUBS);
        plain += check_runs(&resolver);
    }
    assert_in_range(plain, rounds * AREA / 10, rounds * AREA * 9 / 10);
}

/* Errors are told of one by one. */
static void nothing_is_plain_where_errors_are_asked_for(void **state)
{
    struct patch patch;
    struct lighting lighting;
    struct resolver resolver;
    struct resolved_run run;
    struct plan plan;
    (void)state;
    make_plan(&plan, 0);
    make_patch(&patch, false);
    make_lighting(&lighting, false);
    resolver_init(&resolver, &plan, &patch, &lighting);
    resolver.errors = true;
    resolve_run(&resolver, 0, WIDTH, &run);
    for (int k = 0; k < WIDTH; k++) assert_int_equal(run.plain[k], 0);
}

static void normals_are_read_as_one_by_one(void **state)
{
    static uint32_t wide[100];
    static uint16_t narrow[100];
    static float x[104], y[104], z[104];
    float *const out[3] = {x, y, z};
    (void)state;
    for (uint32_t round = 0; round < 500; round++) {
        const size_t count = 1 + random_bits() % 100, to = round % 4;
        for (size_t i = 0; i < count; i++) {
            wide[i] = i > 0 && !one_in(round % 40 + 2) ? wide[i - 1] : random_bits();
            narrow[i] = (uint16_t)wide[i];
        }
        normals_unpack16(wide, count, to, out);
        for (size_t i = 0; i < count; i++) {
            float n[3];
            octahedron_unpack16(wide[i], n);
            assert_true(x[to + i] == n[0] && y[to + i] == n[1] && z[to + i] == n[2]);
        }
        normals_unpack8(narrow, count, to, out);
        for (size_t i = 0; i < count; i++) {
            float n[3];
            octahedron_unpack8(narrow[i], n);
            assert_true(x[to + i] == n[0] && y[to + i] == n[1] && z[to + i] == n[2]);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(runs_are_their_pixels),
        cmocka_unit_test(nothing_is_plain_where_errors_are_asked_for),
        cmocka_unit_test(normals_are_read_as_one_by_one),
    };
    return cmocka_run_group_tests_name("resolve_run", tests, NULL, NULL);
}
