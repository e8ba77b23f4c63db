#pragma once
/* A scene of panels side by side, one of each kind that a test has; what a surface of it says. */
#include <math.h>
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"
#include "worker/trace/hit/hit_kernels.h"

static struct scene_fixture *f;
static struct render_scene *scene;

/* Adds each panel by `add`. */
static inline int open_panels(int count, void (*add)(int panel))
{
    struct fault fault = {0};
    f = fixture_new();
    for (int k = 0; k < count; k++) add(k);
    return render_scene_create(fixture_scene(f), 1, NULL, &scene, &fault);
}

static int close_panels(void **state)
{
    (void)state;
    render_scene_destroy(&scene);
    free(f);
    return 0;
}

static inline void expect_color(const struct lanes3 *got, int i, float r, float g, float b)
{
    assert_true(fabsf(got->x[i] - r) < 1e-6f && fabsf(got->y[i] - g) < 1e-6f);
    assert_true(fabsf(got->z[i] - b) < 1e-6f);
}
