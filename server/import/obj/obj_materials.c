#include "server/import/obj/obj_materials.h"

#include <assimp/material.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/image/image_decoder.h"
#include "server/import/obj/obj_shading.h"
#include "server/import/scene/surface.h"

#define ABSENT_KD 0.6f /* grey of a material that names no colour, as assimp has it */

int obj_materials_init(struct obj_materials *m, struct files *files, struct builder *builder,
                       const char *name, const struct aiScene *scene, struct fault *fault)
{
    *m = (struct obj_materials){.files = files, .builder = builder, .name = name, .scene = scene};
    m->records = malloc((scene->mNumMaterials + 1) * sizeof *m->records);
    if (m->records == NULL)
        return fault_set(fault, ERR_MEMORY, "materials", "no memory for materials");
    for (unsigned i = 0; i < scene->mNumMaterials; i++) m->records[i] = SCENE_NONE;
    return 0;
}

void obj_materials_fini(struct obj_materials *m)
{
    free(m->records);
    free(m->paths);
    colored_materials_fini(&m->colored);
    *m = (struct obj_materials){0};
}

/* Reads a colour in 0 .. highest; absent colours keep their default. key, type, index: AI_MATKEY_.
 *  */
static int read_color(const struct aiMaterial *from, const char *key, unsigned type, unsigned index,
                      float highest, float inout[3], const char *place, const char *name,
                      struct fault *fault)
{
    struct aiColor4D color;
    if (aiGetMaterialColor(from, key, type, index, &color) != aiReturn_SUCCESS) return 0;
    const float rgb[3] = {color.r, color.g, color.b};
    char at[LIMIT_POINTER_BYTES];
    snprintf(at, sizeof at, "%.200s.%s", place, name);
    for (int i = 0; i < 3; i++) {
        if (!(rgb[i] >= 0 && rgb[i] <= highest))
            return fault_set(fault, ERR_RANGE, at, "%g is not in [0, %g]", (double)rgb[i],
                             (double)highest);
        inout[i] = rgb[i];
    }
    return 0;
}

/* The image of that path, decoded at its first use; one record for colours is all that MTL needs.
 */
static int get_image(struct obj_materials *m, const char *path, const char *place, uint32_t *out,
                     struct fault *fault)
{
    struct builder *b = m->builder;
    uint32_t count = (uint32_t)builder_count(b, SCENE_IMAGES);
    for (uint32_t i = 0; i < count; i++) {
        *out = i;
        if (strcmp(m->paths[i], path) == 0) return 0;
    }
    void *paths = realloc(m->paths, ((size_t)count + 1) * sizeof *m->paths);
    if (paths == NULL) return fault_set(fault, ERR_MEMORY, place, "no memory for images");
    m->paths = paths;
    snprintf(m->paths[count], sizeof *m->paths, "%s", path);
    struct file_view encoded;
    struct image_header header;
    struct scene_image record = {.format = IMAGE_RGBA8, .flags = IMAGE_IS_SRGB};
    void *at;
    int rc = files_map(m->files, path, place, &encoded, fault);
    if (rc != 0) return rc;
    record.first_byte = builder_count(b, SCENE_PIXELS);
    rc = image_measure(encoded.data, encoded.size_bytes, place, &header, fault);
    if (rc == 0)
        rc = builder_append(b, SCENE_PIXELS, 4ull * header.width_px * header.height_px, &at, fault);
    if (rc == 0)
        rc =
            image_decode(encoded.data, encoded.size_bytes, &header, place, at, &b->warnings, fault);
    files_unmap(&encoded);
    if (rc == 0) rc = builder_name(b, path, &record.name, fault);
    if (rc == 0) rc = builder_append(b, SCENE_IMAGES, 1, &at, fault);
    if (rc != 0) return rc;
    record.width_px = header.width_px;
    record.height_px = header.height_px;
    memcpy(at, &record, sizeof record);
    *out = count;
    return 0;
}

static uint32_t wrap_of(enum aiTextureMapMode mode)
{
    return mode == aiTextureMapMode_Clamp    ? WRAP_CLAMP
           : mode == aiTextureMapMode_Mirror ? WRAP_MIRROR
                                             : WRAP_REPEAT;
}

static int read_texture(struct obj_materials *m, const struct aiMaterial *from,
                        enum aiTextureType type, const char *place, struct scene_texture_ref *out,
                        struct fault *fault)
{
    struct aiString name;
    enum aiTextureMapMode modes[3] = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap,
                                      aiTextureMapMode_Wrap};
    char path[LIMIT_PATH_BYTES];
    *out = (struct scene_texture_ref){.texture = SCENE_NONE, .transform = {1, 0, 0, 0, 1, 0}};
    if (aiGetMaterialTexture(from, type, 0, &name, NULL, NULL, NULL, NULL, modes, NULL) !=
            aiReturn_SUCCESS ||
        name.length == 0)
        return 0;
    for (char *c = name.data; *c != 0; c++)
        if (*c == '\\') *c = '/';
    struct scene_texture record = {.wrap_u = wrap_of(modes[0]), .wrap_v = wrap_of(modes[1])};
    void *at;
    int rc = files_resolve(m->name, name.data, false, path, place, fault);
    if (rc == 0) rc = get_image(m, path, place, &record.image, fault);
    out->texture = (uint32_t)builder_count(m->builder, SCENE_TEXTURES);
    if (rc == 0) rc = builder_append(m->builder, SCENE_TEXTURES, 1, &at, fault);
    if (rc == 0) memcpy(at, &record, sizeof record);
    return rc;
}

static bool is_black(const float rgb[3])
{
    return !(rgb[0] > 0 || rgb[1] > 0 || rgb[2] > 0);
}

static int read_colors(struct obj_materials *m, const struct aiMaterial *from, const char *place,
                       struct scene_material *out, struct fault *fault)
{
    char at[LIMIT_POINTER_BYTES];
    int rc = read_color(from, AI_MATKEY_COLOR_DIFFUSE, 1, out->base_color, place, "Kd", fault);
    if (rc == 0)
        rc = read_color(from, AI_MATKEY_COLOR_EMISSIVE, LIMIT_RADIANCE, out->emission, place, "Ke",
                        fault);
    snprintf(at, sizeof at, "%.200s.map_Kd", place);
    if (rc == 0)
        rc = read_texture(m, from, aiTextureType_DIFFUSE, at, &out->base_color_texture, fault);
    snprintf(at, sizeof at, "%.200s.map_Ke", place);
    if (rc == 0)
        rc = read_texture(m, from, aiTextureType_EMISSIVE, at, &out->emission_texture, fault);
    /* A map stands alone when its colour is left out or black, as most writers mean it. */
    if (out->base_color_texture.texture != SCENE_NONE && is_black(out->base_color))
        for (int i = 0; i < 3; i++) out->base_color[i] = 1;
    if (out->emission_texture.texture != SCENE_NONE && is_black(out->emission))
        for (int i = 0; i < 3; i++) out->emission[i] = 1;
    return rc;
}

static int append_material(struct obj_materials *m, unsigned index, struct fault *fault)
{
    const struct aiMaterial *from = m->scene->mMaterials[index];
    struct scene_material material;
    struct aiString name = {0};
    char place[LIMIT_POINTER_BYTES];
    void *at;
    surface_init(&material);
    material.metallic = 0;
    material.specular = 0;
    for (int i = 0; i < 3; i++) material.base_color[i] = ABSENT_KD;
    aiGetMaterialString(from, AI_MATKEY_NAME, &name);
    snprintf(place, sizeof place, "newmtl %.150s", name.data);
    text_make_printable(place);
    int rc = read_colors(m, from, place, &material, fault);
    obj_shading_read(from, place, &material, &m->builder->warnings);
    /* OBJ surfaces are seen from both sides; they emit from the front. */
    if (is_black(material.emission)) material.flags |= MATERIAL_DOUBLE_SIDED;
    if (rc == 0) rc = builder_name(m->builder, name.data, &material.name, fault);
    uint32_t record = (uint32_t)builder_count(m->builder, SCENE_MATERIALS);
    if (rc == 0) rc = builder_append(m->builder, SCENE_MATERIALS, 1, &at, fault);
    if (rc != 0) return rc;
    memcpy(at, &material, sizeof material);
    m->records[index] = record;
    return 0;
}

int obj_material_get(struct obj_materials *m, unsigned index, uint32_t *out, struct fault *fault)
{
    int rc = 0;
    if (index >= m->scene->mNumMaterials)
        return fault_set(fault, ERR_RANGE, "materials", "%u does not exist", index);
    if (m->records[index] == SCENE_NONE) rc = append_material(m, index, fault);
    *out = m->records[index];
    return rc;
}
