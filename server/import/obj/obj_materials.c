#include "server/import/obj/obj_materials.h"

#include <assimp/material.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/scene/mtl_map.h"
#include "server/import/image/image_decoder.h"
#include "server/import/obj/obj_shading.h"
#include "server/import/scene/surface.h"

#define SCALE_MAX 1e6f /* as the blob takes them */
#define ABSENT_KD 0.6f /* grey of a material that names no colour, as assimp has it */

int obj_materials_init(struct obj_materials *m, struct files *files, struct builder *builder,
                       const char *name, const struct mtl *mtl, const struct aiScene *scene,
                       struct fault *fault)
{
    *m = (struct obj_materials){
        .files = files, .builder = builder, .name = name, .mtl = mtl, .scene = scene};
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

/* Takes a colour in 0 .. highest; absent colours keep their default. */
static int take_color(const struct mtl_material *from, uint32_t given, const float rgb[3],
                      float highest, float inout[3], const char *place, const char *name,
                      struct fault *fault)
{
    char at[LIMIT_POINTER_BYTES];
    if (!(from->given & given)) return 0;
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

/* u' = s u + o in OBJ's coordinates, whose v grows upwards while the blob's grows downwards. */
static void set_transform(const struct mtl_image *image, struct scene_texture_ref *out)
{
    out->transform[0] = image->scale[0];
    out->transform[2] = image->offset[0];
    out->transform[4] = image->scale[1];
    out->transform[5] = 1 - image->scale[1] - image->offset[1];
}

static bool is_within(const struct scene_texture_ref *ref, float limit)
{
    for (int i = 0; i < 6; i++)
        if (!(ref->transform[i] >= -limit && ref->transform[i] <= limit)) return false;
    return true;
}

static int read_texture(struct obj_materials *m, const struct mtl_image *image, const char *place,
                        struct scene_texture_ref *out, struct fault *fault)
{
    char path[LIMIT_PATH_BYTES];
    *out = (struct scene_texture_ref){.texture = SCENE_NONE, .transform = {1, 0, 0, 0, 1, 0}};
    if (image->name == NULL) return 0;
    set_transform(image, out);
    if (!is_within(out, SCALE_MAX))
        return fault_set(fault, ERR_RANGE, place, "its -s or -o is beyond %g", (double)SCALE_MAX);
    const uint32_t wrap = image->clamp ? WRAP_CLAMP : WRAP_REPEAT;
    struct scene_texture record = {.wrap_u = wrap, .wrap_v = wrap};
    void *at;
    const char *name = mtl_name_beside(image->name);
    int rc = files_resolve(m->name, name, false, path, place, fault);
    if (rc == 0 && name != image->name)
        warnings_add(&m->builder->warnings, place,
                     "\"%.200s\" is taken from beside the scene, as \"%.200s\"", image->name, name);
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

static int read_colors(struct obj_materials *m, const struct mtl_material *from, const char *place,
                       struct scene_material *out, struct fault *fault)
{
    char at[LIMIT_POINTER_BYTES];
    int rc = take_color(from, MTL_KD, from->kd, 1, out->base_color, place, "Kd", fault);
    if (rc == 0)
        rc = take_color(from, MTL_KE, from->ke, LIMIT_RADIANCE, out->emission, place, "Ke", fault);
    snprintf(at, sizeof at, "%.200s.map_Kd", place);
    if (rc == 0) rc = read_texture(m, &from->map_kd, at, &out->base_color_texture, fault);
    snprintf(at, sizeof at, "%.200s.map_Ke", place);
    if (rc == 0) rc = read_texture(m, &from->map_ke, at, &out->emission_texture, fault);
    /* A map stands alone when its colour is left out or black, as most writers mean it. */
    if (out->base_color_texture.texture != SCENE_NONE && is_black(out->base_color))
        for (int i = 0; i < 3; i++) out->base_color[i] = 1;
    if (out->emission_texture.texture != SCENE_NONE && is_black(out->emission))
        for (int i = 0; i < 3; i++) out->emission[i] = 1;
    return rc;
}

/* The material of a name; where no library has it, one without members, with a warning. */
static const struct mtl_material *find_material(struct obj_materials *m, const char *name,
                                                const char *place)
{
    static const struct mtl_material nothing = {0};
    const struct mtl_material *found = mtl_find(m->mtl, name);
    if (found == NULL && strcmp(name, AI_DEFAULT_MATERIAL_NAME) != 0)
        warnings_add(&m->builder->warnings, place, "no mtllib has this material: it is grey");
    return found != NULL ? found : &nothing;
}

static int append_material(struct obj_materials *m, unsigned index, struct fault *fault)
{
    struct scene_material material;
    struct aiString name = {0};
    char place[LIMIT_POINTER_BYTES];
    void *at;
    surface_init(&material);
    material.metallic = 0;
    material.specular = 0;
    for (int i = 0; i < 3; i++) material.base_color[i] = ABSENT_KD;
    aiGetMaterialString(m->scene->mMaterials[index], AI_MATKEY_NAME, &name);
    snprintf(place, sizeof place, "newmtl %.150s", name.data);
    text_make_printable(place);
    const struct mtl_material *from = find_material(m, name.data, place);
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
