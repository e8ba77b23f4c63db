#pragma once
/* Pictures whose fields' samples are replayed one by one, and rooms for them. */
#include <stdlib.h>

#include "tests/unit/worker/trace/field/field_room.h"
#include "worker/replay/field_replay.h"

struct bench {
    struct scene_fixture *f;
    struct plan plan;
    struct environment_fixture map;
    struct render_scene *scene;
    struct tile_tracer *tracer;
    struct samples *samples; /* of `pass` */
    uint8_t sides[AREA], lobes[AREA];
    struct path_record *record;
    struct field_held held;
};

static inline struct bench *bench_new(void)
{
    struct bench *b = calloc(1, sizeof *b);
    assert_non_null(b);
    b->f = fixture_new();
    b->record = malloc(sizeof *b->record);
    assert_non_null(b->record);
    return b;
}

/* Traces the pass of all of the picture. */
static inline void bench_trace(struct bench *b, const struct plan_pass *pass)
{
    static const float texels[3 * 32] = {[0] = 40, [1] = 30, [2] = 10, [40] = 2, [41] = 3};
    struct fault fault = {0};
    struct counters counters = {0};
    const struct plan *p = &b->plan;
    if (p->environment.kind == ENVIRONMENT_MAP) environment_fixture_open(&b->map, 8, 4, texels);
    assert_int_equal(render_scene_create(fixture_scene(b->f), 1, NULL, &b->scene, &fault), 0);
    assert_int_equal(tile_tracer_create(&b->tracer), 0);
    assert_int_equal(tile_trace_pass(b->tracer, b->scene, b->map.map, p, pass,
                                     (struct rect){0, 0, p->width_px, p->height_px}, NULL, NULL,
                                     &b->samples, &counters),
                     0);
}

static inline void bench_free(struct bench *b)
{
    samples_destroy(&b->samples);
    tile_tracer_destroy(&b->tracer);
    render_scene_destroy(&b->scene);
    if (b->map.map) environment_fixture_close(&b->map);
    free(b->record);
    free(b->f);
    free(b);
}

static const struct path_record *replay(struct bench *b, const struct field_choice *choice, int i,
                                        uint32_t sample)
{
    struct fault fault = {0};
    const int32_t w = b->plan.width_px;
    const int e = field_replay(b->scene, b->map.map, &b->plan, choice, i % w, i / w, sample,
                               b->record, &b->held, &fault);
    if (e) print_message("%s: %s\n", fault.pointer, fault.detail);
    assert_int_equal(e, 0);
    return b->record;
}

static inline void expect_half(uint16_t plane, float value, const char *what, int pixel)
{
    if (plane != half_from_float(value))
        fail_msg("%s of pixel %d: the plane has %.9g, samples add up to %.9g", what, pixel,
                 (double)half_to_float(plane), (double)value);
}

/* A mesh of four vertices whose shading normals lean over. */
static inline void lean(struct scene_fixture *f, uint32_t mesh)
{
    f->meshes[mesh].flags |= MESH_HAS_NORMALS;
    for (uint32_t i = 0; i < 4; i++) {
        float *n = f->normals + (size_t)3 * (f->meshes[mesh].first_normal + i);
        n[0] = 0.8f, n[1] = 0.6f, n[2] = 0.0f;
    }
}

/* Boxes on a floor that ends within the picture, a black panel and one that is not as its normals
 * say: lights with area, few strata and many, one below the floor that none of it sees, one that
 * only leaning normals see, and some without area. */
static inline void lit_room(struct bench *b)
{
    b->plan = floor_plan(b->f, 1.7f, 12);
    struct plan *p = &b->plan;
    const uint32_t black = fixture_material(b->f, 0, 0, 0);
    fixture_panel(b->f, 0, (float[]){0.2f, 1, 0}, (float[]){0.4f, 0, 0}, (float[]){0, 0, -0.4f});
    fixture_panel(b->f, 0, (float[]){-0.8f, 1, 0}, (float[]){0, 0, -0.5f}, (float[]){0, 0.7f, 0});
    fixture_panel(b->f, black, (float[]){1.8f, 0, 0}, (float[]){0.1f, 0, 0}, (float[]){0, 0, -2});
    fixture_panel(b->f, 0, (float[]){1, 0.1f, 1}, (float[]){0.5f, 0, 0}, (float[]){0, 0, -0.5f});
    lean(b->f, b->f->mesh_count - 1);
    fixture_ceiling_light(p, 0, 3, 0, 0.5f, 3)->color[1] = 0.5f;
    fixture_ceiling_light(p, 0.5f, 2.5f, 0.5f, 0.7f, 7)->profile = PROFILE_GAUSSIAN;
    fixture_ceiling_light(p, 0, -1, 0, 0.5f, 2);
    fixture_ceiling_light(p, -1.4f, 0.6f, 0, 0.8f, 4);
    struct plan_light *point = fixture_light(p, LIGHT_POINT, 1);
    point->position[1] = 2;
    fixture_light(p, LIGHT_DIRECTIONAL, 1);
    struct plan_light *low = fixture_light(p, LIGHT_RECTANGLE, 3);
    memcpy(low->position, (float[]){5, -1, 1}, sizeof low->position);
    memcpy(low->direction, (float[]){-1, 0, 0}, sizeof low->direction);
    low->half_u[2] = low->half_v[1] = 0.5f;
}
