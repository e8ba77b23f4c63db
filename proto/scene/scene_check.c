#include "proto/scene/scene_internal.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "proto/plan.h"

/* Floats that were unit vectors before they were rounded. */
#define UNIT_TOLERANCE 1e-2f

/* A matrix whose columns enclose less of their box than this is not safely invertible. */
#define VOLUME_MIN 1e-9

#define ASPECT_MAX 1e6f /* of a camera */
#define MESH_FLAGS                                                                                 \
    (MESH_HAS_NORMALS | MESH_HAS_TANGENTS | MESH_IS_LIGHT | MESH_HAS_COLORS | MESH_IN_BASE)

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
    const struct scene_record at = {s, section, i / per_record, fault};
    if (!isfinite(v[i]))
        return record_refuse(&at, "", ERR_NOT_FINITE, (double)v[i], "is not finite");
    return record_refuse(&at, "", ERR_RANGE, (double)v[i], "is too large");
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
        const struct scene_record at = {s, section, i, fault};
        const float *record = v + i * per_record;
        if (!is_unit(record))
            return record_refuse(&at, "", ERR_RANGE, (double)record[0],
                                 "begins a vector that is not unit");
        if (per_record == 4 && fabsf(record[3]) != 1.0f)
            return record_refuse(&at, "w", ERR_RANGE, (double)record[3], "is neither 1 nor -1");
    }
    return 0;
}

static int check_colors(const struct scene *s, struct fault *fault)
{
    bool good = true;
    for (uint64_t i = 0; i < 4 * s->count[SCENE_COLORS]; i++)
        good &= s->colors[i] >= 0.0f && s->colors[i] <= 1.0f;
    for (uint64_t i = 0; !good && i < s->count[SCENE_COLORS]; i++) {
        const struct scene_record at = {s, SCENE_COLORS, i, fault};
        const int error = record_numbers(&at, "", s->colors + 4 * i, 4, 0.0f, 1.0f);
        if (error) return error;
    }
    return 0;
}

static int check_info(const struct scene *s, struct fault *fault)
{
    const struct scene_record at = {s, SCENE_INFO, 0, fault};
    if (s->count[SCENE_INFO] != 1) return fault_set(fault, ERR_MISSING, "info", "there is none");
    const struct scene_info *info = s->info;
    const float far = LIMIT_COORDINATE;
    int error = record_numbers(&at, "bounds_min", info->bounds_min, 3, -far, far);
    for (int i = 0; i < 3 && !error; i++)
        error = record_number(&at, "bounds_max", info->bounds_max[i], info->bounds_min[i], far);
    const bool is_base = info->flags & SCENE_IS_BASE;
    if (!error && !is_base)
        error = record_index(&at, "default_camera", info->default_camera, SCENE_CAMERAS);
    if (!error) error = record_flags(&at, info->flags, SCENE_MOVES | SCENE_IS_BASE);
    if (!error) error = record_reserved(&at, info->reserved);
    for (int i = 0; i < 3 && !error; i++)
        error = record_number(&at, "origin", (float)info->origin[i], -far, far);
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

static int check_triangles(const struct scene_record *at, const struct scene_mesh *mesh)
{
    const uint32_t *v = at->scene->triangles + 3 * (uint64_t)mesh->first_triangle;
    const uint64_t count = 3 * (uint64_t)mesh->triangle_count;
    uint32_t greatest = 0;
    for (uint64_t i = 0; i < count; i++) greatest = v[i] > greatest ? v[i] : greatest;
    if (count == 0 || greatest < mesh->vertex_count) return 0;
    uint64_t i = 0;
    while (v[i] < mesh->vertex_count) i++;
    const struct scene_record triangle = {at->scene, SCENE_TRIANGLES, mesh->first_triangle + i / 3,
                                          at->fault};
    return record_refuse(&triangle, "", ERR_RANGE, v[i], "is an index past its mesh's vertices");
}

/* Checks an array that runs parallel to the mesh's vertices if `present`. */
static int check_parallel(const struct scene_record *at, const char *field, bool present,
                          uint32_t first, uint32_t vertex_count, uint32_t section)
{
    if (present) return record_range(at, field, first, vertex_count, section);
    return first == 0 ? 0 : record_refuse(at, field, ERR_RANGE, first, "though the mesh has none");
}

/* What frames say of a mesh of their base by themselves. */
#define MESH_OF_FRAME (MESH_IN_BASE | MESH_IS_LIGHT)

/* The arrays of a mesh in the base were checked there. */
static int check_mesh_in_base(const struct scene_record *at, const struct scene_mesh *m)
{
    const struct scene *base = at->scene->base;
    if (!base || at->index >= base->count[SCENE_MESHES])
        return record_refuse(at, "flags", ERR_MISMATCH, m->flags, "names a mesh that no base has");
    const struct scene_mesh *its = &base->meshes[at->index];
    if (m->first_vertex != its->first_vertex || m->vertex_count != its->vertex_count ||
        m->first_triangle != its->first_triangle || m->triangle_count != its->triangle_count ||
        m->first_normal != its->first_normal || m->first_tangent != its->first_tangent ||
        m->first_uv[0] != its->first_uv[0] || m->first_uv[1] != its->first_uv[1] ||
        m->first_color != its->first_color ||
        ((m->flags ^ its->flags) & ~(uint32_t)MESH_OF_FRAME) != 0)
        return record_refuse(at, "first_vertex", ERR_MISMATCH, m->first_vertex,
                             "is a mesh of other ranges than its base's");
    int error = record_index(at, "material", m->material, SCENE_MATERIALS);
    return error ? error : record_name(at, m->name);
}

static int check_mesh(const struct scene_record *at, const struct scene_mesh *m)
{
    const uint32_t n = m->vertex_count;
    int error = record_flags(at, m->flags, MESH_FLAGS);
    if (!error && m->flags & MESH_IN_BASE) return check_mesh_in_base(at, m);
    if (!error) error = record_range(at, "first_vertex", m->first_vertex, n, SCENE_POSITIONS);
    if (!error)
        error = record_range(at, "first_triangle", m->first_triangle, m->triangle_count,
                             SCENE_TRIANGLES);
    if (!error)
        error = check_parallel(at, "first_normal", m->flags & MESH_HAS_NORMALS, m->first_normal, n,
                               SCENE_NORMALS);
    if (!error)
        error = check_parallel(at, "first_tangent", m->flags & MESH_HAS_TANGENTS, m->first_tangent,
                               n, SCENE_TANGENTS);
    for (int set = 0; set < 2 && !error; set++)
        if (m->first_uv[set] != SCENE_NONE)
            error = record_range(at, "first_uv", m->first_uv[set], n, SCENE_UVS);
    if (!error) error = record_index(at, "material", m->material, SCENE_MATERIALS);
    if (!error) error = record_name(at, m->name);
    if (!error)
        error = check_parallel(at, "first_color", m->flags & MESH_HAS_COLORS, m->first_color, n,
                               SCENE_COLORS);
    return error ? error : check_triangles(at, m);
}

bool scene_is_invertible(const float m[12])
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

static int check_instance(const struct scene_record *at, const struct scene_instance *instance)
{
    static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const float far = LIMIT_COORDINATE;
    int error =
        record_flags(at, instance->flags, INSTANCE_IDENTITY | INSTANCE_CATCHER | INSTANCE_HOLDOUT);
    if (!error) error = record_index(at, "mesh", instance->mesh, SCENE_MESHES);
    if (!error) error = record_name(at, instance->name);
    if (!error) error = record_reserved(at, instance->reserved);
    if (!error) error = record_numbers(at, "to_world", instance->to_world, 12, -far, far);
    if (error) return error;
    if (!scene_is_invertible(instance->to_world))
        return record_refuse(at, "to_world", ERR_RANGE, (double)instance->to_world[0],
                             "begins a matrix that has no inverse");
    if (!(instance->flags & INSTANCE_IDENTITY)) return 0;
    for (int i = 0; i < 12; i++)
        if (instance->to_world[i] != identity[i])
            return record_refuse(at, "to_world", ERR_MISMATCH, (double)instance->to_world[i],
                                 "is not the identity's, though flagged so");
    return 0;
}

static int check_light(const struct scene_record *at, const struct scene_light *light)
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
    if (!error) error = record_optional(at, "instance", light->instance, SCENE_INSTANCES);
    if (!error) error = record_name(at, light->name);
    return error;
}

static int check_lens(const struct scene_record *at, const struct scene_camera *camera)
{
    const float far = LIMIT_COORDINATE;
    int error = record_number(at, "yfov_rad", camera->yfov_rad, 0.0f, 3.1415f);
    if (!error) error = record_number(at, "half_width", camera->half_width, 0.0f, far);
    if (!error) error = record_number(at, "half_height", camera->half_height, 0.0f, far);
    if (error) return error;
    if (camera->type == CAMERA_PERSPECTIVE)
        return record_number(at, "yfov_rad", camera->yfov_rad, 1e-6f, 3.1415f);
    error = record_number(at, "half_width", camera->half_width, 1e-8f, far);
    return error ? error : record_number(at, "half_height", camera->half_height, 1e-8f, far);
}

int scene_check_camera(const struct scene_record *at, const struct scene_camera *camera)
{
    char place[64];
    /* Its size on the image plane depends on the image; the rest is judged as in a plan. */
    struct plan_camera as_planned = {.type = camera->type,
                                     .half_width = 1,
                                     .half_height = 1,
                                     .centre_x = camera->centre_x,
                                     .centre_y = camera->centre_y};
    memcpy(as_planned.eye, camera->eye, sizeof camera->eye);
    memcpy(as_planned.right, camera->right, sizeof camera->right);
    memcpy(as_planned.up, camera->up, sizeof camera->up);
    memcpy(as_planned.forward, camera->forward, sizeof camera->forward);
    snprintf(place, sizeof place, "%s[%llu]", scene_section_name(at->section),
             (unsigned long long)at->index);
    int error = plan_camera_check(&as_planned, place, at->fault);
    if (!error) error = record_name(at, camera->name);
    if (!error) error = record_number(at, "aspect", camera->aspect, 0.0f, ASPECT_MAX);
    if (!error) error = check_lens(at, camera);
    if (!error) error = record_value(at, "is_default", camera->is_default, 1);
    if (!error) error = record_reserved(at, camera->reserved);
    return error;
}

/* All texels are there, or none. */
static int check_sky(const struct scene *s, struct fault *fault)
{
    const uint64_t count = s->count[SCENE_SKY];
    if (count != 0 && count != SCENE_SKY_TEXELS)
        return fault_set(fault, ERR_MISMATCH, "sky", "%llu texels are not %u",
                         (unsigned long long)count, SCENE_SKY_TEXELS);
    for (uint64_t i = 0; i < count; i++) {
        const struct scene_record at = {s, SCENE_SKY, i, fault};
        const int error = record_numbers(&at, "rgb", s->sky + 3 * i, 3, 0, LIMIT_RADIANCE);
        if (error) return error;
    }
    return 0;
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

static bool is_same_place(const struct scene_instance *a, const struct scene_instance *b)
{
    for (int i = 0; i < 12; i++)
        if (a->to_world[i] != b->to_world[i]) return false;
    return true;
}

/* Frames begin with all meshes and instances of their base: so a tree over those serves them all.
 */
static int check_base(const struct scene *s, struct fault *fault)
{
    const struct scene *base = s->base;
    if (!base) return 0;
    if (base->base || !(base->info->flags & SCENE_IS_BASE))
        return fault_set(fault, ERR_MISMATCH, "base", "it is no base of frames");
    if (s->count[SCENE_MESHES] < base->count[SCENE_MESHES] ||
        s->count[SCENE_INSTANCES] < base->count[SCENE_INSTANCES])
        return fault_set(fault, ERR_MISMATCH, "base", "it has more meshes or instances");
    for (uint64_t i = 0; i < base->count[SCENE_MESHES]; i++)
        if (!(s->meshes[i].flags & MESH_IN_BASE))
            return fault_set(fault, ERR_MISMATCH, "base", "mesh %llu is not the base's",
                             (unsigned long long)i);
    for (uint64_t i = 0; i < base->count[SCENE_INSTANCES]; i++)
        if (s->instances[i].mesh != base->instances[i].mesh ||
            !is_same_place(&s->instances[i], &base->instances[i]))
            return fault_set(fault, ERR_MISMATCH, "base", "instance %llu is not the base's",
                             (unsigned long long)i);
    return 0;
}

/* Runs a record's check over a section. */
#define CHECK_SECTION(s, section, records, check, fault)                                           \
    do {                                                                                           \
        for (uint64_t i = 0; i < (s)->count[section]; i++) {                                       \
            const struct scene_record at = {s, section, i, fault};                                 \
            const int error_of_record = check(&at, &(records)[i]);                                 \
            if (error_of_record) return error_of_record;                                           \
        }                                                                                          \
    } while (0)

static int check_records(const struct scene *s, struct fault *fault)
{
    CHECK_SECTION(s, SCENE_MESHES, s->meshes, check_mesh, fault);
    CHECK_SECTION(s, SCENE_INSTANCES, s->instances, check_instance, fault);
    CHECK_SECTION(s, SCENE_MATERIALS, s->materials, scene_check_material, fault);
    CHECK_SECTION(s, SCENE_TEXTURES, s->textures, scene_check_texture, fault);
    CHECK_SECTION(s, SCENE_IMAGES, s->images, scene_check_image, fault);
    CHECK_SECTION(s, SCENE_LIGHTS, s->lights, check_light, fault);
    CHECK_SECTION(s, SCENE_CAMERAS, s->cameras, scene_check_camera, fault);
    return 0;
}

int scene_check(const struct scene *s, struct fault *fault)
{
    const bool is_base = s->count[SCENE_INFO] == 1 && s->info->flags & SCENE_IS_BASE;
    const struct scene_record info = {s, SCENE_INFO, 0, fault};
    if (s->count[SCENE_CAMERAS] == 0 && !is_base)
        return fault_set(fault, ERR_MISSING, "cameras", "there is none");
    int error = check_info(s, fault);
    if (!error) error = check_strings(s, fault);
    if (!error) error = record_name(&info, s->info->plate);
    if (!error) error = check_floats(s, SCENE_POSITIONS, s->positions, 3, fault);
    if (!error) error = check_units(s, SCENE_NORMALS, s->normals, 3, fault);
    if (!error) error = check_units(s, SCENE_TANGENTS, s->tangents, 4, fault);
    if (!error) error = check_floats(s, SCENE_UVS, s->uvs, 2, fault);
    if (!error) error = check_colors(s, fault);
    if (!error) error = check_shares(s, fault);
    if (!error) error = check_records(s, fault);
    if (!error) error = check_sky(s, fault);
    if (!error) error = check_placed(s, fault);
    if (!error) error = check_base(s, fault);
    if (!error) error = scene_check_motion(s, fault);
    return error;
}
