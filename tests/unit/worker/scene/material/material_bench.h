#pragma once
/* A scene with one material, which tests change and look at. */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/scene_fixture.h"
#include "worker/scene/material/material.h"

/* A table of one material that a test fills in. */
struct bench {
    struct scene_fixture *f;
    struct scene_material *record;
    struct material_table *table;
};

static inline struct bench open_bench(void)
{
    struct bench b = {.f = calloc(1, sizeof *b.f)};
    assert_non_null(b.f);
    fixture_material(b.f, 0.5f, 0.25f, 1.0f);
    b.record = &b.f->materials[0];
    b.record->specular = 1.0f;
    return b;
}

static inline const struct material *make(struct bench *b)
{
    if (b->table) material_table_destroy(&b->table);
    assert_int_equal(material_table_create(fixture_scene(b->f), &b->table), 0);
    return &b->table->materials[0];
}

static inline void close_bench(struct bench *b)
{
    material_table_destroy(&b->table);
    free(b->f);
}

static inline void expect(float got, double expected)
{
    if (fabs((double)got - expected) > 1e-5 * (1.0 + fabs(expected)))
        fail_msg("%g is not %g", (double)got, expected);
}

/* A texture of one texel for every channel. */
static inline struct scene_texture_ref texel(struct bench *b, uint8_t r, uint8_t g, uint8_t blue,
                                             uint8_t a, uint32_t flags)
{
    const uint8_t rgba[4] = {r, g, blue, a};
    return (struct scene_texture_ref){.texture = fixture_texture(b->f, 1, 1, rgba, flags),
                                      .transform = {1, 0, 0, 0, 1, 0}};
}

static const struct material_uv at_origin;
