/* Textures, samplers and images. An image that serves as colour and as data is decoded once and
 * recorded twice, once flagged as sRGB. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/gltf/gltf.h"
#include "server/import/image/image_decoder.h"

enum { AS_DATA = 0, AS_COLOR = 1, USES = 2 };

struct gltf_images {
    size_t image_count, texture_count; /* of the document */
    uint32_t *records[USES];           /* owned; document image -> scene_image or SCENE_NONE */
    uint32_t *textures[USES];          /* owned; document texture -> scene_texture or SCENE_NONE */
};

static uint32_t *new_indexes(size_t count)
{
    uint32_t *indexes = malloc((count + 1) * sizeof *indexes);
    for (size_t i = 0; indexes != NULL && i < count; i++) indexes[i] = SCENE_NONE;
    return indexes;
}

int gltf_textures_init(struct gltf *g, struct fault *fault)
{
    struct gltf_images *images = calloc(1, sizeof *images);
    if (images == NULL) return fault_set(fault, ERR_MEMORY, "images", "no memory for images");
    g->images = images;
    images->image_count = gltf_count(g->root, "images");
    images->texture_count = gltf_count(g->root, "textures");
    for (int use = 0; use < USES; use++) {
        images->records[use] = new_indexes(images->image_count);
        images->textures[use] = new_indexes(images->texture_count);
        if (images->records[use] == NULL || images->textures[use] == NULL)
            return fault_set(fault, ERR_MEMORY, "images", "no memory for %zu images",
                             images->image_count);
    }
    return 0;
}

void gltf_textures_fini(struct gltf *g)
{
    for (int use = 0; g->images != NULL && use < USES; use++) {
        free(g->images->records[use]);
        free(g->images->textures[use]);
    }
    free(g->images);
    g->images = NULL;
}

/* Appends the record of an image at its first use; its pixels come later. */
static int register_image(struct gltf *g, uint32_t image, int use, uint32_t *out,
                          struct fault *fault)
{
    *out = g->images->records[use][image];
    if (*out != SCENE_NONE) return 0;
    const json_t *json;
    gltf_place place;
    const char *name, *uri;
    void *record;
    int rc = gltf_item(g->root, "images", image, &json, place, fault);
    if (rc == 0) rc = gltf_text(json, place, "name", &name, fault);
    if (rc == 0) rc = gltf_text(json, place, "uri", &uri, fault);
    if (rc != 0) return rc;
    if (name == NULL && uri != NULL && strncmp(uri, "data:", 5) != 0) name = uri;
    *out = (uint32_t)builder_count(g->builder, SCENE_IMAGES);
    rc = builder_append(g->builder, SCENE_IMAGES, 1, &record, fault);
    if (rc != 0) return rc;
    struct scene_image *scene_image = record;
    scene_image->format = IMAGE_RGBA8;
    scene_image->flags = use == AS_COLOR ? IMAGE_IS_SRGB : 0;
    g->images->records[use][image] = *out;
    return builder_name(g->builder, name, &scene_image->name, fault);
}

static int read_wrap(const json_t *sampler, const char *place, const char *key, uint32_t *out,
                     struct fault *fault)
{
    uint64_t mode = 10497;
    gltf_place at;
    int rc = gltf_integer(sampler, place, key, UINT32_MAX, &mode, fault);
    if (rc != 0) return rc;
    switch (mode) {
    case 10497:
        *out = WRAP_REPEAT;
        return 0;
    case 33071:
        *out = WRAP_CLAMP;
        return 0;
    case 33648:
        *out = WRAP_MIRROR;
        return 0;
    default:
        gltf_place_set(at, "%s.%s", place, key);
        return fault_set(fault, ERR_RANGE, at, "%" PRIu64 " is no way to wrap", mode);
    }
}

static int read_sampler(struct gltf *g, uint32_t index, struct scene_texture *out,
                        struct fault *fault)
{
    const json_t *json;
    gltf_place place;
    uint64_t magnify = 9729;
    if (index == SCENE_NONE) return 0; /* zeros: repeat, linear */
    int rc = gltf_item(g->root, "samplers", index, &json, place, fault);
    if (rc == 0) rc = read_wrap(json, place, "wrapS", &out->wrap_u, fault);
    if (rc == 0) rc = read_wrap(json, place, "wrapT", &out->wrap_v, fault);
    if (rc == 0) rc = gltf_integer(json, place, "magFilter", UINT32_MAX, &magnify, fault);
    if (rc != 0) return rc;
    if (magnify != 9728 && magnify != 9729)
        return fault_set(fault, ERR_RANGE, place, "magFilter %" PRIu64 " does not exist", magnify);
    out->filter = magnify == 9728 ? FILTER_NEAREST : FILTER_LINEAR;
    return 0;
}

/* EXT_texture_webp: its image stands for the texture's own, which is for others to read. */
static int read_webp(struct gltf *g, const json_t *json, const char *place, uint32_t *source,
                     struct fault *fault)
{
    const json_t *extension;
    gltf_place at;
    uint32_t webp = SCENE_NONE;
    int rc = gltf_extension(json, place, "EXT_texture_webp", &extension, at, fault);
    if (rc == 0) rc = gltf_index(extension, at, "source", g->images->image_count, &webp, fault);
    if (rc == 0 && webp != SCENE_NONE) *source = webp;
    return rc;
}

/* Says why a texture that no reader of ours takes is left out. */
static void leave_out(struct gltf *g, const json_t *json, const char *place)
{
    const bool basis =
        json_object_get(json_object_get(json, "extensions"), "KHR_texture_basisu") != NULL;
    warnings_add(&g->builder->warnings, place,
                 "the texture has no PNG, JPEG or WebP image and is ignored%s",
                 basis ? gltf_extension_advice("KHR_texture_basisu") : "");
}

/* *out stays SCENE_NONE for a texture whose only image is in a format behind an extension. */
static int register_texture(struct gltf *g, uint32_t texture, int use, uint32_t *out,
                            struct fault *fault)
{
    *out = g->images->textures[use][texture];
    if (*out != SCENE_NONE) return 0;
    const json_t *json;
    gltf_place place;
    uint32_t source = SCENE_NONE, sampler = SCENE_NONE;
    struct scene_texture record = {0};
    int rc = gltf_item(g->root, "textures", texture, &json, place, fault);
    if (rc == 0) rc = gltf_index(json, place, "source", g->images->image_count, &source, fault);
    if (rc == 0)
        rc = gltf_index(json, place, "sampler", gltf_count(g->root, "samplers"), &sampler, fault);
    if (rc == 0) rc = read_sampler(g, sampler, &record, fault);
    if (rc != 0) return rc;
    rc = read_webp(g, json, place, &source, fault);
    if (rc != 0) return rc;
    if (source == SCENE_NONE) {
        leave_out(g, json, place);
        return 0;
    }
    void *at;
    rc = register_image(g, source, use, &record.image, fault);
    uint32_t index = (uint32_t)builder_count(g->builder, SCENE_TEXTURES);
    if (rc == 0) rc = builder_append(g->builder, SCENE_TEXTURES, 1, &at, fault);
    if (rc != 0) return rc;
    memcpy(at, &record, sizeof record);
    *out = g->images->textures[use][texture] = index;
    return 0;
}

/* KHR_texture_transform: translation * rotation * scale, where a positive rotation turns the
 * texture coordinates counter-clockwise as seen in the image, whose v grows downwards:
 * u' = cos u + sin v, v' = -sin u + cos v (checked with Khronos' TextureTransformTest). */
static int read_transform(const json_t *info, const char *info_place, double *set,
                          float transform[6], struct fault *fault)
{
    const json_t *json;
    gltf_place place;
    double offset[2] = {0, 0}, scale[2] = {1, 1}, rotation = 0;
    const double far = 1e6;
    int rc = gltf_extension(info, info_place, "KHR_texture_transform", &json, place, fault);
    if (rc == 0) rc = gltf_vector(json, place, "offset", 2, -far, far, offset, NULL, fault);
    if (rc == 0) rc = gltf_vector(json, place, "scale", 2, -far, far, scale, NULL, fault);
    if (rc == 0) rc = gltf_number(json, place, "rotation", -far, far, &rotation, fault);
    if (rc == 0) rc = gltf_number(json, place, "texCoord", 0, 1000, set, fault);
    if (rc != 0) return rc;
    double c = cos(rotation), s = sin(rotation);
    const double rows[6] = {c * scale[0],  s * scale[1], offset[0],
                            -s * scale[0], c * scale[1], offset[1]};
    for (int i = 0; i < 6; i++) transform[i] = (float)rows[i];
    return 0;
}

int gltf_texture_read(struct gltf *g, const json_t *of, const char *place, const char *key,
                      bool srgb, struct scene_texture_ref *out, const json_t **info,
                      struct fault *fault)
{
    gltf_place at;
    uint32_t texture = SCENE_NONE;
    double set = 0;
    *out = (struct scene_texture_ref){.texture = SCENE_NONE, .transform = {1, 0, 0, 0, 1, 0}};
    gltf_place_set(at, "%s.%s", place, key);
    int rc = gltf_object(of, place, key, info, fault);
    if (rc != 0 || *info == NULL) return rc;
    rc = gltf_index(*info, at, "index", g->images->texture_count, &texture, fault);
    if (rc == 0) rc = gltf_number(*info, at, "texCoord", 0, 1000, &set, fault);
    if (rc == 0) rc = read_transform(*info, at, &set, out->transform, fault);
    if (rc != 0) return rc;
    if (texture == SCENE_NONE) return fault_set(fault, ERR_MISSING, at, "it names no texture");
    out->uv_set = (uint32_t)set;
    return register_texture(g, texture, srgb ? AS_COLOR : AS_DATA, &out->texture, fault);
}

/* The encoded bytes of an image. payload is what must be freed after use. */
static int load_image(struct gltf *g, size_t image, gltf_place place, struct file_view *out,
                      struct gltf_payload *payload, struct fault *fault)
{
    const json_t *json;
    const char *uri;
    uint32_t index;
    *payload = (struct gltf_payload){{NULL, 0}, NULL};
    *out = payload->view;
    int rc = gltf_item(g->root, "images", image, &json, place, fault);
    if (rc == 0) rc = gltf_text(json, place, "uri", &uri, fault);
    if (rc == 0)
        rc = gltf_index(json, place, "bufferView", gltf_count(g->root, "bufferViews"), &index,
                        fault);
    if (rc != 0) return rc;
    if (index != SCENE_NONE) {
        struct gltf_view view;
        rc = gltf_view_open(g, index, &view, fault);
        if (rc == 0) *out = (struct file_view){view.data, view.size_bytes};
        return rc;
    }
    if (uri == NULL)
        return fault_set(fault, ERR_MISSING, place, "it has neither a uri nor a bufferView");
    gltf_place_set(place, "images[%zu].uri", image);
    rc = gltf_payload_load(g, uri, place, payload, fault);
    *out = payload->view;
    return rc;
}

/* Decodes to the end of SCENE_PIXELS. */
static int decode_image(struct gltf *g, size_t image, struct image_header *header,
                        uint64_t *first_byte, struct fault *fault)
{
    struct file_view encoded;
    struct gltf_payload payload;
    gltf_place place;
    void *pixels;
    *first_byte = builder_count(g->builder, SCENE_PIXELS);
    int rc = load_image(g, image, place, &encoded, &payload, fault);
    if (rc == 0) rc = image_measure(encoded.data, encoded.size_bytes, place, header, fault);
    if (rc == 0)
        rc = builder_append(g->builder, SCENE_PIXELS, 4ull * header->width_px * header->height_px,
                            &pixels, fault);
    if (rc == 0)
        rc = image_decode(encoded.data, encoded.size_bytes, header, place, pixels,
                          &g->builder->warnings, fault);
    gltf_payload_free(&payload);
    return rc;
}

int gltf_images_decode(struct gltf *g, struct fault *fault)
{
    for (size_t i = 0; i < g->images->image_count; i++) {
        uint32_t uses[USES] = {g->images->records[AS_DATA][i], g->images->records[AS_COLOR][i]};
        if (uses[AS_DATA] == SCENE_NONE && uses[AS_COLOR] == SCENE_NONE) continue;
        struct image_header header;
        uint64_t first_byte;
        int rc = decode_image(g, i, &header, &first_byte, fault);
        if (rc != 0) return rc;
        for (int use = 0; use < USES; use++) {
            if (uses[use] == SCENE_NONE) continue;
            struct scene_image *record = builder_images(g->builder) + uses[use];
            record->width_px = header.width_px;
            record->height_px = header.height_px;
            record->first_byte = first_byte;
        }
    }
    return 0;
}
