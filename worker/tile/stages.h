#pragma once
/* The stages of a pass: which light fields of pixel centres and of the lens it traces, how many
 * paths, and which light each kind of path leaves to a field. */
#include "proto/plan.h"
#include "worker/trace/path/centre_gbuffer.h"
#include "worker/trace/path/path.h"

struct stages {
    bool centres;          /* pixel centres */
    bool lights;           /* their light fields of lights */
    bool bounces;          /* their bounce rays */
    bool glossy;           /* rays of their glossy lobes */
    bool albedo;           /* their diffuse albedo is needed */
    bool vertices;         /* their BSDFs are needed */
    bool lens;             /* the lens's light field */
    bool skips_paths;      /* those of pixels that show diffuse lobes only */
    bool more;             /* a second set of paths through the lens */
    uint32_t first, count; /* samples of the path tracer */
    struct plan_pass pass;
    struct path_context paths, field, through_lens;
    struct path_context whole; /* of paths through the lens, with all of their light */
};

/* Chooses the stages of a pass. `parts` has the queries with their scene, the lights, the sky, the
 * plan and the counters. `centres` tells paths through the lens which light a field brings. Both
 * are borrowed. */
void stages_init(const struct path_context *parts, struct centre_gbuffer *centres,
                 const struct plan_pass *pass, struct stages *out);
