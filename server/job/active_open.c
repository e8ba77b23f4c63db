/* A job's frames go into work: which is next, and with what. */
#include <assert.h>
#include <string.h>

#include "proto/runtime/build.h"
#include "server/job/frame/picture_file.h"
#include "server/job/jobs_table.h"
#include "server/job/live_view.h"
#include "server/reconstruct/oidn/oidn_library.h"

bool active_job_has_unopened(const struct active_job *job)
{
    return job->state == JOB_RUNNING &&
           (job->frames_opened + job->frames_finished < job->frame_count || job->recalls > 0);
}

static struct active_frame *first_unopened(const struct active_job *job)
{
    struct active_frame *frame = job->frames;
    while (frame->state != FRAME_QUEUED && !(frame->recalled && !frame->work)) frame++;
    return frame;
}

bool active_job_may_open(const struct active_job *job)
{
    if (!active_job_has_unopened(job)) return false;
    const struct active_frame *frame = first_unopened(job);
    return active_frame_is_prepared(job, frame) && active_job_is_in_reach(job, frame);
}

static int start_work(struct active_job *job, struct active_frame *frame, struct fault *fault)
{
    struct jobs *jobs = job->jobs;
    const struct job *document = &job->prepared->job;
    struct plan plan = *active_frame_plan(job, frame);
    const uint32_t l = job_strata_per_axis(document->spp), u = plan.lens_strata_per_axis;
    plan.pattern.frame = (uint32_t)active_frame_number(job, frame);
    struct frame_options options = {
        .id = ++jobs->next_frame_id,
        .number = active_frame_number(job, frame),
        .layers = document->layers,
        .metadata = {.job = job->fingerprint,
                     .build = build_id(),
                     .seed = document->seed,
                     .spp = plan.paths.spp > 0 ? plan.paths.spp
                            : u > 0            ? u * u
                                               : l * l,
                     .frame = active_frame_number(job, frame),
                     .fps = job_frame_count(document) > 1 ? document->fps : 0,
                     .camera = plan.camera,
                     .has_camera = true,
                     .half = document->pixel_type == PIXEL_HALF,
                     .mattes = (frame->prepared ? frame->prepared : job->prepared)->mattes,
                     .codec = document->exr_compression},
        .png = picture_png_options(document),
        .plan = &plan,
        .motion = active_frame_motion(job, frame),
        .plate = active_frame_plate(job, frame),
        .adds = document->composite.mode == COMPOSITE_ADD,
        .pool = jobs->options.pool,
        .scratch = jobs->scratch,
        .objects = jobs->options.objects,
        .spools = job->view ? NULL : jobs->options.spools, /* views come and go */
        .unwatched = jobs->options.unwatched,
        .kept = job->view != NULL,
        .counted = frame->shelved ? frame->shelved->passes : NULL,
        .recalled = frame->recalled,
        .events = active_job_frame_events(jobs),
    };
    memcpy(options.job, job->id, sizeof options.job);
    /* The job may come from a run that had the library. */
    if (plan.residual_filter == RESIDUAL_FILTER_OIDN && !oidn_library_get(fault))
        return fault->code;
    const int error = frame_create(&options, &frame->work);
    return error ? fault_set(fault, error, "/image", "no memory for frame %d", options.number) : 0;
}

static void note_opened(struct active_job *job, struct active_frame *frame)
{
    const int number = active_frame_number(job, frame);
    if (frame->recalled) {
        job->recalls--;
        active_job_log(job, "frame", "frame %d is taken up for the frames beside it", number);
        return;
    }
    frame_state_go(&frame->state, FRAME_RENDERING);
    job->frames_opened++;
    active_job_log(job, "frame", "frame %d is begun", number);
}

void active_job_open_frame(struct active_job *job)
{
    struct jobs *jobs = job->jobs;
    assert(active_job_may_open(job));
    struct active_frame *frame = first_unopened(job);
    frame->is_alone = active_frame_plan(job, frame)->temporal == 0;
    if (frame->recalled && frame->is_alone) {
        job->recalls--;
        frame->recalled = false;
        prepared_destroy(&frame->prepared);
        active_job_draw_windows(job, frame);
        active_job_prepare_ahead(job);
        jobs_advance_soon(jobs);
        return;
    }
    struct fault fault;
    if (start_work(job, frame, &fault) != 0) {
        active_job_fail_or_retry(job, &fault);
        return;
    }
    /* The priority is given in pixels of the full picture. */
    if (!job->view || live_view_scale(job) == 1) frame_steer(frame->work, &job->tile_priority);
    jobs_table_open(jobs, job, frame);
    note_opened(job, frame);
    if (job->pace.started_us == 0) active_job_pace_start(job);
    if (!job->shown && !job->view && !frame->recalled) active_job_show(job, frame);
    job->revision++;
    active_frame_tell(job, frame);
    if (frame->is_alone) active_job_draw_windows(job, frame);
    if (jobs->fleet) fleet_wake(jobs->fleet);
    active_job_prepare_ahead(job);
}
