/* The environment blob. What opens is walked as a worker would: every texel, and the header's mean
 * and maximum are held against them; the address sanitizer watches. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "proto/scene/environment.h"

static void walk(const struct environment_blob *e)
{
    struct environment_header made;
    struct fault fault = {0};
    const struct environment_header *h = e->header;
    if (environment_describe(h->width_px, h->height_px, e->texels, &made, &fault)) abort();
    for (int c = 0; c < 3; c++)
        if (!(made.maximum[c] >= h->maximum[c] && made.maximum[c] <= h->maximum[c]) ||
            !(h->mean[c] >= 0.0f && h->mean[c] <= h->maximum[c]))
            abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    struct environment_blob e;
    struct fault fault = {0};
    void *blob;
    if (posix_memalign(&blob, 64, size_bytes + (size_bytes == 0))) abort();
    memcpy(blob, data, size_bytes);
    const int error = environment_open(blob, size_bytes, &e, &fault);
    if (error && (fault.code != error || fault.detail[0] == '\0')) abort();
    if (!error) walk(&e);
    free(blob);
    return 0;
}
