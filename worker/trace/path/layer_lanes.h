#pragma once
/* The inner loops of path_kernels over layers (layers.h): worker/shade/gltf.c for rough, opaque
 * surfaces in sixteen lanes. Lanes that are off compute, too, but their results are dropped. */
#include "worker/shade/coupling.h"
#include "worker/shade/fresnel.h"
#include "worker/shade/ggx.h"
#include "worker/shade/lobe.h"
#include "worker/trace/hit/vector_lanes.h"
#include "worker/trace/path/path.h"

/* The values of both lobes for a pair of directions. */
struct layer_value {
    float diffuse, pdf;
    struct vector specular;
};

LANE_INLINE float vector_mean(struct vector c)
{
    const float color[3] = {c.x, c.y, c.z};
    return lobe_mean(color);
}

LANE_INLINE float vector_max(struct vector c)
{
    const float m = c.x > c.y ? c.x : c.y;
    return m > c.z ? m : c.z;
}

/* Returns the Fresnel reflectance of facets; `grazing` is (1 - cosine)^5 or a mean of it. */
LANE_INLINE struct vector layer_reflects(const struct layers *l, int i, float grazing)
{
    const float coat = l->coat[i], metal = l->metallic[i];
    return (struct vector){coat * fresnel_schlick(l->f0.x[i], grazing) +
                               metal * fresnel_schlick(l->color.x[i], grazing),
                           coat * fresnel_schlick(l->f0.y[i], grazing) +
                               metal * fresnel_schlick(l->color.y[i], grazing),
                           coat * fresnel_schlick(l->f0.z[i], grazing) +
                               metal * fresnel_schlick(l->color.z[i], grazing)};
}

/* Returns the mean of (1 - w.h)^5 over the facets that w sees. */
LANE_INLINE float layer_grazing(const struct layers *l, int i, struct vector w)
{
    const float u = l->alpha_u[i], v = l->alpha_v[i];
    const float x2 = w.x * w.x, y2 = w.y * w.y, r2 = x2 + y2;
    const float turned = sqrtf((x2 * u * u + y2 * v * v) / (r2 > 0.0f ? r2 : 1.0f));
    return coupling_grazing(w.z, (u != v) & (r2 > 0.0f) ? turned : u);
}

/* Returns the share of diffuse light that passes facets with the mean `grazing`. */
LANE_INLINE float layer_passes(const struct layers *l, int i, float grazing)
{
    return 1.0f - l->specular[i] * fresnel_schlick(l->most_f0[i], grazing);
}

LANE_INLINE float layer_span(const struct layers *l, int i, struct vector w)
{
    const float x = l->alpha_u[i] * w.x, y = l->alpha_v[i] * w.y;
    return sqrtf(x * x + y * y + w.z * w.z);
}

LANE_INLINE void choose_lobe(int i, struct vector reflected, struct layers *l)
{
    const float diffuse = vector_mean(lane_get(&l->albedo, i)) * l->kept[i];
    const float least = l->least[i] * diffuse, mean = vector_mean(reflected);
    const int has = (l->metallic[i] > 0.0f) | (l->coat[i] > 0.0f);
    const float facet = has & (mean < least) ? least : mean;
    const float sum = diffuse + facet, scale = sum > 1e-20f ? 1.0f / sum : 0.0f;
    const float p = diffuse * scale;
    l->p_diffuse[i] = (p > 0.0f) & (sum <= diffuse) ? 1.0f : p;
    l->p_facet[i] = facet * scale;
}

static void kernel_layers_see(const struct lanes3 *restrict back, struct layers *restrict l)
{
    for (int i = 0; i < LANES; i++) {
        const struct vector wo = lane_get(back, i);
        l->coat[i] = (1.0f - l->metallic[i]) * l->specular[i];
        l->most_f0[i] = vector_max(lane_get(&l->f0, i));
        l->span[i] = layer_span(l, i, wo);
        l->passed[i] = layer_passes(l, i, coupling_average(sqrtf(l->alpha_u[i] * l->alpha_v[i])));
        const float grazing = layer_grazing(l, i, wo), kept = layer_passes(l, i, grazing);
        l->kept[i] = kept > 0.0f ? kept : 0.0f;
        choose_lobe(i, layer_reflects(l, i, grazing), l);
    }
}

/* Returns the diffuse lobe over its albedo, for lanes with such a lobe. */
LANE_INLINE float layer_diffuse(const struct layers *l, int i, struct vector wi)
{
    const float in = layer_passes(l, i, layer_grazing(l, i, wi)), all = l->passed[i];
    const int passes = (in > 0.0f) & (all > 1e-6f);
    const float coupled = LAMBERT_INV_PI * l->kept[i] * in / (passes ? all : 1.0f);
    return l->specular[i] <= 0.0f ? LAMBERT_INV_PI : passes ? coupled : 0.0f;
}

/* Does bsdf_evaluate for lane i. */
LANE_INLINE struct layer_value layer_evaluate(const struct layers *l, int i, struct vector wo,
                                              struct vector wi)
{
    const float alpha[2] = {l->alpha_u[i], l->alpha_v[i]}, p_diffuse = l->p_diffuse[i];
    float h[3];
    const float twice = direction_normalize(wo.x + wi.x, wo.y + wi.y, wo.z + wi.z, h);
    const float cosine = 0.5f * twice, d = ggx_facets(h, alpha);
    const float value = d * ggx_visibility(wo.z, l->span[i], wi.z, layer_span(l, i, wi));
    const struct vector color = layer_reflects(l, i, fresnel_grazing(cosine));
    const int seen = (wo.z >= DIRECTION_GRAZING) & (wi.z >= DIRECTION_GRAZING);
    const int lit = seen & (p_diffuse > 0.0f), facets = seen & (l->p_facet[i] > 0.0f);
    const float first = lit ? lobe_diffuse_pdf(p_diffuse, wi.z) : 0.0f;
    const float diffuse = layer_diffuse(l, i, wi);
    const float second = l->p_facet[i] * 0.25f * d * ggx_seen(wo.z, l->span[i]);
    return (struct layer_value){.diffuse = lit ? diffuse : 0.0f,
                                .pdf = facets ? first + second : first,
                                .specular = {facets ? color.x * value : 0.0f,
                                             facets ? color.y * value : 0.0f,
                                             facets ? color.z * value : 0.0f}};
}

/* Turns a vector of the world into v's shading frame. */
LANE_INLINE struct vector to_frame(const struct path_vertex *v, int i, struct vector d)
{
    return (struct vector){dot(d, lane_get(&v->tangent, i)), dot(d, lane_get(&v->bitangent, i)),
                           dot(d, lane_get(&v->surface.normal, i))};
}

/* Turns a vector of v's shading frame into the world. */
LANE_INLINE struct vector from_frame(const struct path_vertex *v, int i, struct vector w)
{
    const struct vector t = lane_get(&v->tangent, i), b = lane_get(&v->bitangent, i);
    const struct vector n = lane_get(&v->surface.normal, i);
    return (struct vector){w.x * t.x + w.y * b.x + w.z * n.x, w.x * t.y + w.y * b.y + w.z * n.y,
                           w.x * t.z + w.y * b.z + w.z * n.z};
}

LANE_INLINE void keep_lane(int on, int i, struct vector v, struct lanes3 *out)
{
    out->x[i] = on ? v.x : out->x[i];
    out->y[i] = on ? v.y : out->y[i];
    out->z[i] = on ? v.z : out->z[i];
}

static void kernel_look_back(const struct RTCRay16 *restrict rays, struct path_vertex *restrict v)
{
    for (int i = 0; i < LANES; i++) {
        const struct vector d = lane_direction(rays, i), back = {-d.x, -d.y, -d.z};
        lane_put(to_frame(v, i, back), i, &v->back);
    }
}

static void kernel_layers_light(const struct nee_sample *restrict light,
                                const struct path_vertex *restrict v,
                                const float *restrict probability, struct lanes3 *restrict diffuse,
                                struct lanes3 *restrict all)
{
    const struct layers *l = &v->layers;
    for (int i = 0; i < LANES; i++) {
        const struct vector d = lane_direction(&light->packet.rays.ray, i);
        const float squared = dot(d, d), scale = 1.0f / sqrtf(squared > 0.0f ? squared : 1.0f);
        const struct vector w = to_frame(v, i, d), a = lane_get(&l->albedo, i);
        const struct vector wi = {scale * w.x, scale * w.y, scale * w.z};
        const struct vector color = lane_get(&light->color, i);
        const struct layer_value f = layer_evaluate(l, i, lane_get(&v->back, i), wi);
        const float density = light->packet.density[i] * probability[i];
        const float ratio = density > 0.0f ? f.pdf / (density > 0.0f ? density : 1.0f) : 0.0f;
        const float e = light->packet.irradiance[i] / (1.0f + ratio * ratio);
        const int on = l->on.on[i] & light->packet.traced.on[i];
        const float lambert = f.diffuse * e;
        keep_lane(on, i, (struct vector){lambert * color.x, lambert * color.y, lambert * color.z},
                  diffuse);
        keep_lane(on, i,
                  (struct vector){(a.x * f.diffuse + f.specular.x) * e * color.x,
                                  (a.y * f.diffuse + f.specular.y) * e * color.y,
                                  (a.z * f.diffuse + f.specular.z) * e * color.z},
                  all);
    }
}

/* Chooses directions, and tells whether a lobe has sent them above the surface. */
static void choose_directions(const struct path_vertex *restrict v, const float *restrict choice,
                              const float *restrict u, const float *restrict w,
                              struct lanes_mask *restrict up, struct lanes3 *restrict out)
{
    const struct layers *l = &v->layers;
    for (int i = 0; i < LANES; i++) {
        const float wo[3] = {v->back.x[i], v->back.y[i], v->back.z[i]}, at[2] = {u[i], w[i]};
        const float alpha[2] = {l->alpha_u[i], l->alpha_v[i]};
        const int diffuse = choice[i] < l->p_diffuse[i];
        struct vector d;
        float h[3], m[3];
        lambert_direction(u[i], w[i], &d.x, &d.y, &d.z);
        ggx_sample(wo, alpha, at, h);
        direction_reflect(wo, h, direction_dot(wo, h), m);
        up->on[i] = -((wo[2] >= DIRECTION_GRAZING) & (diffuse | (l->p_facet[i] > 0.0f)));
        out->x[i] = diffuse ? d.x : m[0];
        out->y[i] = diffuse ? d.y : m[1];
        out->z[i] = diffuse ? d.z : m[2];
    }
}

/* Sends lane i on along wi, of the shading frame, if `goes`, and leaves other lanes as they are. */
LANE_INLINE void send_lane(const struct path_vertex *restrict v, int i, struct vector wi,
                           struct vector d, int on, int goes, struct path_scattering *restrict s)
{
    const struct layers *l = &v->layers;
    const struct vector wo = lane_get(&v->back, i), a = lane_get(&l->albedo, i);
    const struct layer_value f = layer_evaluate(l, i, wo, wi);
    const int dense = f.pdf > BSDF_PDF_MIN;
    const float scale = wi.z / (dense ? f.pdf : 1.0f), diffuse = f.diffuse * scale;
    const struct vector rest = {f.specular.x * scale, f.specular.y * scale, f.specular.z * scale};
    const float lit = f.diffuse > 0.0f ? vector_max(a) : 0.0f, most = vector_max(rest);
    const int bright = (most > lit ? most : lit) > 0.0f;
    const int leaves = dot(d, lane_get(&v->surface.facet, i)) > 0.0f;
    const int above = wi.z >= DIRECTION_GRAZING;
    const int sent = goes & -(above & dense & bright & leaves);
    s->on.on[i] = on ? sent : s->on.on[i];
    s->through.on[i] &= ~on;
    s->pdf[i] = on ? f.pdf : s->pdf[i];
    s->diffuse[i] = on ? diffuse : s->diffuse[i];
    keep_lane(on, i, rest, &s->specular);
    keep_lane(on, i, d, &s->direction);
    keep_lane(
        on, i,
        (struct vector){a.x * diffuse + rest.x, a.y * diffuse + rest.y, a.z * diffuse + rest.z},
        &s->weight);
}

static void kernel_layers_scatter(const struct path_vertex *restrict v,
                                  const float *restrict choice, const float *restrict u,
                                  const float *restrict w, struct path_scattering *restrict s)
{
    struct lanes_mask up;
    struct lanes3 local;
    choose_directions(v, choice, u, w, &up, &local);
    for (int i = 0; i < LANES; i++) {
        const struct vector wi = lane_get(&local, i);
        send_lane(v, i, wi, from_frame(v, i, wi), v->layers.on.on[i], up.on[i], s);
    }
}

static void kernel_layers_turn(const struct path_vertex *restrict v,
                               const struct lanes_mask *restrict turned,
                               const struct lanes3 *restrict way,
                               struct path_scattering *restrict s)
{
    for (int i = 0; i < LANES; i++) {
        const struct vector d = lane_get(way, i), wi = to_frame(v, i, d);
        const int on = v->layers.on.on[i] & turned->on[i];
        send_lane(v, i, wi, d, on, -(v->back.z[i] >= DIRECTION_GRAZING), s);
    }
}

static void kernel_layers_diffuse(const struct path_vertex *restrict v,
                                  const struct layers *restrict l,
                                  const struct lanes3 *restrict direction, float *restrict weight)
{
    for (int i = 0; i < LANES; i++) {
        const struct vector wi = to_frame(v, i, lane_get(direction, i));
        const int seen = (v->back.z[i] >= DIRECTION_GRAZING) & (wi.z >= DIRECTION_GRAZING);
        const float diffuse = layer_diffuse(l, i, wi);
        weight[i] = l->on.on[i] ? ELEMENTARY_PI * (seen ? diffuse : 0.0f) : weight[i];
    }
}

/* Samples a direction by the facets visible from wo, with its weight f |cos| / pdf in the facets'
 * lobe alone. That is F G2 / G1: the share of the visible facets that is visible from wi, too,
 * times their reflectance. */
static void kernel_layers_gloss(const struct path_vertex *restrict v,
                                const struct layers *restrict l, const float *restrict u,
                                const float *restrict w, struct layer_gloss *restrict out)
{
    for (int i = 0; i < LANES; i++) {
        const float wo[3] = {v->back.x[i], v->back.y[i], v->back.z[i]}, at[2] = {u[i], w[i]};
        const float alpha[2] = {l->alpha_u[i], l->alpha_v[i]};
        float h[3], m[3];
        ggx_sample(wo, alpha, at, h);
        const float cosine = direction_dot(wo, h);
        direction_reflect(wo, h, cosine, m);
        const struct vector wi = {m[0], m[1], m[2]};
        const float seen = ggx_visibility(wo[2], l->span[i], wi.z, layer_span(l, i, wi));
        const float open = 4.0f * seen * wi.z / ggx_seen(wo[2], l->span[i]);
        const struct vector color = layer_reflects(l, i, fresnel_grazing(cosine));
        const struct vector d = from_frame(v, i, wi);
        const int up = (wo[2] >= DIRECTION_GRAZING) & (wi.z >= DIRECTION_GRAZING);
        out->on.on[i] = l->on.on[i] & -up;
        out->above.on[i] = -(dot(d, lane_get(&v->surface.facet, i)) > 0.0f);
        lane_put((struct vector){color.x * open, color.y * open, color.z * open}, i, &out->weight);
        lane_put(wi, i, &out->local);
        lane_put(d, i, &out->direction);
    }
}
