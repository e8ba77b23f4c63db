/* The sheared filter of indirect light: against brute force, the plain average and filtering
 * without shear on scenes of formulas; constants; cuts; odd pictures and odd numbers. */
#include <string.h>

#include "tests/unit/server/reconstruct/indirect/v_plane_accuracy.h"
#include "tests/unit/unit.h"

#define LINES 512

static struct v_plane_scene scene;

static struct rect centred(int32_t side)
{
    const int32_t low = (LINES - side) / 2;
    return (struct rect){low, low, low + side, low + side};
}

struct errors {
    double plain, sheared, brute, straight;
};

/* straight: by brute force with the same widths and no shear. */
static struct errors measure(struct rect rect, uint32_t l, int32_t stride)
{
    const struct rect all = {0, 0, LINES, LINES};
    const struct rect seen = rect_intersect(rect_grow(rect, V_PLANE_HALO_PX), all);
    struct patch *patch = v_plane_patch(&scene, seen, l);
    struct v_plane_picture truth = accuracy_truth(&scene, rect, stride);
    struct v_plane_picture plain = accuracy_plain(&scene, patch, rect);
    struct v_plane_picture sheared = accuracy_filter(&scene, patch, rect, LINES, NULL, NULL);
    struct v_plane_picture brute = accuracy_brute(&scene, patch, rect, 1.0f, stride);
    struct v_plane_picture straight = accuracy_brute(&scene, patch, rect, 0.0f, stride);
    const struct errors e = {accuracy_rmse(&truth, &plain, &truth, stride),
                             accuracy_rmse(&truth, &sheared, &truth, stride),
                             accuracy_rmse(&truth, &brute, &truth, stride),
                             accuracy_rmse(&truth, &straight, &truth, stride)};
    print_message("%2u spp: plain %.4f, without shear %.4f, sheared %.4f, brute force %.4f\n",
                  l * l, e.plain, e.straight, e.sheared, e.brute);
    picture_fini(&straight);
    picture_fini(&brute);
    picture_fini(&sheared);
    picture_fini(&plain);
    picture_fini(&truth);
    patch_destroy(&patch);
    return e;
}

/* A near textured reflector is what shear is for; there is nothing to win far from it. Measured at
 * these heights, times less error than without shear: 18.5, 7.8, 1.03; times brute force's:
 * 1.01, .99, 1.01; 15 to 20 times less than plain. The bounds hold that with up to a third to
 * spare; no figure of a paper stands behind them. */
TEST(near_reflector)
{
    static const struct {
        float height;
        double wins, loses; /* against no shear, against brute force */
    } cases[] = {{0.05f, 12.0, 1.12}, {0.1f, 5.0, 1.02}, {0.3f, 0.95, 1.02}};
    v_plane_scene_init(&scene, V_PLANE_CHECKER, LINES, LINES);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        scene.height = cases[i].height;
        const struct errors e = measure(centred(64), 4, 4);
        assert_true(cases[i].wins * e.sheared < e.straight);
        assert_true(e.sheared < cases[i].loses * e.brute);
        assert_true(10.0 * e.sheared < e.plain);
    }
}

/* Among things at all heights: the factored passes cost next to nothing in quality. Measured at 9
 * and 16 samples: sheared .0338 and .0274, brute force .0334 and .0276, plain .83 and .59; without
 * shear .0297 and .0273: it wins nothing here. */
TEST(room)
{
    const struct rect crop = {250, 340, 346, 436};
    v_plane_scene_init(&scene, V_PLANE_ROOM, LINES, LINES);
    for (uint32_t l = 3; l <= 4; l++) {
        const struct errors e = measure(crop, l, 6);
        assert_true(e.sheared < 1.02 * e.brute);
        assert_true(15.0 * e.sheared < e.plain);
    }
}

/* More samples, less error. */
TEST(error_falls)
{
    static const uint32_t strata[] = {2, 3, 4, 6, 8};
    const struct rect crop = {250, 340, 314, 404};
    double last = 1.0;
    v_plane_scene_init(&scene, V_PLANE_ROOM, LINES, LINES);
    struct v_plane_picture truth = accuracy_truth(&scene, crop, 3);
    for (size_t i = 0; i < sizeof strata / sizeof *strata; i++) {
        struct patch *patch = v_plane_patch(&scene, rect_grow(crop, V_PLANE_HALO_PX), strata[i]);
        struct v_plane_picture sheared = accuracy_filter(&scene, patch, crop, LINES, NULL, NULL);
        const double e = accuracy_rmse(&truth, &sheared, &truth, 3);
        print_message("%3u spp: %.4f\n", strata[i] * strata[i], e);
        assert_true(e < last);
        last = e;
        picture_fini(&sheared);
        patch_destroy(&patch);
    }
    picture_fini(&truth);
}

static void set_radiance(struct patch *patch, uint32_t l, const float radiance[3])
{
    const size_t area = (size_t)rect_area(patch->rect);
    for (uint32_t j = 0; j < l * l; j++)
        for (uint32_t c = 0; c < 3; c++)
            for (size_t i = 0; i < area; i++)
                patch->indirect_strata[(4 * j + c) * area + i] = radiance[c];
}

/* A furnace is exactly 1, whatever the distances; other constants are to rounding. */
TEST(constants_stay)
{
    const struct rect crop = {180, 300, 260, 360};
    v_plane_scene_init(&scene, V_PLANE_ROOM, LINES, LINES);
    for (uint32_t l = 1; l <= 16; l += l < 5 ? 1 : 11) {
        struct patch *patch = v_plane_patch(&scene, crop, l);
        set_radiance(patch, l, (const float[3]){1.0f, 0.25f, 0.3f});
        struct v_plane_picture p = accuracy_filter(&scene, patch, crop, LINES, NULL, NULL);
        for (size_t i = 0; i < (size_t)rect_area(crop); i++) {
            assert_true(p.channel[0][i] == 1.0f && p.channel[1][i] == 0.25f);
            assert_true(fabsf(p.channel[2][i] - 0.3f) < 1e-6f);
        }
        set_radiance(patch, l, (const float[3]){0, 0, 0});
        struct v_plane_picture dark = accuracy_filter(&scene, patch, crop, LINES, NULL, NULL);
        for (size_t i = 0; i < 3 * (size_t)rect_area(crop); i++)
            assert_true(dark.channel[0][i] == 0.0f);
        picture_fini(&dark);
        picture_fini(&p);
        patch_destroy(&patch);
    }
}

/* The part of the patch in `rect`. */
static struct patch *cut_patch(const struct patch *from, struct rect rect)
{
    struct patch *cut;
    const uint32_t l = scene.plan.indirect_strata_per_axis;
    const size_t from_area = (size_t)rect_area(from->rect), area = (size_t)rect_area(rect);
    assert_int_equal(patch_create(&scene.plan, rect, &cut), 0);
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t a = picture_index(from->rect, rect.x0, y), b = picture_index(rect, rect.x0, y);
        const size_t bytes = (size_t)rect_width(rect) * sizeof(float);
        memcpy(cut->depth + b, from->depth + a, bytes);
        memcpy(cut->id + b, from->id + a, bytes);
        memcpy(cut->bounce_distance_min + b, from->bounce_distance_min + a, bytes);
        for (int k = 0; k < 3; k++) memcpy(cut->normal[k] + b, from->normal[k] + a, bytes);
        for (uint32_t j = 0; j < 4 * l * l; j++)
            memcpy(cut->indirect_strata + j * area + b, from->indirect_strata + j * from_area + a,
                   bytes);
    }
    return cut;
}

static void assert_same(const struct v_plane_picture *whole, const struct v_plane_picture *part)
{
    const struct rect r = part->rect;
    for (int32_t y = r.y0; y < r.y1; y++)
        for (int c = 0; c < 3; c++)
            assert_memory_equal(whole->channel[c] + picture_index(whole->rect, r.x0, y),
                                part->channel[c] + picture_index(r, r.x0, y),
                                (size_t)rect_width(r) * sizeof(float));
}

/* Any cut into blocks, with no more around them than the halo, gives the same bytes. */
TEST(cuts_do_not_show)
{
    const struct rect all = {0, 0, 150, 120};
    v_plane_scene_init(&scene, V_PLANE_ROOM, 150, 120);
    struct patch *patch = v_plane_patch(&scene, all, 3);
    for (size_t i = 0; i < (size_t)rect_area(all); i++)
        if (i % 17 == 3) patch->bounce_distance_min[i] = 0.0f; /* not traced */
    struct v_plane_picture whole = accuracy_filter(&scene, patch, all, 150, NULL, NULL);
    struct v_plane_picture blocks = accuracy_filter(&scene, patch, all, 23, NULL, NULL);
    assert_same(&whole, &blocks);
    for (int32_t y = 0; y < 120; y += 50) {
        for (int32_t x = 0; x < 150; x += 50) {
            const struct rect inner = rect_intersect((struct rect){x, y, x + 50, y + 50}, all);
            struct patch *cut = cut_patch(
                patch, rect_intersect(rect_grow(inner, v_plane_halo_px(&scene.plan)), all));
            struct v_plane_picture part = accuracy_filter(&scene, cut, inner, 150, NULL, NULL);
            assert_same(&whole, &part);
            picture_fini(&part);
            patch_destroy(&cut);
        }
    }
    picture_fini(&blocks);
    picture_fini(&whole);
    patch_destroy(&patch);
}

/* Finite, and no brighter than what was put in. */
static void check_range(const struct patch *patch, float most)
{
    struct v_plane_picture p = accuracy_filter(&scene, patch, patch->rect, 64, NULL, NULL);
    for (size_t i = 0; i < 3 * (size_t)rect_area(patch->rect); i++)
        assert_true(p.channel[0][i] >= 0.0f && p.channel[0][i] <= most);
    picture_fini(&p);
}

TEST(odd_pictures)
{
    static const int32_t sides[][2] = {{1, 1}, {1, 90}, {90, 1}, {2, 3}, {200, 2}};
    for (size_t i = 0; i < 10; i++) {
        const int32_t *side = sides[i % 5];
        v_plane_scene_init(&scene, i < 5 ? V_PLANE_ROOM : V_PLANE_CHECKER, side[0], side[1]);
        struct patch *patch =
            v_plane_patch(&scene, (struct rect){0, 0, side[0], side[1]}, 2 + (uint32_t)i % 3);
        check_range(patch, 40.0f);
        patch_destroy(&patch);
    }
}

/* Misses that bring light have no height: no shear, and as wide as it gets. */
TEST(all_misses)
{
    const struct rect all = {200, 200, 260, 240};
    float width[60 * 40];
    v_plane_scene_init(&scene, V_PLANE_CHECKER, LINES, LINES);
    struct patch *patch = v_plane_patch(&scene, all, 3);
    const size_t area = (size_t)rect_area(all);
    for (uint32_t j = 0; j < 9; j++)
        for (size_t i = 0; i < area; i++) patch->indirect_strata[(4 * j + 3) * area + i] = 0.0f;
    for (int dark = 0; dark < 2; dark++) {
        if (dark) set_radiance(patch, 3, (const float[3]){0, 0, 0});
        struct v_plane_picture p = accuracy_filter(&scene, patch, all, 64, width, NULL);
        for (size_t i = 0; i < area; i++) {
            assert_true(p.channel[0][i] >= 0.0f && p.channel[0][i] <= (dark ? 0.0f : 1.0f));
            assert_true(width[i] > 7.9f && width[i] < 8.1f);
        }
        picture_fini(&p);
    }
    patch_destroy(&patch);
}

static float wild(struct random *r)
{
    static const float numbers[] = {0, 6e-8f, 1e-4f, 1, 65504, 1e30f, 1e-30f, 4};
    const float base = numbers[random_bits(r) % 8];
    return base < 2.0f ? base * random_unit(r) : base;
}

/* Whatever a patch can hold. */
TEST(all_stays_finite)
{
    struct random r = {5};
    for (int turn = 0; turn < 24; turn++) {
        const struct rect all = {0, 0, 70, 50};
        v_plane_scene_init(&scene, turn % 2 ? V_PLANE_ROOM : V_PLANE_CHECKER, 70, 50);
        scene.plan.mu = turn % 5 == 1 ? 100.0f : turn % 5 == 2 ? 1e-6f : 1.0f;
        scene.plan.camera.type = turn % 3 == 1 ? CAMERA_ORTHOGRAPHIC : CAMERA_PERSPECTIVE;
        scene.plan.length_unit = turn % 4 == 1 ? 0x1p40f : turn % 4 == 2 ? 0x1p-40f : 1.0f;
        struct patch *patch = v_plane_patch(&scene, all, 1 + (uint32_t)turn % 4);
        const uint32_t n = scene.plan.indirect_strata_per_axis;
        const size_t area = (size_t)rect_area(all);
        for (size_t i = 0; i < area; i++) {
            if (random_bits(&r) % 4 == 0) patch->depth[i] = fminf(wild(&r), 1e16f);
            if (random_bits(&r) % 4 == 0) patch->bounce_distance_min[i] = wild(&r);
            for (int k = 0; k < 3 && !(patch->depth[i] > 0.0f); k++) patch->normal[k][i] = 0.0f;
            if (random_bits(&r) % 9 == 0) {
                const float z = 2.0f * random_unit(&r) - 1.0f;
                patch->normal[0][i] = sqrtf(1.0f - z * z);
                patch->normal[1][i] = 0.0f;
                patch->normal[2][i] = z;
            }
        }
        for (size_t i = 0; i < 4 * n * n * area; i++)
            if (random_bits(&r) % 3 == 0)
                patch->indirect_strata[i] = fminf(wild(&r), i / area % 4 == 3 ? 1e30f : 65504.0f);
        check_range(patch, 65505.0f);
        patch_destroy(&patch);
    }
}

/* Slopes of a ceiling are its height's inverse; widths follow the plan's factor. */
TEST(slopes)
{
    const struct rect all = {200, 200, 300, 300}, inner = rect_grow(all, -40);
    v_plane_scene_init(&scene, V_PLANE_CHECKER, LINES, LINES);
    struct patch *patch = v_plane_patch(&scene, all, 4);
    struct v_plane_neighbourhood around;
    assert_int_equal(
        v_plane_neighbourhood_create(&scene.plan, patch, inner, &v_plane_kernels_sse42, &around),
        0);
    assert_int_equal(v_plane_slopes(&around), 0);
    for (int32_t y = inner.y0; y < inner.y1; y++) {
        for (int32_t x = inner.x0; x < inner.x1; x++) {
            const size_t i = v_plane_index(&around, x, y);
            for (int axis = 0; axis < 2; axis++) {
                const struct v_plane_walk *w = &around.walks[axis][i];
                assert_true(fabsf(w->eta * scene.height - 1.0f) < 1e-3f);
                assert_true(fabsf(v_plane_dot(w->tangent, w->tangent) - 1.0f) < 1e-5f);
                assert_true(fabsf(v_plane_dot(w->tangent, around.sources[i].normal)) < 1e-5f);
                assert_int_equal(w->reach, V_PLANE_REACH_PX);
            }
        }
    }
    v_plane_neighbourhood_fini(&around);
    patch_destroy(&patch);
}

/* The kernels' directions are those of proto/v_plane.h. */
TEST(directions)
{
    enum { COUNT = 1000 };
    static float u[COUNT], v[COUNT], arrays[3][16 * COUNT];
    for (uint32_t l = 1; l <= 16; l += 5) {
        const struct v_plane_strata s = {l, COUNT, COUNT, arrays[0], arrays[1], arrays[2]};
        for (int k = 0; k < COUNT; k++) {
            u[k] = (float)k / (COUNT - 0.99f);
            v[k] = 1.0f - (float)(k + 1) / COUNT;
        }
        v_plane_kernels_sse42.strata(&s, u, v);
        for (uint32_t i = 0; i < l; i++) {
            for (uint32_t k = 0; k < COUNT; k++) {
                float side, height, sine, cosine;
                v_plane_column(pattern_axis(u[k], l, i), &side, &height);
                v_plane_row(pattern_axis(v[k], l, i), &sine, &cosine);
                assert_true(fabsf(s.height[i * COUNT + k] - height) < 4e-6f);
                assert_true(fabsf(s.sine[i * COUNT + k] - sine) < 4e-6f);
                assert_true(fabsf(s.cosine[i * COUNT + k] - cosine) < 4e-6f);
            }
        }
    }
}

/* Bad requests are refused; what was not traced is skipped and reads 0; counters add up. */
TEST(counters)
{
    const struct rect all = {0, 0, 96, 96};
    struct indirect_statistics statistics = {0};
    v_plane_scene_init(&scene, V_PLANE_ROOM, 96, 96);
    struct patch *patch = v_plane_patch(&scene, all, 2);
    for (int32_t y = 0; y < 96; y++)
        for (int32_t x = 0; x < 96; x++)
            if (x < 32 || (x + y) % 2) patch->bounce_distance_min[picture_index(all, x, y)] = 0.0f;
    struct v_plane_picture p = accuracy_filter(&scene, patch, all, 32, NULL, &statistics);
    assert_int_equal(statistics.blocks_skipped, 3);
    assert_int_equal(statistics.pixels_filtered, 32 * 96);
    assert_int_equal(statistics.pixels_skipped, 64 * 96);
    for (size_t i = 0; i < (size_t)rect_area(all); i++)
        assert_true(patch->bounce_distance_min[i] > 0.0f || p.channel[0][i] == 0.0f);
    const struct rect outside = {95, 0, 97, 1}, inside = {0, 0, 1, 1};
    float *const *out = p.channel;
    assert_int_equal(v_plane_filter(&scene.plan, patch, outside, out, NULL, &statistics),
                     ERR_RANGE);
    scene.plan.indirect_strata_per_axis = V_PLANE_STRATA_MAX + 1;
    assert_int_equal(v_plane_filter(&scene.plan, patch, inside, out, NULL, &statistics), ERR_RANGE);
    scene.plan.indirect_strata_per_axis = 2;
    scene.plan.indirect_filter = INDIRECT_FILTER_LINEAR;
    assert_int_equal(v_plane_filter(&scene.plan, patch, inside, out, NULL, &statistics), ERR_RANGE);
    assert_int_equal(v_plane_halo_px(&scene.plan), 0);
    picture_fini(&p);
    patch_destroy(&patch);
}
