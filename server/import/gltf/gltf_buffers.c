/* Buffers: files, base64 data and the GLB's chunk, each loaded at its first use. */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/gltf/gltf.h"

struct gltf_buffer {
    bool loaded;
    struct gltf_payload payload; /* what the bytes came from; empty for the GLB's chunk */
    const uint8_t *data;
    size_t size_bytes;
};

int gltf_buffers_init(struct gltf *g, struct fault *fault)
{
    g->buffer_count = gltf_count(g->root, "buffers");
    g->buffers = calloc(g->buffer_count + 1, sizeof *g->buffers);
    g->view_count = gltf_count(g->root, "bufferViews");
    g->decoded_views = calloc(g->view_count + 1, sizeof *g->decoded_views);
    if (g->buffers != NULL && g->decoded_views != NULL) return 0;
    return fault_set(fault, ERR_MEMORY, "buffers", "no memory for %zu buffers", g->buffer_count);
}

void gltf_buffers_fini(struct gltf *g)
{
    for (size_t i = 0; g->buffers != NULL && i < g->buffer_count; i++)
        gltf_payload_free(&g->buffers[i].payload);
    free(g->buffers);
    g->buffers = NULL;
    for (size_t i = 0; g->decoded_views != NULL && i < g->view_count; i++)
        free(g->decoded_views[i]);
    free(g->decoded_views);
    g->decoded_views = NULL;
}

static int base64_value(char c)
{
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+' || c == '-') return 62;
    if (c == '/' || c == '_') return 63;
    return -1;
}

/* Decodes `text` into out, which has room for 3/4 of it. False for characters out of place. */
static bool decode_base64(const char *text, uint8_t *out, size_t *size_bytes)
{
    uint32_t bits = 0;
    unsigned held = 0;
    size_t n = 0;
    for (; *text != 0 && *text != '='; text++) {
        int value = base64_value(*text);
        if (value < 0) return false;
        bits = bits << 6 | (uint32_t)value;
        held += 6;
        if (held < 8) continue;
        held -= 8;
        out[n++] = (uint8_t)(bits >> held);
    }
    *size_bytes = n;
    return strspn(text, "=") == strlen(text) && held < 6;
}

static int decode_data_uri(const char *uri, const char *place, struct gltf_payload *out,
                           struct fault *fault)
{
    const char *text = strstr(uri, ";base64,");
    const char *comma = strchr(uri, ',');
    if (text == NULL || comma == NULL || comma < text)
        return fault_set(fault, ERR_UNSUPPORTED, place, "a data URI must be base64");
    text += strlen(";base64,");
    out->decoded = malloc(strlen(text) / 4 * 3 + 4);
    if (out->decoded == NULL)
        return fault_set(fault, ERR_MEMORY, place, "no memory for %zu characters", strlen(text));
    out->view.data = out->decoded;
    if (decode_base64(text, out->decoded, &out->view.size_bytes)) return 0;
    gltf_payload_free(out);
    return fault_set(fault, ERR_SYNTAX, place, "the data URI is not base64");
}

int gltf_payload_load(struct gltf *g, const char *uri, const char *place, struct gltf_payload *out,
                      struct fault *fault)
{
    *out = (struct gltf_payload){{(const uint8_t *)"", 0}, NULL};
    if (strncmp(uri, "data:", 5) == 0) return decode_data_uri(uri, place, out, fault);
    char path[LIMIT_PATH_BYTES];
    int rc = files_resolve(g->name, uri, true, path, place, fault);
    if (rc == 0) rc = files_map(g->files, path, place, &out->view, fault);
    return rc;
}

void gltf_payload_free(struct gltf_payload *payload)
{
    if (payload->decoded != NULL)
        free(payload->decoded);
    else if (payload->view.data != NULL)
        files_unmap(&payload->view);
    *payload = (struct gltf_payload){{(const uint8_t *)"", 0}, NULL};
}

/* Finds a buffer's bytes; what is beyond byteLength is not the buffer's. */
static int load_buffer(struct gltf *g, uint32_t index, struct fault *fault)
{
    struct gltf_buffer *buffer = &g->buffers[index];
    const json_t *json;
    gltf_place place, uri_place;
    const char *uri;
    uint64_t wanted = UINT64_MAX;
    int rc = gltf_item(g->root, "buffers", index, &json, place, fault);
    if (rc == 0) rc = gltf_text(json, place, "uri", &uri, fault);
    if (rc == 0) rc = gltf_integer(json, place, "byteLength", LIMIT_ASSET_BYTES, &wanted, fault);
    if (rc != 0) return rc;
    gltf_place_set(uri_place, "%s.uri", place);
    if (wanted == UINT64_MAX)
        return fault_set(fault, ERR_MISSING, place, "the buffer has no byteLength");
    if (uri != NULL) {
        rc = gltf_payload_load(g, uri, uri_place, &buffer->payload, fault);
        if (rc != 0) return rc;
        buffer->data = buffer->payload.view.data;
        buffer->size_bytes = buffer->payload.view.size_bytes;
    } else if (index == 0 && g->bin != NULL) {
        buffer->data = g->bin;
        buffer->size_bytes = g->bin_bytes;
    } else {
        return fault_set(fault, ERR_MISSING, uri_place, "the buffer has no bytes");
    }
    if (buffer->size_bytes < wanted) {
        gltf_payload_free(&buffer->payload); /* the next frame asks for it again */
        return fault_set(fault, ERR_TRUNCATED, place, "of %" PRIu64 " bytes only %zu are there",
                         wanted, buffer->size_bytes);
    }
    buffer->size_bytes = (size_t)wanted;
    buffer->loaded = true;
    return 0;
}

int gltf_range_open(struct gltf *g, const json_t *json, const char *place, struct gltf_view *out,
                    struct fault *fault)
{
    uint32_t buffer = SCENE_NONE;
    uint64_t offset = 0, length = UINT64_MAX;
    int rc = gltf_index(json, place, "buffer", g->buffer_count, &buffer, fault);
    if (rc == 0) rc = gltf_integer(json, place, "byteOffset", LIMIT_ASSET_BYTES, &offset, fault);
    if (rc == 0) rc = gltf_integer(json, place, "byteLength", LIMIT_ASSET_BYTES, &length, fault);
    if (rc != 0) return rc;
    if (buffer == SCENE_NONE || length == UINT64_MAX)
        return fault_set(fault, ERR_MISSING, place, "a buffer view has a buffer and a byteLength");
    if (!g->buffers[buffer].loaded) rc = load_buffer(g, buffer, fault);
    if (rc != 0) return rc;
    size_t size_bytes = g->buffers[buffer].size_bytes;
    if (offset > size_bytes || length > size_bytes - offset)
        return fault_set(fault, ERR_TRUNCATED, place,
                         "bytes %" PRIu64 " to %" PRIu64 " are not all in a buffer of %zu", offset,
                         offset + length, size_bytes);
    *out = (struct gltf_view){g->buffers[buffer].data + offset, (size_t)length, 0};
    return 0;
}

int gltf_view_open(struct gltf *g, uint32_t index, struct gltf_view *out, struct fault *fault)
{
    const json_t *json;
    gltf_place place;
    uint64_t stride = 0;
    bool compressed;
    int rc = gltf_item(g->root, "bufferViews", index, &json, place, fault);
    if (rc == 0)
        rc = gltf_meshopt_open(g, json, place, &g->decoded_views[index], out, &compressed, fault);
    if (rc != 0 || compressed) return rc;
    rc = gltf_integer(json, place, "byteStride", 252, &stride, fault);
    if (rc == 0) rc = gltf_range_open(g, json, place, out, fault);
    out->stride_bytes = (size_t)stride;
    return rc;
}
