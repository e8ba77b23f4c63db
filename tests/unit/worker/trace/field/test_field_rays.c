/* A replayed ray of a light field, of those that bounce and of those of glossy lobes, is the traced
 * one: all of a pixel's, added up as tiles do, are what the tile's planes hold, bit by bit. */
#include "tests/unit/unit.h"
#include "tests/unit/worker/trace/field/field_bench.h"

/* What the steps tell, added up in their order, is what the ray brings. */
static void steps_add_up(const struct path_record *r)
{
    float sum[3] = {0, 0, 0};
    for (uint32_t d = 1; d < r->count; d++) {
        const struct path_record_vertex *v = &r->vertices[d];
        for (int k = 0; k < 3; k++) {
            for (uint32_t m = 0; m < v->met_count; m++) sum[k] += v->met[m].value[k];
            sum[k] += v->light.value[k];
        }
    }
    assert_memory_equal(sum, r->radiance, sizeof sum);
    if (!r->rejected) assert_memory_equal(r->stored, r->radiance, sizeof sum);
    if (r->count < 2) return;
    for (int k = 0; k < 3; k++) {
        assert_true(r->vertices[1].direction[k] == r->field.direction[k]);
        assert_true(r->vertices[1].throughput[k] == r->field.weight[k]);
    }
}

struct seen_of_rays {
    uint32_t bright, below, untraced, long_ones, mirrored, missed;
    uint32_t shone, soft; /* first hits that shine by themselves; skies whose soft share counts */
};

static void note_ray(const struct path_record *r, struct seen_of_rays *seen)
{
    steps_add_up(r);
    seen->bright += r->stored[0] > 0;
    seen->below += r->field.below;
    seen->untraced += !r->field.drawn;
    seen->long_ones += r->count > 2;
    seen->mirrored += r->field.mirrored > 0;
    seen->missed += r->field.distance == INFINITY;
    for (uint32_t m = 0; r->count > 1 && m < r->vertices[1].met_count; m++) {
        const struct path_record_met *met = &r->vertices[1].met[m];
        seen->shone += met->light == LIGHT_CHOICE_EMITTERS;
        seen->soft += met->light == LIGHT_CHOICE_ENVIRONMENT && met->weight < 1.0f;
    }
}

/* Which of the halves a ray is of, in pixels that all have l x l. */
static uint32_t half_of(uint32_t l, uint32_t sample)
{
    return (sample % l + sample / l) & 1;
}

static void expect_slot(struct bench *b, const struct path_record *r, uint32_t s, int i)
{
    const float scale = b->plan.radiance_scale, unit = b->plan.length_unit;
    if (!(b->samples->layout.planes & BIT(INDIRECT_STRATA))) return;
    for (uint32_t c = 0; c < 3; c++) {
        const uint16_t slot = samples_u16(b->samples, PLANE_INDIRECT_STRATA, 4 * s + c)[i];
        expect_half(slot, r->stored[c] * scale, "stratum", i);
        assert_true(b->held.has_slot && b->held.slot[c] == half_to_float(slot) / scale);
    }
    const float met = r->field.distance < INFINITY ? r->field.distance : 0.0f;
    expect_half(samples_u16(b->samples, PLANE_INDIRECT_STRATA, 4 * s + 3)[i], met / unit,
                "distance", i);
}

/* As store_radiance: `l` strata an axis of the pixel; `own`: pixels differ in that. */
static void add_up_bounces(struct bench *b, const struct field_choice *choice, uint32_t l, bool own,
                           int i, struct seen_of_rays *seen)
{
    const uint32_t n = l * l, odd = n / 2;
    const uint64_t planes = b->samples->layout.planes;
    const float scale = b->plan.radiance_scale;
    float half[2][3] = {{0}}, open = 0;
    for (uint32_t s = 0; s < n; s++) {
        const struct path_record *r = replay(b, choice, i, s);
        const uint32_t side = own ? s & 1 : half_of(l, s);
        for (int c = 0; c < 3; c++) half[side][c] += r->stored[c];
        open += r->field.distance >= b->plan.occlusion_distance ? 1.0f : 0.0f;
        if (r->field.drawn) assert_int_equal(r->field.half, side);
        note_ray(r, seen);
        expect_slot(b, r, s, i);
    }
    for (uint32_t c = 0; c < 3; c++) {
        const float mean = (half[0][c] + half[1][c]) / ((float)(n - odd) + (float)odd);
        if (planes & BIT(INDIRECT_MEAN))
            expect_half(samples_u16(b->samples, PLANE_INDIRECT_MEAN, c)[i], mean * scale, "mean",
                        i);
        if (!(planes & BIT(INDIRECT_HALVES))) continue;
        expect_half(samples_u16(b->samples, PLANE_INDIRECT_HALVES, c)[i],
                    half[0][c] / (float)(n - odd) * scale, "half", i);
        if (n > 1)
            expect_half(samples_u16(b->samples, PLANE_INDIRECT_HALVES, c + 3)[i],
                        half[1][c] / (float)odd * scale, "half", i);
    }
    if (b->plan.occlusion_distance > 0 && (planes & BIT(OPEN)))
        expect_half(samples_u16(b->samples, PLANE_OPEN, 0)[i], open / (float)n, "open", i);
    if (planes & BIT(INDIRECT_MEAN) && b->record->vertices[0].hit)
        assert_true(b->held.mean_count == 3 &&
                    half_from_float(b->held.mean[0] * scale) ==
                        samples_u16(b->samples, PLANE_INDIRECT_MEAN, 0)[i]);
}

static void expect_bounces(struct bench *b, uint32_t step, struct seen_of_rays *seen)
{
    const struct field_choice choice = {.kind = PATH_RECORD_INDIRECT};
    const struct plan_pass pass = plan_scheduled_pass(&b->plan, 0);
    bench_trace(b, &pass);
    for (int i = 0; i < b->plan.width_px * b->plan.height_px; i += (int)step)
        add_up_bounces(b, &choice, b->plan.indirect_strata_per_axis, false, i, seen);
}

/* Lambert and other floors under all that shines; with the sheared filter's strata, too. */
TEST(bounce_rays_add_up_to_planes)
{
    static const enum kind kinds[] = {LAMBERT, COATED, ASHIKHMIN};
    for (int k = 0; k < 3; k++) {
        struct bench *b = bench_new();
        struct seen_of_rays seen = {0};
        b->plan = room(b->f, kinds[k], SHINES_RECT | SHINES_MESH | SHINES_MAP);
        b->plan.bounces = 3;
        b->plan.paths.spp = 4;
        add_field(&b->plan, 3);
        b->plan.planes |= BIT(INDIRECT_HALVES) | BIT(OPEN);
        b->plan.occlusion_distance = 1;
        if (k != 1) b->plan.planes |= BIT(INDIRECT_STRATA);
        if (k == 2) b->plan.indirect_filter = INDIRECT_FILTER_SHEARED;
        expect_bounces(b, 11, &seen);
        assert_true(seen.bright > 0 && seen.long_ones > 0 && seen.missed > 0);
        bench_free(b);
    }
}

/* Light fields alone, where not every surface has a field, and some rays go below the facet:
 * emission that no light stands for belongs to bounce rays. */
TEST(so_they_do_without_paths)
{
    struct bench *b = bench_new();
    struct seen_of_rays seen = {0};
    lit_room(b);
    const uint32_t glow = fixture_material(b->f, 0, 0, 0);
    for (int k = 0; k < 3; k++) b->f->materials[glow].emission[k] = 3.0f + (float)k;
    fixture_panel(b->f, glow, (float[]){0, 5, 1}, (float[]){1.8f, 0, 0}, (float[]){0, 0, 1.8f});
    fixture_bounces(&b->plan, 4);
    b->plan.bounces = 2;
    b->plan.sub_samples = 2;
    expect_bounces(b, 5, &seen);
    assert_true(seen.bright > 0 && seen.untraced > 0 && seen.missed > 0 && seen.below > 0);
    assert_true(seen.shone > 0);
    bench_free(b);
}

/* Rays that look how far they come, and bring nothing. */
TEST(so_do_rays_that_only_look)
{
    struct bench *b = bench_new();
    struct seen_of_rays seen = {0};
    lit_room(b);
    b->plan.planes |= BIT(OPEN) | BIT(REFLECTOR);
    b->plan.indirect_strata_per_axis = 3;
    b->plan.occlusion_distance = 1.5f;
    expect_bounces(b, 5, &seen);
    assert_true(seen.bright == 0 && seen.untraced > 0 && seen.missed > 0);
    bench_free(b);
}

/* A mirror that the camera looks into, under a sky whose soft share fields bring. */
TEST(so_they_do_behind_mirrors)
{
    struct bench *b = bench_new();
    struct seen_of_rays seen = {0};
    const uint32_t metal = fixture_material(b->f, 0.9f, 0.8f, 0.7f);
    const uint32_t red = fixture_material(b->f, 0.8f, 0.3f, 0.2f);
    b->f->materials[metal].metallic = b->f->materials[metal].specular = 1;
    b->f->materials[metal].roughness = 0;
    fixture_panel(b->f, metal, (float[]){-2, 0, -4}, (float[]){2, 0, 0}, (float[]){0, 4, 0});
    fixture_panel(b->f, red, (float[]){2, 0, -4}, (float[]){2, 0, 0}, (float[]){0, 4, 0});
    fixture_panel(b->f, red, (float[]){0, 0, 3}, (float[]){-20, 0, 0}, (float[]){0, 20, 0});
    struct plan *p = &b->plan;
    *p = fixture_plan(12, 12, (float[]){0, 0, 0}, 0.5f);
    p->environment =
        (struct plan_environment){.kind = ENVIRONMENT_MAP, .radiance = {1, 2, 4}, .power = 1};
    p->planes =
        PLANES_LENS | BIT(DEPTH) | BIT(NORMAL) | BIT(INDIRECT_MEAN) | BIT(REFLECTOR) | BIT(ALBEDO);
    p->light_planes = 0;
    p->bounces = 2;
    p->lens_strata_per_axis = 2;
    p->lens_light = LENS_LIGHT_SKY;
    p->lens_mirrors = 2;
    p->indirect_strata_per_axis = 2;
    p->camera.aperture_radius = 0.1f;
    p->camera.focus_distance = 6;
    p->radiance_scale = 0.125f;
    p->length_unit = 8;
    expect_bounces(b, 7, &seen);
    assert_true(seen.bright > 0 && seen.mirrored > 0 && seen.soft > 0);
    bench_free(b);
}

/* ---- glossy lobes ---- */

/* As store: l x l rays of the pixel's lobe. */
static void add_up_lobes(struct bench *b, const struct field_choice *choice, uint32_t l, int i,
                         struct seen_of_rays *seen)
{
    const uint32_t n = l * l;
    const float scale = b->plan.radiance_scale, share = 1.0f / (float)n;
    float sum[3] = {0, 0, 0}, weight = 0, near = 0, traced = 0;
    for (uint32_t s = 0; s < n; s++) {
        const struct path_record *r = replay(b, choice, i, s);
        for (int c = 0; c < 3; c++) sum[c] += r->stored[c];
        weight += r->field.whole;
        traced += r->field.distance > 0 ? 1.0f : 0.0f;
        near += r->field.distance > 0 ? 1.0f / r->field.distance : 0.0f;
        note_ray(r, seen);
    }
    for (uint32_t c = 0; c < 3; c++)
        expect_half(samples_u16(b->samples, PLANE_GLOSSY_MEAN, c)[i], sum[c] * share * scale,
                    "lobe", i);
    expect_half(samples_u16(b->samples, PLANE_GLOSSY_MEAN, 3)[i], weight * share, "weight", i);
    if (b->samples->layout.planes & BIT(GLOSSY_NEARNESS))
        expect_half(samples_u16(b->samples, PLANE_GLOSSY_NEARNESS, 0)[i],
                    traced > 0 ? near / traced * b->plan.length_unit : 0, "nearness", i);
    assert_true(b->held.mean_count == 4);
    assert_true(b->held.mean[3] == half_to_float(samples_u16(b->samples, PLANE_GLOSSY_MEAN, 3)[i]));
}

static void glossy_room(struct bench *b, enum kind kind)
{
    b->plan = room(b->f, kind, SHINES_RECT | SHINES_SKY);
    b->plan.camera.half_width = b->plan.camera.half_height = 0.9f;
    b->plan.bounces = 2;
    b->plan.paths.spp = 4;
    add_field(&b->plan, 3);
    b->plan.planes |= PLANES_GLOSSY;
    b->plan.paths.without_glossy_indirect = 1;
    b->plan.sub_samples = 2;
}

TEST(lobes_rays_add_up_to_planes)
{
    static const enum kind kinds[] = {METAL, DIELECTRIC, LAMBERT};
    for (int k = 0; k < 3; k++) {
        struct bench *b = bench_new();
        struct seen_of_rays seen = {0};
        const struct field_choice choice = {.kind = PATH_RECORD_GLOSSY};
        glossy_room(b, kinds[k]);
        if (kinds[k] == METAL) lean(b->f, 0);
        const struct plan_pass pass = plan_scheduled_pass(&b->plan, 0);
        bench_trace(b, &pass);
        for (int i = 0; i < AREA; i += 9) add_up_lobes(b, &choice, 3, i, &seen);
        assert_true(seen.bright > 0 && seen.long_ones > 0 && seen.untraced > 0);
        assert_true(seen.below > 0 || kinds[k] != METAL);
        bench_free(b);
    }
}

/* ---- later passes ---- */

TEST(later_passes_are_replayed)
{
    struct bench *b = bench_new();
    struct seen_of_rays seen = {0};
    glossy_room(b, DIELECTRIC);
    b->plan.planes &= ~BIT(INDIRECT_MEAN);
    b->plan.planes |= BIT(INDIRECT_HALVES) | BIT(PATH_SPREAD) | BIT(PATH_SPLIT) | BIT(GLOSSY_HALF);
    b->plan.target_error = 0.1f;
    b->plan.spp_most = 1024;
    const uint32_t number = plan_pass_count(&b->plan) + 2;
    const struct plan_pass pass = {.number = number, .strata = 4};
    struct field_choice choice = {.kind = PATH_RECORD_INDIRECT, .pass = number, .side = 4};
    bench_trace(b, &pass);
    for (int i = 0; i < AREA; i += 29) add_up_bounces(b, &choice, 4, false, i, &seen);
    choice.kind = PATH_RECORD_GLOSSY;
    for (int i = 0; i < AREA; i += 29) add_up_lobes(b, &choice, 4, i, &seen);
    assert_true(seen.bright > 0);
    bench_free(b);
}

/* Each pixel has rays of its own number. */
TEST(second_sets_are_replayed)
{
    struct bench *b = bench_new();
    struct seen_of_rays seen = {0};
    glossy_room(b, COATED);
    b->plan.planes |= BIT(REFLECTOR_FAR) | BIT(GLOSSY_SPAN);
    b->plan.planes &= ~(BIT(SUB_REFLECTANCE) | BIT(GLOSSY_HALF));
    b->plan.indirect_filter = INDIRECT_FILTER_RATE;
    b->plan.rate = (struct plan_rate){.mu = 1, .rays_most = 1000};
    const uint32_t number = plan_pass_count(&b->plan);
    for (int i = 0; i < AREA; i++) {
        b->sides[i] = (uint8_t)(i % 3 == 0 ? 5 : i % 3 == 1 ? 2 : 0);
        b->lobes[i] = (uint8_t)(i % 2 == 0 ? 3 : 5);
    }
    const struct plan_pass pass = {
        .number = number, .strata = 5, .sides = b->sides, .lobes = b->lobes};
    bench_trace(b, &pass);
    for (int i = 0; i < AREA; i += 17) {
        struct field_choice choice = {
            .kind = PATH_RECORD_INDIRECT, .pass = number, .side = b->sides[i]};
        if (choice.side > 0) add_up_bounces(b, &choice, choice.side, true, i, &seen);
        choice =
            (struct field_choice){.kind = PATH_RECORD_GLOSSY, .pass = number, .side = b->lobes[i]};
        add_up_lobes(b, &choice, choice.side, i, &seen);
    }
    assert_true(seen.bright > 0);
    bench_free(b);
}
