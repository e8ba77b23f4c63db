/* What is said of a job's frames, and what is kept: a frame with files is finished once the store
 * has it on record. */
#include <stdlib.h>

#include "server/job/jobs_table.h"

void active_frame_release_pictures(const struct jobs *jobs, const struct digest *exr,
                                   const struct digest *png)
{
    objects_release(jobs->options.objects, exr);
    objects_release(jobs->options.objects, png);
}

int32_t active_frame_number(const struct active_job *job, const struct active_frame *frame)
{
    return job_frame_number(&job->prepared->job, (uint32_t)(frame - job->frames));
}

void active_frame_tell(const struct active_job *job, const struct active_frame *frame)
{
    jobs_event((struct active_job *)job, "frame",
               active_job_frame_json(job->id, active_frame_number(job, frame), frame->state),
               false);
}

/* A commit of one frame is on its way. */
struct recording {
    struct active_job *job;
    unsigned run; /* of the job: another one has other frames */
    struct active_frame *frame;
    struct digest exr, png; /* held until they are on record, or never will be */
};

static void on_recorded(void *ctx, int error)
{
    struct recording *recording = ctx;
    struct active_job *job = recording->job;
    struct active_frame *frame = recording->frame;
    const bool is_past = recording->run != job->runs;
    const bool is_over =
        job->gone || job->jobs->stopping || job_state_is_final(job->state) || is_past;
    if (is_over || !error)
        active_frame_release_pictures(job->jobs, &recording->exr, &recording->png);
    free(recording);
    job->holds--;
    if (job->gone) {
        active_job_release(job);
        return;
    }
    if (is_over) return;
    if (error) {
        active_job_retry_record(job, frame);
        return;
    }
    job->pauses = job->tries = 0;
    frame_state_go(&frame->state, FRAME_FINISHED);
    job->frames_opened--;
    job->frames_finished++;
    job->revision++;
    active_job_forget_spools(job, frame);
    active_frame_tell(job, frame);
    if (job->frames_finished == job->frame_count)
        active_job_finish(job);
    else
        jobs_progress_soon(job->jobs, job);
    jobs_advance_soon(job->jobs);
}

/* Records a frame with its cost, which would be lost if the coordinator were killed before the job
 * ends. */
void active_job_record_frame(struct active_job *job, struct active_frame *frame)
{
    struct recording *recording = malloc(sizeof *recording);
    char *report = recording ? active_job_kept_report(job) : NULL;
    if (!report) {
        free(recording);
        active_job_retry_record(job, frame);
        return;
    }
    *recording = (struct recording){
        .job = job, .run = job->runs, .frame = frame, .exr = frame->exr, .png = frame->png};
    struct frame_row row = {.number = active_frame_number(job, frame),
                            .state = frame_state_name(FRAME_FINISHED),
                            .exr = frame->exr,
                            .png = frame->png};
    job->holds++;
    job_store_update_frame(job->jobs->options.store, job->id, &row, report, on_recorded, recording);
    free(report);
}
