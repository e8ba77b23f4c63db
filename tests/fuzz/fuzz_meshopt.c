// sources: server/import/[!m]*.c server/import/*/*.c server/import/*/*.cc
// sources: server/image/exr_file.c server/image/exr_read.c server/image/image.c
// libs: -lassimp -lOpenEXRCore-3_1 -lpng -lturbojpeg -lwebp -lmeshoptimizer -ldraco -lstdc++
/* Buffer views of EXT_meshopt_compression. Input: a byte each for mode, filter, stride and a third
 * of the count, then the stream. Whatever they are, a fault that says why, or as many bytes as were
 * counted; the address sanitizer watches. */
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/gltf/gltf.h"

#define HEAD_BYTES 4

static json_t *view_of(const uint8_t head[HEAD_BYTES], size_t size_bytes)
{
    static const char *const modes[] = {"ATTRIBUTES", "TRIANGLES", "INDICES"};
    static const char *const filters[] = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};
    return json_pack("{s:{s:{s:i, s:I, s:i, s:i, s:s, s:s}}}", "extensions",
                     "EXT_meshopt_compression", "buffer", 0, "byteLength", (json_int_t)size_bytes,
                     "byteStride", head[2], "count", 3 * head[3], "mode", modes[head[0] % 3],
                     "filter", filters[head[1] % 4]);
}

static void open_view(struct gltf *g, const json_t *view, size_t promised)
{
    struct gltf_view out = {0};
    struct fault fault = {0};
    uint8_t *bytes = NULL;
    bool compressed;
    const int error =
        gltf_meshopt_open(g, view, "bufferViews[0]", &bytes, &out, &compressed, &fault);
    if (!compressed || (error && (fault.code != error || fault.detail[0] == '\0' || bytes)))
        abort();
    if (!error && (out.data != bytes || out.size_bytes != promised)) abort();
    free(bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    struct fault fault = {0};
    if (size_bytes <= HEAD_BYTES) return 0;
    const size_t length = size_bytes - HEAD_BYTES;
    uint8_t *exact = malloc(length);
    if (!exact) abort();
    memcpy(exact, data + HEAD_BYTES, length);
    json_t *view = view_of(data, length);
    struct gltf g = {.bin = exact, .bin_bytes = length};
    g.root = json_pack("{s:[{s:I}]}", "buffers", "byteLength", (json_int_t)length);
    if (!view || !g.root || gltf_buffers_init(&g, &fault) != 0) abort();
    open_view(&g, view, (size_t)3 * data[3] * data[2]);
    gltf_buffers_fini(&g);
    json_decref(g.root);
    json_decref(view);
    free(exact);
    return 0;
}
