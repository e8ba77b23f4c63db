/* The light field of glossy lobes beside that of diffuse light and paths: together they are the
 * picture that the path tracer gives alone, and surfaces without such a lobe stay with the paths.
 */
#include <stdio.h>
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/trace/field/field_room.h"

static void add_lobes(struct plan *p)
{
    p->planes |= PLANES_GLOSSY;
    p->paths.without_glossy_indirect = 1;
}

/* The lobe's part of the picture. */
static double lobe_at(const struct samples *s, uint32_t c, int i)
{
    return samples_u16(s, PLANE_GLOSSY_LOBE, c)[i] / 65535.0 * half_at(s, PLANE_GLOSSY_MEAN, c, i);
}

static struct scene_material *floor_of(struct scene_fixture *f)
{
    return &f->materials[0];
}

static struct plan hybrid_of(const struct plan *plain)
{
    struct plan p = *plain;
    add_field(&p, 16);
    add_lobes(&p);
    p.sub_samples = 3;
    return p;
}

static bool is_glossy(enum kind kind)
{
    return kind != LAMBERT && kind != PHONG;
}

static void compare(enum kind kind, uint32_t shines, uint32_t bounces)
{
    struct scene_fixture *f = fixture_new();
    struct plan plain = room(f, kind, shines);
    char what[96];
    plain.bounces = bounces;
    const struct plan hybrid = hybrid_of(&plain);
    struct sums *a = trace_sums(f, &plain), *b = trace_sums(f, &hybrid);
    const bool glossy = is_glossy(kind);
    for (uint32_t c = 0; c < 3; c++) {
        double together[AREA];
        for (int i = 0; i < AREA; i++) {
            const double lobe = lobe_at(b->first, c, i);
            together[i] = b->radiance[c][i] + field_at(b->first, c, i) + lobe;
            assert_true(a->direct[c][i] == b->direct[c][i]);
            if (glossy || kind == LAMBERT) assert_true(b->indirect[c][i] == 0.0);
            if (!glossy) assert_true(lobe == 0.0);
        }
        snprintf(what, sizeof what, "kind %d, lights %u, %u bounces, channel %u", (int)kind, shines,
                 bounces, c);
        expect_same(what, a->radiance[c], together, 0.02);
    }
    sums_free(&a);
    sums_free(&b);
    free(f);
}

TEST(fields_and_paths_are_the_picture)
{
    static const uint32_t shines = SHINES_RECT | SHINES_MESH | SHINES_SKY;
    for (int kind = 0; kind < KIND_COUNT; kind++) {
        compare((enum kind)kind, shines, is_glossy((enum kind)kind) ? 8 : 2);
        if (kind == DIELECTRIC || kind == METAL) compare((enum kind)kind, shines, 1);
    }
}

TEST(whatever_shines)
{
    static const uint32_t lights[] = {SHINES_RECT,  SHINES_MESH,
                                      SHINES_SKY,   SHINES_MAP,
                                      SHINES_POINT, SHINES_RECT | SHINES_POINT | SHINES_MAP};
    for (int k = 0; k < 6; k++) compare(k % 2 ? METAL : DIELECTRIC, lights[k], 2);
}

/* A change to the floor's material after which it has no glossy lobe. */
static void stays(void (*change)(struct scene_material *m))
{
    struct scene_fixture *f = fixture_new();
    struct plan plain = room(f, COATED, SHINES_RECT | SHINES_SKY);
    plain.bounces = 2;
    change(floor_of(f));
    struct plan lobes = hybrid_of(&plain), without = lobes;
    without.planes &= ~PLANES_GLOSSY;
    without.paths.without_glossy_indirect = 0;
    struct sums *a = trace_sums(f, &without), *b = trace_sums(f, &lobes);
    double seen = 0;
    for (uint32_t c = 0; c < 3; c++)
        for (int i = 0; i < AREA; i++) {
            assert_true(a->radiance[c][i] == b->radiance[c][i]);
            assert_int_equal(samples_u16(b->first, PLANE_GLOSSY_LOBE, c)[i], 0);
            assert_int_equal(samples_u16(b->first, PLANE_GLOSSY_LOBE, 3)[i], 0);
            assert_int_equal(samples_u16(b->first, PLANE_GLOSSY_MEAN, c)[i], 0);
            for (uint32_t k = 0; k < 3; k++)
                assert_int_equal(samples_u16(b->first, PLANE_SUB_REFLECTANCE, 3 * k + c)[i], 0);
            seen += b->indirect[c][i];
        }
    assert_true(seen > 0);
    assert_true(a->counters.value[COUNTER_RAYS_INDIRECT] ==
                b->counters.value[COUNTER_RAYS_INDIRECT]);
    sums_free(&a);
    sums_free(&b);
    free(f);
}

static void sharpen(struct scene_material *m)
{
    m->roughness = 0.09f;
}

static void clear(struct scene_material *m)
{
    m->transmission = 0.5f;
    m->metallic = 0.0f;
}

TEST(other_lobes_stay_with_paths)
{
    stays(sharpen);
    stays(clear);
}

/* What the planes say of a lobe: its roughness, its reflectance at centres and beside them, weights
 * whose mean is the reflectance, how near the rays' hits are. */
TEST(planes_describe_lobes)
{
    static const enum kind kinds[] = {DIELECTRIC, COATED, METAL, KELEMEN, WARD};
    static const double alphas[] = {0.25, 0.0625, 0.16, 0.2126, 0.2126};
    for (int k = 0; k < 5; k++) {
        struct scene_fixture *f = fixture_new();
        struct plan plain = room(f, kinds[k], SHINES_RECT);
        plain.bounces = 1;
        plain.paths.spp = 4;
        const struct plan p = hybrid_of(&plain);
        struct sums *s = trace_sums(f, &p);
        double weight = 0;
        for (int i = 0; i < AREA; i++) {
            const double near =
                half_at(s->first, PLANE_GLOSSY_NEARNESS, 0, i) / (double)p.length_unit;
            const int r = samples_u16(s->first, PLANE_GLOSSY_LOBE, 0)[i];
            assert_true(fabs(samples_u16(s->first, PLANE_GLOSSY_LOBE, 3)[i] / 65535.0 - alphas[k]) <
                        2e-5);
            assert_int_equal(samples_u16(s->first, PLANE_GLOSSY_STRETCH, 0)[i],
                             kinds[k] == WARD ? 16384 : 0);
            assert_true(abs(samples_u16(s->first, PLANE_SUB_REFLECTANCE, 3)[i] - r) <= 2);
            assert_true(near > 0.05 && near < 3);
            weight += half_at(s->first, PLANE_GLOSSY_MEAN, 3, i) / AREA;
        }
        assert_true(fabs(weight - 1) < 0.006);
        sums_free(&s);
        free(f);
    }
}

/* No sample depends on the tile that it is traced with. */
TEST(parts_are_the_whole)
{
    struct scene_fixture *f = fixture_new();
    struct plan plain = room(f, METAL, SHINES_RECT | SHINES_MAP);
    plain.environment.kind = ENVIRONMENT_CONSTANT;
    plain.bounces = 3;
    plain.paths.spp = 4;
    const struct plan p = hybrid_of(&plain);
    struct sums *whole = trace_sums(f, &p);
    const struct rect r = {3, 5, 12, 16};
    struct render_scene *scene;
    struct tile_tracer *tracer;
    struct samples *part = NULL;
    struct counters counters = {0};
    struct fault fault = {0};
    assert_int_equal(render_scene_create(fixture_scene(f), 1, NULL, &scene, &fault), 0);
    assert_int_equal(tile_tracer_create(&tracer), 0);
    assert_int_equal(
        tile_trace(tracer,
                   &(struct tile_job){.scene = scene, .plan = &p, .rect = r, .counters = &counters},
                   0, &part),
        0);
    for (int y = r.y0; y < r.y1; y++)
        for (int x = r.x0; x < r.x1; x++) {
            const int from = y * SIDE_PX + x, to = (y - r.y0) * (r.x1 - r.x0) + x - r.x0;
            for (uint32_t c = 0; c < 4; c++)
                assert_int_equal(samples_u16(whole->first, PLANE_GLOSSY_MEAN, c)[from],
                                 samples_u16(part, PLANE_GLOSSY_MEAN, c)[to]);
            assert_int_equal(samples_u16(whole->first, PLANE_GLOSSY_NEARNESS, 0)[from],
                             samples_u16(part, PLANE_GLOSSY_NEARNESS, 0)[to]);
        }
    samples_destroy(&part);
    tile_tracer_destroy(&tracer);
    render_scene_destroy(&scene);
    sums_free(&whole);
    free(f);
}

/* A lobed floor whose lobes have n = l^2 rays, under a target. */
static struct plan halved(struct scene_fixture *f, uint32_t l)
{
    struct plan p = room(f, DIELECTRIC, SHINES_RECT | SHINES_SKY);
    p.bounces = 2;
    add_field(&p, l);
    add_lobes(&p);
    p.planes = (p.planes & ~BIT(INDIRECT_MEAN)) | BIT(INDIRECT_HALVES) | BIT(PATH_M2) |
               BIT(PATH_HALF_DIFFERENCE2);
    p.sub_samples = 3;
    p.target_error = 0.1f;
    p.spp_max = 1024;
    return p;
}

static double plane_mean(const struct samples *s, enum plane_id plane, uint32_t c)
{
    double sum = 0;
    for (int i = 0; i < AREA; i++) sum += half_at(s, plane, c, i);
    return sum / AREA;
}

/* Halves bring what the whole does, by other rays; one ray is its own half. */
TEST(halves_bring_the_same)
{
    static const uint32_t sides[] = {1, 3, 16};
    for (int k = 0; k < 3; k++) {
        const uint32_t l = sides[k];
        struct scene_fixture *f = fixture_new();
        const struct plan p = halved(f, l);
        struct sums *s = trace_sums(f, &p);
        uint32_t equal = 0, lobes = 0;
        for (int i = 0; i < AREA; i++) {
            if (half_at(s->first, PLANE_GLOSSY_MEAN, 0, i) == 0) continue;
            lobes++;
            equal += half_at(s->first, PLANE_GLOSSY_MEAN, 0, i) ==
                     half_at(s->first, PLANE_GLOSSY_HALF, 0, i);
        }
        assert_true(lobes > AREA / 4 && (l == 1 ? equal == lobes : equal < lobes / 8));
        for (uint32_t c = 0; c < 4; c++) {
            const double all = plane_mean(s->first, PLANE_GLOSSY_MEAN, c);
            const double half = plane_mean(s->first, PLANE_GLOSSY_HALF, c);
            if (!(all > 0 && fabs(half / all - 1) < (l == 16 ? 0.01 : 0.1)))
                fail_msg("l %u, channel %u: %g of halves, %g of all", l, c, half, all);
        }
        sums_free(&s);
        free(f);
    }
}

/* Passes after the schedule trace lobes, too: the same light by other rays, and nothing that the
 * first has said once and for all. */
TEST(later_passes_have_lobes)
{
    struct scene_fixture *f = fixture_new();
    const struct plan p = halved(f, 8);
    const uint64_t planes =
        BIT(GLOSSY_MEAN) | BIT(GLOSSY_HALF) | BIT(GLOSSY_NEARNESS) | BIT(INDIRECT_HALVES);
    const uint32_t count = plan_pass_count(&p);
    const struct plan_pass later = {.number = count, .strata = 8};
    struct sums *s = trace_sums(f, &p);
    struct render_scene *scene;
    struct tile_tracer *tracer;
    struct fault fault = {0};
    struct counters counters = {0};
    struct samples *more;
    assert_int_equal(render_scene_create(fixture_scene(f), 1, NULL, &scene, &fault), 0);
    assert_int_equal(tile_tracer_create(&tracer), 0);
    assert_int_equal(
        tile_trace_pass(tracer,
                        &(struct tile_job){.scene = scene,
                                           .plan = &p,
                                           .pass = &later,
                                           .rect = (struct rect){0, 0, SIDE_PX, SIDE_PX},
                                           .counters = &counters},
                        &more),
        0);
    assert_int_equal(more->layout.planes & (PLANES_GLOSSY | BIT(INDIRECT_HALVES)), planes);
    uint32_t equal = 0;
    for (int i = 0; i < AREA; i++)
        equal +=
            half_at(more, PLANE_GLOSSY_MEAN, 0, i) > 0 &&
            half_at(more, PLANE_GLOSSY_MEAN, 0, i) == half_at(s->first, PLANE_GLOSSY_MEAN, 0, i);
    assert_true(equal < AREA / 8);
    for (uint32_t c = 0; c < 4; c++)
        assert_true(fabs(plane_mean(more, PLANE_GLOSSY_MEAN, c) /
                             plane_mean(s->first, PLANE_GLOSSY_MEAN, c) -
                         1) < 0.05);
    assert_true(fabs(plane_mean(more, PLANE_GLOSSY_NEARNESS, 0) /
                         plane_mean(s->first, PLANE_GLOSSY_NEARNESS, 0) -
                     1) < 0.05);
    samples_destroy(&more);
    tile_tracer_destroy(&tracer);
    render_scene_destroy(&scene);
    sums_free(&s);
    free(f);
}

/* A second set: each lobe's rays are its own, whatever the tile and the pixels beside it; lobes
 * without any are skipped, and what bounce rays get does not matter to them. */
TEST(second_sets_are_of_each_lobe)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f, METAL, SHINES_RECT | SHINES_SKY);
    p.bounces = 2;
    add_field(&p, 4);
    add_lobes(&p);
    p.planes |= BIT(BOUNCE_DISTANCE_MAX) | BIT(GLOSSY_SPAN);
    p.planes &= ~(BIT(SUB_REFLECTANCE) | BIT(GLOSSY_HALF));
    p.indirect_filter = INDIRECT_FILTER_ADAPTIVE;
    p.adaptive = (struct plan_adaptive){.mu = 1, .rays_max = 1000};
    struct fault fault = {0};
    struct render_scene *scene;
    struct tile_tracer *tracer;
    struct counters counters = {0};
    const uint32_t last = plan_pass_count(&p);
    const struct rect all = {0, 0, SIDE_PX, SIDE_PX}, part = {3, 1, SIDE_PX - 2, SIDE_PX};
    uint8_t none[AREA] = {0}, some[AREA], mixed[AREA], equal[AREA], cut_lobes[AREA];
    for (int i = 0; i < AREA; i++) {
        equal[i] = 7;
        some[i] = (uint8_t)(i % 2);
        mixed[i] = (uint8_t)(i % 3 == 0 ? 7 : i % 3 == 1 ? 5 : 0);
    }
    for (int32_t y = part.y0, k = 0; y < part.y1; y++)
        for (int32_t x = part.x0; x < part.x1; x++) cut_lobes[k++] = mixed[y * SIDE_PX + x];
    assert_int_equal(render_scene_create(fixture_scene(f), 1, NULL, &scene, &fault), 0);
    assert_int_equal(tile_tracer_create(&tracer), 0);
    struct samples *first, *more, *cut, *whole;
    const struct plan_pass start = plan_scheduled_pass(&p, 0);
    const struct plan_pass second = {last, 0, 0, 7, none, mixed},
                           same = {last, 0, 0, 7, some, equal},
                           in_part = {last, 0, 0, 7, none, cut_lobes};
#define TRACE(its_pass, its_rect, out, count)                                                      \
    assert_int_equal(tile_trace_pass(tracer,                                                       \
                                     &(struct tile_job){.scene = scene,                            \
                                                        .plan = &p,                                \
                                                        .pass = its_pass,                          \
                                                        .rect = its_rect,                          \
                                                        .counters = count},                        \
                                     out),                                                         \
                     0)
    TRACE(&start, all, &first, &(struct counters){{0}});
    TRACE(&second, all, &more, &counters);
    TRACE(&same, all, &whole, &(struct counters){{0}});
    TRACE(&in_part, part, &cut, &(struct counters){{0}});
#undef TRACE
    assert_int_equal(more->layout.planes, BIT(INDIRECT_MEAN) | BIT(GLOSSY_MEAN));
    assert_int_equal(counters.value[COUNTER_SKIPPED_ENOUGH], AREA / 3);
    assert_true(counters.value[COUNTER_RAYS_INDIRECT] > 0);
    double of_first = 0, of_second = 0;
    for (uint32_t c = 0; c < 4; c++)
        for (int i = 0; i < AREA; i++) {
            const uint16_t value = samples_u16(more, PLANE_GLOSSY_MEAN, c)[i];
            if (mixed[i] == 0) assert_int_equal(value, 0);
            if (mixed[i] == 7) assert_int_equal(value, samples_u16(whole, PLANE_GLOSSY_MEAN, c)[i]);
            of_first += half_at(first, PLANE_GLOSSY_MEAN, c, i);
            of_second += half_at(whole, PLANE_GLOSSY_MEAN, c, i);
        }
    assert_true(fabs(of_second - of_first) < 0.1 * of_first);
    for (int32_t y = part.y0; y < part.y1; y++)
        for (int32_t x = part.x0; x < part.x1; x++)
            assert_int_equal(samples_u16(more, PLANE_GLOSSY_MEAN, 1)[y * SIDE_PX + x],
                             samples_u16(cut, PLANE_GLOSSY_MEAN,
                                         1)[(y - part.y0) * rect_width(part) + x - part.x0]);
    /* lobes see from the nearest to the farthest; their mean lies between */
    for (int i = 0; i < AREA; i++) {
        const double near = half_at(first, PLANE_GLOSSY_SPAN, 0, i) * p.radiance_scale;
        const double far = half_at(first, PLANE_GLOSSY_SPAN, 1, i) * p.radiance_scale;
        const double mean = half_at(first, PLANE_GLOSSY_NEARNESS, 0, i) * p.radiance_scale;
        assert_true(near == (double)BOUNCE_DISTANCE_NONE ? far == 0.0 : far >= near && near > 0.0);
        assert_true(mean * near <= 1.002);
    }
    struct samples **const made[] = {&first, &more, &cut, &whole};
    for (int k = 0; k < 4; k++) samples_destroy(made[k]);
    tile_tracer_destroy(&tracer);
    render_scene_destroy(&scene);
    free(f);
}
