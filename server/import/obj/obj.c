#include "server/import/obj/obj.h"

#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "server/import/obj/obj_io.h"
#include "server/import/obj/obj_materials.h"
#include "server/import/obj/obj_near.h"
#include "server/import/scene/mesh.h"
#include "server/import/scene/origin.h"

#define STEPS                                                                                      \
    (aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_JoinIdenticalVertices |             \
     aiProcess_ValidateDataStructure)

/* Below this a text cannot hold a triangle; assimp refuses shorter files with a puzzling reason. */
#define LEAST_BYTES 16

/* Copies vectors of three; NULL when there are none. */
static int copy_vectors(const struct aiVector3D *from, uint32_t count, float **out,
                        struct fault *fault)
{
    if (from == NULL) return 0;
    float *to = malloc(((size_t)count * 3 + 1) * sizeof *to);
    if (to == NULL) return fault_set(fault, ERR_MEMORY, "meshes", "no memory for vertices");
    for (size_t v = 0; v < count; v++) {
        to[3 * v] = from[v].x;
        to[3 * v + 1] = from[v].y;
        to[3 * v + 2] = from[v].z;
    }
    *out = to;
    return 0;
}

/* OBJ's v grows upwards, the blob's grows downwards. */
static int copy_uvs(const struct aiVector3D *from, uint32_t count, float **out, struct fault *fault)
{
    if (from == NULL) return 0;
    float *to = malloc(((size_t)count * 2 + 1) * sizeof *to);
    if (to == NULL) return fault_set(fault, ERR_MEMORY, "meshes", "no memory for vertices");
    for (size_t v = 0; v < count; v++) {
        to[2 * v] = from[v].x;
        to[2 * v + 1] = 1 - from[v].y;
    }
    *out = to;
    return 0;
}

/* Colours of vertices are meant as they look on a screen: they are sRGB. */
static float linear_of(float srgb)
{
    const float v = fminf(fmaxf(srgb, 0), 1);
    return v <= 0.04045f ? v / 12.92f : powf((v + 0.055f) / 1.055f, 2.4f);
}

static int copy_colors(const struct aiColor4D *from, uint32_t count, float **out,
                       struct fault *fault)
{
    if (from == NULL) return 0;
    float *to = malloc(((size_t)count * 4 + 1) * sizeof *to);
    if (to == NULL) return fault_set(fault, ERR_MEMORY, "meshes", "no memory for vertices");
    for (size_t v = 0; v < count; v++) {
        to[4 * v] = linear_of(from[v].r);
        to[4 * v + 1] = linear_of(from[v].g);
        to[4 * v + 2] = linear_of(from[v].b);
        to[4 * v + 3] = 1;
    }
    *out = to;
    return 0;
}

static int copy_triangles(const struct aiMesh *from, struct mesh *out, struct fault *fault)
{
    out->triangles = malloc(((size_t)from->mNumFaces * 3 + 1) * sizeof *out->triangles);
    if (out->triangles == NULL)
        return fault_set(fault, ERR_MEMORY, "meshes", "no memory for triangles");
    for (unsigned f = 0; f < from->mNumFaces; f++) {
        const struct aiFace *face = &from->mFaces[f];
        if (face->mNumIndices != 3) continue;
        for (size_t k = 0; k < 3; k++)
            out->triangles[3 * (size_t)out->triangle_count + k] = face->mIndices[k];
        out->triangle_count++;
    }
    return 0;
}

static int copy_mesh(const struct aiMesh *from, const char *place, struct warnings *warnings,
                     struct mesh *out, struct fault *fault)
{
    uint32_t n = from->mNumVertices;
    *out = (struct mesh){.vertex_count = n};
    if (n > LIMIT_VERTICES || from->mNumFaces > LIMIT_TRIANGLES)
        return fault_set(fault, ERR_LIMIT, place, "%u vertices and %u faces are too many", n,
                         from->mNumFaces);
    int rc = copy_vectors(from->mVertices, n, &out->positions, fault);
    if (rc == 0) rc = copy_vectors(from->mNormals, n, &out->normals, fault);
    if (rc == 0) rc = copy_uvs(from->mTextureCoords[0], n, &out->uvs[0], fault);
    if (rc == 0) rc = copy_triangles(from, out, fault);
    if (rc == 0) rc = copy_colors(from->mColors[0], n, &out->colors, fault);
    if (rc == 0) rc = mesh_check(out, place, warnings, fault);
    if (rc == 0) rc = mesh_compact(out, fault);
    if (rc != 0) mesh_fini(out);
    return rc;
}

static int append_records(struct builder *b, const char *name, struct scene_mesh *mesh,
                          struct fault *fault)
{
    struct scene_instance instance = {.flags = INSTANCE_IDENTITY,
                                      .to_world = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    void *at;
    int rc = builder_name(b, name, &mesh->name, fault);
    instance.mesh = (uint32_t)builder_count(b, SCENE_MESHES);
    instance.name = mesh->name;
    if (rc == 0) rc = builder_append(b, SCENE_MESHES, 1, &at, fault);
    if (rc == 0) memcpy(at, mesh, sizeof *mesh);
    if (rc == 0) rc = builder_append(b, SCENE_INSTANCES, 1, &at, fault);
    if (rc == 0) memcpy(at, &instance, sizeof instance);
    return rc;
}

static int append_mesh(struct obj_materials *materials, const struct aiMesh *from, unsigned index,
                       struct fault *fault)
{
    struct builder *b = materials->builder;
    struct mesh mesh;
    struct scene_mesh record;
    char place[LIMIT_POINTER_BYTES];
    uint32_t material;
    snprintf(place, sizeof place, "group %u (%.150s)", index, from->mName.data);
    text_make_printable(place);
    if (!(from->mPrimitiveTypes & aiPrimitiveType_TRIANGLE)) {
        warnings_add(&b->warnings, place, "points and lines are ignored");
        return 0;
    }
    int rc = obj_material_get(materials, from->mMaterialIndex, &material, fault);
    if (rc == 0 && from->mColors[0] != NULL)
        rc = colored_material_get(&materials->colored, b, material, &material, fault);
    if (rc == 0) rc = copy_mesh(from, place, &b->warnings, &mesh, fault);
    if (rc != 0) return rc;
    rc = mesh_append(&mesh, b, &record, fault);
    record.material = material;
    if (rc == 0) rc = append_records(b, from->mName.data, &record, fault);
    mesh_fini(&mesh);
    return rc;
}

static int convert(const struct aiScene *scene, const struct mtl *mtl, struct files *files,
                   const char *name, struct builder *b, struct fault *fault)
{
    struct obj_materials materials;
    int rc = obj_materials_init(&materials, files, b, name, mtl, scene, fault);
    for (unsigned i = 0; rc == 0 && i < scene->mNumMeshes; i++)
        rc = append_mesh(&materials, scene->mMeshes[i], i, fault);
    obj_materials_fini(&materials);
    if (rc == 0 && builder_count(b, SCENE_TRIANGLES) == 0)
        rc = fault_set(fault, ERR_MISSING, "scene", "the scene has no triangles");
    return rc;
}

/* assimp goes by the file's extension; scenes named by their digest have none. */
static void set_alias(const char *name, char alias[LIMIT_PATH_BYTES])
{
    size_t length = strlen(name);
    bool plain = length > 4 && strcasecmp(name + length - 4, ".obj") == 0;
    snprintf(alias, LIMIT_PATH_BYTES, "%.500s%s", name, plain ? "" : ".obj");
}

/* assimp tells of a failed allocation in its text alone. */
static int refuse(const char *name, const char *why, struct fault *fault)
{
    if (strstr(why, "bad_alloc") != NULL)
        return fault_set(fault, ERR_MEMORY, name, "memory is exhausted");
    return fault_set(fault, ERR_SYNTAX, name, "assimp cannot read it: %.300s", why);
}

static int parse(const char *name, const struct file_view *main, struct aiPropertyStore *settings,
                 const struct aiScene **out, struct fault *fault)
{
    char alias[LIMIT_PATH_BYTES];
    struct obj_io io;
    set_alias(name, alias);
    obj_io_init(&io, alias, main);
    *out = aiImportFileExWithProperties(alias, STEPS, &io.callbacks, settings);
    return *out != NULL ? 0 : refuse(name, aiGetErrorString(), fault);
}

static void set_origin(struct builder *b, const char *name, const struct obj_near *near)
{
    origin_move_scene(b, name);
    for (int i = 0; i < 3; i++) b->origin[i] += near->origin[i];
}

int obj_import(struct files *files, const char *name, const struct file_view *main,
               struct builder *builder, struct fault *fault)
{
    struct mtl mtl;
    struct obj_near near = {0};
    const struct aiScene *scene = NULL;
    if (main->size_bytes < LEAST_BYTES)
        return fault_set(fault, ERR_TRUNCATED, name, "%zu bytes are no scene", main->size_bytes);
    int rc = mtl_read(&mtl, files, name, main, &builder->warnings, fault);
    if (rc != 0) return rc;
    struct aiPropertyStore *settings = aiCreatePropertyStore();
    if (settings == NULL)
        rc = fault_set(fault, ERR_MEMORY, name, "no memory for assimp");
    else
        rc = obj_near_open(&near, name, main, fault);
    if (rc == 0) rc = parse(name, &near.view, settings, &scene, fault);
    if (rc == 0 && scene != NULL) rc = convert(scene, &mtl, files, name, builder, fault);
    if (rc == 0) set_origin(builder, name, &near);
    obj_near_close(&near);
    aiReleaseImport(scene);
    if (settings != NULL) aiReleasePropertyStore(settings);
    mtl_fini(&mtl);
    return rc;
}
