#include "server/import/gltf/gltf_draco.h"

#include <inttypes.h>
#include <stdlib.h>

#include "server/import/draco/draco_shim.h"
#include "server/import/gltf/gltf_accessor.h"

bool gltf_draco_is(const json_t *primitive)
{
    return json_object_get(json_object_get(primitive, "extensions"),
                           "KHR_draco_mesh_compression") != NULL;
}

static int check_counts(const struct gltf_draco *d, struct fault *fault)
{
    const uint32_t vertices = draco_shim_vertices(d->mesh);
    const uint32_t triangles = draco_shim_triangles(d->mesh);
    if (vertices <= LIMIT_VERTICES && triangles <= LIMIT_TRIANGLES) return 0;
    return fault_set(fault, ERR_LIMIT, d->place,
                     "%" PRIu32 " vertices and %" PRIu32 " triangles are too many", vertices,
                     triangles);
}

static int decode(struct gltf *g, const struct gltf_view *view, struct fault *fault)
{
    struct gltf_draco *d = &g->draco;
    switch (draco_shim_decode(view->data, view->size_bytes, &d->mesh)) {
    case DRACO_SHIM_OK:
        return check_counts(d, fault);
    case DRACO_SHIM_NO_MEMORY:
        return fault_set(fault, ERR_MEMORY, d->place, "no memory for the compressed mesh");
    default:
        return fault_set(fault, ERR_CORRUPT, d->place,
                         "the compressed mesh is damaged, or not of Draco's bitstream 2.2");
    }
}

int gltf_draco_begin(struct gltf *g, const json_t *primitive, const char *place,
                     struct fault *fault)
{
    struct gltf_view view;
    const json_t *extension;
    uint32_t index = SCENE_NONE;
    struct gltf_draco *d = &g->draco;
    int rc =
        gltf_extension(primitive, place, "KHR_draco_mesh_compression", &extension, d->place, fault);
    if (rc == 0)
        rc = gltf_index(extension, d->place, "bufferView", gltf_count(g->root, "bufferViews"),
                        &index, fault);
    if (rc == 0) rc = gltf_object(extension, d->place, "attributes", &d->ids, fault);
    if (rc == 0 && (index == SCENE_NONE || d->ids == NULL))
        rc = fault_set(fault, ERR_MISSING, d->place, "it has no bufferView or no attributes");
    if (rc == 0) rc = gltf_view_open(g, index, &view, fault);
    return rc == 0 ? decode(g, &view, fault) : rc;
}

void gltf_draco_end(struct gltf *g)
{
    if (g->draco.mesh != NULL) draco_shim_destroy(&g->draco.mesh);
    g->draco = (struct gltf_draco){0};
}

int gltf_draco_triangles(struct gltf *g, struct mesh *out, struct fault *fault)
{
    const struct gltf_draco *d = &g->draco;
    out->triangle_count = draco_shim_triangles(d->mesh);
    out->triangles = malloc((3 * (size_t)out->triangle_count + 1) * sizeof *out->triangles);
    if (out->triangles == NULL)
        return fault_set(fault, ERR_MEMORY, d->place, "no memory for %" PRIu32 " triangles",
                         out->triangle_count);
    if (draco_shim_indices(d->mesh, out->triangles)) return 0;
    return fault_set(fault, ERR_CORRUPT, d->place, "an index is past the vertices");
}

/* The id of an attribute in the stream; SCENE_NONE: it holds none. */
static int find_id(const struct gltf_draco *d, const char *key, uint32_t *out, struct fault *fault)
{
    gltf_place at;
    gltf_place_set(at, "%s.attributes", d->place);
    *out = SCENE_NONE;
    return d->mesh != NULL ? gltf_index(d->ids, at, key, UINT32_MAX, out, fault) : 0;
}

/* Numbers of the stream are plain; the accessor says what its integers mean. */
static int normalize(struct gltf *g, uint32_t accessor, float *values, size_t count,
                     struct fault *fault)
{
    float scale;
    int rc = gltf_accessor_scale(g, accessor, &scale, fault);
    for (size_t i = 0; rc == 0 && values != NULL && scale != 1 && i < count; i++)
        values[i] = values[i] * scale < -1 ? -1 : values[i] * scale;
    return rc;
}

static int read_stream(struct gltf *g, const char *key, uint32_t id, uint32_t *components,
                       uint32_t *count, float **out, struct fault *fault)
{
    const struct gltf_draco *d = &g->draco;
    const uint32_t has = draco_shim_components(d->mesh, id);
    gltf_place at;
    gltf_place_set(at, "%s.attributes.%s", d->place, key);
    if (has == 0) return fault_set(fault, ERR_RANGE, at, "the stream has no attribute %u", id);
    if (*components == 0) *components = has;
    if (has != *components || has > 4)
        return fault_set(fault, ERR_TYPE, at, "it has %u components where %u are needed", has,
                         *components);
    *count = draco_shim_vertices(d->mesh);
    *out = malloc(((size_t)*count * has + 1) * sizeof **out);
    if (*out == NULL) return fault_set(fault, ERR_MEMORY, at, "no memory for its vertices");
    if (draco_shim_floats(d->mesh, id, has, *out)) return 0;
    free(*out);
    *out = NULL;
    return fault_set(fault, ERR_CORRUPT, at, "its numbers cannot be read");
}

int gltf_vertex_floats(struct gltf *g, const char *key, uint32_t accessor, uint32_t *components,
                       uint32_t *count, float **out, struct fault *fault)
{
    uint32_t id;
    int rc = find_id(&g->draco, key, &id, fault);
    *out = NULL;
    if (rc != 0) return rc;
    if (id != SCENE_NONE) {
        rc = read_stream(g, key, id, components, count, out, fault);
        if (rc == 0) rc = normalize(g, accessor, *out, (size_t)*count * *components, fault);
        if (rc != 0) {
            free(*out);
            *out = NULL;
        }
        return rc;
    }
    if (*components == 0) rc = gltf_accessor_components(g, accessor, components, fault);
    return rc == 0 ? gltf_read_floats(g, accessor, *components, count, out, fault) : rc;
}
