#pragma once
/* A file being read, for exr_read.c and what reads whole files. */
#include "server/image/exr.h"
#include "server/image/exr_file.h"

struct exr_reader {
    const char *path;
    const struct exr_selection *selection; /* NULL: everything */
    struct fault *fault;
    /* Fills the image, which has all channels of the file; NULL: DWA is refused. */
    int (*read_dwa)(struct exr_reader *r);
    struct exr_file file;
    exr_context_t context;
    exr_decode_pipeline_t decoder;
    bool decoding; /* decoder is initialised */
    exr_attr_box2i_t window;
    struct image *image;
    float *sink; /* a row, for channels that are passed over */
};

/* Reads the file. An error may leave an image, which the caller frees, too. */
int exr_reader_run(struct exr_reader *r);
