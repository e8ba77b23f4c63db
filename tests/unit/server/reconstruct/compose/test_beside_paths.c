/* Indirect light and occlusion of light fields: filtered blocks, alone and beside paths. */
#include <math.h>

#include "proto/job/job.h"
#include "server/reconstruct/lighting/lighting.h"
#include "tests/unit/server/reconstruct/film_picture.h"
#include "tests/unit/server/reconstruct/synthetic_paths.h"
#include "tests/unit/unit.h"

#define LAYERS (LAYERS_AVAILABLE & ~LAYER_ERROR)

/* The picture after `passes` passes. */
static struct image *render_cut(const struct plan *plan, int32_t block_px, int32_t more_halo_px,
                                uint32_t passes, struct block_statistics *sum)
{
    struct film *film = picture_film(plan, block_px, more_halo_px);
    struct image *image;
    struct tile_grid grid;
    *sum = (struct block_statistics){0};
    tile_grid_init(&grid, plan->width_px, plan->height_px, plan->tile_px);
    assert_int_equal(image_create(LAYERS, plan->width_px, plan->height_px, &image), 0);
    for (uint32_t p = 0; p < passes; p++)
        for (uint32_t t = 0; t < tile_grid_count(&grid); t++) {
            assert_int_equal(film_land(film, t, p, synthetic_pass(plan, t, p)), 0);
            picture_draw(plan, film, image, sum);
        }
    assert_true(film_complete(film) == (passes == plan_pass_count(plan)));
    film_destroy(&film);
    return image;
}

static struct image *render(const struct plan *plan, uint32_t passes, struct block_statistics *sum)
{
    return render_cut(plan, block_side_px(plan), 0, passes, sum);
}

static size_t area_of(const struct image *image)
{
    return (size_t)image->width_px * (size_t)image->height_px;
}

static void same(const struct image *a, const struct image *b, const char *name)
{
    assert_memory_equal(picture_channel(a, name), picture_channel(b, name),
                        area_of(a) * sizeof(float));
}

static void is_sum(const struct image *sum, const char *name, const struct image *a,
                   const char *of_a, const struct image *b, const char *of_b)
{
    const float *s = picture_channel(sum, name), *x = picture_channel(a, of_a),
                *y = picture_channel(b, of_b);
    for (size_t i = 0; i < area_of(sum); i++) assert_true(s[i] == x[i] + y[i]);
}

/* The same samples as two plans see them. */
static void split(const struct plan *beside, struct plan *paths, struct plan *field)
{
    *paths = *field = *beside;
    paths->planes &= PLANES_PATH | PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ID);
    paths->paths.without_diffuse_indirect = 0;
    paths->sub_samples = paths->indirect_strata_per_axis = 0;
    paths->indirect_filter = INDIRECT_FILTER_NONE;
    field->planes &= ~PLANES_PATH;
    field->paths = (struct plan_paths){.spp = 0};
    field->light_count = 0;
}

static void check_sum(const struct plan *plan, uint32_t passes, const struct image *paths,
                      const struct block_statistics *of_paths)
{
    struct plan paths_plan, field_plan;
    struct block_statistics sum, of_field;
    split(plan, &paths_plan, &field_plan);
    struct image *all = render(plan, passes, &sum);
    struct image *field = render(&field_plan, 1, &of_field);
    is_sum(all, "R", paths, "R", field, "indirect.R");
    is_sum(all, "G", paths, "G", field, "indirect.G");
    is_sum(all, "B", paths, "B", field, "indirect.B");
    is_sum(all, "indirect.G", paths, "indirect.G", field, "indirect.G");
    is_sum(all, "samples.N", paths, "samples.N", field, "samples.N");
    static const char *const from_paths[] = {"A", "direct.R", "emission.B", "albedo.G",
                                             "diffuse_direct.R"};
    for (size_t i = 0; i < sizeof from_paths / sizeof from_paths[0]; i++)
        same(all, paths, from_paths[i]);
    static const char *const from_field[] = {"diffuse_indirect.R",
                                             "diffuse_indirect.B",
                                             "occlusion.O",
                                             "filter_width.W",
                                             "depth.Z",
                                             "id.I"};
    for (size_t i = 0; i < sizeof from_field / sizeof from_field[0]; i++)
        same(all, field, from_field[i]);
    if (passes == plan_pass_count(plan)) {
        assert_int_equal(sum.sub_samples_unmatched, of_field.sub_samples_unmatched);
        assert_int_equal(sum.pixels_background, of_paths->pixels_background);
        assert_int_equal(sum.indirect.pixels_filtered, of_field.indirect.pixels_filtered);
    }
    image_destroy(&all);
    image_destroy(&field);
}

/* With every filter, after the first pass and after the last. */
TEST(pictures_are_sums_of_paths_and_light_fields)
{
    struct plan plan, paths_plan, field_plan;
    synthetic_beside_plan(&plan, 150, 90, 32, 64);
    assert_int_equal(plan_pass_count(&plan), 3);
    split(&plan, &paths_plan, &field_plan);
    for (uint32_t passes = 1; passes <= 3; passes += 2) {
        struct block_statistics of_paths;
        struct image *paths = render(&paths_plan, passes, &of_paths);
        for (uint32_t f = INDIRECT_FILTER_NONE; f <= INDIRECT_FILTER_BLEND; f++) {
            plan.indirect_filter = f;
            check_sum(&plan, passes, paths, &of_paths);
        }
        image_destroy(&paths);
    }
}

/* Where fields bring direct light of listed lights: theirs and what shines come on top of what
 * paths have, whose albedo is whole. */
TEST(listed_lights_come_on_top_of_paths)
{
    struct plan plan, paths_plan, field_plan;
    struct block_statistics sum, of_paths, of_field;
    synthetic_beside_plan(&plan, 150, 90, 32, 64);
    plan.planes |= PLANE_BIT(EMISSION) | PLANE_BIT(ALBEDO);
    plan.light_planes =
        1u << LIGHT_PLANE_IRRADIANCE | 1u << LIGHT_PLANE_VISIBILITY | 1u << LIGHT_PLANE_SLOPES;
    plan.paths.without_diffuse_direct = DIRECT_LEFT_LISTED;
    split(&plan, &paths_plan, &field_plan);
    paths_plan.paths.without_diffuse_direct = DIRECT_LEFT_NONE;
    paths_plan.light_planes = 0;
    field_plan.light_count = plan.light_count;
    struct image *all = render(&plan, 3, &sum), *paths = render(&paths_plan, 3, &of_paths);
    struct image *field = render(&field_plan, 1, &of_field);
    is_sum(all, "direct.R", paths, "direct.R", field, "direct.R");
    is_sum(all, "indirect.G", paths, "indirect.G", field, "indirect.G");
    is_sum(all, "emission.B", paths, "emission.B", field, "emission.B");
    same(all, paths, "albedo.G");
    const float *r = picture_channel(all, "R"), *p = picture_channel(paths, "R"),
                *f = picture_channel(field, "R"), *e = picture_channel(all, "emission.R"),
                *d = picture_channel(field, "direct.R");
    uint32_t lit = 0, shines = 0;
    for (size_t i = 0; i < area_of(all); i++) {
        assert_true(fabsf(r[i] - (p[i] + f[i])) <= 1e-5f * r[i]);
        lit += d[i] > 0.0f, shines += e[i] > 0.0f;
    }
    assert_true(lit > 1000 && shines > 1000);
    assert_int_equal(sum.pixels_background, of_field.pixels_background);
    image_destroy(&all);
    image_destroy(&paths);
    image_destroy(&field);
}

TEST(no_cut_changes_a_bit)
{
    static const struct {
        int32_t block_px, more_halo_px, tile_px;
    } cuts[] = {{37, 0, 64}, {64, 5, 8}, {31, 3, 100}};
    struct block_statistics sum;
    struct plan plan;
    synthetic_beside_plan(&plan, 150, 90, 32, 17);
    for (uint32_t f = INDIRECT_FILTER_NONE; f <= INDIRECT_FILTER_BLEND; f++) {
        plan.indirect_filter = f;
        plan.tile_px = 32;
        struct image *whole = render_cut(&plan, 256, 0, 2, &sum);
        for (size_t i = 0; i < sizeof cuts / sizeof cuts[0]; i++) {
            plan.tile_px = cuts[i].tile_px;
            struct image *cut = render_cut(&plan, cuts[i].block_px, cuts[i].more_halo_px, 2, &sum);
            assert_memory_equal(whole->data, cut->data,
                                area_of(whole) * whole->channel_count * sizeof(float));
            image_destroy(&cut);
        }
        image_destroy(&whole);
    }
}

/* Unfiltered, a pixel's centre shows what was measured there, and openness where there is nothing.
 */
TEST(averages_are_what_was_measured)
{
    struct block_statistics sum;
    struct plan plan;
    synthetic_beside_plan(&plan, 50, 40, 32, 1);
    struct image *image = render(&plan, 1, &sum);
    const float *open = picture_channel(image, "occlusion.O"),
                *red = picture_channel(image, "diffuse_indirect.R");
    const float *samples = picture_channel(image, "samples.N"),
                *width = picture_channel(image, "filter_width.W");
    for (int32_t y = 0, i = 0; y < 40; y++)
        for (int32_t x = 0; x < 50; x++, i++) {
            const struct synthetic_pixel p = synthetic_pixel(&plan, x, y);
            const bool there = p.depth > 0;
            assert_true(open[i] == (there ? p.open : 1.0f));
            assert_true(fabsf(red[i] - p.indirect[0]) < 1e-3f);
            assert_true(samples[i] == (there ? 10.0f : 1.0f));
            assert_true(width[i] == 0.0f);
        }
    assert_int_equal(sum.indirect.pixels_filtered + sum.indirect.pixels_skipped, 0);
    assert_true(sum.indirect_cpu_us == 0 && sum.shadow_cpu_us == 0);
    image_destroy(&image);
}

/* Without sub-samples nobody reads beyond a block: every pixel counts once. */
TEST(counters_add_up)
{
    struct block_statistics sum;
    struct plan plan;
    synthetic_beside_plan(&plan, 150, 90, 32, 17);
    plan.sub_samples = 0;
    plan.planes &=
        ~(PLANE_BIT(SUB_DEPTH) | PLANE_BIT(SUB_NORMAL) | PLANE_BIT(SUB_ALBEDO) | PLANE_BIT(SUB_ID));
    plan.indirect_filter = INDIRECT_FILTER_CONSTANT;
    struct image *image = render(&plan, 2, &sum);
    uint64_t there = 0, wide = 0;
    for (size_t i = 0; i < area_of(image); i++) {
        there += picture_channel(image, "depth.Z")[i] > 0.0f;
        wide += picture_channel(image, "filter_width.W")[i] > 0.0f;
    }
    assert_int_equal(sum.indirect.pixels_filtered, there);
    assert_int_equal(sum.indirect.pixels_skipped, area_of(image) - there);
    assert_true(wide > there / 2 && wide <= there);
    image_destroy(&image);
}

/* A patch as the film makes it, whose bounce rays have come in the parts that `planes` say. */
static void fill_parts(const struct plan *plan, struct patch *patch)
{
    const int32_t width = rect_width(patch->rect);
    const size_t area = (size_t)rect_area(patch->rect);
    for (size_t i = 0; i < area; i++) {
        struct synthetic_pixel p = synthetic_pixel(plan, (int32_t)i % width, (int32_t)i / width);
        patch->depth[i] = p.depth;
        patch->id[i] = p.id;
        patch->bounce_distance_min[i] = p.bounce_distance_min;
        for (int c = 0; c < 3; c++) {
            patch->normal[c][i] = p.normal[c];
            /* 5 even samples, 4 odd ones */
            if (patch->indirect[c]) patch->indirect[c][i] = p.indirect[c];
            if (patch->indirect_even[c]) patch->indirect_even[c][i] = p.indirect[c] * 1.8f;
            if (patch->indirect_odd[c]) patch->indirect_odd[c][i] = 0.0f;
            for (uint32_t s = 0; s < 9 && patch->indirect_strata; s++)
                patch->indirect_strata[(s * 4 + (uint32_t)c) * area + i] =
                    s % 2 ? 0.0f : p.indirect[c] * 1.8f;
        }
    }
}

/* Means, means over halves, single strata: the same light, filtered or not. */
TEST(parts_make_the_same_light)
{
    const struct rect rect = {0, 0, 60, 50}, lit = {7, 5, 50, 41};
    for (uint32_t f = INDIRECT_FILTER_NONE; f <= INDIRECT_FILTER_LINEAR; f++) {
        struct lighting made[3];
        for (int k = 0; k < 3; k++) {
            static const enum plane_id planes[] = {PLANE_INDIRECT_MEAN, PLANE_INDIRECT_HALVES,
                                                   PLANE_INDIRECT_STRATA};
            struct lighting_statistics statistics = {.shadow_cpu_us = 0};
            struct plan plan;
            struct patch *patch;
            synthetic_plan(&plan, 60, 50, 32);
            plan.light_count = 0;
            plan.planes = PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ID) |
                          PLANE_BIT(BOUNCE_DISTANCE_MIN) | UINT64_C(1) << planes[k];
            plan.indirect_filter = f;
            assert_int_equal(patch_create(&plan, rect, &patch), 0);
            fill_parts(&plan, patch);
            assert_int_equal(lighting_create(&plan, patch, lit, false, &made[k], &statistics), 0);
            assert_true((statistics.indirect.pixels_filtered > 0) == (f != INDIRECT_FILTER_NONE));
            patch_destroy(&patch);
        }
        for (int32_t i = 0; i < 60 * 50; i++) {
            const bool inside = i % 60 >= 7 && i % 60 < 50 && i / 60 >= 5 && i / 60 < 41;
            const float mean = made[0].indirect[1][i];
            assert_true(inside || mean == 0.0f);
            assert_true(made[0].total[1][i] == mean);
            for (int k = 1; k < 3; k++)
                assert_true(fabsf(made[k].indirect[1][i] - mean) <= 1e-4f * mean);
        }
        for (int k = 0; k < 3; k++) lighting_fini(&made[k]);
    }
}

/* Occlusion alone needs no surfaces beside the centres. */
TEST(occlusion_comes_alone)
{
    struct block_statistics sum;
    struct plan plan, alone;
    synthetic_beside_plan(&plan, 100, 70, 32, 4);
    plan.indirect_filter = INDIRECT_FILTER_CONSTANT;
    alone = plan;
    alone.planes &= PLANES_PATH | PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ID) |
                    PLANE_BIT(BOUNCE_DISTANCE_MIN) | PLANE_BIT(AMBIENT_VISIBILITY);
    alone.paths.without_diffuse_indirect = 0;
    alone.sub_samples = alone.bounces = 0;
    assert_int_equal(block_halo_px(&alone) + PATCH_RING_PX, block_halo_px(&plan));
    struct image *with = render(&plan, 1, &sum);
    struct image *without = render(&alone, 1, &sum);
    same(with, without, "occlusion.O");
    same(with, without, "filter_width.W");
    image_destroy(&with);
    image_destroy(&without);
}

/* A wall that is the more open the farther right; nothing is in the way near its edge, where lines
 * are fitted to one side. */
static void fill_wall(struct patch *patch, float distance)
{
    const int32_t width = rect_width(patch->rect);
    for (int32_t i = 0; i < rect_area(patch->rect); i++) {
        patch->depth[i] = distance;
        patch->id[i] = 1;
        patch->normal[0][i] = patch->normal[1][i] = 0.0f;
        patch->normal[2][i] = 1.0f;
        patch->bounce_distance_min[i] = distance;
        patch->ambient_visibility[i] = fminf(1.0f, (float)(i % width) / 74.0f);
    }
}

/* Also where linear fits go beyond what they are made of. */
TEST(openness_is_a_share)
{
    const struct rect rect = {0, 0, 80, 40};
    for (uint32_t f = INDIRECT_FILTER_NONE; f <= INDIRECT_FILTER_BLEND; f++) {
        struct plan plan;
        struct patch *patch;
        struct image *image;
        struct block_statistics statistics;
        synthetic_plan(&plan, 80, 40, 32);
        plan.light_count = 0;
        plan.planes = PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ID) |
                      PLANE_BIT(BOUNCE_DISTANCE_MIN) | PLANE_BIT(AMBIENT_VISIBILITY);
        plan.camera.type = CAMERA_ORTHOGRAPHIC;
        plan.indirect_filter = f;
        plan.mu = 10.0f;
        assert_int_equal(patch_create(&plan, rect, &patch), 0);
        assert_int_equal(image_create(LAYER_OCCLUSION, 80, 40, &image), 0);
        fill_wall(patch, plan.length_unit);
        assert_int_equal(block_reconstruct(&plan, patch, rect, image, &statistics), 0);
        const float *open = picture_channel(image, "occlusion.O");
        for (size_t i = 0; i < area_of(image); i++) assert_true(open[i] >= 0.0f && open[i] <= 1.0f);
        patch_destroy(&patch);
        image_destroy(&image);
    }
}
