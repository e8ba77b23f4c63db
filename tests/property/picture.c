#include "tests/property/picture.h"

#include <stdlib.h>
#include <string.h>

#include "server/job/plan/plan.h"
#include "tests/property/picture_frame.h"
#include "tests/property/stage.h"

static struct picture_facts last;

const struct picture_facts *picture_facts(void)
{
    return &last;
}

static void note(const struct plan *plan, const struct plan_report *report,
                 const struct statistics *statistics)
{
    last = (struct picture_facts){
        .integrator = (int)report->integrator,
        .has_rounds = plan_has_rounds(plan),
        .most_rays = plan->adaptive.rays_max,
        .strata_maps = plan_strata_maps(plan),
        .rounds = (uint32_t)statistics->target_rounds,
        .paths = statistics->target_paths,
        .bounces = statistics->target_bounces,
        .first_rays = statistics->adaptive_first_rays,
        .second_rays = statistics->adaptive_second_rays,
        .lens_paths = statistics->lens_second_paths,
    };
}

struct image *picture_render(const struct property_case *c, const struct change *change,
                             char *refused, size_t refused_bytes)
{
    static struct plan plan;
    static struct plan_report report;
    struct fault fault = {0};
    struct job job;
    struct statistics statistics;
    struct image *image;
    struct stage stage;
    char *text = stage_job(c, change);
    stage_build(c, change, &stage);
    int error = job_read(text, strlen(text), &job, &fault);
    free(text);
    const struct plan_source source = {.scene = stage.scene, .map = stage.map.header};
    if (!error) {
        error = plan_make(&job, &source, 0, &plan, &report, &fault);
        job_fini(&job);
    }
    if (error) {
        snprintf(refused, refused_bytes, "%s: %s", fault.pointer, fault.detail);
        stage_free(&stage);
        return NULL;
    }
    const struct picture_frame_options options = {
        .layers = report.layers, .block_px = c->block, .backwards = change->backwards};
    picture_frame_render(&plan, stage.scene, &stage.map, &options, &image, &statistics);
    note(&plan, &report, &statistics);
    stage_free(&stage);
    return image;
}
