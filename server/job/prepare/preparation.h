#pragma once
/* Prepares a job for tracing: its scene and its environment map are imported or found, mapped, and
 * planned. */
#include "server/image/plate.h"
#include "server/job/plan/plan.h"
#include "server/job/prepare/imports.h"
#include "server/job/prepare/scene_parts.h"
#include "server/job/prepare/shared_base.h"

struct preparation;

/* A finished preparation. Owned by its receiver; prepared_destroy frees it. */
struct prepared {
    struct job job;
    int32_t number;            /* of the frame whose time the scene has */
    bool moves;                /* other frames have other scenes */
    struct motion *motion;     /* held; for layers and windows; NULL: nothing moves */
    struct shared_base *base;  /* what the scene stands on; NULL: nothing */
    struct plate *plate;       /* held; the job's; NULL: none, or another frame has it */
    struct exr_mattes *mattes; /* held; of layers of ids; NULL: the job has none */
    struct plan plan;          /* of that frame; others differ in pattern.frame if nothing moves */
    struct plan_report report;
    /* Of a live job, which is planned again with each move; else zero. */
    struct scene scene;
    struct environment_blob map;
    struct environment_header studio; /* where the scene may need that light, else zero */
    struct digest studio_blob;
    struct scene_part *parts; /* owned; nodes that may be moved */
    uint32_t part_count;
    uint64_t import_cpu_us;
    uint64_t plan_cpu_us;
};

/* Tells the outcome. fault NULL: `prepared` is handed over. Else it is NULL. */
typedef void (*preparation_done)(void *ctx, const struct fault *fault, struct prepared *prepared);

/* Prepares the scene of a frame. A base that another frame stands on may be given, which has the
 * plate, too; NULL: none is known. The job is taken (left empty), also on failure. `done` comes
 * later, once. ERR_MEMORY. */
int preparation_start(struct imports *imports, struct thread_pool *pool,
                      const struct objects *objects, struct job *job, int32_t number,
                      struct shared_base *base, preparation_done done, void *ctx,
                      struct preparation **out);

/* Returns what plans of a live job are made from. It borrows the preparation's scene and map. */
struct plan_source prepared_source(const struct prepared *prepared);

/* Finds the light that the scene's importer estimated, or else the studio light if it may be
 * needed, places its blob and makes it the source's. `estimate` outlives the source. ERR_IO,
 * ERR_MEMORY, ... */
int prepared_find_light(struct prepared *prepared, const struct objects *objects,
                        const struct scene *scene, struct environment_header *estimate,
                        struct plan_source *source, struct fault *fault);

/* Cancels the preparation; `done` is not called. Nulls the pointer. */
void preparation_cancel(struct preparation **preparation);

void prepared_destroy(struct prepared **prepared);
