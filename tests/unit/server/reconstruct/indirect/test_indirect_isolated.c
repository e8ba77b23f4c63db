/* Indirect light of pixels that have no neighbours of their surface: a board of facets, each a
 * pixel wide, that face eight ways. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/reconstruct/indirect/indirect.h"
#include "tests/random.h"
#include "tests/unit/server/reconstruct/indirect/indirect_scene.h"
#include "tests/unit/unit.h"

enum { SIDE = 120, FIRST = 52, END = 68, AREA = SIDE * SIDE };

static const struct rect inner = {FIRST, FIRST, END, END};

struct board {
    struct plan plan;
    struct patch *patch;
    float *out[3];
    struct indirect_statistics statistics;
};

/* What a facet that faces way k gets. */
static float light_of(int k)
{
    return 1.0f + 0.1f * (float)(k < 4 ? k : 8 - k);
}

static void facet(int k, bool flat, float normal[3])
{
    const float tilt = flat ? 0.0f : 0.354f, turn = 0.785398163f * (float)k;
    normal[0] = tilt * cosf(turn);
    normal[1] = tilt * sinf(turn);
    normal[2] = sqrtf(1.0f - normal[0] * normal[0] - normal[1] * normal[1]);
}

static int way_of(int32_t x, int32_t y)
{
    return (x + 2 * y) & 7;
}

/* Facets of a board two units ahead; `noise` around their light. */
static void board_init(struct board *b, uint32_t light, uint32_t strata, bool flat, float noise)
{
    struct random r = {7};
    *b = (struct board){0};
    room_plan(&b->plan, 512, INDIRECT_FILTER_CONSTANT, strata);
    b->plan.lens_relight = light;
    assert_int_equal(patch_create(&b->plan, (struct rect){0, 0, SIDE, SIDE}, &b->patch), 0);
    for (int c = 0; c < 3; c++) assert_non_null(b->out[c] = calloc(AREA, sizeof(float)));
    for (int32_t y = 0; y < SIDE; y++)
        for (int32_t x = 0; x < SIDE; x++) {
            float o[3], d[3], normal[3];
            const size_t i = (size_t)(y * SIDE + x);
            plan_camera_ray(&b->plan, (float)x + 0.5f, (float)y + 0.5f, o, d);
            facet(way_of(x, y), flat, normal);
            b->patch->depth[i] = -2.0f / d[2];
            b->patch->bounce_distance_min[i] = 1.0f;
            b->patch->id[i] = 1;
            for (int c = 0; c < 3; c++) {
                b->patch->normal[c][i] = normal[c];
                b->patch->indirect[c][i] =
                    light_of(flat ? 0 : way_of(x, y)) + noise * (random_unit(&r) - 0.5f);
            }
        }
    const float *const in[3] = {b->patch->indirect[0], b->patch->indirect[1],
                                b->patch->indirect[2]};
    assert_int_equal(
        indirect_filter(&b->plan, b->patch, inner, 3, in, b->out, NULL, &b->statistics), 0);
}

static void board_fini(struct board *b)
{
    for (int c = 0; c < 3; c++) free(b->out[c]);
    patch_destroy(&b->patch);
}

/* RMS distance of the first channel from the facets' light, over `inner`. */
static float error_of(const struct board *b)
{
    double sum = 0.0;
    for (int32_t y = FIRST; y < END; y++)
        for (int32_t x = FIRST; x < END; x++) {
            const double d = (double)(b->out[0][y * SIDE + x] - light_of(way_of(x, y)));
            sum += d * d;
        }
    return (float)sqrt(sum / (double)rect_area(inner));
}

static float error_with(uint32_t light, uint32_t strata, float noise, uint64_t *isolated)
{
    struct board b;
    board_init(&b, light, strata, false, noise);
    const float error = error_of(&b);
    *isolated = b.statistics.pixels_isolated;
    board_fini(&b);
    return error;
}

/* Under a lens their noise goes; under a pinhole nothing looks at a window. */
TEST(noise_goes)
{
    uint64_t isolated;
    const float noise = error_with(LENS_RELIGHT_OWN, 3, 4.0f, &isolated);
    assert_int_equal(isolated, 0);
    const float left = error_with(LENS_RELIGHT_SKY, 3, 4.0f, &isolated);
    assert_int_equal(isolated, rect_area(inner));
    print_message("noise of %.3f, alone %.3f, in windows %.3f\n", 4.0 / sqrt(12.0), (double)noise,
                  (double)left);
    assert_true(noise > 0.15f && left < 0.4f * noise);
}

/* What others bring fades, and is gone when a surface's own rays are enough. */
TEST(bias_goes)
{
    uint64_t isolated;
    const float few = error_with(LENS_RELIGHT_SKY, 1, 0.0f, &isolated);
    const float more = error_with(LENS_RELIGHT_SKY, 3, 0.0f, &isolated);
    const float many = error_with(LENS_RELIGHT_SKY, 8, 0.0f, &isolated);
    print_message("off by %.4f, %.4f, %.6f\n", (double)few, (double)more, (double)many);
    assert_true(few < 0.11f && more < 0.9f * few);
    assert_true(many < 1e-5f);
}

/* A plane's pixels are not alone: filters follow it, and nothing else happens. */
TEST(planes_are_left_alone)
{
    struct board own, lens;
    board_init(&own, LENS_RELIGHT_OWN, 3, true, 4.0f);
    board_init(&lens, LENS_RELIGHT_SKY, 3, true, 4.0f);
    assert_int_equal(lens.statistics.pixels_isolated, 0);
    for (int c = 0; c < 3; c++) assert_memory_equal(own.out[c], lens.out[c], AREA * sizeof(float));
    board_fini(&own);
    board_fini(&lens);
}

/* A constant stays what it is, to rounding. */
TEST(windows_keep_constants)
{
    struct board b;
    board_init(&b, LENS_RELIGHT_INDIRECT, 3, false, 0.0f);
    for (size_t i = 0; i < AREA; i++) b.patch->indirect[0][i] = 0.75f;
    const float *const in[3] = {b.patch->indirect[0], b.patch->indirect[0], b.patch->indirect[0]};
    assert_int_equal(indirect_filter(&b.plan, b.patch, inner, 3, in, b.out, NULL, &b.statistics),
                     0);
    for (int32_t y = FIRST; y < END; y++)
        for (int32_t x = FIRST; x < END; x++)
            assert_true(fabsf(b.out[2][y * SIDE + x] - 0.75f) < 1e-6f);
    board_fini(&b);
}
