#pragma once
/* Plans with indirect light, without the filter of paths. */
#include "proto/samples.h"
#include "tests/unit/server/job/plan/plan_stage.h"
#include "tests/unit/unit.h"

#define BIT(plane) PLANE_BIT(plane)
#define PLANES_SURFACE                                                                             \
    (PLANES_CENTRE | BIT(ALBEDO) | BIT(SUB_DEPTH) | BIT(SUB_NORMAL) | BIT(SUB_ALBEDO) |            \
     BIT(SUB_ID) | BIT(LONE))
#define PLANES_ALONE (PLANES_SURFACE | BIT(MIXED)) /* without paths beside them */

static inline void must_make(struct stage *s)
{
    if (make(s) != 0) fail_msg("%s: %s", s->fault.pointer, s->fault.detail);
    assert_int_equal(plan_check(&s->plan, &s->fault), 0);
}

/* The filter of paths, and its planes, are test_plan_residual's. */
static inline int set_up(void **state)
{
    const int error = stage_set_up(state);
    ((struct stage *)*state)->job.residual = RESIDUAL_NONE;
    return error;
}
