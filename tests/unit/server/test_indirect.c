/* The axis-aligned filters of indirect light: their error on a room of formulas, what they keep
 * exactly, that nothing hangs on how a picture is cut, and odd input. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "server/reconstruct/indirect.h"
#include "tests/random.h"
#include "tests/unit/server/indirect_scene.h"

#define LINES 512

static const uint32_t filters[] = {INDIRECT_FILTER_CONSTANT, INDIRECT_FILTER_LINEAR,
                                   INDIRECT_FILTER_BLEND};
#define FILTERS (sizeof filters / sizeof *filters)

struct picture {
    float *channel[3], *width; /* of the patch's size */
    struct indirect_statistics statistics;
};

static void picture_init(struct picture *p, const struct patch *patch)
{
    const size_t area = (size_t)rect_area(patch->rect);
    *p = (struct picture){0};
    for (int c = 0; c < 3; c++) p->channel[c] = calloc(area, sizeof(float));
    p->width = calloc(area, sizeof(float));
    assert_true(p->channel[0] && p->channel[1] && p->channel[2] && p->width);
}

static void picture_fini(struct picture *p)
{
    for (int c = 0; c < 3; c++) free(p->channel[c]);
    free(p->width);
}

/* Filters the patch's indirect light over `inner`, block by block. */
static void filter_blocks(const struct plan *plan, const struct patch *patch, struct rect inner,
                          int32_t side, struct picture *out)
{
    const float *const in[3] = {patch->indirect[0], patch->indirect[1], patch->indirect[2]};
    for (int32_t y = inner.y0; y < inner.y1; y += side) {
        for (int32_t x = inner.x0; x < inner.x1; x += side) {
            const struct rect block =
                rect_intersect((struct rect){x, y, x + side, y + side}, inner);
            assert_int_equal(indirect_filter(plan, patch, block, 3, in, out->channel, out->width,
                                             &out->statistics),
                             0);
        }
    }
}

static size_t index_of(const struct patch *patch, int32_t x, int32_t y)
{
    return (size_t)(y - patch->rect.y0) * (size_t)rect_width(patch->rect) +
           (size_t)(x - patch->rect.x0);
}

/* The yellow box's and the white sphere's contacts with the floor; the blue sphere, the floor and
 * the red wall behind; the tall box before the far wall. */
#define CROPS 3
static const struct rect crops[CROPS] = {
    {274, 364, 322, 412}, {84, 408, 132, 456}, {196, 204, 244, 252}};
#define TRUTH_STEP 4
#define TRUTH_SIDE 80 /* 6400 samples: an error of 0.5 % of the mean */
#define TRUTHS     (48 / TRUTH_STEP * 48 / TRUTH_STEP)

struct truth {
    double light[CROPS][TRUTHS][3], albedo[CROPS][TRUTHS][3], mean;
};

static struct truth truth; /* one for all: it takes a second */

static int truth_init(void **state)
{
    (void)state;
    struct truth *t = &truth;
    struct plan camera;
    const struct plan *plan = &camera;
    room_plan(&camera, LINES, INDIRECT_FILTER_CONSTANT, 4);
    t->mean = 0.0;
    for (int c = 0; c < CROPS; c++) {
        for (int i = 0; i < TRUTHS; i++) {
            const int32_t x = crops[c].x0 + TRUTH_STEP * (i % (48 / TRUTH_STEP));
            const int32_t y = crops[c].y0 + TRUTH_STEP * (i / (48 / TRUTH_STEP));
            const struct room_hit h = room_primary(plan, x, y);
            room_truth(plan, x, y, TRUTH_SIDE, t->light[c][i]);
            for (int k = 0; k < 3; k++) {
                t->albedo[c][i][k] = (double)h.albedo[k];
                t->mean += t->light[c][i][k] * t->albedo[c][i][k] / (3 * CROPS * TRUTHS);
            }
        }
    }
    return 0;
}

/* Adds the squared errors of the light sent on, over its true mean. */
static void add_errors(const struct truth *t, int crop, const struct patch *patch,
                       float *const channel[3], double *squares)
{
    for (int i = 0; i < TRUTHS; i++) {
        const int32_t x = crops[crop].x0 + TRUTH_STEP * (i % (48 / TRUTH_STEP));
        const int32_t y = crops[crop].y0 + TRUTH_STEP * (i / (48 / TRUTH_STEP));
        for (int k = 0; k < 3; k++) {
            const double light = (double)channel[k][index_of(patch, x, y)];
            const double d = (light - t->light[crop][i][k]) * t->albedo[crop][i][k] / t->mean;
            *squares += d * d;
        }
    }
}

/* Root of the mean squared error of the crops at l x l samples. */
static void measure(const struct truth *t, uint32_t filter, uint32_t l, double *plain,
                    double *filtered)
{
    struct plan plan;
    room_plan(&plan, LINES, filter, l);
    *plain = *filtered = 0.0;
    for (int c = 0; c < CROPS; c++) {
        struct picture picture;
        struct patch *patch = room_patch(&plan, rect_grow(crops[c], indirect_halo_px(&plan)));
        assert_non_null(patch);
        picture_init(&picture, patch);
        filter_blocks(&plan, patch, crops[c], 64, &picture);
        add_errors(t, c, patch, patch->indirect, plain);
        add_errors(t, c, patch, picture.channel, filtered);
        picture_fini(&picture);
        patch_destroy(&patch);
    }
    *plain = sqrt(*plain / (3 * CROPS * TRUTHS));
    *filtered = sqrt(*filtered / (3 * CROPS * TRUTHS));
}

static uint32_t filter_for(uint32_t samples)
{
    return samples <= 25 ? INDIRECT_FILTER_CONSTANT : INDIRECT_FILTER_LINEAR;
}

/* With the filter that the plan takes by itself. Measured at 4, 9, 16, 25, 36, 64, 144, 256
 * samples, plain: 1.07 .77 .57 .47 .36 .27 .16 .12, filtered: .0309 .0262 .0239 .0208 .0143 .0110
 * .0088 .0078 (the truth's own error is .005): 24 times less than plain at 16 samples, where 10 are
 * asked for, and steps of 9 % and more. */
static void error_falls(void **state)
{
    (void)state;
    static const uint32_t strata[] = {2, 3, 4, 5, 6, 8, 12, 16};
    double last = 1.0;
    for (size_t i = 0; i < sizeof strata / sizeof *strata; i++) {
        const uint32_t n = strata[i] * strata[i];
        double plain, error;
        measure(&truth, filter_for(n), strata[i], &plain, &error);
        print_message("%u spp: plain %.4f, filtered %.4f\n", n, plain, error);
        assert_true(error < last);
        if (n == 16) assert_true(10.0 * error < plain);
        last = error;
    }
}

/* The blend, with a tenth more than was measured allowed; from 64 samples on it beats linear fits.
 */
static void blend_errs_little(void **state)
{
    (void)state;
    static const struct {
        uint32_t strata;
        double measured;
    } cases[] = {{4, .0177}, {6, .0152}, {8, .0106}, {12, .0084}, {16, .0074}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double plain, linear, blend;
        measure(&truth, INDIRECT_FILTER_LINEAR, cases[i].strata, &plain, &linear);
        measure(&truth, INDIRECT_FILTER_BLEND, cases[i].strata, &plain, &blend);
        print_message("%u spp: linear %.4f, blend %.4f\n", cases[i].strata * cases[i].strata,
                      linear, blend);
        assert_true(blend < 1.1 * cases[i].measured);
        if (cases[i].strata >= 8) assert_true(blend < linear);
    }
}

/* Of the whole room, at every eighth pixel of 256 lines. Measured: -0.20 %,
 * -0.23 % and -0.20 %, where 0.5 % are allowed. */
static void energy_is_kept(void **state)
{
    (void)state;
    static const uint32_t strata[FILTERS] = {4, 6, 8};
    static double lights[32 * 32][3];
    struct plan plan;
    double mean = 0.0;
    room_plan(&plan, 256, INDIRECT_FILTER_CONSTANT, 4);
    for (int32_t i = 0; i < 32 * 32; i++) {
        room_truth(&plan, 8 * (i % 32) + 4, 8 * (i / 32) + 4, 48, lights[i]);
        for (int k = 0; k < 3; k++) mean += lights[i][k];
    }
    for (size_t f = 0; f < FILTERS; f++) {
        struct picture picture;
        double off = 0.0;
        room_plan(&plan, 256, filters[f], strata[f]);
        struct patch *patch = room_patch(&plan, (struct rect){0, 0, 256, 256});
        assert_non_null(patch);
        picture_init(&picture, patch);
        filter_blocks(&plan, patch, patch->rect, 128, &picture);
        for (int32_t i = 0; i < 32 * 32; i++) {
            const size_t at = index_of(patch, 8 * (i % 32) + 4, 8 * (i / 32) + 4);
            for (int k = 0; k < 3; k++)
                off += ((double)picture.channel[k][at] - lights[i][k]) / mean;
        }
        print_message("filter %u, %u spp: energy %+.4f\n", filters[f], strata[f] * strata[f], off);
        assert_true(fabs(off) < 0.005);
        picture_fini(&picture);
        patch_destroy(&patch);
    }
}

/* The samples of `rect` cut out of a larger patch. */
static struct patch *cut_patch(const struct plan *plan, const struct patch *from, struct rect rect)
{
    struct patch *p;
    assert_int_equal(patch_create(plan, rect, &p), 0);
    const size_t width = (size_t)rect_width(rect);
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t to = index_of(p, rect.x0, y), at = index_of(from, rect.x0, y);
        memcpy(p->depth + to, from->depth + at, width * sizeof(float));
        memcpy(p->id + to, from->id + at, width * sizeof *p->id);
        memcpy(p->reflector + to, from->reflector + at, width * sizeof(float));
        for (int k = 0; k < 3; k++) {
            memcpy(p->normal[k] + to, from->normal[k] + at, width * sizeof(float));
            memcpy(p->indirect[k] + to, from->indirect[k] + at, width * sizeof(float));
        }
    }
    return p;
}

static void assert_same_pixels(const struct picture *a, const struct patch *whole,
                               const struct picture *b, const struct patch *part, struct rect rect)
{
    const size_t bytes = (size_t)rect_width(rect) * sizeof(float);
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t i = index_of(whole, rect.x0, y), j = index_of(part, rect.x0, y);
        for (int c = 0; c < 3; c++)
            assert_memory_equal(a->channel[c] + i, b->channel[c] + j, bytes);
        assert_memory_equal(a->width + i, b->width + j, bytes);
    }
}

/* Cuts of any size into blocks, and patches that hold no more than a block and its halo, give the
 * same bits. */
static void cuts_do_not_show(void **state)
{
    (void)state;
    static const int32_t sides[] = {16, 64, 128};
    const struct rect all = {0, 0, 150, 150};
    struct plan plan;
    room_plan(&plan, 150, INDIRECT_FILTER_CONSTANT, 2);
    plan.mu = 2.0f; /* as wide as at 300 lines */
    struct patch *patch = room_patch(&plan, all);
    assert_non_null(patch);
    for (size_t f = 0; f < FILTERS; f++) {
        struct picture whole;
        plan.indirect_filter = filters[f];
        picture_init(&whole, patch);
        filter_blocks(&plan, patch, all, 150, &whole);
        for (size_t s = 0; s < 3; s++) {
            const struct rect block = {37, 61, 37 + sides[s], 61 + sides[s]};
            const struct rect inner = rect_intersect(block, all);
            const struct rect seen = rect_grow(inner, indirect_halo_px(&plan));
            struct patch *part = cut_patch(&plan, patch, rect_intersect(seen, all));
            struct picture cut, alone;
            picture_init(&cut, patch);
            picture_init(&alone, part);
            filter_blocks(&plan, patch, all, sides[s], &cut);
            filter_blocks(&plan, part, inner, 128, &alone);
            assert_same_pixels(&whole, patch, &cut, patch, all);
            assert_same_pixels(&whole, patch, &alone, part, inner);
            picture_fini(&cut);
            picture_fini(&alone);
            patch_destroy(&part);
        }
        picture_fini(&whole);
    }
    patch_destroy(&patch);
}

static void constants_stay(void **state)
{
    (void)state;
    static const float constants[3] = {0.1f, 65504.0f, 3e-6f};
    const struct rect all = {0, 0, 100, 100};
    struct plan plan;
    room_plan(&plan, 100, INDIRECT_FILTER_CONSTANT, 3);
    plan.mu = 4.0f;
    struct patch *patch = room_patch(&plan, all);
    assert_non_null(patch);
    for (size_t i = 0; i < 100 * 100; i++)
        for (int c = 0; c < 3; c++) patch->indirect[c][i] = constants[c];
    for (size_t f = 0; f < FILTERS; f++) {
        struct picture picture;
        plan.indirect_filter = filters[f];
        picture_init(&picture, patch);
        filter_blocks(&plan, patch, all, 64, &picture);
        for (size_t i = 0; i < 100 * 100; i++) {
            assert_true(picture.width[i] > 0.0f);
            for (int c = 0; c < 3; c++) assert_true(picture.channel[c][i] == constants[c]);
        }
        assert_int_equal(picture.statistics.pixels_filtered, 100 * 100);
        assert_int_equal(picture.statistics.pixels_skipped, 0);
        picture_fini(&picture);
    }
    patch_destroy(&patch);
}

/* A plane across the view, `distance` away, whose reflectors are `reflector` away. */
static struct patch *plane_patch(struct plan *plan, int32_t width, int32_t height, float distance,
                                 float reflector)
{
    struct patch *p;
    room_plan(plan, LINES, INDIRECT_FILTER_CONSTANT, 4);
    plan->width_px = width;
    plan->height_px = height;
    plan->camera.half_width = 0.3f * (float)width / (float)height;
    plan->camera.half_height = 0.3f;
    assert_int_equal(patch_create(plan, (struct rect){0, 0, width, height}, &p), 0);
    for (int32_t y = 0; y < height; y++) {
        for (int32_t x = 0; x < width; x++) {
            const size_t i = index_of(p, x, y);
            float o[3], d[3];
            plan_camera_ray(plan, (float)x + 0.5f, (float)y + 0.5f, o, d);
            p->depth[i] = distance / -d[2];
            p->id[i] = 1;
            p->reflector[i] = reflector;
            for (int k = 0; k < 3; k++) {
                p->normal[k][i] = k == 2 ? 1.0f : 0.0f;
                p->indirect[k][i] = 1.0f + (float)((x * 7 + y * 3 + k) % 5);
            }
        }
    }
    return p;
}

/* Rule B keeps what is linear on a plane, up to the picture's border and to rounding; rule A is
 * drawn inwards there. Measured: 2e-7 and 0.06. */
static void lines_stay_straight(void **state)
{
    (void)state;
    struct plan plan;
    struct patch *patch = plane_patch(&plan, 90, 80, 5.0f, REFLECTOR_NONE * 2.0f);
    float worst[2] = {0};
    plan.mu = 3.0f;
    for (size_t i = 0; i < 90 * 80; i++) {
        const float a = ((float)(i % 90) + 0.5f) / 90.0f, b = ((float)(i / 90) + 0.5f) / 80.0f;
        for (int k = 0; k < 3; k++) patch->indirect[k][i] = 2.0f + a - b;
    }
    for (size_t f = 0; f < 2; f++) {
        struct picture picture;
        plan.indirect_filter = filters[f];
        picture_init(&picture, patch);
        filter_blocks(&plan, patch, patch->rect, 64, &picture);
        for (size_t i = 0; i < 90 * 80; i++)
            worst[f] = fmaxf(worst[f], fabsf(picture.channel[0][i] - patch->indirect[0][i]));
        picture_fini(&picture);
    }
    print_message("rule A off by %g, rule B by %g\n", (double)worst[0], (double)worst[1]);
    assert_true(worst[0] > 0.01f && worst[1] < 2e-5f);
    patch_destroy(&patch);
}

/* Walls that meet at right angles, and pixels where nothing was measured, lend each other nothing.
 */
static void surfaces_stay_apart(void **state)
{
    (void)state;
    const struct rect all = {0, 0, 128, 128};
    struct plan plan;
    room_plan(&plan, 128, INDIRECT_FILTER_CONSTANT, 2);
    plan.mu = 4.0f;
    struct patch *patch = room_patch(&plan, all);
    assert_non_null(patch);
    for (size_t i = 0; i < 128 * 128; i++) {
        const bool sphere = patch->id[i] > 1 + ROOM_BOXES;
        if (sphere) patch->reflector[i] = 0.0f;
        for (int c = 0; c < 3; c++) patch->indirect[c][i] = 2.0f + patch->normal[c][i];
    }
    for (size_t f = 0; f < FILTERS; f++) {
        struct picture picture;
        plan.indirect_filter = filters[f];
        picture_init(&picture, patch);
        filter_blocks(&plan, patch, all, 64, &picture);
        for (size_t i = 0; i < 128 * 128; i++) {
            const bool sphere = patch->id[i] > 1 + ROOM_BOXES;
            assert_true((picture.width[i] > 0.0f) == !sphere);
            for (int c = 0; c < 3; c++)
                assert_true(picture.channel[c][i] == (sphere ? 0.0f : patch->indirect[c][i]));
        }
        assert_true(picture.statistics.pixels_skipped > 100);
        assert_int_equal(picture.statistics.pixels_skipped + picture.statistics.pixels_filtered,
                         128 * 128);
        picture_fini(&picture);
    }
    patch_destroy(&patch);
}

/* Lengths may be in any unit. */
static void nothing_hangs_on_the_unit(void **state)
{
    (void)state;
    const struct rect all = {0, 0, 96, 96};
    struct plan plan;
    room_plan(&plan, 96, INDIRECT_FILTER_CONSTANT, 3);
    plan.mu = 3.0f;
    struct patch *patch = room_patch(&plan, all);
    assert_non_null(patch);
    for (size_t f = 0; f < FILTERS; f++) {
        struct picture small, large;
        plan.indirect_filter = filters[f];
        picture_init(&small, patch);
        picture_init(&large, patch);
        filter_blocks(&plan, patch, all, 96, &small);
        for (size_t i = 0; i < 96 * 96; i++) {
            patch->depth[i] *= 1024.0f;
            patch->reflector[i] *= 1024.0f;
        }
        plan.length_unit *= 1024.0f;
        filter_blocks(&plan, patch, all, 96, &large);
        assert_same_pixels(&small, patch, &large, patch, all);
        for (size_t i = 0; i < 96 * 96; i++) {
            patch->depth[i] /= 1024.0f;
            patch->reflector[i] /= 1024.0f;
        }
        plan.length_unit /= 1024.0f;
        picture_fini(&small);
        picture_fini(&large);
    }
    patch_destroy(&patch);
}

/* Far reflectors: the cap; near ones: what they allow; mu multiplies both. */
static void widths(void **state)
{
    (void)state;
    struct plan plan;
    struct patch *patch = plane_patch(&plan, 512, 512, 5.0f, REFLECTOR_NONE * 2.0f);
    const size_t centre = 256 * 512 + 256;
    const struct rect inner = {250, 250, 260, 260};
    const float pixel = plan_pixel_size(&plan, 5.0f);
    static const float near_px[] = {0.01f, 10.0f, 1000.0f};
    static const float expected_px[] = {4.761905f, 5.952381f, 7.5f}; /* 8, 10 px * 2 / 2.8 / 1.2 */
    for (int k = 0; k < 3; k++) {
        for (size_t i = 0; i < 512 * 512; i++) patch->reflector[i] = near_px[k] * pixel;
        struct picture picture;
        picture_init(&picture, patch);
        for (plan.mu = 0.5f; plan.mu < 3.0f; plan.mu *= 2.0f) {
            filter_blocks(&plan, patch, inner, 64, &picture);
            const float width = picture.width[centre] / plan.mu;
            assert_true(fabsf(width - expected_px[k]) < 1e-3f * expected_px[k]);
        }
        picture_fini(&picture);
    }
    patch_destroy(&patch);
}

/* Mean and least width of the blend over the columns x0 .. x1 - 1. */
static void blend_widths(const struct plan *plan, const struct patch *patch, int32_t x0, int32_t x1,
                         float *mean, float *least)
{
    struct picture picture;
    const struct rect inner = {60, 60, 140, 140};
    picture_init(&picture, patch);
    filter_blocks(plan, patch, inner, 64, &picture);
    *mean = 0.0f;
    *least = 1e30f;
    for (int32_t y = inner.y0; y < inner.y1; y++) {
        for (int32_t x = x0; x < x1; x++) {
            const float width = picture.width[index_of(patch, x, y)];
            *mean += width / (float)((x1 - x0) * (inner.y1 - inner.y0));
            *least = fminf(*least, width);
        }
    }
    picture_fini(&picture);
}

/* Where there is nothing but noise, independent or blue, the blend stands near its widest, twice
 * rule B's; where light changes, noise or none, near its finest, half of rule B's. Measured, over
 * rule B: 1.99 and 1.98 (least 1.71), 0.61 and 0.64. */
static void widths_follow_noise(void **state)
{
    (void)state;
    struct plan plan;
    struct random r = {11};
    struct patch *patch = plane_patch(&plan, 200, 200, 5.0f, REFLECTOR_NONE * 2.0f);
    float mean, least;
    plan.indirect_filter = INDIRECT_FILTER_BLEND;
    plan.indirect_strata_per_axis = 8;
    const float rule = 7.0f / cbrtf(2.0f) * 200.0f / (float)LINES;
    for (int blue = 0; blue < 2; blue++) {
        for (size_t i = 0; i < 200 * 200; i++) {
            const float sign = (i % 200 + i / 200) % 2 ? 1.0f : -1.0f, u = random_unit(&r) - 0.5f;
            for (int k = 0; k < 3; k++)
                patch->indirect[k][i] = 1.0f + (blue ? 0.3f * sign + 0.1f * u : 0.6f * u);
        }
        blend_widths(&plan, patch, 60, 140, &mean, &least);
        print_message("noise: %.3f of rule B, least %.3f\n", (double)(mean / rule),
                      (double)(least / rule));
        assert_true(mean > 1.8f * rule && least > 1.5f * rule);
    }
    for (int noisy = 0; noisy < 2; noisy++) {
        for (size_t i = 0; i < 200 * 200; i++) {
            const float u = noisy ? 0.2f * (random_unit(&r) - 0.5f) : 0.0f;
            for (int k = 0; k < 3; k++) patch->indirect[k][i] = (i % 200 < 100 ? 0.2f : 1.0f) + u;
        }
        blend_widths(&plan, patch, 98, 102, &mean, &least);
        print_message("edge: %.3f of rule B, least %.3f\n", (double)(mean / rule),
                      (double)(least / rule));
        assert_true(mean < 0.7f * rule);
    }
    patch_destroy(&patch);
}

static void halo_is_bounded(void **state)
{
    (void)state;
    struct plan plan;
    room_plan(&plan, LINES, INDIRECT_FILTER_NONE, 4);
    assert_int_equal(indirect_halo_px(&plan), 0);
    plan.indirect_filter = INDIRECT_FILTER_CONSTANT;
    assert_int_equal(indirect_halo_px(&plan), 21); /* 2.5 * 7.5 and two more */
    for (plan.height_px = 1; plan.height_px <= LIMIT_IMAGE_SIDE_PX; plan.height_px *= 2) {
        for (uint32_t l = 1; l <= LIMIT_STRATA_PER_AXIS; l += 5) {
            for (plan.mu = 1e-3f; plan.mu <= (float)LIMIT_FILTER_MU; plan.mu *= 10.0f) {
                plan.indirect_strata_per_axis = l;
                for (size_t f = 0; f < FILTERS; f++) {
                    plan.indirect_filter = filters[f];
                    assert_in_range(indirect_halo_px(&plan), 1, INDIRECT_REACH_MAX_PX);
                }
            }
        }
    }
}

/* One pixel, one row, one column; nothing met anywhere, everything met at once. */
static void small_pictures(void **state)
{
    (void)state;
    static const int32_t sizes[][2] = {{1, 1}, {1, 700}, {700, 1}, {3, 2}, {17, 33}};
    static const float reflectors[] = {0.0f, 1e-30f, 1.0f, REFLECTOR_NONE * 2.0f};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        for (size_t r = 0; r < 4; r++) {
            struct plan plan;
            struct patch *patch = plane_patch(&plan, sizes[s][0], sizes[s][1], 3.0f, reflectors[r]);
            const size_t area = (size_t)rect_area(patch->rect);
            for (size_t f = 0; f < FILTERS; f++) {
                struct picture picture;
                plan.indirect_filter = filters[f];
                picture_init(&picture, patch);
                filter_blocks(&plan, patch, patch->rect, 1024, &picture);
                for (size_t i = 0; i < area; i++) {
                    const float v = picture.channel[0][i];
                    assert_true(r == 0 ? v == 0.0f : v > 0.3f && v < 6.0f);
                    assert_true((picture.width[i] > 0.0f) == (r != 0));
                }
                assert_int_equal(picture.statistics.blocks_skipped, r == 0);
                assert_int_equal(picture.statistics.pixels_skipped, r == 0 ? area : 0);
                picture_fini(&picture);
            }
            patch_destroy(&patch);
        }
    }
}

static float wild(struct random *r, float least, float most)
{
    return least * powf(most / least, random_unit(r));
}

/* Whatever a film can hold comes out finite and not negative. */
static void all_stays_finite(void **state)
{
    (void)state;
    struct random r = {5};
    struct plan plan;
    struct patch *patch = plane_patch(&plan, 60, 50, 3.0f, 1.0f);
    for (int turn = 0; turn < 4; turn++) {
        const float spread = turn == 0 ? 1.01f : turn == 1 ? 1e3f : 1e20f;
        plan.mu = turn == 3 ? 100.0f : 1.0f;
        for (size_t i = 0; i < 60 * 50; i++) {
            const bool empty = random_unit(&r) < 0.1f;
            patch->depth[i] = empty ? 0.0f : fminf(wild(&r, 1.0f, spread) * 1e-4f, 1e16f);
            patch->id[i] = empty ? 0 : (uint32_t)(random_bits(&r) % 3) + UINT32_MAX - 3;
            patch->reflector[i] = empty || random_unit(&r) < 0.1f ? 0.0f : wild(&r, 1e-20f, 1e20f);
            for (int k = 0; k < 3; k++) {
                patch->indirect[k][i] = random_unit(&r) < 0.3f ? 0.0f : wild(&r, 1e-20f, 1e16f);
                if (empty) patch->normal[k][i] = 0.0f;
            }
        }
        for (size_t f = 0; f < FILTERS; f++) {
            struct picture picture;
            plan.indirect_filter = filters[f];
            picture_init(&picture, patch);
            filter_blocks(&plan, patch, patch->rect, 64, &picture);
            for (size_t i = 0; i < 60 * 50; i++) {
                assert_true(isfinite(picture.width[i]));
                for (int c = 0; c < 3; c++)
                    assert_true(picture.channel[c][i] >= 0.0f && isfinite(picture.channel[c][i]));
            }
            picture_fini(&picture);
        }
    }
    patch_destroy(&patch);
}

static void plain_average(void **state)
{
    (void)state;
    struct plan plan;
    struct patch *patch = plane_patch(&plan, 20, 10, 3.0f, 1.0f);
    struct picture picture;
    patch->reflector[7] = 0.0f;
    plan.indirect_filter = INDIRECT_FILTER_NONE;
    picture_init(&picture, patch);
    filter_blocks(&plan, patch, patch->rect, 64, &picture);
    for (size_t i = 0; i < 20 * 10; i++) {
        assert_true(picture.channel[1][i] == (i == 7 ? 0.0f : patch->indirect[1][i]));
        assert_true(picture.width[i] == 0.0f);
    }
    assert_int_equal(picture.statistics.pixels_filtered, 0);
    picture_fini(&picture);
    patch_destroy(&patch);
}

static void refuses(void **state)
{
    (void)state;
    struct plan plan;
    struct patch *patch = plane_patch(&plan, 20, 10, 3.0f, 1.0f);
    struct indirect_statistics statistics = {0};
    struct picture p;
    picture_init(&p, patch);
    const float *const in[3] = {patch->indirect[0], patch->indirect[1], patch->indirect[2]};
    const struct rect all = patch->rect, outside = {0, 0, 21, 10}, empty = {3, 3, 3, 5};
    assert_int_equal(indirect_filter(&plan, patch, outside, 3, in, p.channel, NULL, &statistics),
                     ERR_RANGE);
    assert_int_equal(indirect_filter(&plan, patch, empty, 3, in, p.channel, NULL, &statistics),
                     ERR_RANGE);
    assert_int_equal(indirect_filter(&plan, patch, all, INDIRECT_CHANNELS_MAX + 1, in, p.channel,
                                     NULL, &statistics),
                     ERR_RANGE);
    static const uint32_t not_these[] = {INDIRECT_FILTER_SHEARED + 1, 99};
    for (int i = 0; i < 2; i++) {
        plan.indirect_filter = not_these[i];
        assert_int_equal(indirect_filter(&plan, patch, all, 3, in, p.channel, NULL, &statistics),
                         ERR_RANGE);
    }
    assert_int_equal(statistics.pixels_filtered + statistics.pixels_skipped, 0);
    plan.indirect_filter = INDIRECT_FILTER_CONSTANT;
    assert_int_equal(indirect_filter(&plan, patch, all, 3, in, p.channel, NULL, &statistics), 0);
    picture_fini(&p);
    patch_destroy(&patch);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(error_falls),
        cmocka_unit_test(blend_errs_little),
        cmocka_unit_test(energy_is_kept),
        cmocka_unit_test(cuts_do_not_show),
        cmocka_unit_test(constants_stay),
        cmocka_unit_test(lines_stay_straight),
        cmocka_unit_test(surfaces_stay_apart),
        cmocka_unit_test(nothing_hangs_on_the_unit),
        cmocka_unit_test(widths),
        cmocka_unit_test(widths_follow_noise),
        cmocka_unit_test(halo_is_bounded),
        cmocka_unit_test(small_pictures),
        cmocka_unit_test(all_stays_finite),
        cmocka_unit_test(plain_average),
        cmocka_unit_test(refuses),
    };
    return cmocka_run_group_tests(tests, truth_init, NULL);
}
