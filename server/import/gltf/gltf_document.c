/* The container (GLB chunks or plain JSON), the version, and the extensions. */
#include <string.h>

#include "proto/json.h"
#include "server/import/gltf/gltf.h"

#define GLB_HEADER_BYTES   12u
#define CHUNK_HEADER_BYTES 8u
#define CHUNK_JSON         0x4e4f534au
#define CHUNK_BIN          0x004e4942u

static const char *const supported[] = {
    "EXT_mesh_gpu_instancing",    "KHR_materials_clearcoat",
    "KHR_materials_sheen",        "KHR_materials_diffuse_transmission",
    "KHR_materials_iridescence",  "KHR_materials_dispersion",
    "KHR_draco_mesh_compression", "EXT_meshopt_compression",
    "EXT_texture_webp",           "KHR_materials_variants",
    "KHR_node_visibility",        "KHR_lights_punctual",
    "KHR_materials_anisotropy",   "KHR_materials_emissive_strength",
    "KHR_materials_ior",          "KHR_materials_specular",
    "KHR_materials_transmission", "KHR_materials_unlit",
    "KHR_materials_volume",       "KHR_mesh_quantization",
    "KHR_texture_transform",      "KHR_animation_pointer",
};

/* Known to change nothing in a still picture. */
static const char *const harmless[] = {
    "KHR_xmp",
    "KHR_xmp_json_ld",
};

static uint32_t read_u32(const uint8_t *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

struct chunk {
    uint32_t type;
    const uint8_t *data;
    size_t size_bytes;
};

/* Takes the chunk at *at and moves on. */
static int next_chunk(const uint8_t **at, const uint8_t *end, struct chunk *out,
                      struct fault *fault)
{
    size_t left = (size_t)(end - *at);
    if (left < CHUNK_HEADER_BYTES)
        return fault_set(fault, ERR_TRUNCATED, "glb", "%zu bytes are no chunk header", left);
    *out = (struct chunk){read_u32(*at + 4), *at + CHUNK_HEADER_BYTES, read_u32(*at)};
    if (out->size_bytes > left - CHUNK_HEADER_BYTES)
        return fault_set(fault, ERR_TRUNCATED, "glb", "a chunk of %zu bytes has only %zu",
                         out->size_bytes, left - CHUNK_HEADER_BYTES);
    *at = out->data + out->size_bytes;
    return 0;
}

/* Splits a GLB into its JSON and binary chunks; others are skipped, as the format asks. */
static int split_glb(struct gltf *g, const struct file_view *main, struct chunk *json,
                     struct fault *fault)
{
    if (main->size_bytes < GLB_HEADER_BYTES)
        return fault_set(fault, ERR_TRUNCATED, "glb", "%zu bytes are no GLB header",
                         main->size_bytes);
    uint32_t version = read_u32(main->data + 4);
    size_t size_bytes = read_u32(main->data + 8);
    if (version != 2)
        return fault_set(fault, ERR_VERSION, "glb", "container version %u is not 2", version);
    if (size_bytes > main->size_bytes)
        return fault_set(fault, ERR_TRUNCATED, "glb", "of %zu bytes only %zu are there", size_bytes,
                         main->size_bytes);
    if (size_bytes < GLB_HEADER_BYTES)
        return fault_set(fault, ERR_RANGE, "glb", "%zu bytes are shorter than the header",
                         size_bytes);
    const uint8_t *at = main->data + GLB_HEADER_BYTES, *end = main->data + size_bytes;
    int rc = next_chunk(&at, end, json, fault);
    if (rc != 0) return rc;
    if (json->type != CHUNK_JSON)
        return fault_set(fault, ERR_SYNTAX, "glb", "the first chunk is not JSON");
    for (bool second = true; rc == 0 && at < end; second = false) {
        struct chunk chunk = {0};
        rc = next_chunk(&at, end, &chunk, fault);
        if (rc != 0 || chunk.type != CHUNK_BIN) continue;
        if (!second)
            return fault_set(fault, ERR_SYNTAX, "glb", "the binary chunk is not the second");
        g->bin = chunk.data;
        g->bin_bytes = chunk.size_bytes;
    }
    return rc;
}

size_t gltf_text_start(const struct file_view *file)
{
    size_t i = 0;
    while (i < file->size_bytes && (file->data[i] == ' ' || file->data[i] == '\t' ||
                                    file->data[i] == '\r' || file->data[i] == '\n'))
        i++;
    return i;
}

static int check_begins_as_json(const struct file_view *main, struct fault *fault)
{
    size_t i = gltf_text_start(main);
    if (i == main->size_bytes) return fault_set(fault, ERR_TRUNCATED, "", "the file is empty");
    if (main->data[i] == '{') return 0;
    return fault_set(fault, ERR_MAGIC, "", "the file is neither a GLB nor JSON");
}

static int check_version(const json_t *root, struct fault *fault)
{
    const json_t *asset;
    const char *version = NULL, *least = NULL;
    int rc = gltf_object(root, "", "asset", &asset, fault);
    if (rc == 0 && asset == NULL)
        return fault_set(fault, ERR_MISSING, "asset", "a glTF file says its version here");
    if (rc == 0) rc = gltf_text(asset, "asset", "version", &version, fault);
    if (rc == 0) rc = gltf_text(asset, "asset", "minVersion", &least, fault);
    if (rc != 0) return rc;
    if (version == NULL)
        return fault_set(fault, ERR_MISSING, "asset.version", "a glTF file says its version here");
    if (strncmp(version, "2.", 2) != 0)
        return fault_set(fault, ERR_VERSION, "asset.version", "\"%.40s\" is not 2.x", version);
    if (least != NULL && strcmp(least, "2.0") != 0)
        return fault_set(fault, ERR_VERSION, "asset.minVersion", "\"%.40s\" is not 2.0", least);
    return 0;
}

static bool is_listed(const char *name, const char *const *list, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (strcmp(list[i], name) == 0) return true;
    return false;
}

const char *gltf_extension_advice(const char *name)
{
    if (strcmp(name, "KHR_texture_basisu") == 0)
        return ": its images are KTX2; write them as PNG, JPEG or WebP (for instance with "
               "gltf-transform ktxdecompress)";
    return "";
}

/* Calls for each string of root[key]. Elements of other types are faults. */
static int check_names(struct gltf *g, const char *key, bool required, struct fault *fault)
{
    const json_t *names;
    int rc = gltf_array(g->root, "", key, &names, fault);
    for (size_t i = 0; rc == 0 && i < json_array_size(names); i++) {
        const char *name = json_string_value(json_array_get(names, i));
        gltf_place place;
        gltf_place_set(place, "%s[%zu]", key, i);
        if (name == NULL)
            rc = fault_set(fault, ERR_TYPE, place, "it is not a string");
        else if (is_listed(name, supported, sizeof supported / sizeof *supported))
            continue;
        else if (required)
            rc = fault_set(fault, ERR_UNSUPPORTED, place,
                           "the scene requires the extension %.100s, which is not supported%s",
                           name, gltf_extension_advice(name));
        else if (!is_listed(name, harmless, sizeof harmless / sizeof *harmless))
            warnings_add(&g->builder->warnings, "", "the extension %.100s is ignored", name);
    }
    return rc;
}

/* Every top-level array must be one, so that gltf_count may be trusted. */
static int check_arrays(const json_t *root, struct fault *fault)
{
    static const char *const keys[] = {
        "accessors", "animations", "bufferViews", "buffers", "cameras", "images",  "materials",
        "meshes",    "nodes",      "samplers",    "scenes",  "skins",   "textures"};
    int rc = 0;
    for (size_t i = 0; rc == 0 && i < sizeof keys / sizeof *keys; i++) {
        const json_t *array;
        rc = gltf_array(root, "", keys[i], &array, fault);
        if (rc == 0 && json_array_size(array) > LIMIT_INSTANCES)
            rc =
                fault_set(fault, ERR_LIMIT, keys[i], "it has %zu elements", json_array_size(array));
    }
    return rc;
}

int gltf_document_read(struct gltf *g, const struct file_view *main, struct fault *fault)
{
    struct chunk json = {CHUNK_JSON, main->data, main->size_bytes};
    int rc = 0;
    if (main->size_bytes >= 4 && memcmp(main->data, "glTF", 4) == 0)
        rc = split_glb(g, main, &json, fault);
    else
        rc = check_begins_as_json(main, fault);
    if (rc != 0) return rc;
    rc = json_read((const char *)json.data, json.size_bytes, LIMIT_SCENE_JSON_BYTES, &g->root,
                   fault);
    if (rc != 0) return rc;
    if (!json_is_object(g->root))
        return fault_set(fault, ERR_TYPE, "", "the document is not an object");
    rc = check_version(g->root, fault);
    if (rc == 0) rc = check_names(g, "extensionsRequired", true, fault);
    if (rc == 0) rc = check_names(g, "extensionsUsed", false, fault);
    if (rc == 0) rc = check_arrays(g->root, fault);
    return rc;
}
