/* What is told of a job while it lives. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "proto/json.h"
#include "server/job/jobs_table.h"
#include "server/job/live_view.h"

/* Part of a frame's work that is over once all its tiles have landed; the rest are its files. */
#define TRACED_SHARE  0.97
#define ENCODED_SHARE 0.99 /* stored, but not yet recorded */

#define PACE_SPREAD 1.25 /* times as long, or as short, as at the latest pace */
#define SURE_TIMES  1.5  /* from the least to the most: the middle is told, within a third */
#define SURE_S      0.5  /* or so little that nobody minds */

static double frame_fraction(const struct active_frame *frame)
{
    if (frame->recalled) return 0; /* it is counted already */
    if (!frame->work) return frame->state == FRAME_ENCODING ? ENCODED_SHARE : 0;
    if (frame_is_complete(frame->work)) return ENCODED_SHARE;
    return TRACED_SHARE * frame_traced_share(frame->work);
}

static double job_fraction(const struct active_job *job)
{
    double sum = job->frames_finished;
    if (job->frame_count == 0) return 0;
    if (job->view && live_view_scale(job) > 1) return 0; /* the picture is yet to come */
    for (unsigned i = 0; i < job->jobs->open_count; i++)
        if (job->jobs->open[i].job == job) sum += frame_fraction(job->jobs->open[i].frame);
    return sum / job->frame_count;
}

/* CPU time of workers on all that has landed. */
static double cost_us(const struct active_job *job)
{
    struct statistics statistics;
    active_job_statistics(job, &statistics);
    const uint64_t *value = statistics.counters.value;
    return (double)(value[COUNTER_TRACE_CPU_US] + value[COUNTER_PACK_CPU_US]);
}

void active_job_pace_start(struct active_job *job)
{
    pace_start(&job->pace, jobs_clock_us(), cost_us(job));
}

void active_job_pace_note(struct active_job *job)
{
    pace_note(&job->pace, jobs_clock_us(), cost_us(job));
}

/* The CPU time that open frames will take: of workers, and of filters. */
struct open_work {
    double left_us, filters_us;
    uint32_t frames;
};

/* Frames whose files are being written: their work is over, though they have not ended. */
static uint32_t encoding(const struct active_job *job)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < job->frame_count; i++)
        count += !job->frames[i].work && job->frames[i].state == FRAME_ENCODING;
    return count;
}

/* Returns what workers take of a frame, in the mean over those that are traced; until one is, what
 * they will have taken of the one that takes most. */
static double frame_mean_us(const struct active_job *job, double all_us, enum foreseen which)
{
    const struct jobs *jobs = job->jobs;
    uint32_t traced = job->frames_finished;
    double most_us = 0.0;
    for (unsigned i = 0; i < jobs->open_count; i++) {
        const struct frame *work = jobs->open[i].frame->work;
        if (jobs->open[i].job != job) continue;
        most_us = fmax(most_us, frame_done_us(work) + frame_left_us(work, which));
        if (frame_is_waiting(work))
            traced++;
        else
            all_us -= frame_done_us(work);
    }
    return traced > 0 ? fmax(0.0, all_us) / traced : most_us;
}

static struct open_work open_work_of(const struct active_job *job, double all_us,
                                     enum foreseen which)
{
    struct open_work sum = {.frames = encoding(job)};
    const struct jobs *jobs = job->jobs;
    const double mean_us = frame_mean_us(job, all_us, which);
    double waiting_us = 0.0;
    for (unsigned i = 0; i < jobs->open_count; i++) {
        const struct frame *work = jobs->open[i].frame->work;
        if (jobs->open[i].job != job) continue;
        sum.left_us += pace_frame_left_us(frame_left_us(work, which), frame_done_us(work),
                                          frame_traced_share(work), mean_us);
        /* Others are filtered while that one is traced, but for those that wait for it. */
        const double filters_us = frame_filters_left_us(work, which);
        if (!frame_has_window(work)) waiting_us += filters_us;
        sum.filters_us = fmax(fmax(sum.filters_us, filters_us), waiting_us);
        sum.frames += !jobs->open[i].frame->recalled;
    }
    return sum;
}

/* Estimates the time left: what open frames still cost, what frames to come will as those so far
 * do, at the latest pace; and the filters' work that waits. Negative until there is a pace. */
static double time_left_s(const struct active_job *job, enum foreseen which)
{
    if (job->state != JOB_RUNNING || job->paused) return -1.0;
    const double all_us = cost_us(job);
    const struct open_work open = open_work_of(job, all_us, which);
    const uint32_t begun = job->frames_finished + open.frames;
    double left_us = open.left_us;
    if (begun > 0 && begun < job->frame_count)
        left_us += (job->frame_count - begun) * ((all_us + open.left_us) / begun);
    const double traced_s = pace_time_s(&job->pace, jobs_clock_us(), left_us);
    if (traced_s < 0.0) return -1.0;
    const double filtered_s = open.filters_us * 1e-6 / thread_pool_threads(job->jobs->options.pool);
    return traced_s + filtered_s;
}

static double tenths(double s)
{
    return round(s * 10) / 10;
}

/* Adds the range of the time left, and its middle where the samples to come are sure enough. */
static void add_time_left(const struct active_job *job, json_t *progress)
{
    const double likely = time_left_s(job, FORESEEN_LIKELY);
    if (likely < 0.0) return;
    const double least = fmin(likely, time_left_s(job, FORESEEN_LEAST));
    const double most = fmax(likely, time_left_s(job, FORESEEN_MOST));
    json_object_set_new(
        progress, "eta_range_s",
        json_pack("[f,f]", tenths(least / PACE_SPREAD), tenths(most * PACE_SPREAD)));
    if (most <= SURE_TIMES * least || most - least <= SURE_S)
        json_object_set_new(progress, "eta_s", json_real(tenths(sqrt(least * most))));
}

/* Passes of tiles, as a frame counts them. */
static uint64_t tiles_a_frame(const struct active_job *job)
{
    struct tile_grid grid;
    const struct plan *plan = job->prepared ? &job->prepared->plan : NULL;
    if (!plan || tile_grid_init(&grid, plan->width_px, plan->height_px, plan->tile_px) != 0)
        return 0;
    return (uint64_t)tile_grid_count(&grid) * plan_pass_count(plan);
}

static json_t *point_of(const float v[3], const double origin[3])
{
    return json_pack("[f,f,f]", origin[0] + (double)v[0], origin[1] + (double)v[1],
                     origin[2] + (double)v[2]);
}

json_t *active_job_plan_json(const struct prepared *prepared, const struct plan *plan,
                             const struct plan_report *report)
{
    json_t *json = plan_report_json(plan, report), *nodes = json_array();
    int failures = !json || !nodes;
    for (uint32_t i = 0; i < prepared->part_count && failures == 0; i++) {
        const struct scene_part *part = &prepared->parts[i];
        json_t *name = json_words(part->name);
        failures +=
            json_array_append_new(
                nodes, json_pack("{s:o,s:s,s:o,s:o}", "name", name, "role", scene_part_role(part),
                                 "lowest", point_of(part->lowest, report->origin), "highest",
                                 point_of(part->highest, report->origin))) != 0;
    }
    if (failures == 0 && json_object_set(json, "nodes", nodes) == 0) {
        json_decref(nodes);
        return json;
    }
    json_decref(nodes);
    json_decref(json);
    return NULL;
}

json_t *active_job_progress(const struct active_job *job)
{
    if (job->last_progress) return json_incref(job->last_progress);
    uint64_t each = tiles_a_frame(job), total = each * job->frame_count + job->tiles_beyond;
    uint64_t done = each * job->frames_finished + job->tiles_beyond;
    for (uint32_t i = 0; i < job->frame_count; i++) {
        const struct active_frame *frame = &job->frames[i];
        if (frame->work && !frame->recalled) {
            done += frame_tiles_landed(frame->work);
            total += frame_tiles_total(frame->work) - frame_tiles_planned(frame->work);
        }
        if (!frame->work && frame->state == FRAME_ENCODING) done += each;
    }
    double fraction = job_fraction(job);
    json_t *progress = json_pack("{s:I,s:I,s:f,s:n,s:n,s:i,s:i}", "tiles_done", (json_int_t)done,
                                 "tiles_total", (json_int_t)total, "fraction",
                                 round(fraction * 1e4) / 1e4, "eta_s", "eta_range_s", "frames_done",
                                 (int)job->frames_finished, "frames_total", (int)job->frame_count);
    if (progress) add_time_left(job, progress);
    if (progress && job->view) json_object_set_new(progress, "view", live_view_json(job));
    return progress;
}

void active_job_add_work(const struct active_job *job, struct statistics *sum)
{
    struct rusage usage;
    struct fleet_totals totals = {0};
    if (job->work_started_us == 0) return;
    sum->wall_us += jobs_clock_us() - job->work_started_us;
    sum->coordinate_cpu_us += jobs_loop_cpu_us() - job->work_started_cpu_us;
    getrusage(RUSAGE_SELF, &usage);
    if (job->jobs->fleet) fleet_totals(job->jobs->fleet, &totals);
    struct statistics peaks = {.server_peak_rss_bytes = (uint64_t)usage.ru_maxrss * 1024,
                               .worker_peak_rss_bytes = totals.peak_rss_bytes};
    statistics_add(sum, &peaks);
}

void active_job_statistics(const struct active_job *job, struct statistics *out)
{
    *out = job->statistics;
    for (unsigned i = 0; i < job->jobs->open_count; i++)
        if (job->jobs->open[i].job == job)
            statistics_add(out, frame_statistics(job->jobs->open[i].frame->work));
    for (uint32_t i = 0; i < job->frame_count; i++)
        if (job->frames[i].shelved) statistics_add(out, &job->frames[i].shelved->statistics);
    active_job_add_work(job, out);
}

static json_t *report_of(const struct active_job *job, const struct statistics *statistics)
{
    json_t *warnings = json_object_get(job->plan, "warnings");
    return json_pack("{s:o,s:O?,s:o,s:o,s:I,s:O?,s:o*}", "progress", active_job_progress(job),
                     "plan", job->plan, "statistics", statistics_json(statistics), "warnings",
                     warnings ? json_incref(warnings) : json_array(), "revision",
                     (json_int_t)job->revision, "log", job->log, "view",
                     job->view ? live_view_json(job) : NULL);
}

json_t *active_job_report(const struct active_job *job)
{
    struct statistics statistics;
    active_job_statistics(job, &statistics);
    return report_of(job, &statistics);
}

char *active_job_kept_report(const struct active_job *job)
{
    struct statistics statistics = job->statistics;
    active_job_add_work(job, &statistics);
    json_t *report = report_of(job, &statistics);
    char *text = json_text(report, JSON_COMPACT);
    json_decref(report);
    return text;
}

void active_job_keep_report(struct active_job *job, const char *state)
{
    char *text = active_job_kept_report(job);
    job_store_update(job->jobs->options.store, job->id, state, NULL, text, NULL, NULL);
    free(text);
}

void active_job_picture_path(const char *id, int32_t number, const char *kind, char out[96])
{
    snprintf(out, 96, "/v1/jobs/%s/frames/%d/image.%s", id, number, kind);
}

json_t *active_job_frame_json(const char *id, int32_t number, enum frame_state state)
{
    char exr[96], png[96];
    bool there = state == FRAME_FINISHED;
    active_job_picture_path(id, number, "exr", exr);
    active_job_picture_path(id, number, "png", png);
    return json_pack("{s:i,s:s,s:s?,s:s?}", "number", number, "state", frame_state_name(state),
                     "exr", there ? exr : NULL, "png", there ? png : NULL);
}

/* Long jobs would make long answers: of frames that wait only the first are listed. */
#define WAITING_LISTED 100

json_t *active_job_frames(const struct active_job *job)
{
    json_t *list = json_array();
    unsigned waiting = 0;
    for (uint32_t i = 0; i < job->frame_count; i++) {
        const struct active_frame *frame = &job->frames[i];
        enum frame_state state = frame->work ? frame_state(frame->work) : frame->state;
        if (state == FRAME_QUEUED && ++waiting > WAITING_LISTED) continue;
        int32_t number = job_frame_number(&job->prepared->job, i);
        json_array_append_new(list, active_job_frame_json(job->id, number, state));
    }
    return list;
}
