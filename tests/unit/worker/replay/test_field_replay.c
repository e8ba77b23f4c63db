/* A replayed stratum of a light's field is the traced one: all of a pixel's, added up as tiles do,
 * are what the tile's planes hold, bit by bit. And what is no sample of a field is refused with
 * what there is instead. */
#include "tests/unit/unit.h"
#include "tests/unit/worker/trace/field/field_bench.h"

struct seen_of_lights {
    uint32_t blocked, visible, hidden, skipped, below, black, missed;
};

/* The strata of one light in a pixel against its planes. */
static void add_up_light(struct bench *b, uint32_t k, int i, struct seen_of_lights *seen)
{
    const struct field_choice choice = {.kind = PATH_RECORD_LIGHT, .light = k};
    const uint32_t l = b->plan.lights[k].strata_per_axis, planes = plan_light_planes(&b->plan, k);
    float sum = 0, row = 0, least = INFINITY, most = 0;
    for (uint32_t s = 0; s < l * l; s++) {
        const struct path_record *r = replay(b, &choice, i, s);
        const struct path_record_field *f = &r->field;
        const struct path_record_light *ray = &r->vertices[0].light;
        row += f->arrives;
        if (s % l + 1 == l) sum += row, row = 0;
        assert_int_equal(r->kind, PATH_RECORD_LIGHT);
        assert_int_equal(r->last, l * l - 1);
        if (planes >> LIGHT_PLANE_VISIBILITY & 1)
            assert_int_equal(samples_light_visibility(b->samples, k, s >> 3)[i] >> (s & 7) & 1,
                             f->seen);
        if (f->blocked) least = fminf(least, f->slope), most = fmaxf(most, f->slope);
        assert_true(f->arrives == (ray->traced && !ray->blocked ? f->irradiance : 0.0f));
        if (ray->blocked) {
            assert_true(ray->blocked_at < ray->distance && ray->blocker > 0);
            if (f->blocked)
                assert_true(fabsf(ray->blocked_at / (ray->distance / 0.9999f - ray->blocked_at) -
                                  f->slope) < 1e-3f * (1 + f->slope));
        }
        seen->blocked += ray->blocked;
        seen->visible += ray->traced && !ray->blocked;
        seen->hidden += f->hidden;
        seen->skipped += f->drawn && !ray->traced;
        seen->below += f->drawn && ray->skip == LIGHT_BELOW_FACET && !f->seen;
        seen->black += r->vertices[0].hit && !f->drawn && !f->hidden;
        seen->missed += !r->vertices[0].hit;
    }
    if (planes >> LIGHT_PLANE_IRRADIANCE & 1) {
        const float held = samples_light_irradiance(b->samples, k)[i];
        if (held != sum * (1.0f / (float)(l * l)))
            fail_msg("light %u of pixel %d: the plane has %.9g, strata add up to %.9g", k, i,
                     (double)held, (double)(sum / (float)(l * l)));
        assert_true(b->held.irradiance == held);
    }
    if (!(planes >> LIGHT_PLANE_SLOPES & 1)) return;
    expect_half(samples_light_slope(b->samples, k, 0)[i], least < INFINITY ? least : 0, "slope", i);
    expect_half(samples_light_slope(b->samples, k, 1)[i], most, "slope", i);
}

TEST(strata_add_up_to_planes)
{
    for (uint32_t slopes = 0; slopes < 2; slopes++) {
        struct bench *b = bench_new();
        struct seen_of_lights seen = {0};
        lit_room(b);
        if (!slopes) b->plan.light_planes &= ~(1u << LIGHT_PLANE_SLOPES);
        const struct plan_pass pass = plan_scheduled_pass(&b->plan, 0);
        bench_trace(b, &pass);
        for (int i = 0; i < 12 * 12; i += 7)
            for (uint32_t k = 0; k < b->plan.light_count; k++) add_up_light(b, k, i, &seen);
        /* The scene has all of it. */
        assert_true(seen.blocked > 20 && seen.visible > 100 && seen.hidden > 0);
        assert_true(seen.skipped > 0 && seen.below > 0 && seen.black > 0 && seen.missed > 0);
        bench_free(b);
    }
}

/* ---- refusals ---- */

static void refuse(struct bench *b, struct field_choice choice, int32_t x, uint32_t sample,
                   int code, const char *words)
{
    struct fault fault = {0};
    assert_int_equal(
        field_replay(b->scene, NULL, &b->plan, &choice, x, 0, sample, b->record, &b->held, &fault),
        code);
    if (!strstr(fault.detail, words)) fail_msg("\"%s\" has no \"%s\"", fault.detail, words);
}

TEST(says_what_there_is_instead)
{
    struct bench *b = bench_new();
    lit_room(b);
    fixture_bounces(&b->plan, 3);
    const struct plan_pass pass = plan_scheduled_pass(&b->plan, 0);
    bench_trace(b, &pass);
    struct field_choice light = {.kind = PATH_RECORD_LIGHT}, rays = {.kind = PATH_RECORD_INDIRECT},
                        glossy = {.kind = PATH_RECORD_GLOSSY};
    refuse(b, light, 12, 0, ERR_RANGE, "12,0 is outside the image of 12x12");
    refuse(b, light, 0, 9, ERR_RANGE, "samples 0 to 8 (3 x 3)");
    refuse(b, rays, 0, 9, ERR_RANGE, "samples 0 to 8 (3 x 3)");
    light.light = 4;
    refuse(b, light, 0, 1, ERR_RANGE, "the light has no area");
    refuse(b, glossy, 0, 0, ERR_UNSUPPORTED, "indirect (samples 0 to 8)");
    rays.side = 3;
    refuse(b, rays, 0, 0, ERR_MISSING, "goes with --pass");
    rays.pass = 1;
    refuse(b, rays, 0, 0, ERR_RANGE, "rays are all of pass 0");
    light.pass = 1;
    refuse(b, light, 0, 0, ERR_RANGE, "of pass 0 alone");
    b->plan.indirect_filter = INDIRECT_FILTER_RATE;
    b->plan.rate = (struct plan_rate){.mu = 1, .rays_most = 100};
    refuse(b, (struct field_choice){.kind = PATH_RECORD_GLOSSY, .pass = 1, .side = 2}, 0, 0,
           ERR_RANGE, "no rays of glossy lobes");
    refuse(b, (struct field_choice){.kind = PATH_RECORD_INDIRECT, .pass = 1}, 0, 0, ERR_MISSING,
           "--side L");
    refuse(b, (struct field_choice){.kind = PATH_RECORD_INDIRECT, .pass = 1, .side = 10}, 0, 0,
           ERR_RANGE, "cannot have a pass 1 of 10 x 10");
    b->plan.light_planes = 0;
    light.pass = 0;
    refuse(b, light, 0, 0, ERR_UNSUPPORTED, "no field of light 4");
    b->plan.paths.spp = 1;
    refuse(b, light, 0, 0, ERR_UNSUPPORTED, "paths bring that light");
    b->plan.environment.kind = ENVIRONMENT_MAP;
    rays.pass = rays.side = 0;
    refuse(b, rays, 0, 0, ERR_MISSING, "has a map");
    bench_free(b);
}

TEST(reads_names)
{
    struct bench *b = bench_new();
    lit_room(b);
    fixture_bounces(&b->plan, 3);
    const struct scene *scene = fixture_scene(b->f);
    struct field_choice c = {0};
    struct fault fault = {0};
    assert_int_equal(field_choice_read("light:5", &b->plan, scene, &c, &fault), 0);
    assert_int_equal(c.kind, PATH_RECORD_LIGHT);
    assert_int_equal(c.light, 5);
    assert_int_equal(field_choice_read("indirect", &b->plan, scene, &c, &fault), 0);
    assert_int_equal(c.kind, PATH_RECORD_INDIRECT);
    assert_int_equal(field_choice_side(&b->plan, &c), 3);
    assert_int_equal(field_choice_read("glossy", &b->plan, scene, &c, &fault), 0);
    assert_int_equal(c.kind, PATH_RECORD_GLOSSY);
    static const char *const wrong[] = {"",         "light",     "light:",  "light:7",
                                        "light:-1", "indirect ", "light:x", "light:99999999999"};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        memset(&fault, 0, sizeof fault);
        assert_int_not_equal(field_choice_read(wrong[k], &b->plan, scene, &c, &fault), 0);
        assert_non_null(strstr(fault.detail, "light:1 (samples 0 to 48)"));
    }
    while (b->plan.light_count < LIMIT_LIGHTS) fixture_light(&b->plan, LIGHT_POINT, 1);
    char list[FIELD_CHOICE_TEXT];
    assert_non_null(strstr(field_choice_list(&b->plan, scene, list), ", ..."));
    bench_free(b);
}
