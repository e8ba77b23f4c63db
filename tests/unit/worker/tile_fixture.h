#pragma once
/* Tracing fixture scenes with cmocka's checks. */
#include "tests/unit/unit.h"
#include "tests/unit/worker/scene_fixture.h"
#include "worker/tile/tile.h"

struct traced {
    struct render_scene *scene;
    struct tile_tracer *tracer;
    struct samples *samples;
    struct counters counters;
};

struct scene_fixture *fixture_new(void);

/* Makes the scene and the tracer. */
void open_traced(struct scene_fixture *f, struct traced *t);

/* Traces a pass of a tile of the scene into the counters, unless `job` has others. */
int trace_tile(struct traced *t, struct tile_job job, uint32_t pass, struct samples **out);

/* Traces the first pass of a rect. */
struct traced trace(struct scene_fixture *f, const struct plan *plan, struct rect rect);

static inline struct traced trace_all(struct scene_fixture *f, const struct plan *plan)
{
    return trace(f, plan, (struct rect){0, 0, plan->width_px, plan->height_px});
}

void traced_fini(struct traced *t);

static inline uint64_t count(const struct traced *t, enum counter_id id)
{
    return t->counters.value[id];
}

/* A grey floor at y = 0 seen from (0, 4, 0), looking down with z towards the image's bottom; it
 * fills the image where half_side is 2 or more. */
struct plan floor_plan(struct scene_fixture *f, float half_side, int32_t side_px);

/* The point that pixel (x, y) of a floor plan sees. */
void floor_point(const struct plan *p, int32_t x, int32_t y, double out[3]);
