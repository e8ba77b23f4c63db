#pragma once
/* Tracing fixture scenes with cmocka's checks. */
#include <stdio.h>
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/scene_fixture.h"
#include "worker/tile/tile.h"

struct traced {
    struct render_scene *scene;
    struct tile_tracer *tracer;
    struct samples *samples;
    struct counters counters;
};

static inline struct scene_fixture *fixture_new(void)
{
    struct scene_fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    return f;
}

static inline struct traced trace(struct scene_fixture *f, const struct plan *plan,
                                  struct rect rect)
{
    struct traced t = {0};
    struct fault fault = {0};
    int rc = render_scene_create(fixture_scene(f), 1, NULL, &t.scene, &fault);
    if (rc) print_message("%s: %s\n", fault.pointer, fault.detail);
    assert_int_equal(rc, 0);
    assert_int_equal(tile_tracer_create(&t.tracer), 0);
    rc = tile_trace(t.tracer, t.scene, NULL, plan, 0, rect, NULL, NULL, &t.samples, &t.counters);
    assert_int_equal(rc, 0);
    return t;
}

static inline struct traced trace_all(struct scene_fixture *f, const struct plan *plan)
{
    return trace(f, plan, (struct rect){0, 0, plan->width_px, plan->height_px});
}

static inline void traced_fini(struct traced *t)
{
    samples_destroy(&t->samples);
    tile_tracer_destroy(&t->tracer);
    render_scene_destroy(&t->scene);
}

static inline uint64_t count(const struct traced *t, enum counter_id id)
{
    return t->counters.value[id];
}

/* A grey floor at y = 0 seen from (0, 4, 0), looking down with z towards the image's bottom; it
 * fills the image where half_side is 2 or more. */
static inline struct plan floor_plan(struct scene_fixture *f, float half_side, int32_t side_px)
{
    uint32_t grey = fixture_material(f, 0.5f, 0.5f, 0.5f);
    fixture_panel(f, grey, (float[]){0, 0, 0}, (float[]){half_side, 0, 0},
                  (float[]){0, 0, -half_side});
    struct plan p = fixture_plan(side_px, side_px, (float[]){0, 4, 0}, 0.5f);
    fixture_look(&p, (float[]){0, -1, 0}, (float[]){0, 0, -1});
    return p;
}

/* The point that pixel (x, y) of a floor plan sees. */
static inline void floor_point(const struct plan *p, int32_t x, int32_t y, double out[3])
{
    out[0] = (2.0 * (x + 0.5) / p->width_px - 1.0) * 0.5 * 4.0;
    out[1] = 0.0;
    out[2] = -(1.0 - 2.0 * (y + 0.5) / p->height_px) * 0.5 * 4.0;
}
