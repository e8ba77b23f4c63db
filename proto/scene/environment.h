#pragma once
/* The environment blob, which shearwater-import makes of an .hdr or .exr map and workers sample.
 * It is flat, little-endian and can be mapped: a header of 64 bytes precedes rows of RGB floats
 * from the top, which are finite and not negative; behind them stand sentences of what was wrong
 * with the file. A plan needs the header alone. */
#include <stddef.h>
#include <stdint.h>

#include "proto/error.h"

#define ENVIRONMENT_MAGIC   "SWENVIR"
#define ENVIRONMENT_VERSION 2u

/* It was a PNG, JPEG or WebP file, taken as sRGB: a backplate (job_composite.h) that is no map of
 * light. */
enum { ENVIRONMENT_IS_PHOTOGRAPH = 1u };

struct environment_header {
    char magic[8]; /* "SWENVIR\0" */
    uint32_t version;
    uint32_t width_px, height_px;
    float mean[3];          /* over the sphere (weighted by solid angle) */
    float maximum[3];       /* of any texel, by channel */
    uint32_t flags;         /* ENVIRONMENT_IS_PHOTOGRAPH */
    uint32_t warning_bytes; /* of the sentences, NUL-terminated, one after the other */
    uint32_t reserved[3];
};
_Static_assert(sizeof(struct environment_header) == 64, "texels stand at 64");

struct environment_blob {
    const void *blob;
    size_t blob_bytes;
    const struct environment_header *header;
    const float *texels;  /* 3 * width * height */
    const char *warnings; /* warning_bytes of the header; the last is NUL */
};

/* Checks the header and every texel. `blob` must be aligned to 64 bytes and outlive *out.
 * ERR_MAGIC, ERR_VERSION, ERR_LIMIT, ERR_TRUNCATED, ERR_TRAILING, ERR_NOT_FINITE, ERR_RANGE; *fault
 * names the texel. */
int environment_open(const void *blob, size_t size_bytes, struct environment_blob *out,
                     struct fault *fault);

/* Maps a file read-only and opens it; environment_unmap undoes it. */
int environment_map(const char *path, struct environment_blob *out, struct fault *fault);
void environment_unmap(struct environment_blob *e);

/* Fills in the header of a new blob. It checks sides and texels as environment_open does.
 * ERR_LIMIT, ERR_NOT_FINITE, ERR_RANGE. */
int environment_describe(uint32_t width_px, uint32_t height_px, const float *texels,
                         struct environment_header *out, struct fault *fault);

/* Returns 1 - cos of the angle from +y to the upper edge of row `row` (0 .. height_px). The bits
 * are the same on every CPU. A texel of row y covers 2 pi / width_px * (edge(y + 1) - edge(y)). */
double environment_edge(uint32_t row, uint32_t height_px);
