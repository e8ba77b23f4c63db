#include "server/import/draco/draco_shim.h"

#include <draco/compression/decode.h>

#include <memory>
#include <new>

#include "server/import/draco/draco_claims.h"

struct draco_shim {
    std::unique_ptr<draco::Mesh> mesh;
};

namespace
{
draco_shim_status decode(const uint8_t *data, size_t size_bytes, draco_shim **out)
{
    if (!draco_claims_fit(data, size_bytes)) return DRACO_SHIM_DAMAGED;
    draco::DecoderBuffer buffer;
    draco::Decoder decoder;
    buffer.Init(reinterpret_cast<const char *>(data), size_bytes);
    auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
    if (!mesh.ok()) return DRACO_SHIM_DAMAGED;
    auto shim = std::make_unique<draco_shim>();
    shim->mesh = std::move(mesh).value();
    if (!shim->mesh) return DRACO_SHIM_DAMAGED;
    *out = shim.release();
    return DRACO_SHIM_OK;
}
} // namespace

draco_shim_status draco_shim_decode(const uint8_t *data, size_t size_bytes, draco_shim **out)
{
    try {
        return decode(data, size_bytes, out);
    } catch (const std::bad_alloc &) {
        return DRACO_SHIM_NO_MEMORY;
    } catch (...) { /* std::length_error, ...: of sizes that lie */
        return DRACO_SHIM_DAMAGED;
    }
}

void draco_shim_destroy(draco_shim **mesh)
{
    delete *mesh;
    *mesh = nullptr;
}

uint32_t draco_shim_vertices(const draco_shim *mesh)
{
    return mesh->mesh->num_points();
}

uint32_t draco_shim_triangles(const draco_shim *mesh)
{
    return mesh->mesh->num_faces();
}

int draco_shim_indices(const draco_shim *mesh, uint32_t *out)
{
    const uint32_t vertices = mesh->mesh->num_points();
    for (draco::FaceIndex f(0); f < mesh->mesh->num_faces(); ++f) {
        const draco::Mesh::Face &face = mesh->mesh->face(f);
        for (int k = 0; k < 3; k++) {
            if (face[k].value() >= vertices) return 0;
            *out++ = face[k].value();
        }
    }
    return 1;
}

uint32_t draco_shim_components(const draco_shim *mesh, uint32_t id)
{
    const draco::PointAttribute *attribute = mesh->mesh->GetAttributeByUniqueId(id);
    return attribute ? static_cast<uint32_t>(attribute->num_components()) : 0;
}

int draco_shim_floats(const draco_shim *mesh, uint32_t id, uint32_t components, float *out)
{
    const draco::PointAttribute *found = mesh->mesh->GetAttributeByUniqueId(id);
    if (!found || components > 4) return 0;
    if (found->data_type() == draco::DT_BOOL) return 0; /* glTF has none; 2 would be one here */
    draco::GeometryAttribute raw = *found;              /* shares the buffer */
    raw.set_normalized(false);
    for (draco::PointIndex i(0); i < mesh->mesh->num_points(); ++i) {
        const draco::AttributeValueIndex value = found->mapped_index(i);
        if (value.value() >= found->size()) return 0;
        if (!raw.ConvertValue<float>(value, static_cast<int8_t>(components), out)) return 0;
        out += components;
    }
    return 1;
}
