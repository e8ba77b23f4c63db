/* The scenes of a moving job's frames: each frame has its own, prepared before it is opened. */
#include "server/job/jobs_table.h"
#include "server/job/live_view.h"

/* Frames whose scenes wait for their turn: importing goes on while others are traced. */
#define SCENES_AHEAD 2u

/* Returns whether a frame shows the scene that the job was planned with. */
static bool has_first_scene(const struct active_job *job, const struct active_frame *frame)
{
    return !job->prepared->moves || frame == job->frames;
}

bool active_frame_is_prepared(const struct active_job *job, const struct active_frame *frame)
{
    return frame->prepared || has_first_scene(job, frame);
}

const struct plan *active_frame_plan(const struct active_job *job, const struct active_frame *frame)
{
    if (job->view) return live_view_plan(job);
    return frame->prepared ? &frame->prepared->plan : &job->prepared->plan;
}

struct motion *active_frame_motion(const struct active_job *job, const struct active_frame *frame)
{
    return frame->prepared ? frame->prepared->motion : job->prepared->motion;
}

struct plate *active_frame_plate(const struct active_job *job, const struct active_frame *frame)
{
    if (job->view) return live_view_plate(job);
    struct plate *own = frame->prepared ? frame->prepared->plate : NULL;
    return own ? own : job->prepared->plate;
}

const struct digest *active_frame_base(const struct active_job *job,
                                       const struct active_frame *frame)
{
    const struct prepared *prepared = frame->prepared ? frame->prepared : job->prepared;
    return prepared->base ? shared_base_digest(prepared->base) : NULL;
}

/* Returns the frame that is prepared next; NULL: enough frames are. */
static struct active_frame *next_to_prepare(const struct active_job *job)
{
    unsigned ahead = 0;
    for (uint32_t i = 0; i < job->frame_count && ahead < SCENES_AHEAD; i++) {
        struct active_frame *frame = &job->frames[i];
        if (frame->work || (frame->state != FRAME_QUEUED && !frame->recalled)) continue;
        if (!active_frame_is_prepared(job, frame)) return frame;
        ahead++;
    }
    return NULL;
}

static void on_prepared(void *ctx, const struct fault *fault, struct prepared *prepared)
{
    struct active_job *job = ctx;
    job->preparation = NULL;
    if (fault) {
        active_job_fail_or_retry(job, fault);
        jobs_advance_soon(job->jobs);
        return;
    }
    job->statistics.import_cpu_us += prepared->import_cpu_us;
    job->jobs->past.import_cpu_us += prepared->import_cpu_us;
    uint32_t index;
    if (job_frame_find(&job->prepared->job, prepared->number, &index) &&
        !job->frames[index].prepared)
        job->frames[index].prepared = prepared;
    else
        prepared_destroy(&prepared);
    active_job_prepare_ahead(job);
    jobs_advance_soon(job->jobs);
}

void active_job_prepare_ahead(struct active_job *job)
{
    struct jobs *jobs = job->jobs;
    if (job->state != JOB_RUNNING || !job->prepared->moves || job->preparation) return;
    const struct active_frame *frame = next_to_prepare(job);
    struct job document;
    if (!frame) return;
    int error = job_copy(&job->prepared->job, &document);
    if (!error)
        error = preparation_start(jobs->imports, jobs->options.pool, jobs->options.objects,
                                  &document, active_frame_number(job, frame), job->prepared->base,
                                  on_prepared, job, &job->preparation);
    if (!error) return;
    struct fault fault;
    fault_set(&fault, error, "", "no memory to import the scene of frame %d",
              active_frame_number(job, frame));
    active_job_fail_or_retry(job, &fault);
}
