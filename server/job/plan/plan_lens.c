/* Plans the lens's light field: l x l paths a pixel, one through each stratum of the lens, and the
 * filter that makes a picture of them. */
#include <inttypes.h>
#include <stdio.h>

#include "proto/link/message.h"
#include "proto/samples.h"
#include "server/job/plan/plan_parts.h"

#define LAYERS_PER_STRATUM (LAYER_VISIBILITY | LAYER_SLOPE_MIN | LAYER_SLOPE_MAX)

/* Layers that lens samples give, or that pixel centres beside them give as through a pinhole. */
#define LAYERS_OF_LENS                                                                             \
    (LAYER_BEAUTY | LAYER_SAMPLES | LAYER_FILTER_WIDTH | LAYER_DEPTH | LAYER_NORMAL | LAYER_ID |   \
     LAYERS_PER_STRATUM | LAYERS_MOTION | LAYERS_CRYPTO)

static uint32_t strata_of(const struct job *job)
{
    return job_strata_per_axis(job->lens_spp ? job->lens_spp : job->spp);
}

uint64_t plan_lens_bytes(const struct job *job, bool surfaces)
{
    const uint64_t l = strata_of(job), seen = 3 * sizeof(float) + sizeof(uint16_t);
    const uint64_t met = surfaces ? 2 * sizeof(uint16_t) + 2 * sizeof(uint32_t) : 0;
    const uint64_t more = job->lens_extra > 0 ? 4 * sizeof(float) : 0;
    return l * l * (seen + met) + sizeof(uint16_t) + more;
}

static const char *first_other_layer(const struct job *job)
{
    const uint32_t others = job->layers & ~(uint32_t)LAYERS_OF_LENS;
    return others ? layer_name((enum layer)(others & -others)) : NULL;
}

bool plan_lens_possible(const struct job *job, const struct plan *plan, char why[PLAN_WHY_BYTES])
{
    const uint32_t l = strata_of(job), most = LIMIT_PLANE_STRATA_PER_AXIS;
    const uint64_t pixels = (uint64_t)plan->width_px * (uint64_t)plan->height_px;
    const char *layer = first_other_layer(job);
    if (layer)
        snprintf(why, PLAN_WHY_BYTES, "with a lens only paths give the layer %s", layer);
    else if (job->target_error > 0.0f)
        snprintf(why, PLAN_WHY_BYTES, "sampling.target_error needs samples of known error");
    else if (job->residual == RESIDUAL_OIDN)
        snprintf(why, PLAN_WHY_BYTES, "filter.residual is oidn, which filters whole pixels");
    else if (l > most)
        snprintf(why, PLAN_WHY_BYTES, "%u lens samples are more than the %u that travel one by one",
                 l * l, most * most);
    else if (plan_lens_bytes(job, false) * pixels > LIMIT_LENS_BYTES)
        snprintf(why, PLAN_WHY_BYTES,
                 "%" PRIu64 " pixels of %" PRIu64 " bytes of lens samples are above %llu in all",
                 pixels, plan_lens_bytes(job, false), LIMIT_LENS_BYTES);
    else
        return true;
    return false;
}

const char *plan_lens_filter_name(uint32_t filter)
{
    return filter ? lens_method_name(LENS_AVERAGE + filter) : "none";
}

/* Reports that the filter which was asked for does not run. */
static void tell_none(const struct job *job, struct plan_report *report)
{
    plan_skip(report, "filter of the lens", "%.*s", (int)PLAN_WHY_BYTES - 1,
              report->lens_filter_why);
    if (job->lens == LENS_AXIS_ALIGNED || job->lens == LENS_SHEARED)
        plan_warn(report, "filter.lens is %s, but no lens samples are filtered: %s",
                  lens_method_name(job->lens), report->lens_filter_why);
}

void plan_lens_none(const struct job *job, const char *why, struct plan_report *report)
{
    snprintf(report->lens_filter_why, sizeof report->lens_filter_why, "%s", why);
    tell_none(job, report);
    if (job->lens_spp)
        plan_skip(report, "sampling.lens_spp", "%.*s", (int)PLAN_WHY_BYTES - 1,
                  report->lens_filter_why);
    if (job->lens_extra)
        plan_skip(report, "sampling.lens_extra", "%.*s", (int)PLAN_WHY_BYTES - 1,
                  report->lens_filter_why);
}

uint32_t plan_choose_lens_filter(const struct job *job, char why[PLAN_FILTER_WHY_BYTES])
{
    const size_t n = PLAN_FILTER_WHY_BYTES;
    const bool average = job->lens == LENS_AVERAGE;
    if (average || (job->lens == LENS_AUTO && job->method == FILTER_AVERAGE)) {
        snprintf(why, n, "filter.%s is average", average ? "lens" : "method");
        return LENS_FILTER_NONE;
    }
    if (job->lens != LENS_AUTO) {
        snprintf(why, n, "filter.lens asks for it");
        return job->lens - LENS_AVERAGE;
    }
    if (job->method != FILTER_AUTO) {
        snprintf(why, n, "filter.method asks for it");
        return job->method == FILTER_SHEARED ? LENS_FILTER_SHEARED : LENS_FILTER_AXIS_ALIGNED;
    }
    snprintf(why, n, "filtering along the slopes of what is out of focus needs the fewest samples");
    return LENS_FILTER_SHEARED;
}

/* Plans pixel centres, for the layers that show them. Layers of lights' strata tell by the depth
 * whether there is a surface. */
static void plan_centres(struct plan *plan, struct plan_report *report)
{
    static const struct {
        const char *name;
        uint64_t plane;
        uint32_t layers;
    } readers[] = {
        {"plane depth", PLANE_BIT(DEPTH),
         LAYER_DEPTH | LAYER_NORMAL | LAYERS_PER_STRATUM | LAYERS_MOTION},
        {"plane normal", PLANE_BIT(NORMAL), LAYER_NORMAL},
        {"plane id", PLANE_BIT(ID), LAYER_ID | LAYERS_MOTION},
    };
    for (unsigned i = 0; i < sizeof readers / sizeof readers[0]; i++) {
        if (plan->planes & readers[i].plane) continue;
        if (report->layers & readers[i].layers)
            plan->planes |= readers[i].plane;
        else
            plan_skip(report, readers[i].name, "no layer of this plan reads it");
    }
}

/* Plans second sets, which go to pixels by the errors that their samples' differences tell. */
static void plan_extra(const struct job *job, struct plan *plan, struct plan_report *report)
{
    if (job->lens_extra == 0) return;
    if (plan->lens_filter != LENS_FILTER_SHEARED) {
        plan_skip(report, "sampling.lens_extra", "only the sheared filter mixes second sets in");
    } else if (plan->lens_strata_per_axis < 2) {
        plan_skip(report, "sampling.lens_extra",
                  "one sample per pixel cannot tell which pixels need more");
    } else if (!(report->layers & LAYER_BEAUTY)) {
        plan_skip(report, "sampling.lens_extra", "no layer of this plan shows the picture");
    } else {
        plan->lens_extra = job->lens_extra;
        plan->planes |= PLANE_BIT(LENS_SECOND_SET);
        plan->capabilities |= CAPABILITY_STRATA_MAPS;
    }
}

void plan_lens_one_set(const char *why, struct plan *plan, struct plan_report *report)
{
    plan->lens_extra = 0;
    plan->planes &= ~PLANE_BIT(LENS_SECOND_SET);
    plan->capabilities &= ~(uint32_t)CAPABILITY_STRATA_MAPS;
    plan_skip(report, "sampling.lens_extra", "%s", why);
    plan_warn(report, "sampling.lens_extra is left out: %s", why);
}

/* Second sets go by the samples' own differences, which the filter would take away. */
bool plan_lens_paths_possible(const struct job *job)
{
    char unused[PLAN_FILTER_WHY_BYTES];
    const bool asked = job->residual == RESIDUAL_HALVES ||
                       (job->residual == RESIDUAL_AUTO && job->method != FILTER_AVERAGE);
    return asked && job->lens_extra == 0 && strata_of(job) > 1 &&
           plan_choose_lens_filter(job, unused) == LENS_FILTER_SHEARED;
}

/* Plans that lens samples without light of fields are paths, too, which the residual filter cleans.
 */
static void plan_paths_of_lens(const struct job *job, struct plan *plan, struct plan_report *report)
{
    const uint32_t samples = plan->lens_strata_per_axis * plan->lens_strata_per_axis;
    if (plan->lens_relight != LENS_RELIGHT_OWN || !plan_lens_paths_possible(job)) return;
    plan->paths.spp = samples;
    plan_residual(job, plan, report);
    if (plan->residual_filter == RESIDUAL_FILTER_NONE) plan->paths.spp = 0;
}

void plan_lens(const struct job *job, struct plan *plan, struct plan_report *report)
{
    plan->lens_strata_per_axis = strata_of(job);
    plan->lens_filter = plan_choose_lens_filter(job, report->lens_filter_why);
    plan->paths.pixel_filter = job->pixel_filter;
    plan->planes |= PLANE_BIT(LENS_RADIANCE);
    plan->capabilities |= CAPABILITY_PATHS;
    if (plan->lens_filter == LENS_FILTER_NONE) {
        tell_none(job, report);
        plan_skip(report, "plane lens_slope", "no filter of this plan reads it");
    } else {
        plan->planes |= PLANE_BIT(LENS_SLOPE);
    }
    if (report->layers & LAYER_BEAUTY)
        plan->planes |= PLANE_BIT(LENS_COVERAGE);
    else
        plan_skip(report, "plane lens_coverage", "no layer of this plan reads it");
    plan_extra(job, plan, report);
    plan_paths_of_lens(job, plan, report);
    plan_centres(plan, report);
    plan_path_effects(plan, report);
}
