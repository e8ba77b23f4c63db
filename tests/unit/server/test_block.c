/* Reconstruction of blocks: constants stay constants, silhouettes are the mixture of what covers
 * them, light does not leak over edges, and no cut of the image changes a bit. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "server/film/film.h"
#include "server/image/image.h"
#include "server/reconstruct/block.h"
#include "server/team/team.h"
#include "tests/unit/server/synthetic.h"

#define ALL_LAYERS 0xfffu
#define PI         3.14159265358979f

/* A picture of two surfaces: what is left of the edge (in pixel coordinates, slanted) is near. */
struct world {
    float edge_x,
        slant; /* the edge's x at row y is edge_x + slant y; edge_x < 0: only the far one */
    bool far_missing;
    float slat_px; /* how wide the near one is; 0: all that is left of the edge */
    float near_depth, far_depth;
    float near_light, far_light; /* irradiance */
    float near_albedo, far_albedo;
    float normal_turn; /* radians between the two normals */
    uint32_t near_id, far_id;
    float tilt; /* of the far plane against the view, radians */
};

static const struct world plain = {.edge_x = -1e6f,
                                   .near_depth = 2.0f,
                                   .far_depth = 5.0f,
                                   .near_light = PI,
                                   .far_light = PI,
                                   .near_albedo = 0.5f,
                                   .far_albedo = 0.5f,
                                   .near_id = 1,
                                   .far_id = 2};

struct shade {
    float depth, normal[3], albedo, light;
    uint32_t id;
};

/* What the ray through (px, py) meets; depth along the unit ray. */
static struct shade look(const struct plan *plan, const struct world *w, float px, float py)
{
    struct shade s = {0};
    float origin[3], d[3];
    plan_camera_ray(plan, px, py, origin, d);
    const float left = w->edge_x + w->slant * py - px;
    if (left > 0 && (w->slat_px == 0 || left < w->slat_px)) {
        const float n[3] = {sinf(w->normal_turn), 0, cosf(w->normal_turn)};
        memcpy(s.normal, n, sizeof n);
        s = (struct shade){.depth = w->near_depth / -d[2],
                           .normal = {n[0], n[1], n[2]},
                           .albedo = w->near_albedo,
                           .light = w->near_light,
                           .id = w->near_id};
    } else if (!w->far_missing) {
        const float n[3] = {0, sinf(w->tilt), cosf(w->tilt)};
        float facing = -(d[1] * n[1] + d[2] * n[2]);
        s = (struct shade){.depth = w->far_depth * n[2] / facing,
                           .normal = {n[0], n[1], n[2]},
                           .albedo = w->far_albedo,
                           .light = w->far_light,
                           .id = w->far_id};
    }
    return s;
}

static void put_pixel(struct samples *s, const struct plan *plan, const struct world *w, size_t i,
                      int32_t x, int32_t y)
{
    struct shade centre = look(plan, w, (float)x + 0.5f, (float)y + 0.5f);
    bool hit = centre.depth > 0.0f;
    samples_f32(s, PLANE_DEPTH, 0)[i] = centre.depth;
    samples_u32(s, PLANE_ID, 0)[i] = centre.id;
    samples_u32(s, PLANE_NORMAL, 0)[i] = hit ? octahedron_pack16(centre.normal) : 0;
    samples_light_irradiance(s, 0)[i] = centre.light;
    for (uint32_t c = 0; c < 3; c++) {
        samples_u16(s, PLANE_ALBEDO, c)[i] = (uint16_t)lrintf(centre.albedo * 65535.0f);
    }
    for (uint32_t k = 0; k < plan->sub_samples; k++) {
        float at[2];
        pattern_pixel(&plan->pattern, x, y, k, plan->sub_samples, at);
        struct shade sub = look(plan, w, (float)x + at[0], (float)y + at[1]);
        bool sub_hit = sub.depth > 0.0f;
        float reference = hit ? centre.depth : plan->length_unit;
        samples_u16(s, PLANE_SUB_DEPTH, k)[i] =
            half_from_float(sub_hit ? sub.depth / reference - 1.0f : SUB_DEPTH_MISS);
        samples_u16(s, PLANE_SUB_ID, k)[i] = synthetic_sub_id(sub.id);
        samples_u16(s, PLANE_SUB_NORMAL, k)[i] = sub_hit ? octahedron_pack8(sub.normal) : 0;
        for (uint32_t c = 0; c < 3; c++) {
            samples_u16(s, PLANE_SUB_ALBEDO, k * 3 + c)[i] =
                (uint16_t)lrintf(sub.albedo * 65535.0f);
        }
    }
}

static struct samples *world_tile(const struct plan *plan, const struct world *w, uint32_t tile)
{
    struct tile_grid grid;
    struct samples_layout layout;
    struct samples *s;
    tile_grid_init(&grid, plan->width_px, plan->height_px, plan->tile_px);
    struct rect r = tile_grid_rect(&grid, tile);
    assert_int_equal(samples_layout_init(&layout, plan, 0, rect_width(r), rect_height(r)), 0);
    assert_int_equal(samples_create(&layout, &s), 0);
    size_t i = 0;
    for (int32_t y = r.y0; y < r.y1; y++) {
        for (int32_t x = r.x0; x < r.x1; x++) put_pixel(s, plan, w, i++, x, y);
    }
    return s;
}

static double cpu_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

/* Lands all tiles, reconstructs all blocks. w NULL: the synthetic scene. */
static struct image *render(const struct plan *plan, const struct world *w, int32_t block_px,
                            int32_t more_halo_px, struct block_statistics *sum, double *seconds)
{
    struct film *film;
    struct image *image;
    struct tile_grid grid;
    struct block_statistics statistics;
    uint32_t block;
    tile_grid_init(&grid, plan->width_px, plan->height_px, plan->tile_px);
    assert_int_equal(film_create(plan, block_px, block_halo_px(plan) + more_halo_px, &film), 0);
    assert_int_equal(image_create(ALL_LAYERS, plan->width_px, plan->height_px, &image), 0);
    for (uint32_t t = 0; t < tile_grid_count(&grid); t++) {
        struct samples *s = w ? world_tile(plan, w, t) : synthetic_tile(plan, t);
        assert_int_equal(film_land(film, t, 0, s), 0);
    }
    double start = cpu_s();
    if (sum) *sum = (struct block_statistics){0};
    while (film_next_ready(film, &block)) {
        struct patch *patch;
        assert_int_equal(film_gather(film, block, &patch), 0);
        assert_int_equal(
            block_reconstruct(plan, patch, film_block_rect(film, block), image, &statistics), 0);
        patch_destroy(&patch);
        film_block_done(film, block);
        if (!sum) continue;
        sum->sub_samples_unmatched += statistics.sub_samples_unmatched;
        sum->pixels_background += statistics.pixels_background;
    }
    if (seconds) *seconds = cpu_s() - start;
    assert_true(film_complete(film));
    film_destroy(&film);
    return image;
}

static float at(const struct image *image, const char *channel, int32_t x, int32_t y)
{
    const struct plane *plane = image_plane(image, channel);
    assert_non_null(plane);
    return *plane_at(plane, x, y);
}

static void make_plan(struct plan *plan, int32_t width, int32_t height)
{
    synthetic_plan(plan, width, height, 32);
}

static void a_constant_field_stays_constant(void **state)
{
    (void)state;
    static const int32_t sizes[][2] = {{70, 70}, {1, 1}, {1, 40}, {67, 1}, {2, 3}};
    for (uint32_t subs = 0; subs <= 3; subs++) {
        for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
            struct plan plan;
            struct block_statistics sum;
            struct world world = plain;
            world.tilt = 1.1f;
            make_plan(&plan, sizes[i][0], sizes[i][1]);
            plan.sub_samples = subs;
            if (subs == 0)
                plan.planes &= ~(PLANE_BIT(SUB_DEPTH) | PLANE_BIT(SUB_NORMAL) |
                                 PLANE_BIT(SUB_ALBEDO) | PLANE_BIT(SUB_ID));
            struct image *image = render(&plan, &world, 16, 0, &sum, NULL);
            float first = at(image, "R", 0, 0);
            assert_true(fabsf(first - 0.5f) < 1e-4f);
            for (int32_t y = 0; y < plan.height_px; y++) {
                for (int32_t x = 0; x < plan.width_px; x++) {
                    assert_true(at(image, "G", x, y) == first);
                    assert_true(at(image, "A", x, y) == 1.0f);
                }
            }
            assert_int_equal(sum.sub_samples_unmatched, 0);
            assert_int_equal(sum.pixels_background, 0);
            image_destroy(&image);
        }
    }
}

static void assert_same(const struct image *a, const struct image *b)
{
    size_t pixels = (size_t)a->width_px * (size_t)a->height_px;
    assert_int_equal(a->channel_count, b->channel_count);
    assert_memory_equal(a->data, b->data, pixels * a->channel_count * sizeof(float));
}

/* How many of a pixel's samples lie left of the edge. */
static int near_samples(const struct plan *plan, const struct world *w, int32_t x, int32_t y)
{
    int count = (float)x + 0.5f < w->edge_x + w->slant * ((float)y + 0.5f);
    for (uint32_t k = 0; k < plan->sub_samples; k++) {
        float p[2];
        pattern_pixel(&plan->pattern, x, y, k, plan->sub_samples, p);
        count += (float)x + p[0] < w->edge_x + w->slant * ((float)y + p[1]);
    }
    return count;
}

/* Each sample has its own side's light and albedo: an edge pixel is exactly the mixture. */
static void assert_mixture(const struct world *world)
{
    struct plan plan;
    struct block_statistics sum;
    make_plan(&plan, 64, 64);
    struct image *image = render(&plan, world, 64, 0, &sum, NULL);
    float near_value = world->near_albedo * world->near_light / PI;
    float far_value = world->far_missing ? 0.0f : world->far_albedo * world->far_light / PI;
    int mixed = 0;
    for (int32_t y = 0; y < 64; y++) {
        for (int32_t x = 0; x < 64; x++) {
            float share = (float)near_samples(&plan, world, x, y) / 4.0f;
            float expected = share * near_value + (1.0f - share) * far_value;
            mixed += share > 0.0f && share < 1.0f;
            assert_true(fabsf(at(image, "R", x, y) - expected) < 2e-4f);
            float cover = world->far_missing ? share : 1.0f;
            assert_true(at(image, "A", x, y) == cover);
        }
    }
    assert_true(mixed > 20);
    assert_int_equal(sum.sub_samples_unmatched, 0);
    image_destroy(&image);
}

static void a_silhouette_is_the_mixture_of_both_surfaces(void **state)
{
    (void)state;
    struct world world = plain;
    world.edge_x = 20.3f;
    world.slant = 0.37f;
    world.near_light = 3.0f;
    world.far_light = 0.0f; /* any leak would show */
    world.near_albedo = 0.25f;
    world.far_albedo = 1.0f;
    assert_mixture(&world);
    world.near_light = 0.0f;
    world.far_light = 100.0f;
    assert_mixture(&world);
}

/* One object, e.g. a scene in a single mesh: only depth tells the surfaces apart. */
static void depth_alone_keeps_light_apart(void **state)
{
    (void)state;
    struct world world = plain;
    world.edge_x = 20.3f;
    world.slant = 0.37f;
    world.near_light = 10.0f;
    world.far_light = 0.0f;
    world.near_id = world.far_id = 7;
    assert_mixture(&world);
    world.tilt = 1.0f;
    assert_mixture(&world);
}

static void normals_alone_keep_light_apart(void **state)
{
    (void)state;
    struct world world = plain;
    world.edge_x = 20.3f;
    world.slant = 0.37f;
    world.near_depth = world.far_depth = 5.0f;
    world.near_light = 10.0f;
    world.far_light = 0.0f;
    world.near_id = world.far_id = 7;
    world.normal_turn = 1.0f;
    assert_mixture(&world);
}

static void ids_are_preferred_on_one_plane(void **state)
{
    (void)state;
    struct plan plan;
    struct world world = plain;
    world.edge_x = 20.3f;
    world.slant = 0.37f;
    world.near_depth = world.far_depth = 5.0f;
    world.near_light = 10.0f;
    world.far_light = 0.0f;
    make_plan(&plan, 64, 64);
    struct image *image = render(&plan, &world, 64, 0, NULL, NULL);
    float value = world.near_albedo * world.near_light / PI;
    for (int32_t y = 0; y < 64; y++) {
        for (int32_t x = 0; x < 64; x++) {
            float share = (float)near_samples(&plan, &world, x, y) / 4.0f;
            assert_true(fabsf(at(image, "R", x, y) - share * value) < 0.06f * value);
        }
    }
    image_destroy(&image);
}

/* 65536 instances on: the low bits that sub-samples carry are 0. */
static void large_ids_match_their_own(void **state)
{
    (void)state;
    struct world world = plain;
    world.edge_x = 20.3f;
    world.slant = 0.37f;
    world.near_light = 10.0f;
    world.far_light = 0.0f;
    world.near_id = 65536;
    world.far_id = 3 * 65536 + 5;
    assert_mixture(&world);
}

/* Tiles land on one thread while blocks are gathered and reconstructed on others. */
struct threaded_block {
    struct team_task task;
    const struct plan *plan;
    struct film *film;
    struct image *image;
    uint32_t block;
};

static void run_block(struct team_task *task)
{
    struct threaded_block *b = (struct threaded_block *)task;
    struct patch *patch;
    struct block_statistics statistics;
    if (film_gather(b->film, b->block, &patch)) return;
    block_reconstruct(b->plan, patch, film_block_rect(b->film, b->block), b->image, &statistics);
    patch_destroy(&patch);
}

static void block_done(struct team_task *task)
{
    struct threaded_block *b = (struct threaded_block *)task;
    film_block_done(b->film, b->block);
    free(b);
}

static void threads_make_the_same_picture(void **state)
{
    (void)state;
    struct plan plan;
    struct film *film;
    struct image *image;
    struct team *team;
    struct tile_grid grid;
    uv_loop_t loop;
    uint32_t block;
    synthetic_plan(&plan, 200, 150, 16);
    struct image *expected = render(&plan, NULL, 64, 0, NULL, NULL);
    tile_grid_init(&grid, 200, 150, 16);
    assert_int_equal(uv_loop_init(&loop), 0);
    assert_int_equal(team_create(&loop, "test", 4, &team), 0);
    assert_int_equal(film_create(&plan, 64, 1, &film), 0);
    assert_int_equal(image_create(ALL_LAYERS, 200, 150, &image), 0);
    for (uint32_t t = tile_grid_count(&grid); t-- > 0;) {
        assert_int_equal(film_land(film, t, 0, synthetic_tile(&plan, t)), 0);
        while (film_next_ready(film, &block)) {
            struct threaded_block *b = malloc(sizeof *b);
            *b = (struct threaded_block){
                {.run = run_block, .done = block_done}, &plan, film, image, block};
            team_submit(team, &b->task);
        }
        uv_run(&loop, UV_RUN_NOWAIT);
    }
    uv_run(&loop, UV_RUN_DEFAULT);
    assert_true(film_complete(film));
    assert_int_equal(film_bytes(film), 0);
    assert_same(expected, image);
    team_destroy(&team);
    uv_run(&loop, UV_RUN_DEFAULT);
    assert_int_equal(uv_loop_close(&loop), 0);
    film_destroy(&film);
    image_destroy(&image);
    image_destroy(&expected);
}

static void an_edge_against_nothing_has_partial_alpha(void **state)
{
    (void)state;
    struct world world = plain;
    world.edge_x = 20.3f;
    world.slant = 0.37f;
    world.far_missing = true;
    assert_mixture(&world);
}

static void background_is_skipped_and_counted(void **state)
{
    (void)state;
    struct plan plan;
    struct block_statistics sum;
    struct world world = plain;
    world.far_missing = true;
    make_plan(&plan, 40, 30);
    struct image *image = render(&plan, &world, 64, 0, &sum, NULL);
    assert_int_equal(sum.pixels_background, 40 * 30);
    for (size_t i = 0; i < image->channel_count * 40u * 30u; i++) {
        assert_true(image->data[i] == 0.0f);
    }
    image_destroy(&image);
}

/* A sub-sample that hit what no pixel around saw: lit by the nearest-looking one, and counted. */
static void a_stray_sub_sample_is_counted(void **state)
{
    (void)state;
    struct plan plan;
    struct patch *patch;
    struct image *image;
    struct block_statistics sum;
    make_plan(&plan, 8, 8);
    struct film *film;
    uint32_t block;
    assert_int_equal(film_create(&plan, 8, 1, &film), 0);
    struct samples *s = world_tile(&plan, &plain, 0);
    samples_u16(s, PLANE_SUB_DEPTH, 1)[27] = half_from_float(-0.8f);
    samples_u16(s, PLANE_SUB_ID, 1)[27] = 99;
    assert_int_equal(film_land(film, 0, 0, s), 0);
    assert_true(film_next_ready(film, &block));
    assert_int_equal(film_gather(film, block, &patch), 0);
    assert_int_equal(image_create(ALL_LAYERS, 8, 8, &image), 0);
    assert_int_equal(block_reconstruct(&plan, patch, patch->rect, image, &sum), 0);
    assert_int_equal(sum.sub_samples_unmatched, 1);
    assert_true(at(image, "R", 3, 3) == at(image, "R", 0, 0));
    struct rect outside = {0, 0, 9, 8};
    assert_int_equal(block_reconstruct(&plan, patch, outside, image, &sum), ERR_RANGE);
    patch_destroy(&patch);
    film_destroy(&film);
    image_destroy(&image);
}

static void no_cut_changes_a_bit(void **state)
{
    (void)state;
    struct world world = plain;
    world.edge_x = 60.3f;
    world.slant = -0.37f;
    world.near_light = 10.0f;
    world.near_depth = 4.9f;
    static const int32_t cuts[][3] = {
        {16, 64, 0}, {64, 7, 0}, {32, 64, 5}, {8, 1, 0}, {128, 33, 2}};
    /* Thinner than a pixel: sub-samples look farther for a pixel that matches. */
    struct world thin = world;
    thin.slat_px = 0.3f;
    thin.slant = -0.05f;
    thin.near_depth = 2.0f;
    thin.far_light = 1.0f;
    const struct world *worlds[] = {&world, &thin, NULL};
    for (int n = 0; n < 3; n++) {
        struct plan plan;
        make_plan(&plan, 131, 67);
        struct image *whole = render(&plan, worlds[n], 200, 0, NULL, NULL);
        for (size_t i = 0; i < sizeof cuts / sizeof cuts[0]; i++) {
            plan.tile_px = cuts[i][0];
            struct image *cut = render(&plan, worlds[n], cuts[i][1], cuts[i][2], NULL, NULL);
            assert_same(whole, cut);
            image_destroy(&cut);
        }
        image_destroy(&whole);
    }
}

static void layers_hold_what_they_say(void **state)
{
    (void)state;
    struct plan plan;
    synthetic_plan(&plan, 24, 24, 8);
    struct image *image = render(&plan, NULL, 64, 0, NULL, NULL);
    for (int32_t y = 0; y < 24; y++) {
        for (int32_t x = 0; x < 24; x++) {
            struct synthetic_pixel p = synthetic_pixel(&plan, x, y);
            bool hit = p.depth > 0.0f;
            float seen = (float)__builtin_popcount(p.visibility) / 9.0f;
            assert_true(at(image, "depth.Z", x, y) == p.depth);
            assert_true(at(image, "id.I", x, y) == (float)p.id);
            assert_true(fabsf(at(image, "normal.Y", x, y) - p.normal[1]) < 1e-4f);
            assert_true(at(image, "samples.N", x, y) == (hit ? 18.0f : 0.0f));
            assert_true(at(image, "visibility.V", x, y) == (hit ? seen : 0.0f));
            float sum = at(image, "direct.G", x, y) + at(image, "indirect.G", x, y) +
                        at(image, "emission.G", x, y);
            assert_true(fabsf(at(image, "G", x, y) - sum) <= 1e-5f * fmaxf(sum, 1.0f));
        }
    }
    image_destroy(&image);
}

static void beauty_does_not_depend_on_other_layers(void **state)
{
    (void)state;
    struct plan plan;
    struct patch *patch;
    struct film *film;
    struct image *all, *one;
    struct block_statistics sum;
    uint32_t block;
    synthetic_plan(&plan, 32, 32, 32);
    assert_int_equal(film_create(&plan, 64, 1, &film), 0);
    assert_int_equal(film_land(film, 0, 0, synthetic_tile(&plan, 0)), 0);
    assert_true(film_next_ready(film, &block));
    assert_int_equal(film_gather(film, block, &patch), 0);
    assert_int_equal(image_create(ALL_LAYERS, 32, 32, &all), 0);
    assert_int_equal(image_create(1, 32, 32, &one), 0);
    assert_int_equal(block_reconstruct(&plan, patch, patch->rect, all, &sum), 0);
    assert_int_equal(block_reconstruct(&plan, patch, patch->rect, one, &sum), 0);
    assert_memory_equal(all->data, one->data, 4u * 32u * 32u * sizeof(float));
    image_destroy(&all);
    image_destroy(&one);
    patch_destroy(&patch);
    film_destroy(&film);
}

/* Every number at the end of its range: what comes out is finite. */
static void extremes_stay_finite(void **state)
{
    (void)state;
    struct plan plan;
    struct film *film;
    struct patch *patch;
    struct image *image;
    struct block_statistics sum;
    uint32_t block;
    make_plan(&plan, 8, 8);
    plan.lights[0].color[0] = LIMIT_RADIANCE;
    plan.radiance_scale = 0x1p-24f;
    assert_int_equal(film_create(&plan, 8, 1, &film), 0);
    struct samples *s = world_tile(&plan, &plain, 0);
    static const float depths[] = {3.4e38f, 1e-45f, 1.0f, 0.0f, 1e15f};
    for (size_t i = 0; i < 64; i++) {
        samples_f32(s, PLANE_DEPTH, 0)[i] = depths[i % 5];
        samples_light_irradiance(s, 0)[i] = i % 3 ? 3.4e38f : 0.0f;
        samples_u32(s, PLANE_NORMAL, 0)[i] = (uint32_t)i * 2654435761u;
        for (uint32_t c = 0; c < 3; c++) {
            samples_u16(s, PLANE_EMISSION, c)[i] = half_from_float(HALF_MAX);
            samples_u16(s, PLANE_INDIRECT_MEAN, c)[i] = half_from_float(HALF_MAX);
            samples_u16(s, PLANE_SUB_DEPTH, c)[i] = half_from_float(i % 2 ? HALF_MAX : -0.9995f);
            samples_u16(s, PLANE_SUB_NORMAL, c)[i] = (uint16_t)(i * 40503u);
        }
    }
    assert_int_equal(film_land(film, 0, 0, s), 0);
    assert_true(film_next_ready(film, &block));
    assert_int_equal(film_gather(film, block, &patch), 0);
    for (int type = 0; type < 2; type++) {
        plan.camera.type = type ? CAMERA_ORTHOGRAPHIC : CAMERA_PERSPECTIVE;
        plan.camera.half_width = type ? LIMIT_COORDINATE : 1e-8f;
        assert_int_equal(image_create(ALL_LAYERS, 8, 8, &image), 0);
        assert_int_equal(block_reconstruct(&plan, patch, patch->rect, image, &sum), 0);
        for (size_t i = 0; i < image->channel_count * 64u; i++) {
            assert_true(isfinite(image->data[i]));
        }
        image_destroy(&image);
    }
    patch_destroy(&patch);
    film_destroy(&film);
}

static void an_orthographic_silhouette_is_clean(void **state)
{
    (void)state;
    struct plan plan;
    struct world world = plain;
    world.edge_x = 20.3f;
    world.slant = 0.37f;
    world.near_light = 10.0f;
    world.far_light = 0.0f;
    world.near_id = world.far_id = 3;
    make_plan(&plan, 64, 64);
    plan.camera.type = CAMERA_ORTHOGRAPHIC;
    struct image *image = render(&plan, &world, 64, 0, NULL, NULL);
    float value = world.near_albedo * world.near_light / PI;
    for (int32_t y = 0; y < 64; y++) {
        for (int32_t x = 0; x < 64; x++) {
            float share = (float)near_samples(&plan, &world, x, y) / 4.0f;
            assert_true(fabsf(at(image, "R", x, y) - share * value) < 1e-3f);
        }
    }
    image_destroy(&image);
}

static void it_is_quick(void **state)
{
    (void)state;
    struct plan plan;
    struct world world = plain;
    double seconds;
    make_plan(&plan, 720, 720);
    world.edge_x = 300.0f;
    world.slant = 0.2f;
    for (int n = 0; n < 2; n++) {
        world.tilt = n ? 1.2f : 0.0f;
        struct image *image = render(&plan, &world, 64, 0, NULL, &seconds);
        print_message("# gather and reconstruction, all layers, tilt %.1f: %.0f ns a pixel\n",
                      (double)world.tilt, seconds / (720.0 * 720.0) * 1e9);
        image_destroy(&image);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_constant_field_stays_constant),
        cmocka_unit_test(a_silhouette_is_the_mixture_of_both_surfaces),
        cmocka_unit_test(depth_alone_keeps_light_apart),
        cmocka_unit_test(normals_alone_keep_light_apart),
        cmocka_unit_test(ids_are_preferred_on_one_plane),
        cmocka_unit_test(large_ids_match_their_own),
        cmocka_unit_test(threads_make_the_same_picture),
        cmocka_unit_test(an_edge_against_nothing_has_partial_alpha),
        cmocka_unit_test(background_is_skipped_and_counted),
        cmocka_unit_test(a_stray_sub_sample_is_counted),
        cmocka_unit_test(no_cut_changes_a_bit),
        cmocka_unit_test(layers_hold_what_they_say),
        cmocka_unit_test(beauty_does_not_depend_on_other_layers),
        cmocka_unit_test(extremes_stay_finite),
        cmocka_unit_test(an_orthographic_silhouette_is_clean),
        cmocka_unit_test(it_is_quick),
    };
    return cmocka_run_group_tests_name("block", tests, NULL, NULL);
}
