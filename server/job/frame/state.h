#pragma once
/* The states of jobs and frames, as tables of the steps that are legal. A step that is not in the
 * table is our own bug and asserts. */
#include <stdbool.h>

enum job_state {
    JOB_QUEUED,    /* durable, waits for its turn */
    JOB_IMPORTING, /* its scene is imported and planned */
    JOB_RUNNING,   /* its frames are traced, reconstructed, encoded */
    JOB_RESTING,   /* live: its picture is complete, its camera may be moved */
    JOB_FINISHED,  /* all files are stored */
    JOB_FAILED,
    JOB_CANCELLED,
    JOB_STATE_COUNT
};

enum frame_state {
    FRAME_QUEUED,
    FRAME_RENDERING, /* tiles are out, or blocks on the pool */
    FRAME_ENCODING,  /* all pixels are there; files are written and recorded */
    FRAME_FINISHED,
    FRAME_STATE_COUNT
};

/* Return the names of the HTTP contract and of the store. */
const char *job_state_name(enum job_state state);
bool job_state_from_name(const char *name, enum job_state *out);
bool job_state_is_final(enum job_state state);
bool job_state_may(enum job_state from, enum job_state to);
void job_state_go(enum job_state *state, enum job_state to);

const char *frame_state_name(enum frame_state state);
bool frame_state_from_name(const char *name, enum frame_state *out);
bool frame_state_may(enum frame_state from, enum frame_state to);
void frame_state_go(enum frame_state *state, enum frame_state to);
