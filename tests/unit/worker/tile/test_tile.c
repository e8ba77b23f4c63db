/* The sample loop: tiles, progress, stopping, counters of what is skipped. */
#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"

#include <xmmintrin.h>

/* A floor with two boxes of quads, two lights, mapped and masked materials: something of all. */
static struct plan busy_plan(struct scene_fixture *f, int32_t w, int32_t h)
{
    static const uint8_t checks[16] = {255, 0, 0,   255, 0,   255, 0, 0,
                                       0,   0, 255, 0,   255, 255, 0, 255};
    struct plan p = floor_plan(f, 3.0f, w);
    p.height_px = h;
    p.camera.half_height = p.camera.half_width * (float)h / (float)w;
    uint32_t red = fixture_material(f, 0.8f, 0.1f, 0.1f);
    uint32_t holes = fixture_material(f, 1, 1, 1);
    f->materials[holes].alpha_mode = ALPHA_MASK;
    f->materials[holes].alpha_cutoff = 0.5f;
    f->materials[holes].base_color_texture.texture =
        fixture_texture(f, 2, 2, checks, IMAGE_IS_SRGB);
    fixture_panel(f, red, (float[]){0.5f, 0.5f, 0}, (float[]){0, 0.5f, 0}, (float[]){0, 0, 0.7f});
    fixture_panel(f, holes, (float[]){-0.5f, 0.6f, 0.4f}, (float[]){0.4f, 0, 0},
                  (float[]){0.1f, 0.1f, -0.5f});
    uint32_t mesh = fixture_mesh(f, red, 0);
    fixture_quad(f, (float[]){0, 0, 0}, (float[]){0.2f, 0, 0}, (float[]){0, 0, -0.2f});
    fixture_place_at(f, mesh, (float[]){1, 0.2f, 0, -1, 0, 1, 0, 0.3f, 0, 0, 1, -1});
    fixture_place_at(f, mesh, (float[]){2, 0, 0, 1, 0, 1, 0, 0.8f, 0.5f, 0, 1, 1});
    fixture_ceiling_light(&p, 0.3f, 2, 0.2f, 0.4f, 3);
    struct plan_light *point = fixture_light(&p, LIGHT_POINT, 1);
    point->position[1] = 1.5f;
    fixture_bounces(&p, 3);
    p.sub_samples = 3;
    p.planes |= PLANE_BIT(SUB_DEPTH) | PLANE_BIT(SUB_NORMAL) | PLANE_BIT(SUB_ALBEDO) |
                PLANE_BIT(SUB_ID) | PLANE_BIT(EMISSION) | PLANES_MATTE;
    return p;
}

/* Compares all bytes of a tile with the same pixels of the whole frame. */
static void expect_same(const struct samples *whole, const struct samples *part, struct rect r)
{
    static const uint32_t element[] = {4, 2, 1};
    const struct samples_layout *a = &whole->layout, *b = &part->layout;
    size_t whole_at = 0, part_at = 0;
    for (int group = 0; group < 3; group++) {
        size_t size = element[group], area = (size_t)b->width_px * (size_t)b->height_px;
        size_t components = b->group_bytes[group] / (size * area);
        assert_int_equal(a->group_bytes[group] % components, 0);
        for (size_t c = 0; c < components; c++)
            for (int32_t y = 0; y < b->height_px; y++) {
                size_t row = (size_t)(r.y0 + y) * (size_t)a->width_px + (size_t)r.x0;
                const uint8_t *from = whole->data + whole_at +
                                      size * (c * (size_t)a->width_px * (size_t)a->height_px + row);
                const uint8_t *to =
                    part->data + part_at + size * (c * area + (size_t)y * (size_t)b->width_px);
                assert_memory_equal(from, to, size * (size_t)b->width_px);
            }
        whole_at += a->group_bytes[group];
        part_at += b->group_bytes[group];
    }
}

TEST(test_tiles_do_not_matter)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = busy_plan(f, 70, 50);
    struct traced t = trace_all(f, &p);
    static const int32_t sides[] = {8, 16, 33};
    for (int s = 0; s < 3; s++) {
        struct counters sum = {0};
        struct tile_grid grid;
        assert_int_equal(tile_grid_init(&grid, p.width_px, p.height_px, sides[s]), 0);
        for (uint32_t i = 0; i < tile_grid_count(&grid); i++) {
            struct samples *part = NULL;
            struct rect r = tile_grid_rect(&grid, i);
            assert_int_equal(trace_tile(&t,
                                        (struct tile_job){.plan = &p, .rect = r, .counters = &sum},
                                        0, &part),
                             0);
            expect_same(t.samples, part, r);
            samples_destroy(&part);
        }
        for (int c = 0; c < COUNTER_COUNT; c++)
            if (c != COUNTER_TRACE_CPU_US) assert_int_equal(sum.value[c], t.counters.value[c]);
    }
    traced_fini(&t);
    free(f);
}

TEST(test_samples_pass_validation)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = busy_plan(f, 40, 24);
    struct traced t = trace_all(f, &p);
    struct bytes_writer w;
    struct samples *back = NULL;
    struct fault fault = {0};
    bytes_writer_init(&w);
    assert_int_equal(samples_pack(t.samples, PACKING_SMALL, &w, NULL), 0);
    assert_int_equal(samples_unpack(w.data, w.size_bytes, &p, 0, 40, 24, &back, &fault), 0);
    assert_memory_equal(back->data, t.samples->data, back->layout.total_bytes);
    samples_destroy(&back);
    bytes_writer_fini(&w);
    traced_fini(&t);
    free(f);
}

TEST(test_progress_and_stop)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 2.5f, 64);
    struct traced t = trace_all(f, &p);
    _Atomic uint64_t progress = 0;
    _Atomic bool stop = false;
    struct samples *s = NULL;
    struct rect r = {3, 5, 40, 28};
    unsigned int mode = _mm_getcsr();
    assert_int_equal(
        trace_tile(&t,
                   (struct tile_job){.plan = &p, .rect = r, .progress = &progress, .stop = &stop},
                   0, &s),
        0);
    assert_int_equal(_mm_getcsr() & 0x8040u, mode & 0x8040u);
    assert_int_equal(progress, 23);
    samples_destroy(&s);
    stop = true;
    assert_int_equal(
        trace_tile(&t,
                   (struct tile_job){.plan = &p, .rect = r, .progress = &progress, .stop = &stop},
                   0, &s),
        ERR_STATE);
    assert_null(s);
    traced_fini(&t);
    free(f);
}

/* A row of blocks can take minutes: what watches it sees that it goes on. */
TEST(test_many_bounce_rays_show_progress)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 2.5f, 64);
    struct traced t = trace_all(f, &p);
    _Atomic uint64_t progress = 0;
    struct samples *s = NULL;
    struct rect block = {28, 28, 32, 32};
    p.bounces = 1;
    p.planes |= PLANE_BIT(INDIRECT_MEAN);
    p.indirect_strata_per_axis = 16;
    assert_int_equal(
        trace_tile(&t, (struct tile_job){.plan = &p, .rect = block, .progress = &progress}, 0, &s),
        0);
    assert_int_equal(progress, 4 + 256 / 16 - 1);
    samples_destroy(&s);
    traced_fini(&t);
    free(f);
}

TEST(test_rectangles_outside_are_refused)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 2.5f, 600);
    struct traced t = trace(f, &p, (struct rect){0, 0, 8, 8});
    static const struct rect wrong[] = {
        {-1, 0, 8, 8}, {0, 0, 0, 8}, {0, 8, 8, 8}, {592, 0, 601, 8}, {0, 0, 257, 8}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        struct samples *s = NULL;
        assert_int_equal(trace_tile(&t, (struct tile_job){.plan = &p, .rect = wrong[i]}, 0, &s),
                         ERR_RANGE);
    }
    traced_fini(&t);
    free(f);
}

TEST(test_background_is_counted)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 1.0f, 32); /* covers half the width and height */
    fixture_ceiling_light(&p, 0, 2, 0, 0.5f, 2);
    struct traced t = trace_all(f, &p);
    assert_int_equal(count(&t, COUNTER_RAYS_PRIMARY), 32 * 32);
    assert_int_equal(count(&t, COUNTER_SKIPPED_BACKGROUND), 32 * 32 * 3 / 4);
    assert_int_equal(count(&t, COUNTER_RAYS_SHADOW), 16 * 16 * 4);
    assert_int_equal(samples_u32(t.samples, PLANE_ID, 0)[0], 0);
    assert_int_equal(samples_u32(t.samples, PLANE_ID, 0)[16 * 32 + 16], 1);
    assert_true(samples_f32(t.samples, PLANE_DEPTH, 0)[0] == 0.0f);
    assert_int_equal(samples_light_visibility(t.samples, 0, 0)[0], 0);
    assert_int_equal(samples_light_visibility(t.samples, 0, 0)[16 * 32 + 16], 15);
    traced_fini(&t);
    free(f);
}

/* One floor under lights of which none needs a ray. */
TEST(test_light_skips_are_counted)
{
    const uint64_t pixels = 16 * 16;
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 2.5f, 16);
    struct plan_light *away = fixture_ceiling_light(&p, 0, 2, 0, 0.5f, 2);
    away->direction[1] = 1;
    struct plan_light *below = fixture_ceiling_light(&p, 0, -2, 0, 0.5f, 3);
    below->direction[1] = 1;
    struct plan_light *spot = fixture_light(&p, LIGHT_SPOT, 1);
    spot->position[1] = 2, spot->position[0] = 50;
    spot->cos_inner = 0.95f, spot->cos_outer = 0.9f;
    struct plan_light *far = fixture_light(&p, LIGHT_POINT, 1);
    far->position[1] = 50, far->range = 20;
    struct plan_light *sun = fixture_light(&p, LIGHT_DIRECTIONAL, 1);
    sun->direction[1] = 1;
    struct traced t = trace_all(f, &p);
    assert_int_equal(count(&t, COUNTER_RAYS_SHADOW), 0);
    assert_int_equal(count(&t, COUNTER_SKIPPED_FACING_AWAY), pixels * 4);
    assert_int_equal(count(&t, COUNTER_SKIPPED_BELOW_HORIZON), pixels * (9 + 1));
    assert_int_equal(count(&t, COUNTER_SKIPPED_OUT_OF_CONE), pixels);
    assert_int_equal(count(&t, COUNTER_SKIPPED_OUT_OF_RANGE), pixels);
    for (uint32_t k = 0; k < p.light_count; k++)
        assert_true(samples_light_irradiance(t.samples, k)[77] == 0.0f);
    assert_int_equal(samples_light_visibility(t.samples, 1, 0)[77], 0xff);
    assert_int_equal(samples_light_visibility(t.samples, 1, 1)[77], 1);
    traced_fini(&t);
    free(f);
}

TEST(test_black_surfaces_are_counted)
{
    const uint64_t pixels = 16 * 16;
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 2.5f, 16);
    for (int i = 0; i < 3; i++) f->materials[0].base_color[i] = 0.0f;
    fixture_ceiling_light(&p, 0, 2, 0, 0.5f, 3);
    fixture_bounces(&p, 2);
    struct traced t = trace_all(f, &p);
    assert_int_equal(count(&t, COUNTER_RAYS_SHADOW) + count(&t, COUNTER_RAYS_INDIRECT), 0);
    assert_int_equal(count(&t, COUNTER_SKIPPED_BLACK_ALBEDO), pixels * (9 + 4));
    assert_int_equal(samples_light_visibility(t.samples, 0, 0)[9], 0xff);
    assert_int_equal(samples_light_visibility(t.samples, 0, 1)[9], 1);
    traced_fini(&t);
    free(f);
}
