/* Radiance pictures: whatever the bytes, a fault or a panorama that a blob may hold after its
 * repair; the address sanitizer watches. */
// sources: server/import/image/panorama.c server/import/image/panorama_radiance.c
// sources: server/import/scene/warnings.c
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/image/panorama.h"

/* Fuzzing is for the rows, not for filling memory. */
#define PIXELS_MAX 1000000u

static void check(struct panorama *p, struct warnings *warnings)
{
    struct environment_header header;
    struct fault fault = {0};
    panorama_repair(p, warnings);
    if (environment_describe(p->width_px, p->height_px, p->texels, &header, &fault)) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    static struct warnings warnings;
    struct panorama p = {0};
    struct fault fault = {0};
    uint8_t *exact = malloc(size_bytes + (size_bytes == 0));
    if (!exact) abort();
    memcpy(exact, data, size_bytes);
    memset(&warnings, 0, sizeof warnings);
    const struct file_view file = {exact, size_bytes};
    const int error = panorama_read_radiance(&file, "map.hdr", &p, &warnings, &fault);
    if (error && (fault.code != error || fault.detail[0] == '\0' || p.texels)) abort();
    if (!error && (uint64_t)p.width_px * p.height_px <= PIXELS_MAX) check(&p, &warnings);
    panorama_destroy(&p);
    free(exact);
    return 0;
}
