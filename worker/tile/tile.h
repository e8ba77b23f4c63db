#pragma once
/* The sample loop: tile + scene + plan -> sample planes.
 *
 * The unit of work is a block of 4 x 4 pixels, aligned to the image. A block's samples are a pure
 * function of scene, plan and block, so that a pixel's samples are the same bytes whichever tile
 * holds it. */
#include <stdatomic.h>
#include <stdbool.h>

#include "proto/counter.h"
#include "proto/plan.h"
#include "proto/samples.h"
#include "proto/scene/environment.h"
#include "worker/scene/environment.h"
#include "worker/scene/render_scene.h"

struct queries;

/* Scratch of one tracing thread. */
struct tile_tracer;

/* Creates a tracer. ERR_MEMORY. Tracing later allocates only the samples it returns, the G-buffer
 * of pixel centres, and the list of lone sub-samples, which the tracer keeps. */
int tile_tracer_create(struct tile_tracer **out);
void tile_tracer_destroy(struct tile_tracer **tracer);

/* Returns the tracer's queries to Embree, borrowed; a benchmark records them. */
struct queries *tile_tracer_queries(struct tile_tracer *tracer);

/* A pass of a tile, and what it is traced with; all borrowed. */
struct tile_job {
    const struct render_scene *scene;
    const struct environment *environment;     /* the plan's map; NULL: it has none */
    const struct environment_blob *photograph; /* the plan's; the same */
    const struct plan *plan;
    const struct plan_pass *pass;
    struct rect rect;           /* of the plan's image */
    _Atomic uint64_t *progress; /* NULL: not reported */
    const _Atomic bool *stop;   /* NULL: never stopped */
    struct counters *counters;  /* grow, also when the tile fails */
};

/* Traces the job's pass into samples of samples_layout_init for its number, which the caller owns.
 *
 * *progress grows by the rows done so far, by rect_height in all, and within blocks of more than
 * PATH_SAMPLES bounce rays or lens samples a pixel. *stop is looked at after every block and as
 * often within. Denormals are flushed to zero meanwhile; the thread's own setting is restored.
 *
 * ERR_STATE when stopped, ERR_RANGE for a rectangle that is empty, outside the image or larger than
 * LIMIT_TILE_SIDE_PX, what plan_pass_check says, ERR_MISSING for a plan with a map or a
 * photograph that the job has not, ERR_LIMIT or ERR_MEMORY from samples.h. */
int tile_trace_pass(struct tile_tracer *tracer, const struct tile_job *job, struct samples **out);

/* Does the same with a pass of the plan's schedule instead of job->pass; ERR_RANGE for one beyond
 * it. */
int tile_trace(struct tile_tracer *tracer, const struct tile_job *job, uint32_t pass,
               struct samples **out);
