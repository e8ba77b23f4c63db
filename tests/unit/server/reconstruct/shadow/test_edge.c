/* Windows along edges: their accuracy on a straight edge, constants, pictures without room, and how
 * their answers join those of the sheared filter. */
#include "server/reconstruct/shadow/edge.h"
#include "tests/unit/server/reconstruct/shadow/shadow_accuracy.h"
#include "tests/unit/unit.h"

#define SIDE      96
#define MARGIN_PX 22

static struct shadow_scene scene;

/* One light over one picture, as far as edges need it. */
struct edge_case {
    struct patch *patch;
    struct receiver_light light;
    struct receivers receivers;
    uint32_t *pixels, count; /* those with a wedge */
    struct edge_answer *answers;
    float *own; /* of all of the picture's pixels */
};

static void list_pixels(struct edge_case *c, const struct wedges *wedges)
{
    const struct rect r = c->receivers.rect, p = c->patch->rect;
    for (int32_t y = p.y0; y < p.y1; y++) {
        for (int32_t x = p.x0; x < p.x1; x++) {
            const size_t i = (size_t)(y - r.y0) * (size_t)rect_width(r) + (size_t)(x - r.x0);
            if (wedges->most[i] >= 0.0f) c->pixels[c->count++] = (uint32_t)i;
        }
    }
}

static void estimate_all(struct edge_case *c)
{
    const struct rect p = c->patch->rect;
    for (int32_t y = p.y0; y < p.y1; y++) {
        for (int32_t x = p.x0; x < p.x1; x += STRATA_RUN) {
            const uint32_t left = (uint32_t)(p.x1 - x);
            strata_estimate(&c->light, c->patch, &shadow_kernels_sse42, x, y,
                            left < STRATA_RUN ? left : STRATA_RUN,
                            c->own + (size_t)(y - p.y0) * (size_t)rect_width(p) + (x - p.x0));
        }
    }
}

static void run_case(struct edge_case *c, const struct shadow_kernels *kernels)
{
    struct wedges wedges;
    struct coverage coverage;
    const size_t area = (size_t)rect_area(c->patch->rect);
    c->count = 0;
    c->pixels = calloc(area, sizeof *c->pixels);
    c->answers = calloc(area, sizeof *c->answers);
    c->own = calloc(area, sizeof *c->own);
    assert_true(c->pixels && c->answers && c->own);
    receiver_light_init(&c->light, &scene.plan, 0);
    assert_int_equal(receivers_create(&c->light, c->patch, kernels,
                                      rect_grow(c->patch->rect, MARGIN_PX), &c->receivers),
                     0);
    assert_int_equal(wedges_create(&c->light, c->patch, &c->receivers, kernels, &wedges), 0);
    assert_int_equal(coverage_create(c->light.strata, c->light.rectangle.profile, 1.0f, &coverage),
                     0);
    assert_int_equal(wedges_shear(&c->light, &wedges, kernels, &coverage, &c->receivers), 0);
    list_pixels(c, &wedges);
    estimate_all(c);
    assert_int_equal(
        edges_filter(&c->light, c->patch, kernels, &c->receivers, c->pixels, c->count, c->answers),
        0);
    coverage_fini(&coverage);
    wedges_fini(&wedges);
}

static void end_case(struct edge_case *c)
{
    receivers_fini(&c->receivers);
    free(c->own);
    free(c->answers);
    free(c->pixels);
}

/* The picture's pixel that number k of the list is. */
static size_t picture_index(const struct edge_case *c, uint32_t k)
{
    const size_t row = (size_t)rect_width(c->receivers.rect);
    const size_t x = c->pixels[k] % row - MARGIN_PX, y = c->pixels[k] / row - MARGIN_PX;
    return y * (size_t)rect_width(c->patch->rect) + x;
}

static void check_answers(const struct edge_case *c)
{
    for (uint32_t k = 0; k < c->count; k++) {
        const struct edge_answer *a = &c->answers[k];
        assert_true(a->seen == -1.0f ? a->kept == 1.0f : a->seen >= 0.0f && a->seen <= 1.0f);
        assert_true(a->kept >= 0.0f && a->kept <= 1.0f);
    }
}

/* A plate a little above the floor: one long edge across the picture, penumbra a few pixels wide.
 */
static void straight_edge(int32_t width, int32_t height, uint32_t profile)
{
    scene_init(&scene, width, height, 1.0f, 3);
    SCENE_BOX(&scene, -9, -9, 0.8f, 0.3f, 9, 0.9f);
    scene_camera(&scene.plan, (float[]){0, -11.5f, 9}, (float[]){0.3f, -0.2f, 0}, 0.3f);
    scene.plan.lights[0].profile = profile;
}

/* Measured, of uniform and Gaussian lights: 3.0 and 3.5 times less error than own estimates. */
TEST(straight_edges_are_smooth)
{
    for (uint32_t profile = 0; profile < 2; profile++) {
        struct shadow_truth truth;
        struct edge_case c;
        double own2 = 0.0, edge2 = 0.0;
        uint32_t count = 0;
        straight_edge(SIDE, SIDE, profile ? PROFILE_GAUSSIAN : PROFILE_UNIFORM);
        truth_init(&truth, &scene);
        c.patch = accuracy_patch(&scene, 3);
        run_case(&c, KERNELS_BEST(shadow_kernels));
        check_answers(&c);
        for (uint32_t k = 0; k < c.count; k++) {
            const size_t i = picture_index(&c, k);
            if (c.answers[k].seen < 0.0f || !truth_in_penumbra(&truth, i)) continue;
            const double own = (double)(c.own[i] - truth.seen[i]);
            const double edge = (double)(c.answers[k].seen - truth.seen[i]);
            own2 += own * own;
            edge2 += edge * edge;
            count++;
        }
        print_message("%u pixels: own estimates %.4f, along the edge %.4f\n", count,
                      sqrt(own2 / count), sqrt(edge2 / count));
        assert_true(count > SIDE);
        assert_true(2.5 * 2.5 * edge2 < own2);
        end_case(&c);
        patch_destroy(&c.patch);
        truth_fini(&truth);
    }
}

/* Own estimates tell of an edge, but the strata are all seen, or none is: exactly 1, exactly 0. */
TEST(constants_stay)
{
    for (uint32_t l = 1; l <= 16; l += l < 5 ? 1 : 11) {
        struct edge_case c;
        straight_edge(48, 48, PROFILE_UNIFORM);
        c.patch = accuracy_patch(&scene, l);
        run_case(&c, KERNELS_BEST(shadow_kernels));
        const struct receivers *r = &c.receivers;
        const size_t area = (size_t)rect_area(r->rect), stride = area + SHADOW_PLANE_PAD;
        float *planes = calloc(3 * stride, sizeof *planes);
        uint32_t *bits = calloc(STRATA_WORDS * stride, sizeof *bits);
        float *sigma_px = calloc(c.count + 1, sizeof *sigma_px);
        float *out = calloc(c.count + 1, sizeof *out);
        assert_true(planes && bits && sigma_px && out);
        const struct edge_field field = {.light = &c.light,
                                         .width = rect_width(r->rect),
                                         .scale = 1.0f,
                                         .pixels = &r->pixels,
                                         .seen = planes,
                                         .jitter = {planes + stride, planes + 2 * stride},
                                         .bits = bits,
                                         .stride = stride};
        for (size_t i = 0; i < area; i++) {
            planes[i] = (float)(i % 7) / 6.0f;
            planes[stride + i] = (float)(i % 31) / 31.0f;
            planes[2 * stride + i] = (float)(i % 37) / 37.0f;
        }
        for (uint32_t k = 0; k < c.count; k++) sigma_px[k] = 0.1f + 0.1f * (float)(k % 12);
        for (int all = 0; all < 2; all++) {
            uint32_t answered = 0;
            memset(bits, all ? 0xff : 0, STRATA_WORDS * stride * sizeof *bits);
            KERNELS_BEST(shadow_kernels)->filter_edges(&field, c.pixels, sigma_px, c.count, out);
            for (uint32_t k = 0; k < c.count; k++) {
                assert_true(out[k] == -1.0f || out[k] == (all ? 1.0f : 0.0f));
                answered += out[k] >= 0.0f;
            }
            assert_true(answered > c.count / 2);
        }
        free(out);
        free(sigma_px);
        free(bits);
        free(planes);
        end_case(&c);
        patch_destroy(&c.patch);
    }
}

TEST(pictures_without_room)
{
    static const int32_t sides[][2] = {{1, 1}, {1, 70}, {70, 1}, {2, 3}, {11, 5}};
    for (size_t i = 0; i < sizeof sides / sizeof *sides; i++) {
        struct edge_case c;
        straight_edge(sides[i][0], sides[i][1], PROFILE_UNIFORM);
        c.patch = accuracy_patch(&scene, 3);
        for (size_t k = 0; k < (size_t)rect_area(c.patch->rect); k++) {
            c.patch->lights[0].slope_min[k] = 0.01f; /* narrow everywhere */
            c.patch->lights[0].slope_max[k] = 0.02f;
        }
        run_case(&c, KERNELS_BEST(shadow_kernels));
        assert_true(c.count > 0);
        check_answers(&c);
        /* nothing differs around a single pixel */
        if (c.count == 1) assert_true(c.answers[0].seen == -1.0f && c.answers[0].kept == 1.0f);
        end_case(&c);
        patch_destroy(&c.patch);
    }
}

/* Every instruction set answers alike but for rounding, and a picture's pixels do not depend on who
 * else asks. */
TEST(answers_stand_alone)
{
    struct edge_case c, plain;
    straight_edge(64, 64, PROFILE_UNIFORM);
    c.patch = plain.patch = accuracy_patch(&scene, 3);
    run_case(&c, KERNELS_BEST(shadow_kernels));
    run_case(&plain, &shadow_kernels_sse42);
    assert_int_equal(c.count, plain.count);
    for (uint32_t k = 0; k < c.count; k++) {
        assert_true(fabsf(c.answers[k].seen - plain.answers[k].seen) <= 1e-5f);
        assert_true(fabsf(c.answers[k].kept - plain.answers[k].kept) <= 1e-5f);
    }
    for (uint32_t k = 0; k < c.count; k += 17) {
        struct edge_answer alone;
        assert_int_equal(edges_filter(&c.light, c.patch, KERNELS_BEST(shadow_kernels), &c.receivers,
                                      &c.pixels[k], 1, &alone),
                         0);
        assert_memory_equal(&alone, &c.answers[k], sizeof alone);
    }
    end_case(&plain);
    end_case(&c);
    patch_destroy(&c.patch);
}

TEST(answers_join)
{
    const struct edge_answer none = {.seen = -1.0f, .kept = 1.0f}, all = {.seen = 0.25f};
    const struct edge_answer half = {.seen = 0.25f, .kept = 0.5f};
    assert_true(edge_join(&none, 0.75f) == 0.75f && edge_join(&none, -1.0f) == -1.0f);
    assert_true(edge_join(&all, -1.0f) == 0.25f && edge_join(&half, -1.0f) == 0.25f);
    assert_true(edge_join(&half, 0.75f) == 0.5f && edge_join(&half, 0.25f) == 0.25f);
}
