/* How the surface's coat and inside differ from glTF's core: Khronos' extensions. */
#include <float.h>
#include <math.h>

#include "server/import/gltf/gltf_material.h"

#define TURN 6.283185307179586

static int read_specular(struct gltf *g, const json_t *json, const char *place,
                         struct scene_material *m, struct fault *fault)
{
    const json_t *extension, *info;
    gltf_place at;
    int rc = gltf_extension(json, place, "KHR_materials_specular", &extension, at, fault);
    if (rc == 0) rc = gltf_float(extension, at, "specularFactor", 0, 1, &m->specular, fault);
    if (rc == 0)
        rc = gltf_floats(extension, at, "specularColorFactor", 3, 0, 1e6, m->specular_color, fault);
    if (rc == 0)
        rc = gltf_texture_read(g, extension, at, "specularTexture", false, &m->specular_texture,
                               &info, fault);
    if (rc == 0)
        rc = gltf_texture_read(g, extension, at, "specularColorTexture", true,
                               &m->specular_color_texture, &info, fault);
    return rc;
}

static int read_ior(const json_t *json, const char *place, struct scene_material *m,
                    struct fault *fault)
{
    const json_t *extension;
    gltf_place at;
    int rc = gltf_extension(json, place, "KHR_materials_ior", &extension, at, fault);
    if (rc == 0) rc = gltf_float(extension, at, "ior", 0, 1000, &m->ior, fault);
    if (rc == 0 && m->ior > 0 && m->ior < 1) /* 0 stands for infinity */
        rc = fault_set(fault, ERR_RANGE, at, "an ior of %g is below 1", (double)m->ior);
    return rc;
}

static int read_transmission(struct gltf *g, const json_t *json, const char *place,
                             struct scene_material *m, struct fault *fault)
{
    const json_t *extension, *info;
    gltf_place at;
    int rc = gltf_extension(json, place, "KHR_materials_transmission", &extension, at, fault);
    if (rc == 0)
        rc = gltf_float(extension, at, "transmissionFactor", 0, 1, &m->transmission, fault);
    if (rc == 0)
        rc = gltf_texture_read(g, extension, at, "transmissionTexture", false,
                               &m->transmission_texture, &info, fault);
    return rc;
}

/* An absent distance is infinite: a clear solid. */
static int read_attenuation(const json_t *extension, const char *place, struct scene_material *m,
                            struct fault *fault)
{
    double distance = INFINITY;
    int rc = gltf_floats(extension, place, "attenuationColor", 3, 0, 1, m->attenuation, fault);
    if (rc == 0)
        rc = gltf_number(extension, place, "attenuationDistance", 0, DBL_MAX, &distance, fault);
    if (rc == 0 && !(distance >= (double)FLT_MIN))
        return fault_set(fault, ERR_RANGE, place, "an attenuationDistance of %g is not above 0",
                         distance);
    if (distance <= (double)LIMIT_COORDINATE) m->attenuation_distance = (float)distance;
    for (int i = 0; i < 3; i++) /* 0 becomes the least that has a logarithm */
        if (m->attenuation[i] < FLT_MIN) m->attenuation[i] = FLT_MIN;
    return rc;
}

static int read_dispersion(const json_t *json, const char *place, struct scene_material *m,
                           struct fault *fault)
{
    const json_t *extension;
    gltf_place at;
    int rc = gltf_extension(json, place, "KHR_materials_dispersion", &extension, at, fault);
    return rc == 0 ? gltf_float(extension, at, "dispersion", 0, 1000, &m->dispersion, fault) : rc;
}

static int read_iridescence(struct gltf *g, const json_t *json, const char *place,
                            struct scene_material *m, struct fault *fault)
{
    const json_t *extension, *info;
    gltf_place at;
    int rc = gltf_extension(json, place, "KHR_materials_iridescence", &extension, at, fault);
    if (rc == 0) rc = gltf_float(extension, at, "iridescenceFactor", 0, 1, &m->iridescence, fault);
    if (rc == 0)
        rc = gltf_float(extension, at, "iridescenceIor", 1, 1000, &m->iridescence_ior, fault);
    if (rc == 0)
        rc = gltf_float(extension, at, "iridescenceThicknessMinimum", 0, 1e6, &m->iridescence_nm[0],
                        fault);
    if (rc == 0)
        rc = gltf_float(extension, at, "iridescenceThicknessMaximum", 0, 1e6, &m->iridescence_nm[1],
                        fault);
    if (rc == 0)
        rc = gltf_texture_read(g, extension, at, "iridescenceTexture", false,
                               &m->iridescence_texture, &info, fault);
    if (rc == 0)
        rc = gltf_texture_read(g, extension, at, "iridescenceThicknessTexture", false,
                               &m->iridescence_thickness_texture, &info, fault);
    return rc;
}

static int read_diffuse_transmission(struct gltf *g, const json_t *json, const char *place,
                                     struct scene_material *m, struct fault *fault)
{
    const json_t *extension, *info;
    gltf_place at;
    int rc =
        gltf_extension(json, place, "KHR_materials_diffuse_transmission", &extension, at, fault);
    if (rc == 0)
        rc = gltf_float(extension, at, "diffuseTransmissionFactor", 0, 1, &m->diffuse_transmission,
                        fault);
    if (rc == 0)
        rc = gltf_floats(extension, at, "diffuseTransmissionColorFactor", 3, 0, 1,
                         m->diffuse_transmission_color, fault);
    if (rc == 0)
        rc = gltf_texture_read(g, extension, at, "diffuseTransmissionTexture", false,
                               &m->diffuse_transmission_texture, &info, fault);
    if (rc == 0)
        rc = gltf_texture_read(g, extension, at, "diffuseTransmissionColorTexture", true,
                               &m->diffuse_transmission_color_texture, &info, fault);
    return rc;
}

static int read_volume(struct gltf *g, const json_t *json, const char *place,
                       struct scene_material *m, struct fault *fault)
{
    const json_t *extension;
    gltf_place at;
    const double far = (double)LIMIT_COORDINATE;
    int rc = gltf_extension(json, place, "KHR_materials_volume", &extension, at, fault);
    if (rc != 0 || extension == NULL) return rc;
    rc = gltf_float(extension, at, "thicknessFactor", 0, far, &m->thickness, fault);
    if (rc == 0) rc = read_attenuation(extension, at, m, fault);
    bool solid = m->thickness > 0 && (m->transmission > 0 || m->diffuse_transmission > 0);
    const json_t *texture = NULL;
    if (rc == 0) rc = gltf_object(extension, at, "thicknessTexture", &texture, fault);
    if (rc != 0 || texture == NULL) return rc;
    if (solid)
        warnings_add(&g->builder->warnings, at,
                     "thicknessTexture is ignored: paths find how thick the solid is");
    gltf_place map;
    uint32_t unused = SCENE_NONE;
    gltf_place_set(map, "%s.thicknessTexture", at);
    return gltf_index(texture, map, "index", gltf_count(g->root, "textures"), &unused, fault);
}

static int read_anisotropy(struct gltf *g, const json_t *json, const char *place,
                           struct scene_material *m, struct fault *fault)
{
    const json_t *extension, *info;
    gltf_place at;
    double rotation = 0;
    int rc = gltf_extension(json, place, "KHR_materials_anisotropy", &extension, at, fault);
    if (rc == 0) rc = gltf_float(extension, at, "anisotropyStrength", 0, 1, &m->anisotropy, fault);
    if (rc == 0) rc = gltf_number(extension, at, "anisotropyRotation", -1e6, 1e6, &rotation, fault);
    if (rc == 0)
        rc = gltf_texture_read(g, extension, at, "anisotropyTexture", false, &m->anisotropy_texture,
                               &info, fault);
    m->anisotropy_rad = (float)remainder(rotation, TURN);
    return rc;
}

static int read_clearcoat(struct gltf *g, const json_t *json, const char *place,
                          struct scene_material *m, struct fault *fault)
{
    const json_t *extension, *info;
    gltf_place at;
    int rc = gltf_extension(json, place, "KHR_materials_clearcoat", &extension, at, fault);
    if (rc == 0) rc = gltf_float(extension, at, "clearcoatFactor", 0, 1, &m->clearcoat, fault);
    if (rc == 0)
        rc = gltf_float(extension, at, "clearcoatRoughnessFactor", 0, 1, &m->clearcoat_roughness,
                        fault);
    if (rc == 0)
        rc = gltf_texture_read(g, extension, at, "clearcoatTexture", false, &m->clearcoat_texture,
                               &info, fault);
    if (rc == 0)
        rc = gltf_texture_read(g, extension, at, "clearcoatRoughnessTexture", false,
                               &m->clearcoat_roughness_texture, &info, fault);
    if (rc == 0)
        rc = gltf_texture_read(g, extension, at, "clearcoatNormalTexture", false,
                               &m->clearcoat_normal_texture, &info, fault);
    if (rc != 0) return rc;
    gltf_place map;
    gltf_place_set(map, "%s.clearcoatNormalTexture", at);
    return gltf_float(info, map, "scale", -1e6, 1e6, &m->clearcoat_normal_scale, fault);
}

static int read_sheen(struct gltf *g, const json_t *json, const char *place,
                      struct scene_material *m, struct fault *fault)
{
    const json_t *extension, *info;
    gltf_place at;
    int rc = gltf_extension(json, place, "KHR_materials_sheen", &extension, at, fault);
    if (rc == 0)
        rc = gltf_floats(extension, at, "sheenColorFactor", 3, 0, 1, m->sheen_color, fault);
    if (rc == 0)
        rc = gltf_float(extension, at, "sheenRoughnessFactor", 0, 1, &m->sheen_roughness, fault);
    if (rc == 0)
        rc = gltf_texture_read(g, extension, at, "sheenColorTexture", true, &m->sheen_color_texture,
                               &info, fault);
    if (rc == 0)
        rc = gltf_texture_read(g, extension, at, "sheenRoughnessTexture", false,
                               &m->sheen_roughness_texture, &info, fault);
    return rc;
}

int gltf_material_extensions_read(struct gltf *g, const json_t *json, const char *place,
                                  struct scene_material *m, struct fault *fault)
{
    int rc = read_specular(g, json, place, m, fault);
    if (rc == 0) rc = read_ior(json, place, m, fault);
    if (rc == 0) rc = read_transmission(g, json, place, m, fault);
    if (rc == 0) rc = read_dispersion(json, place, m, fault);
    if (rc == 0) rc = read_iridescence(g, json, place, m, fault);
    if (rc == 0) rc = read_diffuse_transmission(g, json, place, m, fault);
    if (rc == 0) rc = read_volume(g, json, place, m, fault);
    if (rc == 0) rc = read_anisotropy(g, json, place, m, fault);
    if (rc == 0) rc = read_clearcoat(g, json, place, m, fault);
    if (rc == 0) rc = read_sheen(g, json, place, m, fault);
    return rc;
}
