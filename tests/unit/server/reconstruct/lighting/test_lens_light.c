/* Light fields of pixel centres light lens samples. */
#include <math.h>
#include <stdlib.h>

#include "proto/half.h"
#include "proto/job/job.h"
#include "proto/lens_pattern.h"
#include "proto/octahedron.h"
#include "proto/pattern_path.h"
#include "proto/samples.h"
#include "proto/shared_exponent.h"
#include "server/film/film.h"
#include "server/reconstruct/block.h"
#include "server/reconstruct/lens/lens.h"
#include "server/reconstruct/lens/lens_extra.h"
#include "server/reconstruct/lighting/lens_light.h"
#include "tests/unit/unit.h"

enum { SIDE = 200, TILE = 32, L = 3, N = L * L };

/* A wall at z = 2, and behind it, right of its edge in the middle, one at z = 8; the focus lies
 * between them. Slopes are 9 and -4.5 pixels. */
#define NEAR_Z 2.0f
#define FAR_Z  8.0f
static float edge = 0.5f * SIDE;
static bool noise; /* paths find light that differs from sample to sample */

static void wall_plan(struct plan *plan, uint32_t filter)
{
    *plan = (struct plan){
        .width_px = SIDE,
        .height_px = SIDE,
        .tile_px = TILE,
        .pattern = {3, 1},
        .camera = {.type = CAMERA_PERSPECTIVE,
                   .right = {1, 0, 0},
                   .up = {0, 1, 0},
                   .forward = {0, 0, -1},
                   .half_width = 0.5f,
                   .half_height = 0.5f,
                   .aperture_radius = 0.18f,
                   .focus_distance = 4},
        .light_count = 1,
        .lights = {{.type = LIGHT_POINT, .color = {3, 2, 1}, .power = 1, .strata_per_axis = 1}},
        .planes = PLANES_LENS | PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL),
        .light_planes = 1u << LIGHT_PLANE_IRRADIANCE,
        .lens_strata_per_axis = L,
        .lens_filter = filter,
        .lens_light = LENS_LIGHT_DIFFUSE,
        .radiance_scale = 4,
        .length_unit = 1,
        .mu = 1,
    };
}

static float slope_of(const struct plan *plan, float z)
{
    const float scale = plan->camera.aperture_radius * (float)SIDE;
    return half_to_float(half_from_float(scale * (1.0f / z - 1.0f / plan->camera.focus_distance)));
}

/* What a pinhole sees. */
static float depth_at(float x)
{
    return x < edge ? NEAR_Z : FAR_Z;
}

/* Irradiance grows evenly over the image, so that means of pixels are exact. */
static float irradiance_at(float x, float y)
{
    return 1.0f + 0.01f * x + 0.02f * y;
}

static void put_sample(const struct plan *plan, struct samples *s, int32_t x, int32_t y, uint32_t k,
                       size_t at)
{
    static const float normal[3] = {0, 0, 1}, albedo[3] = {0.5f, 0.5f, 0.25f};
    const float found = noise ? 40.0f * (float)((7 * x + 13 * y + 5 * (int32_t)k) % 11) : 256.0f;
    const float own[3] = {found, found, found};
    float u[2], p[2];
    lens_pattern_point(plan, x, y, k / L, k % L, u);
    path_pair(path_key(plan->pattern.seed, plan->pattern.frame, x, y), k, PATH_PIXEL, &p[0], &p[1]);
    const float qx = (float)x + p[0] + slope_of(plan, NEAR_Z) * u[0];
    const float z = qx < edge ? NEAR_Z : FAR_Z; /* the near wall hides what is behind it */
    samples_u16(s, PLANE_LENS_COVERAGE, 0)[at] = half_from_float(1.0f);
    samples_u16(s, PLANE_LENS_SLOPE, k)[at] = half_from_float(slope_of(plan, z));
    samples_u16(s, PLANE_LENS_DEPTH, k)[at] = half_from_float(z);
    samples_u16(s, PLANE_LENS_NORMAL, k)[at] = octahedron_pack8(normal);
    samples_u32(s, PLANE_LENS_ALBEDO, k)[at] = shared_exponent_pack(albedo, SHARED_EXPONENT_9);
    samples_u32(s, PLANE_LENS_LIGHT, k)[at] = shared_exponent_pack(own, SHARED_EXPONENT_8);
    samples_f32(s, PLANE_LENS_RADIANCE, k * 3 + 2)[at] = 0.125f; /* shines by itself */
}

static struct samples *tile_of(const struct plan *plan, struct rect r)
{
    static const float normal[3] = {0, 0, 1};
    struct samples_layout layout;
    struct samples *s;
    size_t at = 0;
    assert_int_equal(samples_layout_init(&layout, plan, 0, rect_width(r), rect_height(r)), 0);
    assert_int_equal(samples_create(&layout, &s), 0);
    for (int32_t y = r.y0; y < r.y1; y++)
        for (int32_t x = r.x0; x < r.x1; x++, at++) {
            float from[3], d[3];
            plan_camera_ray(plan, (float)x + 0.5f, (float)y + 0.5f, from, d);
            samples_f32(s, PLANE_DEPTH, 0)[at] = depth_at((float)x + 0.5f) / -d[2];
            samples_u32(s, PLANE_NORMAL, 0)[at] = octahedron_pack16(normal);
            samples_light_irradiance(s, 0)[at] = irradiance_at((float)x + 0.5f, (float)y + 0.5f);
            for (uint32_t k = 0; k < N; k++) put_sample(plan, s, x, y, k, at);
        }
    return s;
}

static void land_all(const struct plan *plan, struct film *film)
{
    struct tile_grid grid;
    assert_int_equal(tile_grid_init(&grid, SIDE, SIDE, TILE), 0);
    for (uint32_t t = 0; t < tile_grid_count(&grid); t++)
        assert_int_equal(film_land(film, t, 0, tile_of(plan, tile_grid_rect(&grid, t))), 0);
}

static struct image *picture(const struct plan *plan, int32_t block_px,
                             struct lens_light_statistics *sum)
{
    struct film *film;
    struct image *image;
    uint32_t block;
    *sum = (struct lens_light_statistics){0};
    assert_int_equal(film_create(plan, block_px, block_core_px(plan), block_halo_px(plan), &film),
                     0);
    assert_int_equal(image_create(LAYER_BEAUTY, SIDE, SIDE, &image), 0);
    land_all(plan, film);
    while (film_next_ready(film, &block)) {
        struct patch *patch;
        struct block_statistics statistics;
        const struct rect rect = film_block_rect(film, block);
        assert_int_equal(film_gather(film, block, &patch), 0);
        assert_int_equal(block_reconstruct(plan, patch, rect, image, &statistics), 0);
        sum->samples_lit += statistics.lens_light.samples_lit;
        sum->samples_own += statistics.lens_light.samples_own;
        patch_destroy(&patch);
        film_block_done(film, block);
    }
    film_destroy(&film);
    return image;
}

/* Far from the edge between the walls every sample shows what some pixel's centre does: the mean
 * of an even field is its value at the pixel, and what shines by itself is there, too. */
TEST(samples_take_light_from_where_the_middle_sees_their_point)
{
    static const float colors[] = {3, 2, 1}, albedo[] = {0.5f, 0.5f, 0.25f};
    static const char *const names[] = {"R", "G", "B"};
    struct lens_light_statistics sum;
    struct plan plan;
    wall_plan(&plan, LENS_FILTER_NONE);
    struct image *image = picture(&plan, 64, &sum);
    for (int32_t y = 20; y < SIDE - 20; y++)
        for (int32_t x = 20; x < SIDE - 20; x++) {
            if (abs(x - SIDE / 2) < 24) continue;
            for (int c = 0; c < 3; c++) {
                const float own = c == 2 ? 0.125f : 0.0f;
                const float is = *plane_at(image_plane(image, names[c]), x, y);
                const float e = irradiance_at((float)x + 0.5f, (float)y + 0.5f);
                const float should = own + e * colors[c] / 3.14159265f * albedo[c];
                /* points of the pixel and of the lens do not balance each other exactly */
                assert_true(fabsf(is - should) < 0.05f * should);
            }
        }
    image_destroy(&image);
}

/* The far wall's part that the near one hides from the middle, next to the edge: lit by the samples
 * themselves, which are much brighter here. Nothing else is, but for what lies outside the image.
 */
TEST(hidden_points_keep_their_own_light)
{
    struct lens_light_statistics sum;
    struct plan plan;
    double hidden = 0.0, open = 0.0;
    wall_plan(&plan, LENS_FILTER_NONE);
    struct image *image = picture(&plan, 64, &sum);
    const struct plane *r = image_plane(image, "R");
    for (int32_t y = 20; y < SIDE - 20; y++) {
        for (int32_t x = SIDE / 2 - 6; x < SIDE / 2 + 6; x++) hidden += (double)*plane_at(r, x, y);
        for (int32_t x = 40; x < 52; x++) open += (double)*plane_at(r, x, y);
    }
    assert_true(hidden > 2.0 * open);
    assert_int_equal(sum.samples_lit + sum.samples_own, SIDE * SIDE * N);
    assert_true(sum.samples_own > 0 && sum.samples_own < SIDE * SIDE * N / 8);
    image_destroy(&image);
}

/* No pixel depends on how the image is cut, though light is found for a part around each alone. */
TEST(blocks_do_not_show)
{
    static const uint32_t filters[] = {LENS_FILTER_NONE, LENS_FILTER_AXIS_ALIGNED,
                                       LENS_FILTER_SHEARED};
    static const float apertures[] = {0.18f, 0.47f, 0.1f, 0.05f}; /* slopes of 1.2 to almost 24 */
    static const char *const names[] = {"R", "G", "B"};
    struct lens_light_statistics small, large;
    struct plan plan;
    for (size_t k = 0; k < 4 * sizeof filters / sizeof filters[0]; k++) {
        wall_plan(&plan, filters[k / 4]);
        plan.camera.aperture_radius = apertures[k % 4];
        noise = true; /* hidden points share what they have found */
        struct image *a = picture(&plan, 64, &small), *b = picture(&plan, SIDE, &large);
        noise = false;
        for (int32_t y = 0; y < SIDE; y++)
            for (int32_t x = 0; x < SIDE; x++)
                for (int c = 0; c < 3; c++) {
                    const float p = *plane_at(image_plane(a, names[c]), x, y);
                    const float q = *plane_at(image_plane(b, names[c]), x, y);
                    if (!(p == q))
                        fail_msg("filter %zu, (%d, %d): %.9g and %.9g", k, x, y, (double)p,
                                 (double)q);
                }
        assert_int_equal(small.samples_lit, large.samples_lit);
        assert_int_equal(small.samples_own, large.samples_own);
        image_destroy(&a);
        image_destroy(&b);
    }
}

/* Who needs a second set is told by samples as they are lit: what comes of their paths alone is the
 * same everywhere here, and only hidden points are brighter than what is around them. */
TEST(second_sets_go_where_lit_samples_differ)
{
    static uint8_t levels[SIDE * SIDE];
    struct block_statistics statistics;
    struct plan plan;
    struct film *film;
    struct patch *patch;
    struct image *image;
    uint32_t block;
    int32_t hidden = 0, open = 0;
    wall_plan(&plan, LENS_FILTER_SHEARED);
    plan.planes |= PLANE_BIT(LENS_MORE);
    plan.lens_extra = 9;
    assert_int_equal(film_create(&plan, SIDE, block_core_px(&plan), block_halo_px(&plan), &film),
                     0);
    assert_int_equal(image_create(LAYER_BEAUTY, SIDE, SIDE, &image), 0);
    land_all(&plan, film);
    assert_true(film_next_ready(film, &block));
    assert_int_equal(film_gather(film, block, &patch), 0);
    patch->lens_levels = levels;
    assert_int_equal(
        block_reconstruct(&plan, patch, film_block_rect(film, block), image, &statistics), 0);
    for (int32_t y = 20; y < SIDE - 20; y++)
        for (int32_t x = 40; x < SIDE / 2 + 6; x++) {
            const int32_t level = levels[y * SIDE + x];
            if (x < 52 && level > open) open = level;
            if (x >= SIDE / 2 - 6 && level > hidden) hidden = level;
        }
    assert_true(open > 0 && hidden > open + 8);
    patch_destroy(&patch);
    film_block_done(film, block);
    film_destroy(&film);
    image_destroy(&image);
}

/* The patch of the block in the middle, and the light of its pixels. */
static struct rect gather_middle(const struct plan *plan, struct film **film, struct patch **patch,
                                 struct lighting *lighting)
{
    struct lighting_statistics cost = {.shadow_cpu_us = 0};
    struct rect block = {0, 0, 0, 0};
    uint32_t k;
    assert_int_equal(film_create(plan, 64, block_core_px(plan), block_halo_px(plan), film), 0);
    land_all(plan, *film);
    while (film_next_ready(*film, &k)) {
        block = film_block_rect(*film, k);
        if (block.x0 == 64 && block.y0 == 64) break;
        film_block_done(*film, k);
    }
    assert_int_equal(film_gather(*film, k, patch), 0);
    const struct rect lit = rect_grow(block, lens_light_ring_px(plan));
    assert_int_equal(
        lighting_create(plan, *patch, rect_intersect(lit, (*patch)->core), lighting, &cost), 0);
    return block;
}

/* The block's picture, and which of its pixels need second sets, where samples that are not lit
 * have the radiance `other`. */
static void see_beside(const struct plan *plan, const struct patch *patch,
                       const struct lighting *lighting, struct rect block, float other,
                       float *const out[3], uint8_t *levels)
{
    const size_t count = (size_t)rect_area(patch->rect) * N * 3;
    const struct rect lit = rect_intersect(rect_grow(block, lens_light_ring_px(plan)), patch->core);
    struct lens_light_statistics lights = {0};
    struct lens_statistics lens = {0};
    struct patch shown = *patch;
    shown.lens_radiance = malloc(count * sizeof(float));
    assert_non_null(shown.lens_radiance);
    for (size_t i = 0; i < count; i++) shown.lens_radiance[i] = other;
    assert_int_equal(
        lens_light_take(plan, patch, lighting, lit,
                        rect_intersect(rect_grow(block, lens_halo_px(plan)), patch->rect), block,
                        shown.lens_radiance, &lights),
        0);
    assert_int_equal(lens_filter(plan, &shown, block, out, NULL, &lens), 0);
    assert_int_equal(lens_extra_levels(plan, &shown, block, levels), 0);
    free(shown.lens_radiance);
}

/* The radiance of all samples of the block in the middle, as lens_light_take leaves it; whether
 * fields light any lobes of theirs. */
struct middle {
    struct plan plan;
    struct film *film;
    struct patch *patch;
    struct lighting lighting;
    struct rect block;
    float *radiance;
    size_t area;
};

static void middle_init(struct middle *m)
{
    wall_plan(&m->plan, LENS_FILTER_SHEARED);
    m->block = gather_middle(&m->plan, &m->film, &m->patch, &m->lighting);
    m->area = (size_t)rect_area(m->patch->rect);
    m->radiance = calloc(m->area * N * 3, sizeof(float));
    assert_non_null(m->radiance);
}

static void middle_fini(struct middle *m)
{
    free(m->radiance);
    lighting_fini(&m->lighting);
    patch_destroy(&m->patch);
    film_destroy(&m->film);
}

static void middle_take(struct middle *m)
{
    const struct rect lit =
        rect_intersect(rect_grow(m->block, lens_light_ring_px(&m->plan)), m->patch->core);
    const struct rect seen =
        rect_intersect(rect_grow(m->block, lens_halo_px(&m->plan)), m->patch->rect);
    struct lens_light_statistics lights = {0};
    assert_int_equal(lens_light_take(&m->plan, m->patch, &m->lighting, lit, seen, m->block,
                                     m->radiance, &lights),
                     0);
}

/* Of pixel (x, y), in red; which of the walls it shows, and where the middle sees its point. */
static float sample_of(const struct middle *m, int32_t x, int32_t y, uint32_t k, float *z, float *q)
{
    const size_t at = k * m->area + patch_pixel(m->patch, x, y);
    float u[2], p[2];
    lens_pattern_point(&m->plan, x, y, k / L, k % L, u);
    path_pair(path_key(m->plan.pattern.seed, m->plan.pattern.frame, x, y), k, PATH_PIXEL, &p[0],
              &p[1]);
    *z = half_to_float(m->patch->lens_depth[at]);
    *q = (float)x + p[0] + slope_of(&m->plan, *z) * u[0];
    return m->radiance[at + 2 * k * m->area];
}

/* Light that differs from sample to sample, from 0 to 400 evenly: what hidden ones are left with is
 * as bright and differs less. */
TEST(hidden_points_share_their_light)
{
    struct middle m;
    double sum = 0.0, square = 0.0, count = 0.0;
    noise = true;
    middle_init(&m);
    noise = false;
    middle_take(&m);
    for (int32_t y = m.block.y0; y < m.block.y1; y++)
        for (int32_t x = m.block.x0; x < m.block.x1; x++)
            for (uint32_t k = 0; k < N; k++) {
                float z, q;
                const double r = (double)sample_of(&m, x, y, k, &z, &q);
                if (z != FAR_Z || !(q < edge - 1.5f)) continue;
                sum += r;
                square += r * r;
                count += 1.0;
            }
    assert_true(count > 500.0);
    const double mean = sum / count, spread = sqrt(square / count - mean * mean) / mean;
    print_message("mean %.3g, spread %.3g\n", mean, spread);
    assert_true(fabs(mean - 25.0) < 1.5); /* 200 / radiance_scale * albedo */
    assert_true(spread < 0.3);            /* 0.63 of each by itself */
    middle_fini(&m);
}

/* Samples that bring a lobe have what lobes see around their point times its albedo on top. */
TEST(lobes_add_what_they_see)
{
    static const float albedo[3] = {0.25f, 0.5f, 0.125f};
    struct middle with, without;
    double count = 0.0;
    middle_init(&with);
    middle_init(&without);
    middle_take(&without);
    uint32_t *lobe = calloc(with.area * N, sizeof *lobe);
    float *sees = calloc(with.area, sizeof *sees), *alpha = calloc(with.area, sizeof *alpha);
    assert_true(lobe && sees && alpha);
    /* Every other column has no lobe, and has seen something else all around. */
    for (size_t i = 0; i < with.area; i++) sees[i] = i % 2 ? 2.0f : 5.0f;
    for (size_t i = 0; i < with.area; i++) alpha[i] = i % 2 ? 0.25f : 0.0f;
    for (size_t i = 0; i < with.area * N; i += 2)
        lobe[i] = shared_exponent_pack(albedo, SHARED_EXPONENT_9);
    with.patch->lens_lobe = lobe;
    with.patch->glossy_alpha = alpha;
    for (int c = 0; c < 3; c++) with.lighting.glossy[c] = sees;
    middle_take(&with);
    for (int32_t y = with.block.y0; y < with.block.y1; y++)
        for (int32_t x = with.block.x0; x < with.block.x1; x++)
            for (uint32_t k = 0; k < N; k++) {
                float z, q;
                const float a = sample_of(&with, x, y, k, &z, &q);
                const float b = sample_of(&without, x, y, k, &z, &q);
                const size_t at = k * with.area + patch_pixel(with.patch, x, y);
                if (fabsf(q - edge) < 1.5f || (z == FAR_Z && q < edge)) continue;
                assert_true(fabsf(a - b - (lobe[at] ? 0.5f : 0.0f)) < 1e-5f);
                count += lobe[at] ? 1.0 : 0.0;
            }
    assert_true(count > 1000.0);
    with.patch->lens_lobe = NULL;
    with.patch->glossy_alpha = NULL;
    for (int c = 0; c < 3; c++) with.lighting.glossy[c] = NULL;
    middle_fini(&with);
    middle_fini(&without);
    free(lobe);
    free(sees);
    free(alpha);
}

/* Of the block in the middle. */
static void expect_unread(const struct plan *plan)
{
    static uint8_t levels[2][64 * 64];
    struct film *film;
    struct patch *patch;
    struct lighting lighting;
    float *a[3], *b[3];
    const struct rect block = gather_middle(plan, &film, &patch, &lighting);
    const size_t area = (size_t)rect_area(patch->rect);
    for (int c = 0; c < 3; c++) {
        a[c] = calloc(area, sizeof(float));
        b[c] = calloc(area, sizeof(float));
        assert_true(a[c] && b[c]);
    }
    see_beside(plan, patch, &lighting, block, 0.0f, a, levels[0]);
    see_beside(plan, patch, &lighting, block, NAN, b, levels[1]);
    if (plan->lens_filter == LENS_FILTER_SHEARED)
        assert_memory_equal(levels[0], levels[1], sizeof levels[0]);
    for (int c = 0; c < 3; c++) {
        assert_memory_equal(a[c], b[c], area * sizeof(float));
        free(a[c]);
        free(b[c]);
    }
    lighting_fini(&lighting);
    patch_destroy(&patch);
    film_destroy(&film);
}

/* Samples that no filter reads are not lit, whatever they then are: slopes of this picture take
 * samples to and beyond the reach of the block. */
TEST(unlit_samples_are_not_read)
{
    static const uint32_t filters[] = {LENS_FILTER_NONE, LENS_FILTER_AXIS_ALIGNED,
                                       LENS_FILTER_SHEARED};
    static const float radii[] = {0.002f, 0.03f, 0.09f, 0.18f, 0.3f, 0.47f, 0.8f};
    for (size_t k = 0; k < 3 * sizeof radii / sizeof radii[0]; k++) {
        struct plan plan;
        wall_plan(&plan, filters[k % 3]);
        plan.camera.aperture_radius = radii[k / 3];
        expect_unread(&plan);
    }
}

/* Pixels of the block whose samples all show the near wall look for what is in focus behind it
 * beside the block. */
TEST(hidden_focus_is_lit)
{
    static const float radii[] = {0.03f, 0.06f, 0.09f};
    for (size_t k = 0; k < 3; k++)
        for (int32_t beside = 2; beside < 14; beside++) {
            struct plan plan;
            wall_plan(&plan, LENS_FILTER_SHEARED);
            plan.camera.focus_distance = FAR_Z;
            plan.camera.aperture_radius = radii[k];
            edge = 128.0f + (float)beside;
            expect_unread(&plan);
        }
    edge = 0.5f * SIDE;
}

/* Plans whose fields light none read no more than before. */
TEST(others_have_no_ring)
{
    struct plan plan;
    wall_plan(&plan, LENS_FILTER_SHEARED);
    assert_true(lens_light_ring_px(&plan) > 24);
    plan.lens_light = LENS_LIGHT_OWN;
    plan.planes &= ~PLANES_LENS_SURFACE;
    assert_int_equal(lens_light_ring_px(&plan), 0);
    assert_int_equal(block_halo_px(&plan), lens_halo_px(&plan));
}
