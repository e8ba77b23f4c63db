/* EXT_meshopt_compression: buffer views that are compressed. Each is decoded at its first use. */
#include <inttypes.h>
#include <meshoptimizer.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/gltf/gltf.h"

#define STRIDE_MAX 256u /* of attributes, as the extension has it */

enum mode { MODE_ATTRIBUTES, MODE_TRIANGLES, MODE_INDICES, MODES };
static const char *const mode_names[MODES] = {"ATTRIBUTES", "TRIANGLES", "INDICES"};

enum filter { FILTER_NONE, FILTER_OCTAHEDRAL, FILTER_QUATERNION, FILTER_EXPONENTIAL, FILTERS };
static const char *const filter_names[FILTERS] = {"NONE", "OCTAHEDRAL", "QUATERNION",
                                                  "EXPONENTIAL"};

struct stream {
    struct gltf_view encoded;
    uint32_t mode, filter;
    uint64_t count, stride_bytes;
};

/* The place of a word in a list. */
static int read_word(const json_t *json, const char *place, const char *key,
                     const char *const *words, uint32_t count, uint32_t *out, struct fault *fault)
{
    const char *word = NULL;
    gltf_place at;
    int rc = gltf_text(json, place, key, &word, fault);
    *out = 0;
    if (rc != 0 || word == NULL) return rc;
    for (uint32_t i = 0; i < count; i++) {
        *out = i;
        if (strcmp(words[i], word) == 0) return 0;
    }
    gltf_place_set(at, "%s.%s", place, key);
    return fault_set(fault, ERR_RANGE, at, "\"%.40s\" does not exist", word);
}

/* Checks what the decoder takes for granted. */
static int check(const struct stream *s, const char *place, struct fault *fault)
{
    const uint64_t stride = s->stride_bytes;
    const bool indices = s->mode != MODE_ATTRIBUTES;
    if (indices ? stride != 2 && stride != 4
                : stride == 0 || stride % 4 != 0 || stride > STRIDE_MAX)
        return fault_set(fault, ERR_RANGE, place, "a byteStride of %" PRIu64 " does not exist here",
                         stride);
    if (s->count == 0 || s->count * stride > LIMIT_ASSET_BYTES)
        return fault_set(fault, ERR_LIMIT, place,
                         "%" PRIu64 " elements of %" PRIu64 " bytes are none or too many", s->count,
                         stride);
    if (s->mode == MODE_TRIANGLES && s->count % 3 != 0)
        return fault_set(fault, ERR_RANGE, place, "%" PRIu64 " indices are no triangles", s->count);
    if (indices && s->filter != FILTER_NONE)
        return fault_set(fault, ERR_RANGE, place, "indices have no filter");
    if ((s->filter == FILTER_QUATERNION && stride != 8) ||
        (s->filter == FILTER_OCTAHEDRAL && stride != 4 && stride != 8))
        return fault_set(fault, ERR_RANGE, place, "its filter does not work on %" PRIu64 " bytes",
                         stride);
    return 0;
}

static int read_stream(struct gltf *g, const json_t *json, const char *place, struct stream *out,
                       struct fault *fault)
{
    out->count = out->stride_bytes = 0;
    int rc = gltf_range_open(g, json, place, &out->encoded, fault);
    if (rc == 0) rc = gltf_integer(json, place, "count", LIMIT_ASSET_BYTES, &out->count, fault);
    if (rc == 0)
        rc = gltf_integer(json, place, "byteStride", STRIDE_MAX, &out->stride_bytes, fault);
    if (rc == 0) rc = read_word(json, place, "mode", mode_names, MODES, &out->mode, fault);
    if (rc == 0) rc = read_word(json, place, "filter", filter_names, FILTERS, &out->filter, fault);
    return rc == 0 ? check(out, place, fault) : rc;
}

static bool decode(const struct stream *s, uint8_t *out)
{
    const uint8_t *data = s->encoded.data;
    const size_t size_bytes = s->encoded.size_bytes, count = s->count, stride = s->stride_bytes;
    int failed;
    if (s->mode == MODE_ATTRIBUTES)
        failed = meshopt_decodeVertexBuffer(out, count, stride, data, size_bytes);
    else if (s->mode == MODE_TRIANGLES)
        failed = meshopt_decodeIndexBuffer(out, count, stride, data, size_bytes);
    else
        failed = meshopt_decodeIndexSequence(out, count, stride, data, size_bytes);
    if (failed != 0) return false;
    if (s->filter == FILTER_OCTAHEDRAL) meshopt_decodeFilterOct(out, count, stride);
    if (s->filter == FILTER_QUATERNION) meshopt_decodeFilterQuat(out, count, stride);
    if (s->filter == FILTER_EXPONENTIAL) meshopt_decodeFilterExp(out, count, stride);
    return true;
}

int gltf_meshopt_open(struct gltf *g, const json_t *json, const char *place, uint8_t **cache,
                      struct gltf_view *out, bool *compressed, struct fault *fault)
{
    const json_t *extension;
    gltf_place at;
    struct stream s;
    int rc = gltf_extension(json, place, "EXT_meshopt_compression", &extension, at, fault);
    *compressed = extension != NULL;
    if (rc != 0 || extension == NULL) return rc;
    rc = read_stream(g, extension, at, &s, fault);
    if (rc != 0) return rc;
    const size_t size_bytes = (size_t)(s.count * s.stride_bytes);
    if (*cache == NULL) {
        /* Filters work in steps of sixteen bytes at most. */
        uint8_t *decoded = calloc(size_bytes + 64, 1);
        if (decoded == NULL)
            return fault_set(fault, ERR_MEMORY, at, "no memory for %zu bytes", size_bytes);
        if (!decode(&s, decoded)) {
            free(decoded);
            return fault_set(fault, ERR_CORRUPT, at, "the compressed bytes are damaged");
        }
        *cache = decoded;
    }
    const size_t stride = s.mode == MODE_ATTRIBUTES ? (size_t)s.stride_bytes : 0;
    *out = (struct gltf_view){*cache, size_bytes, stride};
    return 0;
}
