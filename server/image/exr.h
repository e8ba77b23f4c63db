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
