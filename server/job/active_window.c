/* Frames that are drawn with samples of the frames beside them. A frame waits, traced, until those
 * of its window are traced, too; their histories stay until the last frame that reads them is being
 * drawn. A coordinator that was killed, or a frame that was shelved, may lack histories of frames
 * that are drawn already: these are recalled, from their spools or traced again, and give the same
 * samples as before. */
#include "server/job/jobs_table.h"

uint32_t active_job_reach(const struct active_job *job)
{
    const struct prepared *p = job->prepared;
    if (!p) return 0;
    if (!p->moves) return p->plan.temporal;
    return job_may_be_temporal(&p->job) ? LIMIT_TEMPORAL_FRAMES : 0;
}

/* Returns the frame that many numbers away; NULL: the job has none. */
static struct active_frame *beside(const struct active_job *job, const struct active_frame *frame,
                                   int32_t steps)
{
    uint32_t index;
    const int32_t number = active_frame_number(job, frame) + steps;
    return job_frame_find(&job->prepared->job, number, &index) ? &job->frames[index] : NULL;
}

/* Returns whether it reads no histories any more: those of its window are held by its work. */
static bool has_its_window(const struct active_frame *frame)
{
    if (frame->is_alone || frame->state == FRAME_FINISHED || frame->state == FRAME_ENCODING)
        return true;
    return frame->work && frame_has_window(frame->work);
}

static struct residual_history *history_of(const struct active_frame *frame)
{
    return frame->history ? frame->history : frame->work ? frame_history(frame->work) : NULL;
}

/* Returns whether some frame in reach is yet to get its window. */
static bool is_needed(const struct active_job *job, const struct active_frame *frame)
{
    const int32_t reach = (int32_t)active_job_reach(job);
    for (int32_t steps = -reach; steps <= reach; steps++) {
        const struct active_frame *other = steps != 0 ? beside(job, frame, steps) : NULL;
        if (other && !has_its_window(other)) return true;
    }
    return false;
}

/* Paths that leave out other light have other sums. */
static bool fits(const struct plan *a, const struct plan *b)
{
    return a->width_px == b->width_px && a->height_px == b->height_px && a->planes == b->planes &&
           a->paths.without_diffuse_direct == b->paths.without_diffuse_direct &&
           a->paths.without_diffuse_indirect == b->paths.without_diffuse_indirect &&
           a->paths.without_glossy_indirect == b->paths.without_glossy_indirect;
}

/* Adds a side of a frame's window, up to the first frame that is not there or has no samples of the
 * same kind. Returns false while that is not known. */
static bool find_side(const struct active_job *job, const struct active_frame *frame,
                      enum motion_side side, struct frame_window *window)
{
    const struct plan *plan = active_frame_plan(job, frame);
    for (int32_t k = 1; k <= (int32_t)plan->temporal; k++) {
        const struct active_frame *other = beside(job, frame, side == MOTION_BACKWARD ? -k : k);
        if (!other || other->is_alone) return true;
        struct residual_history *history = history_of(other);
        if (!history) return false;
        if (!fits(plan, &history->plan)) return true;
        window->frames[side][window->count[side]++] = history;
    }
    return true;
}

static void draw_window(const struct active_job *job, const struct active_frame *frame)
{
    struct frame_window window = {.count = {0}};
    if (!frame->work || frame->recalled || !frame_history(frame->work) ||
        !frame_is_waiting(frame->work))
        return;
    if (find_side(job, frame, MOTION_BACKWARD, &window) &&
        find_side(job, frame, MOTION_FORWARD, &window))
        frame_draw(frame->work, &window);
}

static void let_go(const struct active_job *job, struct active_frame *frame)
{
    if (frame->history && !is_needed(job, frame)) residual_history_drop(&frame->history);
}

/* What a frame's window has become may free what is twice as far away. */
static void let_all_go(const struct active_job *job, const struct active_frame *frame)
{
    const int32_t reach = 2 * (int32_t)active_job_reach(job);
    for (int32_t steps = -reach; steps <= reach; steps++) {
        struct active_frame *other = beside(job, frame, steps);
        if (other) let_go(job, other);
    }
}

void active_job_draw_windows(struct active_job *job, const struct active_frame *frame)
{
    const int32_t reach = (int32_t)active_job_reach(job);
    for (int32_t steps = -reach; steps <= reach && job->frames; steps++) {
        const struct active_frame *other = beside(job, frame, steps);
        if (other) draw_window(job, other);
    }
    if (job->frames) let_all_go(job, frame);
}

void active_job_keep_history(struct active_job *job, struct active_frame *frame)
{
    if (frame->work && !frame->history && is_needed(job, frame))
        frame->history = residual_history_hold(frame_history(frame->work));
    let_all_go(job, frame);
}

void active_job_recall(struct active_job *job)
{
    if (active_job_reach(job) == 0) return;
    for (uint32_t i = 0; i < job->frame_count; i++) {
        struct active_frame *frame = &job->frames[i];
        const bool is_drawn = frame->state == FRAME_FINISHED || frame->state == FRAME_ENCODING;
        if (!is_drawn || frame->work || frame->history || frame->recalled || frame->is_alone ||
            !is_needed(job, frame))
            continue;
        frame->recalled = true;
        job->recalls++;
    }
}

void active_job_forget_spools(struct active_job *job, const struct active_frame *frame)
{
    const int32_t reach = (int32_t)active_job_reach(job);
    if (!job->jobs->options.spools) return;
    for (int32_t steps = -reach; steps <= reach; steps++) {
        const struct active_frame *other = beside(job, frame, steps);
        bool ended = other != NULL;
        for (int32_t k = -reach; k <= reach && ended; k++) {
            const struct active_frame *reader = beside(job, other, k);
            ended = !reader || reader->state == FRAME_FINISHED;
        }
        if (ended)
            spools_remove(job->jobs->options.spools, job->id, active_frame_number(job, other));
    }
}

/* Frames that wait are no more than the first of them needs, and one. */
bool active_job_is_in_reach(const struct active_job *job, const struct active_frame *frame)
{
    const uint32_t reach = active_job_reach(job);
    if (reach == 0) return true;
    uint32_t first = 0;
    while (first < job->frame_count && has_its_window(&job->frames[first])) first++;
    return (uint32_t)(frame - job->frames) <= first + reach + 1;
}
