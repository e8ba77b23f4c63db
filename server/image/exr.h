#pragma once
/* OpenEXR files through the C core API. Scan-line, ZIP; one part. */
#include "server/image/image.h"

struct exr_metadata {
    const char *job, *build; /* attributes shearwater:job, shearwater:build; NULL: left out */
    uint64_t seed;
    uint32_t spp;
    int32_t frame;
    bool half; /* store all channels but depth, id and samples as half floats, clamped */
};

/* Writes a whole file at `path` (replacing it). Blocking. ERR_IO with *fault naming the reason. */
int exr_write(const char *path, const struct image *image, const struct exr_metadata *metadata,
              struct fault *fault);

/* The same file, to the byte, from the top while the image forms: rows that are written may change
 * no more, others may. Image and metadata are borrowed until finish or abort. One thread at a time.
 */
struct exr_rows;
int exr_rows_begin(const char *path, const struct image *image, const struct exr_metadata *metadata,
                   struct exr_rows **out, struct fault *fault);
/* Rows below `end`, as far as they fill whole chunks of the file. On an error only abort is left.
 */
int exr_rows_write(struct exr_rows *rows, int32_t end, struct fault *fault);
/* All that is left, and the file's name. Frees and nulls, also on an error: then no file is there.
 */
int exr_rows_finish(struct exr_rows **rows, struct fault *fault);
/* NULL: nothing to do. */
void exr_rows_abort(struct exr_rows **rows);

/* Reads a flat scan-line or tiled file of half, float or uint channels, any compression of the core
 * library (PIZ too), the data window as the image. Owned by the caller. ERR_NOT_FOUND, ERR_IO,
 * ERR_CORRUPT, ERR_LIMIT, and ERR_UNSUPPORTED for several parts, deep or subsampled channels. */
int exr_read(const char *path, struct image **out, struct fault *fault);

/* What of a file is wanted, for files of which little is known. */
struct exr_selection {
    const char *const *channels; /* those of them that the file has; others are passed over */
    uint32_t channel_count;
    int64_t pixels_max; /* checked before memory is touched: ERR_LIMIT */
    bool whole;         /* the data window must be the display window: else ERR_UNSUPPORTED */
};

/* The same from a file in memory, of which `name` stands in faults. ERR_MISSING when it has none of
 * the channels. */
int exr_read_memory(const void *data, size_t size_bytes, const char *name,
                    const struct exr_selection *selection, struct image **out, struct fault *fault);
