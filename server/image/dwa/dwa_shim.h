#pragma once
/* DWA compression from C, by the C++ half of OpenEXR, as the C half of Debian 12 has none. No
 * exception leaves these functions. */
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum dwa_status { DWA_OK, DWA_DAMAGED, DWA_NO_MEMORY, DWA_NO_ROOM };

/* A channel of a picture. DWA loses something of those named R, G, B or Y, in whatever layer,
 * normals too; A is kept, and so is all else. */
struct dwa_channel {
    const char *name;
    int is_half;   /* else a float */
    int is_linear; /* for the eye: no light */
};

/* Compresses the rows of one chunk, at most 32. `packed` has row after row, and in each the
 * channels in the order of the array, which is that of their names. Writes at most `capacity`
 * bytes, and how many to *size_bytes. */
enum dwa_status dwa_shim_compress(const struct dwa_channel *channels, int count, int32_t width_px,
                                  int32_t rows, const uint8_t *packed, uint8_t *out,
                                  size_t capacity, size_t *size_bytes);

/* A channel of a file, and where its pixels go as floats. */
struct dwa_plane {
    const char *name;
    float *data;
    ptrdiff_t stride; /* floats from row to row */
};

/* Reads the named channels of an open file of one flat part. The planes must hold its data window:
 * the caller has looked. */
enum dwa_status dwa_shim_read(int fd, const struct dwa_plane *planes, int count);

#ifdef __cplusplus
}
#endif
