#pragma once
/* What a pass of a plan runs: which fields of pixel centres and of the lens, how many paths, and
 * what each kind of path brings and leaves to others. */
#include "proto/plan.h"
#include "worker/trace/path/centre_gbuffer.h"
#include "worker/trace/path/path.h"

struct stages {
    bool centres;          /* pixel centres */
    bool lights;           /* their light fields of lights */
    bool bounces;          /* bounce rays leave them */
    bool glossy;           /* and rays of their glossy lobes */
    bool vertices;         /* somebody asks for their BSDFs */
    bool lens;             /* the lens's light field */
    bool more;             /* or a second set of paths through it */
    uint32_t first, count; /* samples of the path tracer */
    struct plan_pass pass;
    struct path_context paths, field, through_lens;
    struct path_context whole; /* through the lens, with all of their light */
};

/* `parts` has the queries with their scene, the lights, the sky, the plan and the counters, all of
 * which are borrowed, as are `centres`, which paths through the lens ask what fields will light. */
void stages_init(const struct path_context *parts, struct centre_gbuffer *centres,
                 const struct plan_pass *pass, struct stages *out);
