/* Which filter cleans which light: by kind of light and kind of lobe that sends it on. */
#include "proto/samples.h"
#include "server/job/plan/plan_parts.h"

enum lit_by { LIT_RECTANGLE, LIT_POINT, LIT_EMITTER, LIT_ENVIRONMENT, LIT_INDIRECT, LIT_COUNT };

static const char *const lit_names[LIT_COUNT] = {"rectangle", "point", "emitter", "environment",
                                                 "indirect"};

/* Lights without area are points here. */
static bool has_light(const struct plan *plan, const struct plan_report *report, enum lit_by kind)
{
    bool points = false;
    for (uint32_t k = 0; k < plan->light_count; k++)
        points |= plan->lights[k].type != LIGHT_RECTANGLE;
    switch (kind) {
    case LIT_RECTANGLE:
        return plan_has_rectangle(plan);
    case LIT_POINT:
        return points;
    case LIT_EMITTER:
        return report->emitters.flux > 0;
    case LIT_ENVIRONMENT:
        return plan->environment.kind != ENVIRONMENT_NONE;
    default:
        return plan->bounces > 0;
    }
}

/* Returns whether fields of pixel centres bring the light that such lobes send on. */
static bool is_field(const struct plan *plan, const struct plan_report *report, enum lit_by kind,
                     bool diffuse)
{
    if (kind == LIT_INDIRECT || (kind == LIT_ENVIRONMENT && plan_sky_in_fields(plan)))
        return plan->planes & (diffuse ? PLANES_BOUNCE_LIGHT : PLANE_BIT(GLOSSY_MEAN));
    return diffuse && kind <= LIT_POINT &&
           (report->integrator == INTEGRATOR_LIGHT_FIELD || report->by_lobe);
}

static const char *field_filter(const struct plan *plan, const struct plan_report *report,
                                enum lit_by kind, bool diffuse)
{
    if (kind == LIT_RECTANGLE) return filter_method_name(report->method);
    if (kind == LIT_POINT) return "none";
    return diffuse ? plan_indirect_filter_name(plan->indirect_filter)
                   : plan_glossy_filter_name(plan->glossy_filter);
}

static json_t *row_of(const struct plan *plan, const struct plan_report *report, enum lit_by kind,
                      bool diffuse)
{
    const bool lens = report->integrator == INTEGRATOR_LENS_FIELD;
    const bool field = !lens && is_field(plan, report, kind, diffuse);
    const bool cleaned = plan->residual_filter != RESIDUAL_FILTER_NONE;
    const char *filter = lens && !cleaned ? plan_lens_filter_name(plan->lens_filter)
                         : field          ? field_filter(plan, report, kind, diffuse)
                                          : plan_residual_filter_name(plan->residual_filter);
    return json_pack("{s:s,s:s,s:s,s:s}", "light", lit_names[kind], "lobes",
                     diffuse ? "diffuse" : "other", "by",
                     lens    ? "lens"
                     : field ? "light_field"
                             : "paths",
                     "filter", filter);
}

json_t *plan_light_filters(const struct plan *plan, const struct plan_report *report)
{
    const bool others = report->integrator != INTEGRATOR_LIGHT_FIELD;
    json_t *list = json_array();
    for (int kind = 0; kind < LIT_COUNT; kind++) {
        if (!has_light(plan, report, (enum lit_by)kind)) continue;
        json_array_append_new(list, row_of(plan, report, (enum lit_by)kind, true));
        if (others) json_array_append_new(list, row_of(plan, report, (enum lit_by)kind, false));
    }
    return list;
}
