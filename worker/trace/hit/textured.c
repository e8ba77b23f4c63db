#include "worker/trace/hit/textured.h"

#include "worker/scene/mesh.h"
#include "worker/trace/hit/hit_kernels.h"
#include "worker/trace/hit/texels.h"

/* Where lanes are on their mesh: one set of UVs. */
struct uv_lanes {
    _Alignas(LANES_ALIGN) float u[LANES];
    _Alignas(LANES_ALIGN) float v[LANES];
};

/* Zeros in other lanes, and for a set that the mesh lacks, as mesh_uv. */
static void find_uvs(const struct mesh_view *mesh, uint32_t set, const struct lanes_mask *on,
                     const struct RTCHit16 *hit, struct uv_lanes *out)
{
    const float *uvs = mesh->uvs[set];
    for (int i = 0; i < LANES; i++) {
        out->u[i] = out->v[i] = 0.0f;
        if (!on->on[i] || !uvs) continue;
        const struct mesh_point at = mesh_point_at(mesh, hit->primID[i], hit->u[i], hit->v[i]);
        out->u[i] = mesh_interpolate(&at, uvs, 2, 0);
        out->v[i] = mesh_interpolate(&at, uvs, 2, 1);
    }
}

/* Places a texture's texels, if there is a texture. UVs are computed once for textures of one set.
 *  */
static void place(const struct hit_kernels *kernels, const struct texture *t,
                  const struct uv_lanes uvs[2], struct texel_lanes *out)
{
    if (t->texels) kernels->place_texels(t, uvs[t->uv_set].u, uvs[t->uv_set].v, out);
}

static void find_sets(const struct mesh_view *mesh, const struct lanes_mask *on,
                      const struct RTCHit16 *hit, const struct texture *const *textures, int count,
                      struct uv_lanes uvs[2])
{
    bool wanted[2] = {false, false};
    for (int k = 0; k < count; k++)
        if (textures[k]->texels) wanted[textures[k]->uv_set] = true;
    for (uint32_t set = 0; set < 2; set++)
        if (wanted[set]) find_uvs(mesh, set, on, hit, &uvs[set]);
}

/* Ones where there is no texture. */
static void blend(const struct texture *t, const struct texel_lanes *at, int i, float out[4])
{
    if (t->texels)
        texels_blend(t, at, i, out);
    else
        out[0] = out[1] = out[2] = out[3] = 1.0f;
}

static void map_normals(const struct hit_kernels *kernels, const struct mesh_view *mesh,
                        const struct lanes_mask *on, const struct RTCHit16 *hit,
                        const struct uv_lanes uvs[2], struct surface *out)
{
    const struct texture *t = &mesh->material->normal_texture;
    struct texel_lanes at;
    float texel[4], bend[3] = {0.0f, 0.0f, 1.0f};
    place(kernels, t, uvs, &at);
    for (int i = 0; i < LANES; i++) {
        if (!on->on[i]) continue;
        const struct mesh_point point = mesh_point_at(mesh, hit->primID[i], hit->u[i], hit->v[i]);
        if (t->texels) {
            texels_blend(t, &at, i, texel);
            material_bend(mesh->material, texel, bend);
        }
        hit_bend_normal(&point, bend, i, out);
    }
}

static void color_lanes(const struct hit_kernels *kernels, const struct texture *t,
                        const float factor[3], const struct lanes_mask *on,
                        const struct uv_lanes uvs[2], struct lanes3 *out)
{
    struct texel_lanes at;
    float texel[4];
    place(kernels, t, uvs, &at);
    for (int i = 0; i < LANES; i++) {
        if (!on->on[i]) continue;
        blend(t, &at, i, texel);
        out->x[i] = factor[0] * texel[0];
        out->y[i] = factor[1] * texel[1];
        out->z[i] = factor[2] * texel[2];
    }
}

/* Multiplies by the colours of vertices, which are those of base colours. */
static void tint(const struct mesh_view *mesh, const struct lanes_mask *on,
                 const struct RTCHit16 *hit, struct lanes3 *out)
{
    if (!mesh->material->colored || !mesh->colors) return;
    for (int i = 0; i < LANES; i++) {
        if (!on->on[i]) continue;
        const struct mesh_point at = mesh_point_at(mesh, hit->primID[i], hit->u[i], hit->v[i]);
        out->x[i] *= mesh_interpolate(&at, mesh->colors, 4, 0);
        out->y[i] *= mesh_interpolate(&at, mesh->colors, 4, 1);
        out->z[i] *= mesh_interpolate(&at, mesh->colors, 4, 2);
    }
}

void textured_shade(const struct hit_kernels *kernels, const struct mesh_view *mesh,
                    const struct lanes_mask *on, const struct RTCHit16 *hit, struct surface *out)
{
    const struct material *m = mesh->material;
    const struct texture *shine = m->unlit ? &m->base_color_texture : &m->emission_texture;
    const struct texture *all[3];
    struct uv_lanes uvs[2];
    int count = 0;
    if (mesh->tangents) all[count++] = &m->normal_texture;
    if (m->lambert) all[count++] = &m->base_color_texture;
    if (m->emissive) all[count++] = shine;
    find_sets(mesh, on, hit, all, count, uvs);
    if (mesh->tangents) map_normals(kernels, mesh, on, hit, uvs, out);
    if (m->lambert)
        color_lanes(kernels, &m->base_color_texture, m->base_color, on, uvs, &out->albedo);
    if (m->lambert) tint(mesh, on, hit, &out->albedo);
    if (m->emissive)
        color_lanes(kernels, shine, m->unlit ? m->base_color : m->emission, on, uvs,
                    &out->emission);
    if (m->unlit) tint(mesh, on, hit, &out->emission);
}

bool textured_albedo(const struct hit_kernels *kernels, const struct mesh_view *mesh,
                     const struct lanes_mask *on, const struct RTCHit16 *hit, struct surface *out)
{
    const struct material *m = mesh->material;
    const struct texture *const all[2] = {&m->base_color_texture, &m->metallic_roughness_texture};
    struct uv_lanes uvs[2];
    struct texel_lanes rough_at;
    if (!material_is_metallic_only(m)) return false;
    find_sets(mesh, on, hit, all, 2, uvs);
    color_lanes(kernels, all[0], m->base_color, on, uvs, &out->albedo);
    tint(mesh, on, hit, &out->albedo);
    place(kernels, all[1], uvs, &rough_at);
    for (int i = 0; i < LANES; i++) {
        float rough[4];
        if (!on->on[i]) continue;
        blend(all[1], &rough_at, i, rough);
        const float left = 1.0f - m->metallic * rough[2];
        out->albedo.x[i] *= left;
        out->albedo.y[i] *= left;
        out->albedo.z[i] *= left;
    }
    return true;
}
