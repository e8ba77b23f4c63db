#pragma once
/* The sample loop: tile + scene + plan -> sample planes.
 *
 * The unit of work is a block of 4 x 4 pixels, aligned to the image; what is traced in a block is a
 * pure function of scene, plan and block, so that a pixel's samples are the same bytes whichever
 * tile holds it. */
#include <stdatomic.h>
#include <stdbool.h>

#include "proto/counter.h"
#include "proto/plan.h"
#include "proto/samples.h"
#include "worker/scene/environment.h"
#include "worker/scene/render_scene.h"

struct queries;

/* Scratch of one tracing thread. */
struct tile_tracer;

/* ERR_MEMORY. Tracing allocates nothing afterwards but the samples it returns, what pixel centres
 * around a tile show to lens samples, and room for lone sub-samples, which stays. */
int tile_tracer_create(struct tile_tracer **out);
void tile_tracer_destroy(struct tile_tracer **tracer);

/* What the tracer asks Embree through; a benchmark hangs its recorder on it. Borrowed. */
struct queries *tile_tracer_queries(struct tile_tracer *tracer);

/* Traces a pass of `rect` of the plan's image: samples of samples_layout_init for its number.
 * `environment` is the plan's map, NULL when it has none. *progress (may be NULL) grows by the rows
 * done so far, by rect_height in all, and within blocks of more than PATH_SAMPLES bounce rays or
 * lens samples a pixel; *stop (may be NULL) is looked at after every block and as often within.
 * What was counted is added to *counters, also when the tile fails. The samples are the caller's.
 *
 * Denormals are flushed to zero while it runs; the thread's own setting is restored.
 *
 * ERR_STATE when stopped, ERR_RANGE for a rectangle that is empty, outside the image or larger than
 * LIMIT_TILE_SIDE_PX, what plan_pass_check says, ERR_MISSING for a plan with a map but no
 * environment, ERR_LIMIT or ERR_MEMORY from samples.h. */
int tile_trace_pass(struct tile_tracer *tracer, const struct render_scene *scene,
                    const struct environment *environment, const struct plan *plan,
                    const struct plan_pass *pass, struct rect rect, _Atomic uint64_t *progress,
                    const _Atomic bool *stop, struct samples **out, struct counters *counters);

/* The same of a pass of the schedule; ERR_RANGE for one beyond it. */
int tile_trace(struct tile_tracer *tracer, const struct render_scene *scene,
               const struct environment *environment, const struct plan *plan, uint32_t pass,
               struct rect rect, _Atomic uint64_t *progress, const _Atomic bool *stop,
               struct samples **out, struct counters *counters);
