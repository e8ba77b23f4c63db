/* The light field of glossy lobes beside that of diffuse light and paths: together they are the
 * picture that the path tracer gives alone, and surfaces without such a lobe stay with the paths.
 */
#include "tests/unit/worker/field_room.h"

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

static void compare(enum kind kind, uint32_t shines, uint32_t bounces)
{
    struct scene_fixture *f = fixture_new();
    struct plan plain = room(f, kind, shines);
    char what[96];
    plain.bounces = bounces;
    const struct plan hybrid = hybrid_of(&plain);
    struct sums *a = trace_sums(f, &plain), *b = trace_sums(f, &hybrid);
    const bool glossy = kind == DIELECTRIC || kind == COATED || kind == METAL;
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

static void fields_and_paths_are_the_picture(void **state)
{
    (void)state;
    static const uint32_t bounces[] = {1, 2, 8};
    for (int kind = 0; kind < KIND_COUNT; kind++)
        for (int k = 0; k < 3; k++)
            compare((enum kind)kind, SHINES_RECT | SHINES_MESH | SHINES_SKY, bounces[k]);
}

static void whatever_shines(void **state)
{
    (void)state;
    static const uint32_t lights[] = {SHINES_RECT,  SHINES_MESH,
                                      SHINES_SKY,   SHINES_MAP,
                                      SHINES_POINT, SHINES_RECT | SHINES_POINT | SHINES_MAP};
    for (int k = 0; k < 6; k++) {
        compare(METAL, lights[k], 2);
        compare(DIELECTRIC, lights[k], 2);
    }
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

static void brush(struct scene_material *m)
{
    m->anisotropy = 0.5f;
}

static void clear(struct scene_material *m)
{
    m->transmission = 0.5f;
    m->metallic = 0.0f;
}

static void other_lobes_stay_with_paths(void **state)
{
    (void)state;
    stays(sharpen);
    stays(brush);
    stays(clear);
}

/* What the planes say of a lobe: its roughness, its reflectance at centres and beside them, weights
 * whose mean is the reflectance, how near the rays' hits are. */
static void planes_describe_lobes(void **state)
{
    (void)state;
    static const enum kind kinds[] = {DIELECTRIC, COATED, METAL};
    static const double alphas[] = {0.25, 0.0625, 0.16};
    for (int k = 0; k < 3; k++) {
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
static void parts_are_the_whole(void **state)
{
    (void)state;
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
    assert_int_equal(render_scene_create(fixture_scene(f), 1, &scene, &fault), 0);
    assert_int_equal(tile_tracer_create(&tracer), 0);
    assert_int_equal(tile_trace(tracer, scene, NULL, &p, 0, r, NULL, NULL, &part, &counters), 0);
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
    p.planes = (p.planes & ~BIT(INDIRECT_MEAN)) | BIT(INDIRECT_HALVES) | BIT(PATH_SPREAD) |
               BIT(PATH_SPLIT);
    p.sub_samples = 3;
    p.target_error = 0.1f;
    p.spp_most = 1024;
    return p;
}

static double plane_mean(const struct samples *s, enum plane_id plane, uint32_t c)
{
    double sum = 0;
    for (int i = 0; i < AREA; i++) sum += half_at(s, plane, c, i);
    return sum / AREA;
}

/* Halves bring what the whole does, by other rays; one ray is its own half. */
static void halves_bring_the_same(void **state)
{
    (void)state;
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
static void later_passes_have_lobes(void **state)
{
    (void)state;
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
    assert_int_equal(render_scene_create(fixture_scene(f), 1, &scene, &fault), 0);
    assert_int_equal(tile_tracer_create(&tracer), 0);
    assert_int_equal(tile_trace_pass(tracer, scene, NULL, &p, &later,
                                     (struct rect){0, 0, SIDE_PX, SIDE_PX}, NULL, NULL, &more,
                                     &counters),
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fields_and_paths_are_the_picture),
        cmocka_unit_test(whatever_shines),
        cmocka_unit_test(other_lobes_stay_with_paths),
        cmocka_unit_test(planes_describe_lobes),
        cmocka_unit_test(parts_are_the_whole),
        cmocka_unit_test(halves_bring_the_same),
        cmocka_unit_test(later_passes_have_lobes),
    };
    return cmocka_run_group_tests_name("glossy_field", tests, NULL, NULL);
}
