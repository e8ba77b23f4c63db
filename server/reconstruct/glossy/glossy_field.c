#include "server/reconstruct/glossy/glossy_field.h"

#include <math.h>
#include <string.h>

#include "server/reconstruct/glossy/glossy_mixture.h"
#include "server/reconstruct/patch/surface.h"

#define TINY         1e-30f
#define COSINE_MIN   0.05f
#define ALPHA_MIN    0.002f
#define SIGMA        0.665190105f /* 1 / sqrt(2.26): of GGX facets over alpha */
#define OFF_PX       2.0f         /* neighbours may be so far off the tangent plane */
#define NEARNESS_MAX 1e15f

_Static_assert(sizeof(int32_t) == sizeof(float), "objects are carved like numbers");

enum own_array {
    POINT = 0,
    NORMAL = 3,
    MIRROR = 6,
    ALONG = 9,
    ACROSS = 12,
    SHARPNESS = 15,
    NEARNESS = 16,
    NEAR_PLANE = 17,
    SIMILARITY = 18,
    DISTANCE = 19,
    FOOTPRINT = 20,
    ROUND = 21,
    OWN_ARRAYS = 22
};

/* Returns the natural logarithm of a normal number above 0, as glossy_compare_lanes.h does, since
 * the C library's bits depend on the CPU. */
static float natural_log(float x)
{
    uint32_t bits;
    float m;
    memcpy(&bits, &x, sizeof bits);
    int32_t e = (int32_t)(bits >> 23) - 127;
    bits = (bits & 0x007fffffu) | 0x3f800000u;
    memcpy(&m, &bits, sizeof m);
    if (m > 1.41421356f) m *= 0.5f, e++;
    const float t = (m - 1.0f) / (m + 1.0f), s = t * t;
    const float tail = 1.0f / 3 + s * (1.0f / 5 + s * (1.0f / 7 + s * (1.0f / 9)));
    return (float)e * 0.693147181f + 2.0f * (t + t * s * tail);
}

/* Returns exp(-x) for x >= 0, as glossy_compare_lanes.h does. */
static float exp_minus(float x)
{
    const float y = x * -0.0625f;
    if (!(x < 16.0f)) return 0.0f;
    float p = 1.0f + y * (1.0f + y * (0.5f + y * (1.0f / 6 + y * (1.0f / 24 + y / 120))));
    for (int k = 0; k < 4; k++) p *= p;
    return p;
}

/* The product of a mixture with itself over that of one Gaussian whose variance is `square`,
 * without what is common to all. */
static float mixed_with_itself(float square)
{
    float sum = 0.0f;
    for (int l = 0; l < GLOSSY_MIXED; l++)
        for (int m = 0; m < GLOSSY_MIXED; m++) {
            const float times = glossy_mixed_times[l] + glossy_mixed_times[m];
            sum += glossy_mixed_amount[l] * glossy_mixed_amount[m] *
                   (1.0f - exp_minus(2.0f * times / square)) / times;
        }
    return 2.0f * sum;
}

static int32_t rounded(int32_t count)
{
    return (count + SIMD_LANES - 1) / SIMD_LANES * SIMD_LANES;
}

static int carve(struct glossy_neighbourhood *p, int32_t reach)
{
    const int32_t room = rounded(reach);
    p->field.stride = rounded(room + rect_width(p->rect) + SIMD_LANES + room);
    p->area = (size_t)p->field.stride * (size_t)rect_height(p->rect);
    p->origin = (size_t)room;
    const bool halves = p->channels == GLOSSY_MEASURED;
    const size_t arrays = OWN_ARRAYS + 1 + (halves ? 3 : 2) * p->channels;
    const size_t bytes = arrays * p->area * sizeof(float);
    p->memory = scratch_take(p->scratch, bytes); /* on a cache line, as vectors want */
    if (!p->memory) return ERR_MEMORY;
    memset(p->memory, 0, bytes);
    float *next = p->memory;
    for (int k = 0; k < OWN_ARRAYS; k++, next += p->area) p->own[k] = next;
    for (uint32_t c = 0; c < p->channels; c++, next += p->area) p->channel[c] = next;
    for (uint32_t c = 0; c < p->channels; c++, next += p->area) p->between[c] = next;
    for (uint32_t c = 0; c < p->channels && halves; c++, next += p->area) p->wide[c] = next;
    p->object = (int32_t *)(void *)next;
    return 0;
}

static void show(struct glossy_neighbourhood *p)
{
    struct glossy_field *f = &p->field;
    for (int k = 0; k < 3; k++) {
        f->point[k] = p->own[POINT + k];
        f->normal[k] = p->own[NORMAL + k];
        f->mirror[k] = p->own[MIRROR + k];
        f->along[k] = p->own[ALONG + k];
        f->across[k] = p->own[ACROSS + k];
    }
    f->round = p->own[ROUND];
    f->sharpness = p->own[SHARPNESS];
    f->nearness = p->own[NEARNESS];
    f->near_plane = p->own[NEAR_PLANE];
    f->object = p->object;
}

/* The unit direction from the point back to the camera; false where it lies in the eye. */
static bool look_back(const struct surface_view *view, const float *const own[OWN_ARRAYS], size_t i,
                      float out[3])
{
    float squared = 0.0f;
    for (int k = 0; k < 3; k++) {
        out[k] = view->orthographic ? -view->camera->forward[k] : -own[POINT + k][i];
        squared += out[k] * out[k];
    }
    if (!(squared > TINY)) return false;
    const float length = sqrtf(squared);
    for (int k = 0; k < 3; k++) out[k] /= length;
    return true;
}

/* Computes a unit vector at right angles to unit n, in the plane of n and v unless they are
 * parallel. */
static void tangent(const float n[3], const float v[3], float cosine, float out[3])
{
    float squared = 0.0f;
    for (int k = 0; k < 3; k++) {
        out[k] = v[k] - cosine * n[k];
        squared += out[k] * out[k];
    }
    if (!(squared > 1e-12f)) {
        const bool x = fabsf(n[0]) < 0.6f;
        const float along = x ? n[0] : n[1];
        squared = 1.0f - along * along;
        for (int k = 0; k < 3; k++) out[k] = -along * n[k];
        out[x ? 0 : 1] += 1.0f;
    }
    const float length = sqrtf(squared > TINY ? squared : TINY);
    for (int k = 0; k < 3; k++) out[k] /= length;
}

/* Lays an ellipse along two axes at right angles that add up to the same covariance as a and b, by
 * one of Jacobi's rotations. Where lobes are narrow, it loses nothing, as the covariance's
 * eigenvalues would. */
static void straighten(float a[3], float b[3])
{
    float p = 0.0f, q = 0.0f, r = 0.0f;
    for (int k = 0; k < 3; k++) p += a[k] * a[k], q += b[k] * b[k], r += a[k] * b[k];
    if (!(r * r > TINY)) return;
    const float half = 0.5f * (q - p) / r;
    const float t = (half < 0.0f ? -1.0f : 1.0f) / (fabsf(half) + sqrtf(1.0f + half * half));
    const float c = 1.0f / sqrtf(1.0f + t * t), s = c * t;
    for (int k = 0; k < 3; k++) {
        const float x = a[k], y = b[k];
        a[k] = c * x - s * y;
        b[k] = s * x + c * y;
    }
}

/* Mirrors facets that are spread by `wide` along unit d, a tangent of n. */
static void mirror_spread(const float n[3], const float v[3], float cosine, const float d[3],
                          float wide, float out[3])
{
    const float sine = v[0] * d[0] + v[1] * d[1] + v[2] * d[2];
    for (int k = 0; k < 3; k++) out[k] = wide * (sine * n[k] + cosine * d[k]);
}

/* Gives lobe i, whose facets are spread by `wide` on average, the axes of an anisotropic one:
 * `stretch` is the ratio of its alphas, `tangent` where the larger one lies. */
static void stretch_lobe(const float n[3], const float v[3], float cosine, float wide,
                         const float laid[3], float stretch, size_t i, float *const *own)
{
    const float root = sqrtf(stretch), *d = laid;
    const float along = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
    float u[3], w[3], a[3], b[3];
    tangent(n, d, along, u);
    for (int k = 0; k < 3; k++)
        w[k] = n[(k + 1) % 3] * u[(k + 2) % 3] - n[(k + 2) % 3] * u[(k + 1) % 3];
    mirror_spread(n, v, cosine, u, wide / root, a);
    mirror_spread(n, v, cosine, w, wide * root, b);
    straighten(a, b);
    for (int k = 0; k < 3; k++) {
        own[ALONG + k][i] = a[k];
        own[ACROSS + k][i] = b[k];
    }
}

/* A lobe as it was sent. */
struct sent_lobe {
    float alpha, stretch; /* 0: round */
    float tangent[3];
};

/* Virtual hits take the root of the stretch. Passes along rows and columns cannot follow an ellipse
 * that lies across them, so that the whole stretch leaves them few neighbours. */
static void read_lobe(const struct patch *patch, bool published, size_t q, struct sent_lobe *out)
{
    *out = (struct sent_lobe){.alpha = patch->glossy_alpha[q]};
    if (!patch->glossy_stretch || !patch->glossy_tangent[0]) return;
    const float stretch = patch->glossy_stretch[q];
    out->stretch = published ? stretch : sqrtf(stretch);
    for (int k = 0; k < 3; k++) out->tangent[k] = patch->glossy_tangent[k][q];
}

/* The lobe of pixel i, which has a point and a normal; false where it takes no part. */
static bool set_lobe(const struct surface_view *view, enum glossy_shape shape,
                     const struct sent_lobe *lobe, size_t i, float *const *own)
{
    float v[3], t[3];
    const float n[3] = {own[NORMAL][i], own[NORMAL + 1][i], own[NORMAL + 2][i]};
    if (!look_back(view, (const float *const *)own, i, v)) return false;
    const float cosine = n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
    if (!(cosine >= COSINE_MIN)) return false;
    const float wide = 2.0f * SIGMA * (lobe->alpha > ALPHA_MIN ? lobe->alpha : ALPHA_MIN);
    tangent(n, v, cosine, t);
    const float sine = v[0] * t[0] + v[1] * t[1] + v[2] * t[2];
    const float b[3] = {n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2],
                        n[0] * t[1] - n[1] * t[0]};
    for (int k = 0; k < 3; k++) {
        own[MIRROR + k][i] = 2.0f * cosine * n[k] - v[k];
        own[ALONG + k][i] = wide * (sine * n[k] + cosine * t[k]);
        own[ACROSS + k][i] = wide * cosine * b[k];
    }
    if (lobe->stretch > 0.0f && lobe->stretch < 1.0f)
        stretch_lobe(n, v, cosine, wide, lobe->tangent, lobe->stretch, i, own);
    /* the covariance's determinant is the square of the round lobe's variance */
    const float square = wide * wide * cosine;
    own[ROUND][i] = square;
    own[SHARPNESS][i] = 0.5f * natural_log(square);
    if (shape == GLOSSY_MIXTURE) own[SHARPNESS][i] -= 0.5f * natural_log(mixed_with_itself(square));
    return true;
}

static void load_row(const struct surface_view *view, const struct patch *patch, int32_t y,
                     struct glossy_neighbourhood *p)
{
    const size_t to = glossy_neighbourhood_index(p, p->rect.x0, y);
    const size_t from = patch_pixel(patch, p->rect.x0, y);
    const size_t count = (size_t)rect_width(p->rect);
    surface_points(view, p->rect.x0, y, (uint32_t)count, patch->depth + from, p->own[POINT] + to,
                   p->own[POINT + 1] + to, p->own[POINT + 2] + to);
    for (size_t i = 0; i < count; i++) {
        const size_t q = from + i, at = to + i;
        const float near = patch->glossy_nearness[q];
        for (int k = 0; k < 3; k++) {
            p->own[NORMAL + k][at] = patch->normal[k][q];
            p->channel[k][at] = patch->glossy[k][q];
        }
        p->channel[3][at] = patch->glossy_weight[q];
        if (p->channels == GLOSSY_MEASURED) {
            for (int k = 0; k < 3; k++) p->channel[4 + k][at] = patch->glossy_half[k][q];
            p->channel[7][at] = patch->glossy_half_weight[q];
        }
        p->own[NEARNESS][at] = p->published ? 0.0f : near < NEARNESS_MAX ? near : NEARNESS_MAX;
        p->own[NEAR_PLANE][at] = OFF_PX * surface_pixel_size(view, patch->depth[q]);
        struct sent_lobe lobe;
        read_lobe(patch, p->published, q, &lobe);
        if (patch_is_glossy(patch, q) && set_lobe(view, p->shape, &lobe, at, p->own))
            p->object[at] = (int32_t)patch->id[q];
    }
}

bool glossy_is_published(uint32_t filter)
{
    return filter == GLOSSY_FILTER_SG || filter == GLOSSY_FILTER_SG_MIXTURE ||
           filter == GLOSSY_FILTER_ASG;
}

static enum glossy_shape shape_of(uint32_t filter)
{
    return filter == GLOSSY_FILTER_SG           ? GLOSSY_ROUND
           : filter == GLOSSY_FILTER_SG_MIXTURE ? GLOSSY_MIXTURE
                                                : GLOSSY_ELLIPTIC;
}

int glossy_neighbourhood_create(const struct plan *plan, const struct patch *patch,
                                struct rect rect, int32_t reach, bool halves,
                                struct glossy_neighbourhood *out)
{
    struct surface_view view;
    const uint32_t filter = plan->glossy_filter;
    *out = (struct glossy_neighbourhood){.rect = rect,
                                         .shape = shape_of(filter),
                                         .published = glossy_is_published(filter),
                                         .channels = halves ? GLOSSY_MEASURED : GLOSSY_CHANNELS,
                                         .scratch = patch->scratch};
    const int error = carve(out, reach);
    if (error) return error;
    show(out);
    surface_view_init(&view, plan);
    for (int32_t y = rect.y0; y < rect.y1; y++) load_row(&view, patch, y, out);
    return 0;
}

void glossy_neighbourhood_fini(struct glossy_neighbourhood *around)
{
    scratch_give(around->scratch, around->memory);
    *around = (struct glossy_neighbourhood){0};
}

void glossy_neighbourhood_rule(struct glossy_neighbourhood *around, size_t i,
                               const struct glossy_rule *rule)
{
    around->own[SIMILARITY][i] = rule->similarity;
    around->own[DISTANCE][i] = rule->distance;
    around->own[FOOTPRINT][i] = rule->footprint;
    around->field.similarity = around->own[SIMILARITY];
    around->field.distance = around->own[DISTANCE];
    around->field.footprint = around->own[FOOTPRINT];
}

void glossy_neighbourhood_one_rule(struct glossy_neighbourhood *around)
{
    around->field.similarity = around->field.distance = around->field.footprint = NULL;
}

struct glossy_run glossy_neighbourhood_run(const struct glossy_neighbourhood *around,
                                           struct rect rect, int32_t y, bool along_x, int32_t reach)
{
    const int32_t above = y - around->rect.y0, below = around->rect.y1 - 1 - y;
    return (struct glossy_run){
        .first = glossy_neighbourhood_index(around, rect.x0, y),
        .count = (uint32_t)rounded(rect_width(rect)),
        .step = along_x ? 1 : around->field.stride,
        .before = along_x || above > reach ? reach : above,
        .after = along_x || below > reach ? reach : below,
    };
}
