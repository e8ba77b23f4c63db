#pragma once
/* An open glTF 2.0 document: the JSON, its buffers, and where the scene under construction goes.
 *
 * Everything is read from the JSON and the buffers directly rather than through assimp: a fault
 * must name its place, instances must stay instances, and what assimp drops or bends (emissive
 * strength, fields of view, light ranges, texture transforms, samplers) is most of a material. */
#include "server/import/fence/files.h"
#include "server/import/gltf/gltf_json.h"
#include "server/import/gltf/gltf_nodes.h"
#include "server/import/scene/builder.h"

struct gltf_buffer; /* gltf_buffers.c */
struct gltf_images; /* gltf_textures.c */

struct gltf {
    struct files *files;     /* borrowed */
    struct builder *builder; /* borrowed */
    const char *name;        /* borrowed; the main file's path beneath the root */
    json_t *root;            /* owned */
    const uint8_t *bin;      /* borrowed from the file; the GLB's binary chunk; NULL: none */
    size_t bin_bytes;
    struct gltf_buffer *buffers; /* owned; parallel to root["buffers"] */
    size_t buffer_count;
    struct gltf_images *images; /* owned */
    struct gltf_nodes nodes;
    uint32_t default_material; /* SCENE_NONE until a primitive without material needs it */
};

/* Imports a .glb or .gltf. `name` and `main` are borrowed for the time of the call. */
int gltf_import(struct files *files, const char *name, const struct file_view *main,
                struct builder *builder, struct fault *fault);

/* Where a file's text begins: the first byte that is no white space. */
size_t gltf_text_start(const struct file_view *file);

/* Container and JSON: sets root, bin. Refuses what is not version 2 and required extensions that
 * are not supported; warns of the others. */
int gltf_document_read(struct gltf *g, const struct file_view *main, struct fault *fault);

/* The bytes of a buffer view. *stride is 0 when the elements are packed. */
struct gltf_view {
    const uint8_t *data;
    size_t size_bytes;
    size_t stride_bytes;
};
int gltf_buffers_init(struct gltf *g, struct fault *fault);
void gltf_buffers_fini(struct gltf *g);
int gltf_view_open(struct gltf *g, uint32_t index, struct gltf_view *out, struct fault *fault);

/* Bytes behind a URI: base64 data, which the caller frees, or a mapped file. */
struct gltf_payload {
    struct file_view view;
    uint8_t *decoded; /* owned; NULL for a file */
};
int gltf_payload_load(struct gltf *g, const char *uri, const char *place, struct gltf_payload *out,
                      struct fault *fault);
void gltf_payload_free(struct gltf_payload *payload);

/* All materials, in the file's order, and the textures that they use. */
int gltf_materials_read(struct gltf *g, struct fault *fault);

/* The index of glTF's default material, appended at its first use. */
int gltf_default_material(struct gltf *g, uint32_t *out, struct fault *fault);

/* Reads a texture reference; *out keeps SCENE_NONE when it is absent or ignored. Registers the
 * image for gltf_images_decode. */
int gltf_texture_read(struct gltf *g, const json_t *of, const char *place, const char *key,
                      bool srgb, struct scene_texture_ref *out, const json_t **info,
                      struct fault *fault);
int gltf_textures_init(struct gltf *g, struct fault *fault);
void gltf_textures_fini(struct gltf *g);
int gltf_images_decode(struct gltf *g, struct fault *fault);

/* Geometry and where it stands. */
int gltf_meshes_read(struct gltf *g, struct fault *fault);

int gltf_lights_read(struct gltf *g, struct fault *fault);
int gltf_cameras_read(struct gltf *g, struct fault *fault);
