#include "tests/unit/worker/tile_fixture.h"

#include <stdio.h>
#include <stdlib.h>

struct scene_fixture *fixture_new(void)
{
    struct scene_fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    return f;
}

void open_traced(struct scene_fixture *f, struct traced *t)
{
    struct fault fault = {0};
    const int rc = render_scene_create(fixture_scene(f), 1, NULL, &t->scene, &fault);
    if (rc) print_message("%s: %s\n", fault.pointer, fault.detail);
    assert_int_equal(rc, 0);
    assert_int_equal(tile_tracer_create(&t->tracer), 0);
}

int trace_tile(struct traced *t, struct tile_job job, uint32_t pass, struct samples **out)
{
    job.scene = t->scene;
    if (!job.counters) job.counters = &t->counters;
    return tile_trace(t->tracer, &job, pass, out);
}

struct traced trace(struct scene_fixture *f, const struct plan *plan, struct rect rect)
{
    struct traced t = {0};
    open_traced(f, &t);
    const struct tile_job job = {.plan = plan, .rect = rect};
    assert_int_equal(trace_tile(&t, job, 0, &t.samples), 0);
    return t;
}

void traced_fini(struct traced *t)
{
    samples_destroy(&t->samples);
    tile_tracer_destroy(&t->tracer);
    render_scene_destroy(&t->scene);
}

struct plan floor_plan(struct scene_fixture *f, float half_side, int32_t side_px)
{
    uint32_t grey = fixture_material(f, 0.5f, 0.5f, 0.5f);
    fixture_panel(f, grey, (float[]){0, 0, 0}, (float[]){half_side, 0, 0},
                  (float[]){0, 0, -half_side});
    struct plan p = fixture_plan(side_px, side_px, (float[]){0, 4, 0}, 0.5f);
    fixture_look(&p, (float[]){0, -1, 0}, (float[]){0, 0, -1});
    return p;
}

void floor_point(const struct plan *p, int32_t x, int32_t y, double out[3])
{
    out[0] = (2.0 * (x + 0.5) / p->width_px - 1.0) * 0.5 * 4.0;
    out[1] = 0.0;
    out[2] = -(1.0 - 2.0 * (y + 0.5) / p->height_px) * 0.5 * 4.0;
}
