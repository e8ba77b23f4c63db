#pragma once
/* One of the two files of a picture, written from the top while the picture forms. Final rows are
 * encoded while others are still traced, so that little is left to do after the last. In the end
 * the file becomes an object under its digest. Calls block, are for the pool, and come one at a
 * time. */
#include "proto/job/job.h"
#include "server/image/exr.h"
#include "server/image/png_shade.h"
#include "server/store/objects.h"

struct exr_rows;
struct png_rows;

enum picture_file_kind { PICTURE_FILE_EXR, PICTURE_FILE_PNG, PICTURE_FILE_COUNT };

struct picture_file {
    enum picture_file_kind kind;
    const struct image *image;           /* borrowed, as all below */
    const struct exr_metadata *metadata; /* EXR */
    const char *layer;                   /* PNG: that people look at */
    struct png_options png_options;      /* of that layer */
    const struct objects *objects;
    struct exr_rows *exr; /* owned; begun and not finished; in `dir` */
    struct png_rows *png; /* owned; the same */
    char dir[OBJECTS_PATH_BYTES];
};

/* Returns how a job's PNG files show light. */
struct png_options picture_png_options(const struct job *job);

/* Writes rows before `end`, as far as they fill what is encoded at once. They may change no more.
 * After an error the file is gone, and can be begun again with all rows. */
int picture_file_write(struct picture_file *file, int32_t end, struct fault *fault);

/* Writes the remaining rows, which may be all, and stores the file, held (objects.h). An error has
 * the same effect as above. */
int picture_file_finish(struct picture_file *file, struct digest *out, struct fault *fault);

/* Drops a file that is begun, if any. */
void picture_file_drop(struct picture_file *file);
