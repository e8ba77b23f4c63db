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
