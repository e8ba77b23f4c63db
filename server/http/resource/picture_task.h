#pragma once
/* Encodes a picture on the pool, from a copy of planes or from a stored EXR. */
#include "server/http/etag.h"
#include "server/http/request.h"
#include "server/image/png_shade.h"

enum picture_form {
    PICTURE_PNG,
    PICTURE_EXR,
    PICTURE_FEED, /* the pixel feed of a stored EXR */
};

/* Either image (borrowed for the call) or exr is set. */
struct picture_source {
    const struct image *image;
    const struct exr_metadata *metadata; /* may be NULL */
    const struct digest *exr;
    const char *layer;
    const struct objects *objects;
};

struct picture_task {
    struct pool_task task;
    struct request *request;
    enum picture_form form;
    struct image *image; /* owned; read from exr_path when NULL */
    char exr_path[OBJECTS_PATH_BYTES];
    char layer[32];
    struct png_options png_options;
    bool so_far; /* it will change, and must not be cached */
    char etag[ETAG_BYTES];
    struct exr_metadata metadata;
    char job[JOB_ID_BYTES], build[LIMIT_NAME_BYTES]; /* what metadata points to */
    const struct objects *objects;                   /* where an EXR is written for a moment */
    /* What came of it. */
    int error;
    uint8_t *png; /* owned */
    size_t png_bytes;
    int fd; /* of the written EXR; -1: none; owned */
    uint64_t fd_bytes;
};

/* Copies what it needs: for a PNG the layer's planes alone. NULL on failed allocation. The task
 * finds out whether the image lacks the layer. */
struct picture_task *picture_task_create(enum picture_form form,
                                         const struct picture_source *source);
void picture_task_destroy(struct picture_task **task);

/* Holds the request, runs on the pool, answers, and frees the task. */
void picture_task_start(struct picture_task *task, struct request *request);
