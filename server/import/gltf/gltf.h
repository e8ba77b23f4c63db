#pragma once
/* An open glTF 2.0 document: its JSON, its buffers, and the builder of the scene.
 *
 * The importer reads JSON and buffers itself instead of using assimp. A fault must name its place,
 * and instances must stay instances. assimp also drops or changes emissive strength, fields of
 * view, light ranges, texture transforms and samplers. */
#include "server/import/fence/files.h"
#include "server/import/gltf/gltf_json.h"
#include "server/import/gltf/gltf_nodes.h"
#include "server/import/scene/builder.h"
#include "server/import/scene/colored_materials.h"
#include "server/import/scene/scene_choice.h"

struct gltf_buffer; /* gltf_buffers.c */
struct gltf_images; /* gltf_textures.c */

/* The decoded primitive that is being loaded, if it is a compressed one. */
struct gltf_draco {
    struct draco_shim *mesh; /* owned; NULL: its accessors have its bytes */
    const json_t *ids;       /* attribute -> id in the stream */
    gltf_place place;
};

/* What of a document is imported: all of it at one time; or what frames have in common, which never
 * moves or only as a whole; or the rest of a frame. */
enum gltf_phase { GLTF_WHOLE, GLTF_BASE, GLTF_FRAME };

/* What animations move, by index in the document; owned; NULL: none are known. */
struct gltf_moving {
    uint8_t *nodes;                       /* their place, or whether they show */
    uint8_t *node_weights, *mesh_weights; /* of morph targets */
    uint8_t *materials;
    bool any;
    bool plays; /* by an animation */
};

/* What the job moves (gltf_moves.c). */
struct gltf_moves {
    const struct job_moves *asked; /* borrowed; NULL: nothing */
    uint32_t *of; /* owned; by index of a node: its moves and its ancestors'; bits */
};

/* A mesh of the base that frames place. */
struct gltf_movable {
    uint32_t mesh, primitive, poser;
    uint32_t record;    /* in SCENE_MESHES */
    struct affine back; /* undoes what was taken from its positions */
};

struct gltf {
    enum gltf_phase phase;
    struct gltf_moving moving;
    struct gltf_moves moves;
    struct gltf_movable *movables; /* owned; in order of mesh, primitive, poser */
    uint32_t movable_count, movable_capacity;
    uint32_t base_materials; /* of the base */
    struct files *files;     /* borrowed */
    struct builder *builder; /* borrowed */
    const char *name;        /* borrowed; the main file's path beneath the root */
    json_t *root;            /* owned */
    const uint8_t *bin;      /* borrowed from the file; the GLB's binary chunk; NULL: none */
    size_t bin_bytes;
    struct gltf_buffer *buffers; /* owned; parallel to root["buffers"] */
    size_t buffer_count;
    uint8_t **decoded_views; /* owned; by buffer view: its decoded bytes, or NULL */
    size_t view_count;
    struct gltf_images *images; /* owned */
    uint32_t (*uv_sets)[2];     /* owned; by material: the file's sets that are its 0 and 1 */
    struct gltf_nodes nodes;
    uint32_t default_material; /* SCENE_NONE until a primitive without material needs it */
    struct colored_materials colored;
    struct gltf_draco draco; /* gltf_draco.h */
    uint32_t variant;        /* of KHR_materials_variants; SCENE_NONE: none is asked for */
};

/* Imports a .glb or .gltf. The call borrows all. */
int gltf_import(struct files *files, const char *name, const struct scene_choice *choice,
                const struct file_view *main, struct builder *builder, struct fault *fault);

/* Open a document, which borrows all, and close it. After a failure it is to be closed, too.
 * g->moving says what moves then. */
int gltf_open(struct gltf *g, struct files *files, const char *name,
              const struct scene_choice *choice, const struct file_view *main,
              struct builder *builder, struct fault *fault);
void gltf_close(struct gltf *g);

/* Import parts of an open document: all at one time; a base; frames that stand on it, each into a
 * builder of its own that has begun. */
int gltf_read_whole(struct gltf *g, const struct scene_choice *choice, struct builder *b,
                    struct fault *fault);
int gltf_read_base(struct gltf *g, struct builder *b, struct fault *fault);
int gltf_read_frame(struct gltf *g, const struct scene_choice *choice, double time_s,
                    struct builder *b, struct fault *fault);

/* Returns the offset of a file's first byte that is not white space. */
size_t gltf_text_start(const struct file_view *file);

/* Reads container and JSON, and sets root and bin. Refuses other versions than 2 and required
 * extensions that are not supported; warns of other extensions. */
int gltf_document_read(struct gltf *g, const struct file_view *main, struct fault *fault);

/* Says what to do about an extension whose content is not read, from ":" on; "" where nothing. */
const char *gltf_extension_advice(const char *name);

/* The bytes of a buffer view. *stride is 0 when the elements are packed. */
struct gltf_view {
    const uint8_t *data;
    size_t size_bytes;
    size_t stride_bytes;
};
int gltf_buffers_init(struct gltf *g, struct fault *fault);
void gltf_buffers_fini(struct gltf *g);
int gltf_view_open(struct gltf *g, uint32_t index, struct gltf_view *out, struct fault *fault);

/* Opens bytes byteOffset .. byteOffset + byteLength of the buffer that `json` names, without a
 * stride. */
int gltf_range_open(struct gltf *g, const json_t *json, const char *place, struct gltf_view *out,
                    struct fault *fault);

/* Opens a buffer view that is compressed, into *cache at its first use. *compressed: it is one. */
int gltf_meshopt_open(struct gltf *g, const json_t *json, const char *place, uint8_t **cache,
                      struct gltf_view *out, bool *compressed, struct fault *fault);

/* The bytes behind a URI: base64 data, which the caller frees, or a mapped file. */
struct gltf_payload {
    struct file_view view;
    uint8_t *decoded; /* owned; NULL for a file */
};
int gltf_payload_load(struct gltf *g, const char *uri, const char *place, struct gltf_payload *out,
                      struct fault *fault);
void gltf_payload_free(struct gltf_payload *payload);

/* Reads all materials, in the file's order, and the textures that they use. */
int gltf_materials_read(struct gltf *g, struct fault *fault);

/* Returns the index of glTF's default material, which is appended at its first use. */
int gltf_default_material(struct gltf *g, uint32_t *out, struct fault *fault);

/* Reads a texture reference; *out keeps SCENE_NONE when it is absent or ignored. Registers the
 * image for gltf_images_decode. */
int gltf_texture_read(struct gltf *g, const json_t *of, const char *place, const char *key,
                      bool srgb, struct scene_texture_ref *out, const json_t **info,
                      struct fault *fault);
int gltf_textures_init(struct gltf *g, struct fault *fault);
void gltf_textures_fini(struct gltf *g);
int gltf_images_decode(struct gltf *g, struct fault *fault);

/* Finds the variant of a name. ERR_NOT_FOUND with those that there are. */
int gltf_variant_find(struct gltf *g, const char *name, struct fault *fault);

/* Makes *inout the primitive's material in the variant, if it has one there. */
int gltf_variant_material(struct gltf *g, const json_t *primitive, const char *place,
                          uint32_t *inout, struct fault *fault);

/* Keeps the node once for each of its instances, without camera and light. *instanced: it says how
 * often it stands. ERR_MISMATCH, ERR_LIMIT, ERR_NOT_FINITE. */
int gltf_instancing_keep(struct gltf *g, const json_t *json, const char *place,
                         const struct gltf_node *node, bool *instanced, struct fault *fault);

/* Finds the nodes that the job moves, so that they count as moving. ERR_NOT_FOUND for a name that
 * no node has, with its place in the job document. */
int gltf_moves_find(struct gltf *g, const struct job_moves *moves, struct fault *fault);
/* Moves the nodes that were read. */
void gltf_moves_apply(struct gltf *g);
void gltf_moves_fini(struct gltf_moves *moves);

/* Finds the bounds of the nodes that have one of the bits in `moved`, of all for 0. False: they
 * have none, or the file does not say them. */
bool gltf_nodes_bounds(const struct gltf *g, uint32_t moved, double lowest[3], double highest[3]);

/* Chooses the middle of a scene that is far from the origin for the builder's, zeros for others;
 * moves the nodes by the builder's origin. */
void gltf_origin_choose(struct gltf *g);
void gltf_origin_move(struct gltf *g);

/* Keep what frames place, put it in order once a base has all, and find one of it; NULL: none. */
int gltf_movable_keep(struct gltf *g, const struct gltf_movable *movable, struct fault *fault);
void gltf_movables_sort(struct gltf *g);
const struct gltf_movable *gltf_movable_find(const struct gltf *g, uint32_t mesh,
                                             uint32_t primitive, uint32_t poser);

/* Read geometry, and place it. */
int gltf_meshes_read(struct gltf *g, struct fault *fault);

int gltf_lights_read(struct gltf *g, struct fault *fault);
int gltf_cameras_read(struct gltf *g, struct fault *fault);
