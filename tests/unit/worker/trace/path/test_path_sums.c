/* What paths add up to for the residual filter: halves of a pass's samples, and what they see. */
#include <math.h>
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

#include "worker/trace/path/path_sums.h"

enum { SIDE_PX = 24, AREA = SIDE_PX * SIDE_PX };

/* Sample k of lane i: whole numbers, so that sums are exact; k's bit tells it from all others. */
static void show_sample(struct path_radiance *h, uint32_t slot, uint32_t k, uint32_t lane)
{
    struct path_rgb *const all[] = {
        &h->emission,         &h->direct, &h->indirect, &h->diffuse_direct,
        &h->diffuse_indirect, &h->normal, &h->tint};
    for (uint32_t n = 0; n < 7; n++) {
        all[n]->r[slot] = (float)(UINT32_C(1) << k % 20);
        all[n]->g[slot] = (float)(n + 1);
        all[n]->b[slot] = (float)(k * lane);
    }
    h->normal.r[slot] *= k & 1 ? -1.0f : 1.0f;
    h->distance[slot] = (float)(k + lane);
    h->alpha[slot] = (float)(2 * k + lane);
}

/* In batches of 1, 2, 3 ... samples, as many as are left. */
static void add_pass(struct path_sums *sums, const struct plan_pass *pass)
{
    static struct path_radiance h;
    struct counters counters = {.value = {0}};
    uint32_t done = 0;
    for (uint32_t size = 1; done < pass->count; size++) {
        const uint32_t count = size < pass->count - done ? size : pass->count - done;
        for (uint32_t k = 0; k < count; k++)
            for (uint32_t lane = 0; lane < LANES; lane++)
                show_sample(&h, k * LANES + lane, pass->first + done + k, lane);
        path_sums_add(sums, &h, count, true, &counters);
        done += count;
    }
    assert_int_equal(counters.value[COUNTER_REJECTED_NOT_FINITE], 0);
}

/* Sums over the samples in `set`, a bit each, of what show_sample() gives number n. */
static void expect_sum(const struct lanes3 *sum, uint64_t set, uint32_t n)
{
    for (uint32_t lane = 0; lane < LANES; lane++) {
        float r = 0, g = 0, b = 0;
        for (uint32_t k = 0; k < 64; k++) {
            if (!(set >> k & 1u)) continue;
            r += (float)(UINT32_C(1) << k % 20), g += (float)(n + 1), b += (float)(k * lane);
        }
        assert_true(sum->x[lane] == r && sum->y[lane] == g && sum->z[lane] == b);
    }
}

/* Sums are over the first halves of the longest parts that begin at a multiple of their length. */
TEST(halves_are_first_halves_of_parts)
{
    static const struct {
        uint32_t first, count;
        uint64_t half;
    } cases[] = {
        {0, 1, 0},     {0, 2, 0x1},    {0, 4, 0x3},        {0, 9, 0xf},
        {0, 16, 0xff}, {9, 7, 0x3000}, {4, 8, 0x330},      {16, 9, 0xf0000},
        {3, 1, 0},     {1, 3, 0x4},    {16, 20, 0xff0000},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        static struct path_sums s;
        const struct plan_pass pass = {.first = cases[k].first, .count = cases[k].count};
        const uint64_t half = cases[k].half;
        const uint64_t all = ((UINT64_C(1) << pass.count) - 1) << pass.first;
        path_sums_init(&s, &pass, 0, PLANES_RESIDUAL);
        add_pass(&s, &pass);
        expect_sum(&s.half_direct, half, 3);
        expect_sum(&s.half_indirect, half, 4);
        expect_sum(&s.diffuse_direct, all, 3);
        expect_sum(&s.diffuse_indirect, all, 4);
        for (uint32_t i = 0; i < LANES; i++) {
            float x = 0, distance = 0, alpha = 0, scattered = 0;
            for (uint32_t n = pass.first; n < pass.first + pass.count; n++) {
                x += (n & 1 ? -1.0f : 1.0f) * (float)(UINT32_C(1) << n % 20);
                distance += (float)(n + i);
                alpha += (float)(2 * n + i);
                if (half >> n & 1u) scattered += 5.0f;
            }
            assert_true(s.normal.x[i] == x && s.normal.y[i] == 6.0f * (float)pass.count);
            assert_true(s.distance[i] == distance && s.alpha[i] == alpha);
            assert_true(s.tint.y[i] == 7.0f * (float)pass.count);
            assert_true(s.half_scattered.y[i] == scattered);
        }
        /* As many as the coordinator takes for half of the split samples. */
        const struct plan_split parts = plan_pass_split(&pass);
        assert_true(s.half_direct.y[0] == 4.0f * (float)(parts.count * parts.length / 2));
    }
}

/* Halves of lens samples are every second stratum of the lens, as on a chessboard. */
TEST(halves_of_lens_samples_are_a_chessboard)
{
    static const struct {
        uint32_t strata;
        uint64_t half;
    } cases[] = {{1, 0}, {2, 0x6}, {3, 0xaa}, {4, 0x5a5a}, {5, 0xaaaaaa}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        static struct path_sums s;
        const struct plan_pass pass = {.count = cases[k].strata * cases[k].strata};
        path_sums_init_lens(&s, cases[k].strata, PLANES_RESIDUAL);
        add_pass(&s, &pass);
        expect_sum(&s.half_direct, cases[k].half, 3);
        expect_sum(&s.half_indirect, cases[k].half, 4);
        /* As many as the coordinator takes for half of them. */
        assert_true(s.half_direct.y[0] == 4.0f * (float)(pass.count / 2));
    }
}

/* Sums of four times as many samples are those of as many as the pass says. */
TEST(more_samples_count_as_fewer)
{
    static struct path_sums s;
    static struct samples_layout layout;
    static struct plan plan;
    struct samples *samples = NULL;
    struct block b;
    const struct plan_pass pass = {.count = 4}, all = {.count = 16};
    plan.planes = PLANES_PATH_ALL;
    assert_int_equal(samples_layout_init(&layout, &plan, 0, LANES_ACROSS, LANES_ACROSS), 0);
    assert_int_equal(samples_create(&layout, &samples), 0);
    block_init(&b, 0, 0, LANES_ACROSS, LANES_ACROSS, (struct rect){0, 0, 4, 4});
    path_sums_init(&s, &pass, 2, PLANES_PATH_ALL);
    add_pass(&s, &all);
    expect_sum(&s.half_direct, 0xff, 3);
    const float spread = s.spread.y[3], x = s.spread.x[3], split = s.split_squares[3];
    path_sums_store(&s, &b, samples);
    assert_true(samples_f32(samples, PLANE_PATH_DIFFUSE_DIRECT, 1)[3] == 4.0f * 4.0f);
    assert_true(samples_f32(samples, PLANE_PATH_HALF_DIRECT, 1)[3] == 4.0f * 2.0f);
    assert_true(samples_f32(samples, PLANE_PATH_RADIANCE, 0)[3] == 3.0f * 65535.0f / 4.0f);
    assert_true(samples_f32(samples, PLANE_PATH_DISTANCE, 0)[3] == (120.0f + 16.0f * 3.0f) / 4.0f);
    /* The mean's variance: spread / (n (n - 1)). */
    assert_true(spread == 0.0f && x > 0.0f && split > 0.0f);
    assert_true(fabsf(samples_f32(samples, PLANE_PATH_M2, 0)[3] / 12.0f - x / 240.0f) < x * 1e-8f);
    assert_true(samples_f32(samples, PLANE_PATH_HALF_DIFFERENCE2, 0)[3] == split / 16.0f);
    samples_destroy(&samples);
}

/* Samples that end at what the camera sees: what is scattered follows the coverage. */
TEST(coverage_scales_what_is_scattered)
{
    static struct path_radiance h;
    static struct path_sums s;
    const struct plan_pass pass = {.count = 4};
    struct counters counters = {.value = {0}};
    struct lanes_mask on = {{0}};
    struct lanes3 emission = {.x = {0}};
    float coverage[LANES] = {0};
    on.on[1] = on.on[2] = -1;
    path_sums_init(&s, &pass, 0, PLANES_RESIDUAL);
    for (size_t i = 0; i < LANES; i++) { /* one of four shines, one meets a surface */
        h.emission.r[i] = 8.0f;
        h.direct.r[LANES + i] = 4.0f;
        h.albedo.g[LANES + i] = 0.5f;
        h.distance[LANES + i] = 3.0f;
        h.coverage[LANES + i] = i == 2 ? 0.0f : 1.0f;
    }
    path_sums_add(&s, &h, 4, true, &counters);
    emission.x[1] = emission.x[2] = 8.0f * 8.0f; /* of 28: a half covers, a quarter shines */
    coverage[1] = coverage[2] = 15.0f;
    path_sums_see(&s, &on, &emission, coverage, 28);
    assert_true(s.emission.x[1] == 9.0f && s.coverage[1] == 2.0f);
    assert_true(s.direct.x[1] == 8.0f && s.half_scattered.x[1] == 8.0f);
    assert_true(s.radiance.x[1] == 17.0f && s.albedo.y[1] == 1.0f && s.distance[1] == 6.0f);
    assert_true(s.emission.x[0] == 8.0f && s.direct.x[0] == 4.0f); /* off */
    assert_true(s.emission.x[2] == 8.0f && s.direct.x[2] == 4.0f); /* its surface is not known */
}

TEST(halves_are_not_added_up_unasked)
{
    static struct path_sums s;
    const struct plan_pass pass = {.count = 16};
    path_sums_init(&s, &pass, 0, PLANES_PATH);
    add_pass(&s, &pass);
    expect_sum(&s.half_direct, 0, 3);
    expect_sum(&s.half_scattered, 0, 0);
    expect_sum(&s.normal, 0, 0);
    expect_sum(&s.diffuse_direct, 0xffff, 3);
}

/* A sample that is not finite is black in its half, too. */
TEST(odd_samples_count_as_black_in_halves)
{
    static struct path_radiance h;
    static struct path_sums s;
    const struct plan_pass pass = {.count = 4};
    struct counters counters = {.value = {0}};
    for (uint32_t k = 0; k < 4; k++)
        for (uint32_t i = 0; i < LANES; i++) show_sample(&h, k * LANES + i, k, i);
    h.indirect.g[LANES + 7] = INFINITY;
    path_sums_init(&s, &pass, 0, PLANES_RESIDUAL);
    path_sums_add(&s, &h, 4, true, &counters);
    assert_int_equal(counters.value[COUNTER_REJECTED_NOT_FINITE], 1);
    for (int i = 0; i < LANES; i++) {
        const float samples = i == 7 ? 1.0f : 2.0f;
        assert_true(s.half_direct.y[i] == 4.0f * samples);
        assert_true(s.half_scattered.y[i] == 5.0f * samples);
    }
}

/* A floor with a glossy panel above it, under a light. */
static struct plan room(struct scene_fixture *f, float half_side)
{
    struct plan p = floor_plan(f, half_side, SIDE_PX);
    uint32_t glossy = fixture_material(f, 0.2f, 0.6f, 0.2f);
    f->materials[glossy].specular = 1.0f;
    f->materials[glossy].roughness = 0.4f;
    fixture_panel(f, glossy, (float[]){1, 0.5f, 0}, (float[]){0.5f, 0, 0}, (float[]){0, 0, -0.5f});
    fixture_ceiling_light(&p, 0, 3, 0, 0.5f, 1);
    p.light_planes = 0;
    p.planes = (PLANES_PATH & ~PLANE_BIT(PATH_VISIBILITY)) | PLANES_RESIDUAL;
    p.bounces = 2;
    return p;
}

static const float *plane(const struct traced *t, enum plane_id id, uint32_t c)
{
    const float *v = samples_f32(t->samples, id, c);
    assert_non_null(v);
    return v;
}

/* The first `count` samples of a plan, as a pass of their own. */
static struct samples *trace_first(struct traced *t, const struct plan *p, uint32_t count)
{
    struct samples *out = NULL;
    const struct plan_pass pass = {.number = plan_pass_count(p), .count = count};
    const struct tile_job job = {.scene = t->scene,
                                 .plan = p,
                                 .pass = &pass,
                                 .rect = {0, 0, SIDE_PX, SIDE_PX},
                                 .counters = &t->counters};
    assert_int_equal(tile_trace_pass(t->tracer, &job, &out), 0);
    return out;
}

/* The half of a pass of sixteen samples is what its first eight bring; other planes do not
 * change. */
TEST(half_a_pass_is_a_pass_of_half)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f, 3.0f);
    p.paths.spp = 16;
    p.target_error = 0.1f; /* then there may be more passes */
    p.spp_max = 64;
    struct traced sixteen = trace_all(f, &p);
    struct samples *eight = trace_first(&sixteen, &p, 8);
    p.planes &= ~PLANES_RESIDUAL;
    struct traced plain = trace_all(f, &p);
    const size_t bytes = AREA * sizeof(float);
    double lit = 0;
    for (uint32_t c = 0; c < 3; c++) {
        const float *half = plane(&sixteen, PLANE_PATH_HALF_SCATTERED, c);
        const float *direct = samples_f32(eight, PLANE_PATH_DIRECT, c);
        const float *indirect = samples_f32(eight, PLANE_PATH_INDIRECT, c);
        assert_memory_equal(plane(&sixteen, PLANE_PATH_HALF_DIRECT, c),
                            samples_f32(eight, PLANE_PATH_DIFFUSE_DIRECT, c), bytes);
        assert_memory_equal(plane(&sixteen, PLANE_PATH_HALF_INDIRECT, c),
                            samples_f32(eight, PLANE_PATH_DIFFUSE_INDIRECT, c), bytes);
        for (int i = 0; i < AREA; i++) {
            assert_true(fabsf(half[i] - direct[i] - indirect[i]) <= 1e-5f * half[i]);
            lit += (double)(half[i] > 0.0f);
        }
        assert_memory_equal(plane(&plain, PLANE_PATH_RADIANCE, c),
                            plane(&sixteen, PLANE_PATH_RADIANCE, c), bytes);
    }
    assert_true(lit > AREA);
    traced_fini(&plain);
    samples_destroy(&eight);
    traced_fini(&sixteen);
    free(f);
}

/* Only samples that see something count; the floor ends within the picture. */
TEST(features_are_of_what_is_seen)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f, 0.8f);
    p.paths.spp = 16;
    struct traced t = trace_all(f, &p);
    const float *seen = plane(&t, PLANE_PATH_COVERAGE, 0);
    const float *distance = plane(&t, PLANE_PATH_DISTANCE, 0);
    uint32_t partial = 0, floor = 0, tinted = 0;
    for (int32_t i = 0; i < AREA; i++) {
        double to[3];
        floor_point(&p, i % SIDE_PX, i / SIDE_PX, to);
        const double far = sqrt(to[0] * to[0] + 16.0 + to[2] * to[2]);
        const float up = plane(&t, PLANE_PATH_NORMAL, 1)[i];
        partial += seen[i] > 0.0f && seen[i] < 16.0f;
        assert_true(fabsf(up - seen[i]) <= 1e-4f);
        assert_true(fabsf(plane(&t, PLANE_PATH_NORMAL, 0)[i]) <= 1e-4f);
        assert_true(distance[i] <= 1.01f * (float)far * seen[i]);
        assert_true(plane(&t, PLANE_PATH_TINT, 0)[i] <= seen[i]);
        assert_true(seen[i] > 0.0f || distance[i] == 0.0f);
        tinted += plane(&t, PLANE_PATH_TINT, 1)[i] > 0.0f;
        if (to[0] > 0.4) continue; /* the panel is there */
        floor += seen[i] > 0.0f;
        assert_true(plane(&t, PLANE_PATH_TINT, 0)[i] == 0.0f); /* it is matt */
        assert_true(plane(&t, PLANE_PATH_TINT, 3)[i] == 0.0f);
        assert_true(fabs((double)distance[i] - far * (double)seen[i]) <= 0.03 * (double)seen[i]);
    }
    assert_true(partial > 10 && floor > 50 && tinted > 10);
    traced_fini(&t);
    free(f);
}
