#pragma once
/* What a frame needs, decided once: which effects run, which planes travel, what is left out and
 * why.
 *
 * A pure function of the job and its scene; any thread. Everything that a person may ask about the
 * decision is in struct plan_report. */
#include <jansson.h>
#include <stdbool.h>

#include "proto/job.h"
#include "proto/plan.h"
#include "proto/scene.h"

/* Effects that a plan may run; bits. */
enum plan_effect {
    EFFECT_PRIMARY = 1u << 0,
    EFFECT_ANTIALIAS = 1u << 1,
    EFFECT_DIRECT = 1u << 2,
    EFFECT_SHADOWS = 1u << 3,
    EFFECT_INDIRECT = 1u << 4,
    EFFECT_EMISSION = 1u << 5,
};
#define EFFECT_COUNT 6

/* What is skipped ("plane reflector", "light /lights/2"), and why, as sentences. */
struct plan_skip {
    char what[64];
    char why[128];
};
#define PLAN_SKIPS (LIMIT_LIGHTS + 32)

struct plan_light_source {
    bool of_scene;  /* else of the job */
    uint32_t index; /* there */
    char name[64];  /* cut; "" for none */
};

struct plan_report {
    uint32_t effects;
    uint32_t layers; /* enum layer */
    enum filter_method method;
    uint32_t skip_count;
    struct plan_skip skipped[PLAN_SKIPS];
    uint32_t warning_count;
    char warnings[LIMIT_WARNINGS][LIMIT_DETAIL_BYTES];
    struct plan_light_source lights[LIMIT_LIGHTS]; /* of the plan's lights, in order */
    char camera_name[64];
    bool camera_is_default; /* the importer made it, because the file has none */
};

/* Plans one frame; frames of a job differ in plan->pattern.frame alone. ERR_LIMIT, ERR_NOT_FOUND,
 * ERR_RANGE with *fault pointing into the job document. */
int plan_make(const struct job *job, const struct scene *scene, const struct digest *blob,
              int32_t frame, struct plan *plan, struct plan_report *report, struct fault *fault);

/* {effects, layers, planes, light_planes, skipped: [{what, why}], lights, camera, samples, tiles,
 * warnings}. New reference; NULL on failed allocation. */
json_t *plan_report_json(const struct plan *plan, const struct plan_report *report);

/* Adds a line; what does not fit is dropped. */
void plan_skip(struct plan_report *report, const char *what, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void plan_warn(struct plan_report *report, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The parts of plan_make. */
int plan_resolve_camera(const struct job *job, const struct scene *scene, struct plan_camera *out,
                        struct plan_report *report, struct fault *fault);
int plan_gather_lights(const struct job *job, const struct scene *scene, struct plan *plan,
                       struct plan_report *report, struct fault *fault);
