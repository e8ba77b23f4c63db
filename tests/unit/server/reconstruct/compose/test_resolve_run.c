/* Rows resolved at once, and composed: the bits of pixels resolved one by one. */
#include <math.h>
#include <string.h>

#include "proto/job/job.h"
#include "proto/octahedron.h"
#include "server/image/image.h"
#include "server/reconstruct/compose/compose.h"
#include "server/reconstruct/compose/resolve_run.h"
#include "tests/random.h"
#include "tests/unit/unit.h"

enum { WIDTH = 61, HEIGHT = 5, AREA = WIDTH * HEIGHT, SUBS = 3 };

static struct random numbers_of = {5};

static uint32_t bits(void)
{
    return (uint32_t)random_bits(&numbers_of);
}

static bool one_in(uint32_t many)
{
    return bits() % many == 0;
}

/* Planes of a patch whose sub-samples show their pixel's surface, another one, or none. */
static float numbers[80][AREA];
static uint32_t ids[1 + SUBS][AREA];
static int planes_taken;

static float *take_plane(float least, float range)
{
    float *plane = numbers[planes_taken++];
    for (int i = 0; i < AREA; i++) plane[i] = least + range * random_unit(&numbers_of);
    return plane;
}

static void take_rgb(float *out[3], float range)
{
    for (int c = 0; c < 3; c++) out[c] = take_plane(0.0f, range);
}

static void random_normal(float *const out[3], int i, const float *const like[3])
{
    float n[3], sum = 0.0f;
    for (int c = 0; c < 3; c++) n[c] = (like ? like[c][i] : 0.0f) + 0.1f * random_unit(&numbers_of);
    if (!like || one_in(6)) n[bits() % 3] += 1.0f;
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

/* Pixels are as wide as surfaces are far where `wide`: points lie near however they face. */
static void make_plan(struct plan *plan, uint32_t camera, bool wide)
{
    memset(plan, 0, sizeof *plan);
    plan->width_px = plan->height_px = 128;
    plan->sub_samples = SUBS;
    plan->length_unit = 1.0f;
    plan->camera = (struct plan_camera){.type = camera,
                                        .right = {1, 0, 0},
                                        .up = {0, 1, 0},
                                        .forward = {0, 0, -1},
                                        .half_width = wide ? 100.0f : 0.5f,
                                        .half_height = wide ? 100.0f : 0.5f};
}

/* A resolver with all that it borrows. */
struct resolve_case {
    struct plan plan;
    struct patch patch;
    struct lighting lighting;
    struct resolver resolver;
};

static struct resolver *make_case(struct resolve_case *c, uint32_t camera, bool wide, bool glossy,
                                  bool lit_glossy)
{
    make_plan(&c->plan, camera, wide);
    make_patch(&c->patch, glossy);
    make_lighting(&c->lighting, lit_glossy);
    resolver_init(&c->resolver, &c->plan, &c->patch, &c->lighting);
    return &c->resolver;
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
        const uint32_t count = 1 + bits() % (uint32_t)left;
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

TEST(runs_are_their_pixels)
{
    uint32_t plain = 0, rounds = 200;
    for (uint32_t round = 0; round < rounds; round++) {
        struct resolve_case c;
        make_case(&c, round & 1, round % 3 == 0, round & 2, round & 4);
        if (round % 5 == 0) c.patch.id = NULL;
        resolver_init(&c.resolver, &c.plan, &c.patch, &c.lighting);
        assert_int_equal(c.resolver.subs, SUBS);
        plain += check_runs(&c.resolver);
    }
    assert_in_range(plain, rounds * AREA / 10, rounds * AREA * 9 / 10);
}

/* Errors are told of one by one. */
TEST(nothing_is_plain_where_errors_are_asked_for)
{
    struct resolve_case c;
    struct resolved_run run;
    make_case(&c, 0, false, false, false)->errors = true;
    resolve_run(&c.resolver, 0, WIDTH, &run);
    for (int k = 0; k < WIDTH; k++) assert_int_equal(run.plain[k], 0);
}

TEST(planes_may_be_missing)
{
    struct resolve_case c;
    make_case(&c, 0, false, false, false);
    c.patch.albedo[0] = NULL;
    resolver_init(&c.resolver, &c.plan, &c.patch, &c.lighting);
    assert_int_equal(c.resolver.subs, 0);
    assert_true(check_runs(&c.resolver) > AREA / 2);
    c.patch.depth = NULL;
    resolver_init(&c.resolver, &c.plan, &c.patch, &c.lighting);
    assert_int_equal(check_runs(&c.resolver), 0);
}

/* Beauty, its light apart, and what is left of errors, of a block in the patch. */
/* The variance of emission: 64 points between the least and the most around, of a known mean. */
static float glow_of(const struct patch *p, int c, int32_t x, int32_t y)
{
    const float mean = p->emission[c][patch_pixel(p, x, y)];
    float least = mean, most = mean;
    for (int k = 0; k < 9; k++) {
        const int32_t u = x - 1 + k % 3, v = y - 1 + k / 3;
        if (u < p->core.x0 || u >= p->core.x1 || v < p->core.y0 || v >= p->core.y1) continue;
        least = fminf(least, p->emission[c][patch_pixel(p, u, v)]);
        most = fmaxf(most, p->emission[c][patch_pixel(p, u, v)]);
    }
    return (most - mean) * (mean - least) / 256.0f;
}

static void check_block(const struct resolver *r, struct rect block)
{
    static const char *const rgb[] = {"R", "G", "B"};
    static const char *const shine[] = {"emission.R", "emission.G", "emission.B"};
    struct image *image;
    struct block_variance variance;
    struct block_statistics statistics = {.pixels_background = 0};
    const uint32_t layers = LAYER_BEAUTY | LAYER_EMISSION | LAYER_DIRECT;
    assert_int_equal(image_create(layers, 128, 128, &image), 0);
    assert_int_equal(block_variance_create(block, &variance), 0);
    compose_light_field(r, block, image, &variance, &statistics);
    for (int32_t y = block.y0; y < block.y1; y++)
        for (int32_t x = block.x0; x < block.x1; x++) {
            const size_t i = patch_pixel(r->patch, x, y);
            struct resolved one;
            resolve_pixel(r, i, &one);
            for (int c = 0; c < 3; c++) {
                const float sent = r->patch->emission[c][i];
                const float left =
                    variance
                        .by_source[ERROR_SOURCE_CENTRES][c][block_variance_index(&variance, x, y)];
                assert_true(*plane_at(image_plane(image, rgb[c]), x, y) == one.total[c] + sent);
                assert_true(*plane_at(image_plane(image, shine[c]), x, y) == sent);
                assert_true(left ==
                            (r->errors ? one.spread[c] + glow_of(r->patch, c, x, y) : 0.0f));
            }
        }
    block_variance_fini(&variance);
    image_destroy(&image);
}

TEST(blocks_are_their_pixels)
{
    for (int round = 0; round < 40; round++) {
        struct resolve_case c;
        make_case(&c, 0, false, false, false)->errors = round % 2;
        take_rgb(c.patch.emission, 2.0f);
        const int32_t left = (int32_t)(bits() % 9), top = (int32_t)(bits() % 3);
        const struct rect all = c.patch.rect;
        check_block(&c.resolver, (struct rect){all.x0 + left, all.y0 + top, all.x1 - 2, all.y1});
    }
}

/* Sub-sample k of pixel i lies and faces as the pixel does from now on, as workers have it of those
 * that surely show its surface (lone_finder.h). False: it does not. */
static bool settle(const struct resolver *r, struct patch *p, uint32_t k, size_t i)
{
    struct surface_facing facing = {.known = false};
    float normal[3];
    if (!surface_surely_same(&r->view, p, i, k, &facing) ||
        !surface_near_anyhow(&r->view, p->depth[i], p->sub_depth[k][i]))
        return false;
    for (int c = 0; c < 3; c++) normal[c] = p->normal[c][i];
    octahedron_unpack8((uint16_t)octahedron_coarsen(octahedron_pack16(normal)), normal);
    for (int c = 0; c < 3; c++) p->sub_normal[k][c][i] = normal[c];
    p->sub_depth[k][i] = p->depth[i];
    return true;
}

/* To the last bit, errors too. */
TEST(what_is_surely_same_may_be_settled)
{
    uint32_t settled = 0, rounds = 60;
    for (uint32_t round = 0; round < rounds; round++) {
        struct resolve_case c;
        struct resolved before[AREA];
        make_case(&c, round & 1, round % 3 != 0, round & 2, round & 2)->errors = round & 4;
        for (size_t i = 0; i < AREA; i++) resolve_pixel(&c.resolver, i, &before[i]);
        for (size_t i = 0; i < AREA; i++)
            for (uint32_t k = 0; k < SUBS; k++) settled += settle(&c.resolver, &c.patch, k, i);
        for (size_t i = 0; i < AREA; i++) {
            struct resolved now;
            resolve_pixel(&c.resolver, i, &now);
            assert_memory_equal(&now, &before[i], sizeof now);
        }
    }
    assert_in_range(settled, rounds * AREA * SUBS / 10, rounds * AREA * SUBS * 9 / 10);
}
