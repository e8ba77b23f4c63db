/* Which frames a job has, and when they are: "1-10,20-40x2", or {"first": 1, "last": 10}. */
#include <stdio.h>
#include <string.h>

#include "proto/job/job_internal.h"

#define FRAME_MAX        1073741824 /* 2^30 */
#define LAST_FRAME_UNSET (-1)

uint32_t job_frame_run_count(const struct job_frame_run *run)
{
    return (uint32_t)((run->last - run->first) / run->step) + 1;
}

uint32_t job_frame_count(const struct job *job)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < job->frame_run_count; i++)
        count += job_frame_run_count(&job->frames[i]);
    return count;
}

int32_t job_frame_number(const struct job *job, uint32_t index)
{
    const struct job_frame_run *run = job->frames;
    while (index >= job_frame_run_count(run)) index -= job_frame_run_count(run++);
    return run->first + (int32_t)index * run->step;
}

bool job_frame_find(const struct job *job, int32_t number, uint32_t *index)
{
    *index = 0;
    for (uint32_t i = 0; i < job->frame_run_count; i++) {
        const struct job_frame_run *run = &job->frames[i];
        if (number >= run->first && number <= run->last && (number - run->first) % run->step == 0) {
            *index += (uint32_t)((number - run->first) / run->step);
            return true;
        }
        *index += job_frame_run_count(run);
    }
    return false;
}

bool job_frames_follow(const struct job *job)
{
    for (uint32_t i = 0; i < job->frame_run_count; i++) {
        const struct job_frame_run *run = &job->frames[i];
        const uint32_t count = job_frame_run_count(run);
        const bool before = i > 0 && run[-1].last + 1 == run->first;
        const bool after = i + 1 < job->frame_run_count && run->last + 1 == run[1].first;
        if (count > 1 ? run->step > 1 : !before && !after) return false;
    }
    return true;
}

double job_frame_time_s(const struct job *job, int32_t number)
{
    if (job->stands) return job->time_s;
    return job->start_time_s + ((double)number - 1 + (double)job->shutter_centre) / job->fps;
}

/* Reads up to ten digits, and moves on. */
static bool read_digits(const char **at, int64_t *out)
{
    const char *start = *at;
    *out = 0;
    for (; **at >= '0' && **at <= '9' && *at - start < 11; ++*at) *out = *out * 10 + (**at - '0');
    return *at > start;
}

/* Reads "20", "20-40" or "20-40x2", and moves on. */
static bool read_run(const char **at, int64_t out[3])
{
    if (!read_digits(at, &out[0])) return false;
    out[1] = out[0];
    out[2] = 1;
    if (**at != '-') return true;
    ++*at;
    if (!read_digits(at, &out[1])) return false;
    if (**at != 'x') return true;
    ++*at;
    return read_digits(at, &out[2]);
}

static int check_run(struct json_cursor *at, const struct job *job, const int64_t run[3])
{
    const struct job_frame_run *before =
        job->frame_run_count > 0 ? &job->frames[job->frame_run_count - 1] : NULL;
    if (run[1] > FRAME_MAX || run[2] > FRAME_MAX)
        return json_cursor_refuse(at, ERR_RANGE, "%lld is above %d",
                                  (long long)(run[1] > FRAME_MAX ? run[1] : run[2]), FRAME_MAX);
    if (run[2] < 1) return json_cursor_refuse(at, ERR_RANGE, "a step of 0 never ends");
    if (run[1] < run[0])
        return json_cursor_refuse(at, ERR_RANGE, "%lld is below the first frame %lld",
                                  (long long)run[1], (long long)run[0]);
    if (before && run[0] <= before->last)
        return json_cursor_refuse(at, ERR_RANGE, "%lld comes after %d: frames are named in order",
                                  (long long)run[0], before->last);
    return 0;
}

static int read_list(struct json_cursor *at, const char *text, struct job *job)
{
    job->frame_run_count = 0;
    do {
        int64_t run[3];
        if (job->frame_run_count == LIMIT_FRAME_RUNS)
            return json_cursor_refuse(at, ERR_LIMIT, "it has more than %d parts", LIMIT_FRAME_RUNS);
        if (!read_run(&text, run) || (*text != '\0' && *text != ','))
            return json_cursor_refuse(at, ERR_SYNTAX,
                                      "it is no list of frames such as 1-10,20-40x2");
        int error = check_run(at, job, run);
        if (error) return error;
        job->frames[job->frame_run_count++] =
            (struct job_frame_run){(int32_t)run[0], (int32_t)run[1], (int32_t)run[2]};
    } while (*text++ == ',');
    return 0;
}

static const struct json_member members[] = {{.name = "first",
                                              .read = json_member_i32,
                                              .offset = offsetof(struct job_frame_run, first),
                                              .min = 0,
                                              .max = FRAME_MAX},
                                             {.name = "last",
                                              .read = json_member_i32,
                                              .offset = offsetof(struct job_frame_run, last),
                                              .min = 0,
                                              .max = FRAME_MAX},
                                             {.name = NULL}};

static int read_range(struct json_cursor *at, const json_t *v, struct job *job)
{
    struct job_frame_run run = {.first = 1, .last = LAST_FRAME_UNSET, .step = 1};
    int error = json_cursor_expect(at, v, JSON_OBJECT, "an object or a text");
    if (!error) error = json_cursor_members(at, v, members, &run);
    if (error) return error;
    if (run.last == LAST_FRAME_UNSET) run.last = run.first;
    if (run.last < run.first)
        return json_cursor_refuse_member(at, "last", ERR_RANGE, "%d is below the first frame %d",
                                         run.last, run.first);
    job->frames[0] = run;
    job->frame_run_count = 1;
    return 0;
}

int job_frames_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                    void *object)
{
    struct job *job = object;
    (void)member;
    int error = json_is_string(value) ? read_list(at, json_string_value(value), job)
                                      : read_range(at, value, job);
    if (error) return error;
    const uint32_t count = job_frame_count(job);
    if (count <= LIMIT_FRAMES) return 0;
    return json_cursor_refuse(at, ERR_LIMIT, "%u frames are above the limit of %d", count,
                              LIMIT_FRAMES);
}

int job_frames_of(const json_t *document, struct job *out)
{
    struct json_cursor at;
    const json_t *frames = json_object_get(document, "frames");
    json_cursor_init(&at, NULL);
    *out = (struct job){.frames = {{1, 1, 1}}, .frame_run_count = 1};
    return frames ? job_frames_read(&at, NULL, frames, out) : 0;
}

/* Writes a list; a part is at most "1073741823-1073741824x1073741824,". */
static json_t *write_list(const struct job *job)
{
    char text[LIMIT_FRAME_RUNS * 40];
    size_t used = 0;
    for (uint32_t i = 0; i < job->frame_run_count; i++) {
        const struct job_frame_run *run = &job->frames[i];
        used +=
            (size_t)snprintf(text + used, sizeof text - used, "%s%d", i > 0 ? "," : "", run->first);
        if (run->last > run->first)
            used += (size_t)snprintf(text + used, sizeof text - used, "-%d", run->last);
        if (run->last > run->first && run->step > 1)
            used += (size_t)snprintf(text + used, sizeof text - used, "x%d", run->step);
    }
    return json_string(text);
}

json_t *job_frames_write(const struct job *job)
{
    const struct job_frame_run *run = &job->frames[0];
    if (job->frame_run_count > 1 || run->step > 1) return write_list(job);
    return json_pack("{s:i,s:i}", "first", run->first, "last", run->last);
}
