#pragma once
/* Reads and writes OpenEXR files through the C core API. Written files have one part of scan lines.
 */
#include "proto/exr_codec.h"
#include "proto/plan.h"
#include "server/image/image.h"

struct exr_mattes;

struct exr_metadata {
    const char *job, *build; /* attributes shearwater:job, shearwater:build; NULL: left out */
    uint64_t seed;
    uint32_t spp;
    int32_t frame;
    double fps;                /* of a sequence; 0: left out */
    struct plan_camera camera; /* where has_camera */
    bool has_camera;
    enum exr_codec codec;
    bool half; /* store all channels but depth, ids and samples as half floats, clamped */
    struct exr_mattes *mattes; /* of layers of ids; NULL: none */
    const char *denoiser;      /* shearwater:denoiser, a name and version; static; NULL: left out */
};

/* Writes a whole file at `path`, replacing it. The call blocks. ERR_IO with the reason in *fault.
 */
int exr_write(const char *path, const struct image *image, const struct exr_metadata *metadata,
              struct fault *fault);

/* Writes the same file, to the byte, from the top while the image forms. Rows that are written may
 * change no more. Image and metadata are borrowed until finish or abort. One thread at a time. */
struct exr_rows;
int exr_rows_begin(const char *path, const struct image *image, const struct exr_metadata *metadata,
                   struct exr_rows **out, struct fault *fault);
/* Writes rows before `end`, as far as they fill whole chunks of the file. After an error only abort
 * may be called. */
int exr_rows_write(struct exr_rows *rows, int32_t end, struct fault *fault);
/* Writes the remaining rows and names the file. Frees and nulls, also on an error, which leaves no
 * file. */
int exr_rows_finish(struct exr_rows **rows, struct fault *fault);
/* Frees and nulls a writer, and removes its file. NULL is ignored. */
void exr_rows_abort(struct exr_rows **rows);

/* Reads a flat scan-line or tiled file of half, float or uint channels, any compression, the data
 * window as the image. The caller owns it. ERR_NOT_FOUND, ERR_IO,
 * ERR_CORRUPT, ERR_LIMIT, and ERR_UNSUPPORTED for several parts, deep or subsampled channels. */
int exr_read(const char *path, struct image **out, struct fault *fault);

/* What to read of an untrusted file. */
struct exr_selection {
    const char *const *channels; /* read if the file has them; others are skipped */
    uint32_t channel_count;
    int64_t pixels_max; /* checked before memory is touched: ERR_LIMIT */
    bool whole;         /* the data window must be the display window: else ERR_UNSUPPORTED */
};

/* Reads a file in memory, which faults call `name`; DWA compression is refused. ERR_MISSING if it
 * has none of the channels. */
int exr_read_memory(const void *data, size_t size_bytes, const char *name,
                    const struct exr_selection *selection, struct image **out, struct fault *fault);
