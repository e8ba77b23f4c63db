#pragma once
/* shearwater-worker --replay: a sample's path, printed. */
#include <stdio.h>

#include "proto/plan.h"
#include "worker/process/options.h"
#include "worker/scene/render_scene.h"
#include "worker/trace/path/path_record.h"

/* What is printed, and all that it refers to. */
struct replay_sheet {
    const struct plan *plan;
    const struct scene *scene; /* for names */
    const char *isa;
    int32_t x, y;
    uint32_t sample;
    const struct path_record *record;
};

/* Reads the plan and its blobs, traces options->arguments, prints to `out`. *fault names what is
 * missing or wrong. */
int replay_print(const struct options *options, FILE *out, struct fault *fault);

/* Prints line by line, for people. */
void replay_print_text(const struct replay_sheet *sheet, FILE *out);

/* Prints one JSON document. Numbers have all their digits: read as floats they are those that were
 * traced. ERR_MEMORY, ERR_IO. */
int replay_print_json(const struct replay_sheet *sheet, FILE *out);

/* Return words for both. */
const char *replay_kind(const struct path_record *record);
const char *replay_model(const struct path_record_vertex *v);
/* Returns why a light sample needed no ray; "" for one that did. */
const char *replay_skip(const struct path_record_light *light);
/* Returns why the path ended at its last vertex. */
const char *replay_end(const struct replay_sheet *sheet);
/* Names of an instance (index + 1), of its mesh and of its material; "" for none. */
struct replay_names {
    const char *instance, *mesh, *material;
};
struct replay_names replay_names(const struct scene *scene, uint32_t instance);
/* Returns the scene's name for a light of the plan; "" for lights of the job. */
const char *replay_light_name(const struct plan *plan, const struct scene *scene, uint32_t light);
/* Returns the kind of a light: "rectangle", ...; "surface" and "environment" for what has no
 * number. */
const char *replay_light(const struct plan *plan, uint32_t light);
