#include "worker/trace/hit/back_faces.h"

#include "worker/scene/movers.h"

/* Embree has accessors of N-wide rays for C++ only. Fields follow each other, N values each, in the
 * order of struct RTCRay and struct RTCHit. */
enum { RAY_DIRECTION = 4, HIT_NORMAL = 0 };

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Hit and ray are both in the space of the geometry. */
void back_faces_filter(const struct RTCFilterFunctionNArguments *args)
{
    const struct mesh_view *mesh = args->geometryUserPtr;
    const float *ray = (const float *)args->ray, *hit = (const float *)args->hit;
    const size_t n = args->N;
    if (!mesh->material->culled) return;
    for (size_t i = 0; i < n; i++) {
        float d[3], normal[3];
        for (size_t k = 0; k < 3; k++) {
            d[k] = ray[(RAY_DIRECTION + k) * n + i];
            normal[k] = hit[(HIT_NORMAL + k) * n + i];
        }
        if (args->valid[i] == -1 && dot(normal, d) > 0.0f) args->valid[i] = 0;
    }
}

static void cross(const float a[3], const float b[3], float out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Computes a facet's normal, of any length, in the world: transforms mirror nothing (scene.h). */
static void world_facet(const struct mesh_view *mesh, uint32_t triangle, const float m[12],
                        float out[3])
{
    const uint32_t *corners = mesh->triangles + (size_t)3 * triangle;
    float side[2][3], world[2][3];
    for (size_t k = 0; k < 2; k++) {
        for (size_t j = 0; j < 3; j++)
            side[k][j] = mesh->positions[(size_t)3 * corners[k + 1] + j] -
                         mesh->positions[(size_t)3 * corners[0] + j];
        for (size_t j = 0; j < 3; j++) world[k][j] = dot(m + 4 * j, side[k]);
    }
    cross(world[0], world[1], out);
}

static bool is_back(const struct render_scene *scene, const struct RTCRayHit16 *rays, int i)
{
    const struct RTCHit16 *hit = &rays->hit;
    const struct RTCRay16 *r = &rays->ray;
    const float d[3] = {r->dir_x[i], r->dir_y[i], r->dir_z[i]};
    const uint32_t placed = hit->instID[0][i];
    const uint32_t index = placed != RTC_INVALID_GEOMETRY_ID ? placed : hit->geomID[i];
    const struct scene_instance *instance = &scene->blob->instances[index];
    const struct mesh_view *mesh = &scene->meshes[instance->mesh];
    float normal[3], to_world[12];
    if (!mesh->material->culled) return false;
    mover_to_world(scene, index, r->time[i], to_world);
    world_facet(mesh, hit->primID[i], to_world, normal);
    return dot(normal, d) > 0.0f;
}

/* Finds the lanes that may have met a back. Few have: all others are dropped without a look at
 * their mesh. Normals of placed meshes are not the world's. */
static int32_t find_turned(const struct lanes_mask *restrict valid,
                           const struct RTCRayHit16 *restrict rays, struct lanes_mask *restrict out)
{
    const struct RTCHit16 *hit = &rays->hit;
    const struct RTCRay16 *r = &rays->ray;
    int32_t any = 0;
    for (int i = 0; i < LANES; i++) {
        const float along =
            hit->Ng_x[i] * r->dir_x[i] + hit->Ng_y[i] * r->dir_y[i] + hit->Ng_z[i] * r->dir_z[i];
        const int turned = (along > 0.0f) | (hit->instID[0][i] != RTC_INVALID_GEOMETRY_ID);
        out->on[i] = valid->on[i] & -(turned & (hit->geomID[i] != RTC_INVALID_GEOMETRY_ID));
        any |= out->on[i];
    }
    return any;
}

bool back_faces_find(const struct render_scene *scene, const struct lanes_mask *valid,
                     const struct RTCRayHit16 *rays, struct lanes_mask *out)
{
    bool any = false;
    if (!find_turned(valid, rays, out)) return false;
    for (int i = 0; i < LANES; i++) {
        if (out->on[i] && !is_back(scene, rays, i)) out->on[i] = 0;
        any |= out->on[i] != 0;
    }
    return any;
}
