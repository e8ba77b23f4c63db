/* Samples of a block as light fields leave them, and those that no filter reads. */
#include <math.h>
#include <stdlib.h>

#include "proto/half.h"
#include "proto/lens_pattern.h"
#include "proto/pattern_path.h"
#include "proto/shared_exponent.h"
#include "server/reconstruct/block.h"
#include "server/reconstruct/lens/lens.h"
#include "server/reconstruct/lens/lens_second_set.h"
#include "server/reconstruct/lighting/lens_relight.h"
#include "tests/unit/server/reconstruct/film_picture.h"
#include "tests/unit/server/reconstruct/lighting/lens_wall.h"
#include "tests/unit/unit.h"

/* The patch of the block in the middle, and the light of its pixels. */
static struct rect gather_middle(const struct plan *plan, struct film **film, struct patch **patch,
                                 struct lighting *lighting)
{
    struct lighting_statistics cost = {.shadow_cpu_us = 0};
    struct rect block = {0, 0, 0, 0};
    uint32_t k;
    *film = picture_film(plan, 64, 0);
    wall_land(plan, *film);
    while (film_next_ready(*film, &k)) {
        block = film_block_rect(*film, k);
        if (block.x0 == 64 && block.y0 == 64) break;
        film_block_done(*film, k);
    }
    assert_int_equal(film_gather(*film, k, patch), 0);
    const struct rect lit = rect_grow(block, lens_relight_ring_px(plan));
    assert_int_equal(
        lighting_create(plan, *patch, rect_intersect(lit, (*patch)->core), false, lighting, &cost),
        0);
    return block;
}

/* The block's picture, and which of its pixels need second sets, where samples that are not lit
 * have the radiance `other`. */
static void see_beside(const struct plan *plan, const struct patch *patch,
                       const struct lighting *lighting, struct rect block, float other,
                       float *const out[3], uint8_t *levels)
{
    const size_t count = (size_t)rect_area(patch->rect) * N * 3;
    const struct rect lit =
        rect_intersect(rect_grow(block, lens_relight_ring_px(plan)), patch->core);
    struct lens_relight_statistics lights = {0};
    struct lens_statistics lens = {0};
    struct patch shown = *patch;
    shown.lens_radiance = malloc(count * sizeof(float));
    assert_non_null(shown.lens_radiance);
    for (size_t i = 0; i < count; i++) shown.lens_radiance[i] = other;
    assert_int_equal(
        lens_relight_take(plan, patch, lighting, lit,
                          rect_intersect(rect_grow(block, lens_halo_px(plan)), patch->rect), block,
                          shown.lens_radiance, &lights),
        0);
    assert_int_equal(lens_filter(plan, &shown, block, out, NULL, &lens), 0);
    assert_int_equal(lens_second_set_levels(plan, &shown, block, levels), 0);
    free(shown.lens_radiance);
}

/* The radiance of all samples of the block in the middle, as lens_relight_take leaves it; whether
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
        rect_intersect(rect_grow(m->block, lens_relight_ring_px(&m->plan)), m->patch->core);
    const struct rect seen =
        rect_intersect(rect_grow(m->block, lens_halo_px(&m->plan)), m->patch->rect);
    struct lens_relight_statistics lights = {0};
    assert_int_equal(lens_relight_take(&m->plan, m->patch, &m->lighting, lit, seen, m->block,
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
    *q = (float)x + p[0] + wall_slope(&m->plan, *z) * u[0];
    return m->radiance[at + 2 * k * m->area];
}

/* Light that differs from sample to sample, from 0 to 400 evenly: what hidden ones are left with is
 * as bright and differs less. */
TEST(hidden_points_share_their_light)
{
    struct middle m;
    double sum = 0.0, square = 0.0, count = 0.0;
    wall_noise = true;
    middle_init(&m);
    wall_noise = false;
    middle_take(&m);
    for (int32_t y = m.block.y0; y < m.block.y1; y++)
        for (int32_t x = m.block.x0; x < m.block.x1; x++)
            for (uint32_t k = 0; k < N; k++) {
                float z, q;
                const double r = (double)sample_of(&m, x, y, k, &z, &q);
                if (z != FAR_Z || !(q < wall_edge - 1.5f)) continue;
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
                if (fabsf(q - wall_edge) < 1.5f || (z == FAR_Z && q < wall_edge)) continue;
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
    for (size_t k = 0; k < 3 * sizeof radii / sizeof radii[0]; k += 2) {
        struct plan plan;
        wall_plan(&plan, filters[k % 3]);
        plan.camera.aperture_radius = radii[k / 3];
        expect_unread(&plan);
    }
}

/* Pixels of the block whose samples all show the near wall look for what is in focus behind it
 * beside the block. The edge is at another place with each aperture. */
TEST(hidden_focus_is_lit)
{
    static const float radii[] = {0.03f, 0.06f, 0.09f};
    for (size_t k = 0; k < 3; k++)
        for (int32_t beside = 2 + (int32_t)k; beside < 14; beside += 3) {
            struct plan plan;
            wall_plan(&plan, LENS_FILTER_SHEARED);
            plan.camera.focus_distance = FAR_Z;
            plan.camera.aperture_radius = radii[k];
            wall_edge = 128.0f + (float)beside;
            expect_unread(&plan);
        }
    wall_edge = 0.5f * SIDE;
}
