#include "worker/replay/field_replay.h"

#include <stdio.h>
#include <string.h>

#include "proto/half.h"
#include "worker/tile/tile.h"

/* Why the plan has no such field, and who brings its light. */
static const char *reason(const struct plan *plan, const struct field_choice *choice)
{
    const bool paths = plan->paths.spp > 0, lens = plan->lens_strata_per_axis > 0;
    if (choice->kind != PATH_RECORD_LIGHT && plan->bounces == 0)
        return "no light is scattered more than once (indirect_bounces is 0)";
    if (choice->kind == PATH_RECORD_GLOSSY && plan->indirect_strata_per_axis > 0)
        return "no surface has a glossy lobe wide enough for a field, or what lobes send on is "
               "left to paths or lens samples";
    if (paths) return "paths bring that light: ask without --field";
    return lens ? "lens samples bring that light: ask without --field"
                : "nothing of the picture needs it";
}

static int refuse_field(const struct plan *plan, const struct scene *scene,
                        const struct field_choice *choice, struct fault *fault)
{
    char list[FIELD_CHOICE_TEXT], what[32] = "light";
    if (choice->kind == PATH_RECORD_LIGHT)
        snprintf(what, sizeof what, "light %u", choice->light);
    else
        snprintf(what, sizeof what, "%s",
                 choice->kind == PATH_RECORD_GLOSSY ? "glossy" : "indirect");
    return fault_set(fault, ERR_UNSUPPORTED, "--field",
                     "the plan has no field of %s: %s. Fields there are: %s", what,
                     reason(plan, choice), field_choice_list(plan, scene, list));
}

/* Passes after the schedule, which are decided on while a job runs. */
static int check_pass(const struct plan *plan, const struct field_choice *c,
                      const struct plan_pass *pass, struct fault *fault)
{
    const uint32_t scheduled = plan_pass_count(plan);
    if (c->pass == 0 && c->side == 0) return 0;
    if (c->pass == 0)
        return fault_set(fault, ERR_MISSING, "--side",
                         "goes with --pass: pass 0 gives all pixels as many rays");
    if (c->kind == PATH_RECORD_LIGHT)
        return fault_set(fault, ERR_RANGE, "--pass", "strata of lights are of pass 0 alone");
    if (!plan_has_rounds(plan) || plan->lens_extra > 0)
        return fault_set(fault, ERR_RANGE, "--pass",
                         "the plan's rays are all of pass 0: it has neither a target_error nor the "
                         "filter of rates");
    if (c->pass < scheduled)
        return fault_set(fault, ERR_RANGE, "--pass",
                         "pass %u has paths alone: rays are of pass 0, and of those from %u on",
                         c->pass, scheduled);
    if (c->side == 0)
        return fault_set(fault, ERR_MISSING, "--pass",
                         "say how many rays the pixel got in it: --side L of L x L");
    if (c->kind == PATH_RECORD_GLOSSY && pass->sides && !pass->lobes)
        return fault_set(fault, ERR_RANGE, "--pass", "second sets have no rays of glossy lobes");
    if (plan_pass_check(plan, pass) != 0)
        return fault_set(fault, ERR_RANGE, "--side",
                         "the plan cannot have a pass %u of %u x %u rays a pixel", c->pass, c->side,
                         c->side);
    return 0;
}

static int check(const struct render_scene *scene, const struct environment *environment,
                 const struct plan *plan, const struct field_choice *c,
                 const struct plan_pass *pass, const struct path_record *record,
                 struct fault *fault)
{
    const struct plan_light *light = &plan->lights[c->light];
    const bool strata = c->kind == PATH_RECORD_LIGHT;
    int e = check_pass(plan, c, pass, fault);
    if (e) return e;
    if (record->field.side == 0) return refuse_field(plan, scene->blob, c, fault);
    if (record->field.sample > record->last)
        return fault_set(fault, ERR_RANGE, "sample",
                         "%u: the field has samples 0 to %u (%u x %u%s)", record->field.sample,
                         record->last, record->field.side, record->field.side,
                         strata && light->type != LIGHT_RECTANGLE ? ": the light has no area" : "");
    if (plan->environment.kind == ENVIRONMENT_MAP && !environment)
        return fault_set(fault, ERR_MISSING, "environment", "the plan has a map");
    return 0;
}

/* The pass, of a tile of one pixel: a second set's maps have one side, of which that of the field
 * that nobody asks for is 0. */
static struct plan_pass pass_of(const struct plan *plan, const struct field_choice *c,
                                const uint8_t sides[2])
{
    if (c->pass < plan_pass_count(plan)) return plan_scheduled_pass(plan, c->pass);
    struct plan_pass pass = {.number = c->pass, .strata = c->side};
    const uint32_t maps = plan_side_maps(plan);
    const bool lobes = c->kind == PATH_RECORD_GLOSSY;
    if (maps > 0) pass.sides = &sides[lobes ? 1 : 0];
    if (maps > 1) pass.lobes = &sides[lobes ? 0 : 1];
    return pass;
}

static void unpack(const struct samples *s, enum plane_id plane, uint32_t first, uint32_t count,
                   float scale, float *out)
{
    for (uint32_t k = 0; k < count; k++)
        out[k] = scale * half_to_float(samples_u16(s, plane, first + k)[0]);
}

static void hold_light(const struct samples *s, uint32_t k, struct field_held *out)
{
    out->planes = s->layout.light_planes[k];
    if (out->planes >> LIGHT_PLANE_IRRADIANCE & 1)
        out->irradiance = samples_light_irradiance(s, k)[0];
    for (uint32_t i = 0; out->planes >> LIGHT_PLANE_SLOPES & 1 && i < 2; i++)
        out->slope[i] = half_to_float(samples_light_slope(s, k, i)[0]);
}

static void hold_rays(const struct samples *s, const struct plan *plan,
                      const struct path_record *record, struct field_held *out)
{
    const float scale = 1.0f / plan->radiance_scale; /* a power of two: exact */
    const uint64_t planes = s->layout.planes;
    if (record->kind == PATH_RECORD_GLOSSY && planes >> PLANE_GLOSSY_MEAN & 1) {
        out->mean_count = 4;
        unpack(s, PLANE_GLOSSY_MEAN, 0, 3, scale, out->mean);
        unpack(s, PLANE_GLOSSY_MEAN, 3, 1, 1.0f, out->mean + 3);
    }
    if (record->kind == PATH_RECORD_GLOSSY) return;
    const bool whole = planes >> PLANE_INDIRECT_MEAN & 1;
    out->is_half = !whole && (planes >> PLANE_INDIRECT_HALVES & 1);
    out->mean_count = whole || out->is_half ? 3 : 0;
    if (whole) unpack(s, PLANE_INDIRECT_MEAN, 0, 3, scale, out->mean);
    if (out->is_half)
        unpack(s, PLANE_INDIRECT_HALVES, record->field.half ? 3 : 0, 3, scale, out->mean);
    out->has_slot = planes >> PLANE_INDIRECT_STRATA & 1;
    if (!out->has_slot) return;
    unpack(s, PLANE_INDIRECT_STRATA, 4 * record->field.sample, 3, scale, out->slot);
    unpack(s, PLANE_INDIRECT_STRATA, 4 * record->field.sample + 3, 1, plan->length_unit,
           out->slot + 3);
}

/* The pixel twice: its one sample, and all of them as ever, for what the planes hold. */
static int trace(const struct render_scene *scene, const struct environment *environment,
                 const struct plan *plan, const struct plan_pass *pass, struct rect pixel,
                 struct path_record *record, struct field_held *held)
{
    struct tile_tracer *tracer = NULL;
    struct samples *samples = NULL;
    struct counters counters = {0};
    int e = tile_tracer_create(&tracer);
    if (e) return e;
    tile_tracer_record(tracer, record);
    e = tile_trace_pass(tracer, scene, environment, plan, pass, pixel, NULL, NULL, &samples,
                        &counters);
    samples_destroy(&samples);
    tile_tracer_record(tracer, NULL);
    if (!e)
        e = tile_trace_pass(tracer, scene, environment, plan, pass, pixel, NULL, NULL, &samples,
                            &counters);
    if (!e && record->kind == PATH_RECORD_LIGHT) hold_light(samples, record->field.light, held);
    if (!e && record->kind != PATH_RECORD_LIGHT) hold_rays(samples, plan, record, held);
    samples_destroy(&samples);
    tile_tracer_destroy(&tracer);
    return e;
}

int field_replay(const struct render_scene *scene, const struct environment *environment,
                 const struct plan *plan, const struct field_choice *choice, int32_t x, int32_t y,
                 uint32_t sample, struct path_record *record, struct field_held *held,
                 struct fault *fault)
{
    const uint8_t sides[2] = {(uint8_t)choice->side, 0};
    const struct plan_pass pass = pass_of(plan, choice, sides);
    memset(record, 0, sizeof *record);
    memset(held, 0, sizeof *held);
    record->kind = choice->kind;
    record->field.light = choice->light;
    record->field.sample = sample;
    record->field.pass = choice->pass;
    record->field.side = field_choice_side(plan, choice);
    record->last = record->field.side * record->field.side - 1;
    if (x < 0 || y < 0 || x >= plan->width_px || y >= plan->height_px)
        return fault_set(fault, ERR_RANGE, "pixel", "%d,%d is outside the image of %dx%d", x, y,
                         plan->width_px, plan->height_px);
    int e = check(scene, environment, plan, choice, &pass, record, fault);
    if (e) return e;
    e = trace(scene, environment, plan, &pass, (struct rect){x, y, x + 1, y + 1}, record, held);
    return e ? fault_set(fault, e, "", "%s", error_text(e)) : 0;
}
