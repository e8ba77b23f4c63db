#include "server/job/frame/state.h"

#include <assert.h>
#include <string.h>

#define TO(state) (1u << (state))

/* One line a state: its name, and where it may go. A job may end from anywhere that is no end, and
 * begin again from anywhere that is none. */
static const struct {
    const char *name;
    unsigned next;
} jobs[JOB_STATE_COUNT] = {
    [JOB_QUEUED] = {"queued", TO(JOB_IMPORTING) | TO(JOB_FAILED) | TO(JOB_CANCELLED)},
    [JOB_IMPORTING] = {"importing",
                       TO(JOB_QUEUED) | TO(JOB_RUNNING) | TO(JOB_FAILED) | TO(JOB_CANCELLED)},
    [JOB_RUNNING] = {"running", TO(JOB_QUEUED) | TO(JOB_RESTING) | TO(JOB_FINISHED) |
                                    TO(JOB_FAILED) | TO(JOB_CANCELLED)},
    [JOB_RESTING] = {"resting", TO(JOB_QUEUED) | TO(JOB_RUNNING) | TO(JOB_FINISHED) |
                                    TO(JOB_FAILED) | TO(JOB_CANCELLED)},
    [JOB_FINISHED] = {"finished", 0},
    [JOB_FAILED] = {"failed", 0},
    [JOB_CANCELLED] = {"cancelled", 0},
};

/* A frame that is dropped goes back: it is as if it had never begun. */
static const struct {
    const char *name;
    unsigned next;
} frames[FRAME_STATE_COUNT] = {
    [FRAME_QUEUED] = {"queued", TO(FRAME_RENDERING)},
    [FRAME_RENDERING] = {"rendering", TO(FRAME_ENCODING) | TO(FRAME_QUEUED)},
    [FRAME_ENCODING] = {"encoding", TO(FRAME_FINISHED) | TO(FRAME_QUEUED)},
    [FRAME_FINISHED] = {"finished", 0},
};

const char *job_state_name(enum job_state state)
{
    assert(state < JOB_STATE_COUNT);
    return jobs[state].name;
}

bool job_state_from_name(const char *name, enum job_state *out)
{
    for (unsigned i = 0; i < JOB_STATE_COUNT; i++) {
        if (!strcmp(jobs[i].name, name)) {
            *out = (enum job_state)i;
            return true;
        }
    }
    return false;
}

bool job_state_is_final(enum job_state state)
{
    assert(state < JOB_STATE_COUNT);
    return jobs[state].next == 0;
}

bool job_state_may(enum job_state from, enum job_state to)
{
    assert(from < JOB_STATE_COUNT && to < JOB_STATE_COUNT);
    return (jobs[from].next & TO(to)) != 0;
}

void job_state_go(enum job_state *state, enum job_state to)
{
    assert(job_state_may(*state, to));
    *state = to;
}

const char *frame_state_name(enum frame_state state)
{
    assert(state < FRAME_STATE_COUNT);
    return frames[state].name;
}

bool frame_state_from_name(const char *name, enum frame_state *out)
{
    for (unsigned i = 0; i < FRAME_STATE_COUNT; i++) {
        if (!strcmp(frames[i].name, name)) {
            *out = (enum frame_state)i;
            return true;
        }
    }
    return false;
}

bool frame_state_may(enum frame_state from, enum frame_state to)
{
    assert(from < FRAME_STATE_COUNT && to < FRAME_STATE_COUNT);
    return (frames[from].next & TO(to)) != 0;
}

void frame_state_go(enum frame_state *state, enum frame_state to)
{
    assert(frame_state_may(*state, to));
    *state = to;
}
