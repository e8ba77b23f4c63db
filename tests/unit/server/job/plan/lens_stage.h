#pragma once
/* Plans with a lens. */
#include "proto/samples.h"
#include "tests/unit/server/job/plan/plan_stage.h"
#include "tests/unit/unit.h"

#define BIT(plane) PLANE_BIT(plane)

static inline int set_up_lens(void **state)
{
    stage_set_up(state);
    struct stage *s = *state;
    s->job.aperture_radius = 0.1f;
    s->job.focus_distance = 4;
    return 0;
}

static inline void must_make(struct stage *s)
{
    if (make(s) != 0) fail_msg("%s: %s", s->fault.pointer, s->fault.detail);
}
