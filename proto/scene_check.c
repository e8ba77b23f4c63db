#include "proto/scene_check.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "proto/plan.h"

/* Floats that were unit vectors before they were rounded. */
#define UNIT_TOLERANCE 1e-2f

/* A matrix whose columns enclose less of their box than this is not safely invertible. */
#define VOLUME_MIN 1e-9

#define VALUE_MAX      1e6f /* scales, texture coordinates' factors */
#define IOR_MAX        1e3f /* of real materials below 5 */
#define EXPONENT_MAX   1e5f /* as struct bsdf takes them */
#define TURN_MAX       6.2832f
#define MESH_FLAGS     (MESH_HAS_NORMALS | MESH_HAS_TANGENTS | MESH_IS_LIGHT)
#define MATERIAL_FLAGS (MATERIAL_DOUBLE_SIDED | MATERIAL_UNLIT)

/* The record that is being checked. */
struct record {
    const struct scene *scene;
    uint32_t section;
    uint64_t index;
    struct fault *fault;
};

static int refuse(const struct record *at, const char *field, int code, double value,
                  const char *why)
{
    char pointer[LIMIT_POINTER_BYTES];
    snprintf(pointer, sizeof pointer, "%s[%llu]%s%s", scene_section_name(at->section),
             (unsigned long long)at->index, field[0] ? "." : "", field);
    return fault_set(at->fault, code, pointer, "%.9g %s", value, why);
}

static int check_number(const struct record *at, const char *field, float v, float min, float max)
{
    if (!isfinite(v)) return refuse(at, field, ERR_NOT_FINITE, (double)v, "is not finite");
    if (v < min) return refuse(at, field, ERR_RANGE, (double)v, "is too small");
    if (v > max) return refuse(at, field, ERR_RANGE, (double)v, "is too large");
    return 0;
}

static int check_numbers(const struct record *at, const char *field, const float *v, size_t count,
                         float min, float max)
{
    int error = 0;
    for (size_t i = 0; i < count && !error; i++) error = check_number(at, field, v[i], min, max);
    return error;
}

/* An index into a section. */
static int check_index(const struct record *at, const char *field, uint32_t index, uint32_t section)
{
    if (index < at->scene->count[section]) return 0;
    return refuse(at, field, ERR_RANGE, index, "is an index past the end");
}

static int check_optional(const struct record *at, const char *field, uint32_t index,
                          uint32_t section)
{
    return index == SCENE_NONE ? 0 : check_index(at, field, index, section);
}

/* A stretch of a section. */
static int check_range(const struct record *at, const char *field, uint32_t first, uint64_t count,
                       uint32_t section)
{
    if (first + count <= at->scene->count[section]) return 0;
    return refuse(at, field, ERR_RANGE, first, "starts a range that passes the end");
}

static int check_value(const struct record *at, const char *field, uint32_t value, uint32_t max)
{
    return value <= max ? 0 : refuse(at, field, ERR_RANGE, value, "is no known value");
}

static int check_flags(const struct record *at, uint32_t flags, uint32_t known)
{
    return flags & ~known ? refuse(at, "flags", ERR_RANGE, flags, "has unknown bits") : 0;
}

static int check_reserved(const struct record *at, uint32_t reserved)
{
    return reserved ? refuse(at, "reserved", ERR_RANGE, reserved, "is not 0") : 0;
}

/* Arrays of floats: a branchless pass, and a search only after a fault. */
static int check_floats(const struct scene *s, uint32_t section, const float *v,
                        uint32_t per_record, struct fault *fault)
{
    const uint64_t count = s->count[section] * per_record;
    bool good = true;
    for (uint64_t i = 0; i < count; i++) good &= fabsf(v[i]) <= LIMIT_COORDINATE;
    if (good) return 0;
    uint64_t i = 0;
    while (fabsf(v[i]) <= LIMIT_COORDINATE) i++;
    const struct record at = {s, section, i / per_record, fault};
    if (!isfinite(v[i])) return refuse(&at, "", ERR_NOT_FINITE, (double)v[i], "is not finite");
    return refuse(&at, "", ERR_RANGE, (double)v[i], "is too large");
}

static bool is_unit(const float *v)
{
    return fabsf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] - 1.0f) <= 2.0f * UNIT_TOLERANCE;
}

static int check_units(const struct scene *s, uint32_t section, const float *v, uint32_t per_record,
                       struct fault *fault)
{
    const int error = check_floats(s, section, v, per_record, fault);
    if (error) return error;
    for (uint64_t i = 0; i < s->count[section]; i++) {
        const struct record at = {s, section, i, fault};
        const float *record = v + i * per_record;
        if (!is_unit(record))
            return refuse(&at, "", ERR_RANGE, (double)record[0],
                          "begins a vector that is not unit");
        if (per_record == 4 && fabsf(record[3]) != 1.0f)
            return refuse(&at, "w", ERR_RANGE, (double)record[3], "is neither 1 nor -1");
    }
    return 0;
}

static int check_name(const struct record *at, uint32_t name)
{
    return check_index(at, "name", name, SCENE_NAMES);
}

static int check_info(const struct scene *s, struct fault *fault)
{
    const struct record at = {s, SCENE_INFO, 0, fault};
    if (s->count[SCENE_INFO] != 1) return fault_set(fault, ERR_MISSING, "info", "there is none");
    const struct scene_info *info = s->info;
    const float far = LIMIT_COORDINATE;
    int error = check_numbers(&at, "bounds_min", info->bounds_min, 3, -far, far);
    for (int i = 0; i < 3 && !error; i++)
        error = check_number(&at, "bounds_max", info->bounds_max[i], info->bounds_min[i], far);
    if (!error) error = check_index(&at, "default_camera", info->default_camera, SCENE_CAMERAS);
    if (!error) error = check_reserved(&at, info->reserved);
    return error;
}

static int check_strings(const struct scene *s, struct fault *fault)
{
    const uint64_t names = s->count[SCENE_NAMES], warnings = s->count[SCENE_WARNINGS];
    if (names == 0 || s->names[0] != '\0' || s->names[names - 1] != '\0')
        return fault_set(fault, ERR_CORRUPT, "names", "does not begin and end with a NUL byte");
    if (warnings > 0 && s->warnings[warnings - 1] != '\0')
        return fault_set(fault, ERR_CORRUPT, "warnings", "does not end with a NUL byte");
    return 0;
}

static int check_triangles(const struct record *at, const struct scene_mesh *mesh)
{
    const uint32_t *v = at->scene->triangles + 3 * (uint64_t)mesh->first_triangle;
    const uint64_t count = 3 * (uint64_t)mesh->triangle_count;
    uint32_t greatest = 0;
    for (uint64_t i = 0; i < count; i++) greatest = v[i] > greatest ? v[i] : greatest;
    if (count == 0 || greatest < mesh->vertex_count) return 0;
    uint64_t i = 0;
    while (v[i] < mesh->vertex_count) i++;
    const struct record triangle = {at->scene, SCENE_TRIANGLES, mesh->first_triangle + i / 3,
                                    at->fault};
    return refuse(&triangle, "", ERR_RANGE, v[i], "is an index past its mesh's vertices");
}

/* An array that runs parallel to the mesh's vertices if `present`. */
static int check_parallel(const struct record *at, const char *field, bool present, uint32_t first,
                          uint32_t vertex_count, uint32_t section)
{
    if (present) return check_range(at, field, first, vertex_count, section);
    return first == 0 ? 0 : refuse(at, field, ERR_RANGE, first, "though the mesh has none");
}

static int check_mesh(const struct record *at, const struct scene_mesh *m)
{
    const uint32_t n = m->vertex_count;
    int error = check_flags(at, m->flags, MESH_FLAGS);
    if (!error) error = check_range(at, "first_vertex", m->first_vertex, n, SCENE_POSITIONS);
    if (!error)
        error = check_range(at, "first_triangle", m->first_triangle, m->triangle_count,
                            SCENE_TRIANGLES);
    if (!error)
        error = check_parallel(at, "first_normal", m->flags & MESH_HAS_NORMALS, m->first_normal, n,
                               SCENE_NORMALS);
    if (!error)
        error = check_parallel(at, "first_tangent", m->flags & MESH_HAS_TANGENTS, m->first_tangent,
                               n, SCENE_TANGENTS);
    for (int set = 0; set < 2 && !error; set++)
        if (m->first_uv[set] != SCENE_NONE)
            error = check_range(at, "first_uv", m->first_uv[set], n, SCENE_UVS);
    if (!error) error = check_index(at, "material", m->material, SCENE_MATERIALS);
    if (!error) error = check_name(at, m->name);
    if (!error) error = check_reserved(at, m->reserved);
    return error ? error : check_triangles(at, m);
}

static bool is_invertible(const float m[12])
{
    double lengths = 1.0, c[3][3];
    for (int column = 0; column < 3; column++) {
        for (int row = 0; row < 3; row++) c[column][row] = (double)m[4 * row + column];
        lengths *= sqrt(c[column][0] * c[column][0] + c[column][1] * c[column][1] +
                        c[column][2] * c[column][2]);
    }
    const double volume = c[0][0] * (c[1][1] * c[2][2] - c[1][2] * c[2][1]) -
                          c[0][1] * (c[1][0] * c[2][2] - c[1][2] * c[2][0]) +
                          c[0][2] * (c[1][0] * c[2][1] - c[1][1] * c[2][0]);
    return fabs(volume) >= 1e-36 && fabs(volume) >= VOLUME_MIN * lengths;
}

static int check_instance(const struct record *at, const struct scene_instance *instance)
{
    static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const float far = LIMIT_COORDINATE;
    int error = check_flags(at, instance->flags, INSTANCE_IDENTITY);
    if (!error) error = check_index(at, "mesh", instance->mesh, SCENE_MESHES);
    if (!error) error = check_name(at, instance->name);
    if (!error) error = check_reserved(at, instance->reserved);
    if (!error) error = check_numbers(at, "to_world", instance->to_world, 12, -far, far);
    if (error) return error;
    if (!is_invertible(instance->to_world))
        return refuse(at, "to_world", ERR_RANGE, (double)instance->to_world[0],
                      "begins a matrix that has no inverse");
    if (!(instance->flags & INSTANCE_IDENTITY)) return 0;
    for (int i = 0; i < 12; i++)
        if (instance->to_world[i] != identity[i])
            return refuse(at, "to_world", ERR_MISMATCH, (double)instance->to_world[i],
                          "is not the identity's, though flagged so");
    return 0;
}

static int check_texture_ref(const struct record *at, const char *field,
                             const struct scene_texture_ref *ref)
{
    int error = check_optional(at, field, ref->texture, SCENE_TEXTURES);
    if (!error) error = check_value(at, field, ref->uv_set, 1);
    if (!error) error = check_numbers(at, field, ref->transform, 6, -VALUE_MAX, VALUE_MAX);
    return error;
}

/* An index of refraction from outside; 0 stands for infinity. */
static int check_ior(const struct record *at, float ior)
{
    const int error = check_number(at, "ior", ior, 0.0f, IOR_MAX);
    if (error || ior == 0.0f || ior >= 1.0f) return error;
    return refuse(at, "ior", ERR_RANGE, (double)ior, "is neither 0 nor at least 1");
}

static int check_surface(const struct record *at, const struct scene_material *m)
{
    int error = check_numbers(at, "base_color", m->base_color, 4, 0.0f, 1.0f);
    if (!error) error = check_numbers(at, "emission", m->emission, 3, 0.0f, LIMIT_RADIANCE);
    if (!error) error = check_number(at, "metallic", m->metallic, 0.0f, 1.0f);
    if (!error) error = check_number(at, "roughness", m->roughness, 0.0f, 1.0f);
    if (!error) error = check_number(at, "normal_scale", m->normal_scale, -VALUE_MAX, VALUE_MAX);
    if (!error) error = check_number(at, "alpha_cutoff", m->alpha_cutoff, 0.0f, VALUE_MAX);
    if (!error) error = check_number(at, "specular", m->specular, 0.0f, 1.0f);
    if (!error) error = check_ior(at, m->ior);
    if (!error) error = check_number(at, "transmission", m->transmission, 0.0f, 1.0f);
    if (!error) error = check_numbers(at, "specular_color", m->specular_color, 3, 0.0f, VALUE_MAX);
    if (!error) error = check_number(at, "anisotropy", m->anisotropy, 0.0f, 1.0f);
    if (!error) error = check_number(at, "anisotropy_rad", m->anisotropy_rad, -TURN_MAX, TURN_MAX);
    return error;
}

static int check_volume(const struct record *at, const struct scene_material *m)
{
    int error = check_number(at, "thickness", m->thickness, 0.0f, LIMIT_COORDINATE);
    if (!error) error = check_numbers(at, "attenuation", m->attenuation, 3, FLT_MIN, 1.0f);
    if (!error)
        error = check_number(at, "attenuation_distance", m->attenuation_distance, 0.0f,
                             LIMIT_COORDINATE);
    return error;
}

static int check_model(const struct record *at, const struct scene_material *m)
{
    int error = check_value(at, "model", m->model, MODEL_COUNT - 1);
    if (!error) error = check_numbers(at, "model_specular", m->model_specular, 3, 0.0f, 1.0f);
    if (!error) error = check_number(at, "exponent_u", m->exponent_u, 0.0f, EXPONENT_MAX);
    if (!error) error = check_number(at, "exponent_v", m->exponent_v, 0.0f, EXPONENT_MAX);
    if (!error) error = check_number(at, "alpha_u", m->alpha_u, 0.0f, 1.0f);
    if (!error) error = check_numbers(at, "eta", m->eta, 3, 0.0f, IOR_MAX);
    if (!error) error = check_numbers(at, "k", m->k, 3, 0.0f, IOR_MAX);
    return error;
}

static int check_material_textures(const struct record *at, const struct scene_material *m)
{
    const struct {
        const char *field;
        const struct scene_texture_ref *ref;
    } all[] = {{"base_color_texture", &m->base_color_texture},
               {"metallic_roughness_texture", &m->metallic_roughness_texture},
               {"normal_texture", &m->normal_texture},
               {"emission_texture", &m->emission_texture},
               {"transmission_texture", &m->transmission_texture},
               {"specular_texture", &m->specular_texture},
               {"specular_color_texture", &m->specular_color_texture},
               {"anisotropy_texture", &m->anisotropy_texture}};
    int error = 0;
    for (size_t i = 0; i < sizeof all / sizeof all[0] && !error; i++)
        error = check_texture_ref(at, all[i].field, all[i].ref);
    return error;
}

static int check_material(const struct record *at, const struct scene_material *m)
{
    int error = check_surface(at, m);
    if (!error) error = check_volume(at, m);
    if (!error) error = check_model(at, m);
    if (!error) error = check_value(at, "alpha_mode", m->alpha_mode, ALPHA_BLEND);
    if (!error) error = check_flags(at, m->flags, MATERIAL_FLAGS);
    if (!error) error = check_name(at, m->name);
    if (!error) error = check_reserved(at, m->reserved[0] | m->reserved[1]);
    return error ? error : check_material_textures(at, m);
}

static int check_texture(const struct record *at, const struct scene_texture *t)
{
    int error = check_index(at, "image", t->image, SCENE_IMAGES);
    if (!error) error = check_value(at, "wrap_u", t->wrap_u, WRAP_MIRROR);
    if (!error) error = check_value(at, "wrap_v", t->wrap_v, WRAP_MIRROR);
    if (!error) error = check_value(at, "filter", t->filter, FILTER_NEAREST);
    return error;
}

static int check_image(const struct record *at, const struct scene_image *image)
{
    const uint32_t width = image->width_px, height = image->height_px;
    if (width < 1 || width > LIMIT_TEXTURE_SIDE_PX)
        return refuse(at, "width_px", ERR_LIMIT, width, "is no width of an image");
    if (height < 1 || height > LIMIT_TEXTURE_SIDE_PX)
        return refuse(at, "height_px", ERR_LIMIT, height, "is no height of an image");
    int error = check_value(at, "format", image->format, IMAGE_RGBA8);
    if (!error) error = check_flags(at, image->flags, IMAGE_IS_SRGB);
    if (!error) error = check_name(at, image->name);
    if (!error) error = check_reserved(at, image->reserved);
    if (error) return error;
    const uint64_t need_bytes = 4ull * width * height, have_bytes = at->scene->count[SCENE_PIXELS];
    if (need_bytes > have_bytes || image->first_byte > have_bytes - need_bytes)
        return refuse(at, "first_byte", ERR_RANGE, (double)image->first_byte,
                      "puts the image past the pixels' end");
    return 0;
}

static int check_light(const struct record *at, const struct scene_light *light)
{
    char place[64];
    struct plan_light as_planned = {.type = light->type,
                                    .profile = light->profile,
                                    .cos_inner = light->cos_inner,
                                    .cos_outer = light->cos_outer,
                                    .range = light->range};
    memcpy(as_planned.position, light->position, sizeof light->position);
    memcpy(as_planned.direction, light->direction, sizeof light->direction);
    memcpy(as_planned.half_u, light->half_u, sizeof light->half_u);
    memcpy(as_planned.half_v, light->half_v, sizeof light->half_v);
    memcpy(as_planned.color, light->color, sizeof light->color);
    snprintf(place, sizeof place, "lights[%llu]", (unsigned long long)at->index);
    int error = plan_light_check(&as_planned, place, at->fault);
    if (!error) error = check_optional(at, "instance", light->instance, SCENE_INSTANCES);
    if (!error) error = check_name(at, light->name);
    return error;
}

static int check_lens(const struct record *at, const struct scene_camera *camera)
{
    const float far = LIMIT_COORDINATE;
    int error = check_number(at, "yfov_rad", camera->yfov_rad, 0.0f, 3.1415f);
    if (!error) error = check_number(at, "half_width", camera->half_width, 0.0f, far);
    if (!error) error = check_number(at, "half_height", camera->half_height, 0.0f, far);
    if (error) return error;
    if (camera->type == CAMERA_PERSPECTIVE)
        return check_number(at, "yfov_rad", camera->yfov_rad, 1e-6f, 3.1415f);
    error = check_number(at, "half_width", camera->half_width, 1e-8f, far);
    return error ? error : check_number(at, "half_height", camera->half_height, 1e-8f, far);
}

static int check_camera(const struct record *at, const struct scene_camera *camera)
{
    char place[64];
    /* Its size on the image plane depends on the image; the rest is judged as in a plan. */
    struct plan_camera as_planned = {.type = camera->type, .half_width = 1, .half_height = 1};
    memcpy(as_planned.eye, camera->eye, sizeof camera->eye);
    memcpy(as_planned.right, camera->right, sizeof camera->right);
    memcpy(as_planned.up, camera->up, sizeof camera->up);
    memcpy(as_planned.forward, camera->forward, sizeof camera->forward);
    snprintf(place, sizeof place, "cameras[%llu]", (unsigned long long)at->index);
    int error = plan_camera_check(&as_planned, place, at->fault);
    if (!error) error = check_name(at, camera->name);
    if (!error) error = check_number(at, "aspect", camera->aspect, 0.0f, VALUE_MAX);
    if (!error) error = check_lens(at, camera);
    if (!error) error = check_value(at, "is_default", camera->is_default, 1);
    if (!error) error = check_reserved(at, camera->reserved);
    return error;
}

/* The sum is a number like others: planners size their work by it. */
static int check_placed(const struct scene *s, struct fault *fault)
{
    uint64_t placed = 0;
    for (uint64_t i = 0; i < s->count[SCENE_INSTANCES]; i++)
        placed += s->meshes[s->instances[i].mesh].triangle_count;
    if (placed == s->info->placed_triangles) return 0;
    return fault_set(fault, ERR_MISMATCH, "info[0].placed_triangles", "%llu, but %llu are placed",
                     (unsigned long long)s->info->placed_triangles, (unsigned long long)placed);
}

/* Meshes that differ in material alone may share their arrays. The cap keeps the cost of checking
 * all of them that of the largest scene. */
static int check_shares(const struct scene *s, struct fault *fault)
{
    uint64_t shares = 0;
    for (uint64_t i = 0; i < s->count[SCENE_MESHES]; i++) shares += s->meshes[i].triangle_count;
    if (shares <= LIMIT_TRIANGLES) return 0;
    return fault_set(fault, ERR_LIMIT, "meshes", "they have %llu triangles, more than %u",
                     (unsigned long long)shares, LIMIT_TRIANGLES);
}

/* Runs a record's check over a section. */
#define CHECK_SECTION(s, section, records, check, fault)                                           \
    do {                                                                                           \
        for (uint64_t i = 0; i < (s)->count[section]; i++) {                                       \
            const struct record at = {s, section, i, fault};                                       \
            const int error_of_record = check(&at, &(records)[i]);                                 \
            if (error_of_record) return error_of_record;                                           \
        }                                                                                          \
    } while (0)

static int check_records(const struct scene *s, struct fault *fault)
{
    CHECK_SECTION(s, SCENE_MESHES, s->meshes, check_mesh, fault);
    CHECK_SECTION(s, SCENE_INSTANCES, s->instances, check_instance, fault);
    CHECK_SECTION(s, SCENE_MATERIALS, s->materials, check_material, fault);
    CHECK_SECTION(s, SCENE_TEXTURES, s->textures, check_texture, fault);
    CHECK_SECTION(s, SCENE_IMAGES, s->images, check_image, fault);
    CHECK_SECTION(s, SCENE_LIGHTS, s->lights, check_light, fault);
    CHECK_SECTION(s, SCENE_CAMERAS, s->cameras, check_camera, fault);
    return 0;
}

int scene_check(const struct scene *s, struct fault *fault)
{
    if (s->count[SCENE_CAMERAS] == 0)
        return fault_set(fault, ERR_MISSING, "cameras", "there is none");
    int error = check_info(s, fault);
    if (!error) error = check_strings(s, fault);
    if (!error) error = check_floats(s, SCENE_POSITIONS, s->positions, 3, fault);
    if (!error) error = check_units(s, SCENE_NORMALS, s->normals, 3, fault);
    if (!error) error = check_units(s, SCENE_TANGENTS, s->tangents, 4, fault);
    if (!error) error = check_floats(s, SCENE_UVS, s->uvs, 2, fault);
    if (!error) error = check_shares(s, fault);
    if (!error) error = check_records(s, fault);
    if (!error) error = check_placed(s, fault);
    return error;
}
