#pragma once
/* The record of one path, step by step, which explains a pixel's value to users.
 *
 * The path tracer's own steps fill it while they run, so that it shows what was traced. A context
 * without a record (path_context.record NULL: always, except in a replay) pays one branch for each
 * packet. With a record there must be a single active path; it travels in lane 0. */
#include <stdbool.h>
#include <stdint.h>

#include "proto/limits.h"
#include "worker/scene/light_table.h"
#include "worker/shade/bsdf.h"

struct light_packet;
struct path_context;
struct path_packet;
struct path_vertex;

/* Camera, LIMIT_INDIRECT_BOUNCES after the first scattering, and what the last segment meets. */
#define PATH_RECORD_VERTICES (LIMIT_INDIRECT_BOUNCES + 3)
/* Emitters that one segment can meet: every rectangle, and the sky or a surface. */
#define PATH_RECORD_MET (LIMIT_LIGHTS + 1)

/* Light samples that one surface can take: of lights without extent, and another. */
#define PATH_RECORD_LIGHTS (2 * (LIGHTS_FEW + 1)) /* of both sides */

/* Emission that the path's own ray met. `light`, here and below, is the number of a light of the
 * plan, LIGHT_CHOICE_EMITTERS (the surface that was met) or LIGHT_CHOICE_ENVIRONMENT. */
struct path_record_met {
    uint32_t light;
    float radiance[3];
    float weight;   /* by the power heuristic; times the profile of a rectangle */
    float value[3]; /* what it adds to the sample */
};

struct path_record_light {
    uint32_t light;
    float probability;             /* of choosing it */
    int32_t skip;                  /* enum light_skip: why no ray is needed */
    float origin[3], direction[3]; /* unit */
    float distance;                /* INFINITY: the sky */
    float density;   /* per solid angle, times the probability; 0: nothing else finds the light */
    float scattered; /* density with which scattering would have chosen the direction */
    float weight;    /* of the power heuristic */
    float reflected[3]; /* what arrives is sent on: radiance over the path's throughput */
    bool traced;        /* its ray; else `skip`, or what is sent on is nothing */
    bool blocked;
    uint32_t blocker; /* instance index + 1 of what the ray met first; 0: not found again */
    float blocked_at; /* its distance */
    float value[3];   /* what it adds to the sample */
};

struct path_record_scatter {
    bool tried;
    bool on; /* false: absorbed, or a direction on the wrong side of the surface */
    bool dirac, transmitted;
    float direction[3];
    float pdf;                     /* per solid angle; 0: light samples could not have found it */
    float diffuse[3], specular[3]; /* the weight's parts */
    float weight[3]; /* f |cos| / density: the throughput is multiplied by it. The density is `pdf`,
                        or beside light behind glass that of lobes and lights together */
    bool left_out;   /* all that could come is a light field's */
    bool goes_on;
    bool roulette; /* was played; the throughput then is over `survival` */
    float chance, survival;
};

struct path_record_vertex {
    float origin[3], direction[3]; /* of the ray that came here */
    float pdf;
    float throughput[3]; /* of that ray's light to the camera, dimmed by volumes */
    uint32_t met_count;
    struct path_record_met met[PATH_RECORD_MET];
    bool hit;
    float distance;
    float position[3], normal[3], facet[3]; /* shading and geometric, towards the ray */
    uint32_t instance;                      /* index + 1 */
    uint32_t triangle;
    float u, v;  /* barycentric */
    bool behind; /* met from the side that the winding turns away */
    bool active; /* sends light on */
    bool lambert;
    struct bsdf bsdf; /* unless lambert */
    float albedo[3];
    bool left;     /* ended: a light field brings what would come */
    float kept[3]; /* throughput after what a light field brings was taken out of it */
    bool is_kept;  /* that was done here */
    float stays;   /* the chance of going on with other lobes than those of light fields; 0: sure */
    bool thinned;  /* ended by it */
    bool last;     /* its light sample stands for all direct light */
    uint32_t light_count;
    struct path_record_light lights[PATH_RECORD_LIGHTS];
    struct path_record_scatter scatter;
};

/* The kind of a sample. */
enum path_record_kind {
    PATH_RECORD_PATHS,          /* the path tracer's */
    PATH_RECORD_LENS,           /* of the lens's light field */
    PATH_RECORD_LENS_SECOND_SET /* of a second set through the lens */
};

struct path_record {
    enum path_record_kind kind;
    uint32_t first, last; /* numbers that samples of this kind have */
    float pixel[2];       /* position in the image, px */
    uint32_t count;
    struct path_record_vertex vertices[PATH_RECORD_VERTICES];
    /* What the sample holds: the sum, added up as the samples of a tile are. */
    float emission[3], direct[3], indirect[3], radiance[3];
    float stored[3]; /* what a tile holds of it: radiance, without what light fields light through
                        the lens */
    bool rejected;   /* it was not finite, and counts as nothing */
};

/* The functions below record the steps as path_*.c take them. They are cold, since no picture is
 * rendered with a record. */
#define PATH_RECORD_COLD __attribute__((cold))

/* Begins a new vertex: the packet's ray came back. */
PATH_RECORD_COLD void path_record_arrive(const struct path_context *c, const struct path_packet *p,
                                         const struct path_vertex *v);
PATH_RECORD_COLD void path_record_meet(const struct path_context *c, const struct path_packet *p,
                                       uint32_t light, const float radiance[3], float weight);
/* Records the resolved surface. */
PATH_RECORD_COLD void path_record_surface(const struct path_context *c,
                                          const struct path_vertex *v);
/* Records that the light of light fields was left out. */
PATH_RECORD_COLD void path_record_leave(const struct path_context *c, const struct path_packet *p,
                                        const struct path_vertex *v);
/* Records the roulette of what light fields leave, played with the chance `stays`. */
PATH_RECORD_COLD void path_record_thin(const struct path_context *c, const struct path_packet *p,
                                       const struct path_vertex *v, float stays);
/* Records a light sample before its ray is traced; `all` is the reflected radiance. A choice of
 * nothing, UINT32_MAX, is no sample. */
PATH_RECORD_COLD void path_record_light(const struct path_context *c, const struct path_vertex *v,
                                        uint32_t light, float probability,
                                        const struct light_packet *l, const float all[3]);
/* Records the result of the last light sample's ray. */
PATH_RECORD_COLD void path_record_shadow(const struct path_context *c, const struct path_packet *p,
                                         const struct light_packet *l);
/* Records the next direction; the record adds what the lobes and the roulette did. */
PATH_RECORD_COLD void path_record_scatter(const struct path_context *c, const struct path_packet *p,
                                          const struct path_vertex *v,
                                          const struct path_record_scatter *scatter);
