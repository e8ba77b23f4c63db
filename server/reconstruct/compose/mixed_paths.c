#include "server/reconstruct/compose/mixed_paths.h"

#include <math.h>

#include "server/reconstruct/patch/surface.h"

/* The mean of paths counts as far as it differs by more than this many variances. */
#define CHANCE 2.0f

/* Below this weight a surface has no pixel of its own around. */
#define WEIGHT_MIN 1e-3f

#define SIDE (2 * PATCH_RING_PX + 1)

/* A pixel near by that shows one surface, or none, alone. */
struct pure_pixel {
    size_t i;  /* of the patch */
    size_t at; /* of the picture */
    float near;
    bool shows;
    struct shown_surface surface;
};

/* A block's mixed pixels and what they are made from. */
struct mixture {
    const struct patch *patch;
    const struct residual_picture *picture;
    struct surface_view view;
    bool divided; /* entries have the albedo of surfaces whose diffuse light fields bring, alone */
    struct rect reach; /* pixels that both have */
    struct pure_pixel pure[SIDE * SIDE];
    int count;
};

/* Light of a surface: of its diffuse lobe before albedo, and the rest. */
struct surface_light {
    float diffuse[3], rest[3];
    float albedo[3]; /* that paths have seen */
    float emission;
    float weight;
};

int32_t mixed_paths_ring_px(const struct plan *plan)
{
    const bool beside = plan->paths.without_diffuse_direct != 0;
    return beside && (plan->planes & PLANE_BIT(MIXED)) ? PATCH_RING_PX : 0;
}

/* Finds the pure pixels around (x, y). */
static void find_pure(struct mixture *m, int32_t x, int32_t y)
{
    const struct rect around = {x - PATCH_RING_PX, y - PATCH_RING_PX, x + PATCH_RING_PX + 1,
                                y + PATCH_RING_PX + 1};
    const struct rect r = rect_intersect(around, m->reach);
    const struct mixed_share *mixed = &m->patch->mixed;
    m->count = 0;
    for (int32_t qy = r.y0; qy < r.y1; qy++)
        for (int32_t qx = r.x0; qx < r.x1; qx++) {
            struct pure_pixel *q = &m->pure[m->count];
            const float dx = (float)(qx - x), dy = (float)(qy - y);
            q->i = patch_pixel(m->patch, qx, qy);
            if (mixed_share_find(mixed, q->i) < mixed->count) continue;
            q->at = residual_picture_at(m->picture, qx, qy);
            q->near = 1.0f / (1.0f + dx * dx + dy * dy);
            q->shows = surface_of_pixel(&m->view, m->patch, q->i, &q->surface);
            m->count++;
        }
}

static void add_light(const struct mixture *m, const struct pure_pixel *q, float weight,
                      struct surface_light *sum)
{
    const struct patch *p = m->patch;
    for (int c = 0; c < 3; c++) {
        const float diffuse =
            m->picture->diffuse_direct[c][q->at] + m->picture->diffuse_indirect[c][q->at];
        const float albedo = p->path_albedo[c][q->i] / p->paths.spp[q->i], sent = albedo * diffuse;
        sum->diffuse[c] += weight * diffuse;
        sum->albedo[c] += weight * albedo;
        sum->rest[c] += weight * (m->picture->radiance[c][q->at] - sent);
    }
    for (int c = 0; c < 3; c++) sum->emission += weight * p->path_emission[c][q->i];
    sum->weight += weight;
}

/* Finds the light of a surface, NULL for the background, in the pure pixels. False: there is none.
 */
static bool find_light(const struct mixture *m, const struct shown_surface *surface,
                       struct surface_light *out)
{
    *out = (struct surface_light){.weight = 0.0f};
    for (int k = 0; k < m->count; k++) {
        const struct pure_pixel *q = &m->pure[k];
        if (q->shows != (surface != NULL)) continue;
        const float alike = surface ? surface_match(&m->view, surface, &q->surface) : 1.0f;
        if (alike > 0.0f) add_light(m, q, alike * q->near, out);
    }
    if (!(out->weight >= WEIGHT_MIN)) return false;
    for (int c = 0; c < 3; c++) {
        out->diffuse[c] /= out->weight;
        out->albedo[c] /= out->weight;
        out->rest[c] /= out->weight;
    }
    return true;
}

/* Sums over what covers a pixel. */
struct covered {
    float mean[3], square[3], share;
};

static void add_covered(const struct surface_light *light, const float albedo[3], float share,
                        struct covered *sum)
{
    for (int c = 0; c < 3; c++) {
        const float sent = albedo[c] * light->diffuse[c] + share * light->rest[c];
        sum->mean[c] += sent;
        sum->square[c] += sent * sent / share; /* above 0 */
    }
    sum->share += share;
}

/* What the entries of pixel (x, y) say of it. False where light of one of its surfaces is not
 * known. */
static bool predict(struct mixture *m, int32_t x, int32_t y, uint32_t e, struct covered *out)
{
    static const float none[3] = {0.0f, 0.0f, 0.0f};
    const struct mixed_share *mixed = &m->patch->mixed;
    const size_t i = patch_pixel(m->patch, x, y);
    const int64_t width = rect_width(m->patch->rect);
    struct surface_light light;
    *out = (struct covered){.share = 0.0f};
    find_pure(m, x, y);
    for (; e < mixed->count && mixed_share_pixel(mixed, e) == i; e++) {
        const struct mixed_entry *entry = &mixed->entries[e];
        const int64_t slot = entry->place % MIXED_SLOTS;
        const size_t q = (size_t)((int64_t)i + (slot / 3 - 1) * width + slot % 3 - 1);
        struct shown_surface surface;
        if (!(entry->share > 0.0f)) continue;
        if (!surface_of_pixel(&m->view, m->patch, q, &surface)) return false;
        if (!find_light(m, &surface, &light) || light.emission > 0.0f) return false;
        for (int c = 0; c < 3; c++) light.albedo[c] *= entry->share;
        const bool black = entry->albedo[0] + entry->albedo[1] + entry->albedo[2] <= 0.0f;
        add_covered(&light, m->divided || black ? light.albedo : entry->albedo, entry->share, out);
    }
    if (!(out->share > 0.0f)) return false;
    const float left = 1.0f - out->share;
    if (left < WEIGHT_MIN) return true;
    if (!find_light(m, NULL, &light)) return false;
    add_covered(&light, none, left, out);
    return true;
}

/* Variance of a mean over n stratified paths, of what each surface sends: independent ones over
 * the root of n (resolve.c). */
static float variance_of(const struct covered *c, float n)
{
    float sum = 0.0f;
    for (int k = 0; k < 3; k++) sum += fmaxf(c->square[k] - c->mean[k] * c->mean[k], 0.0f);
    return sum / ((n > 1.5f ? n - 1.0f : 1.0f) * sqrtf(n));
}

static void mix(const struct mixture *m, int32_t x, int32_t y, const struct covered *c)
{
    const size_t at = residual_picture_at(m->picture, x, y);
    const float n = m->patch->paths.spp[patch_pixel(m->patch, x, y)];
    const float chance = CHANCE * variance_of(c, n);
    float squared = 0.0f;
    for (int k = 0; k < 3; k++) {
        const float d = m->picture->radiance[k][at] - c->mean[k];
        squared += d * d;
    }
    const float keep = squared > chance ? 1.0f - chance / squared : 0.0f;
    for (int k = 0; k < 3; k++) {
        float *radiance = &m->picture->radiance[k][at];
        *radiance = fmaxf(c->mean[k] + keep * (*radiance - c->mean[k]), 0.0f);
    }
}

uint64_t mixed_paths_apply(const struct plan *plan, const struct patch *patch, struct rect block,
                           const struct residual_picture *picture)
{
    struct mixture m = {.patch = patch,
                        .picture = picture,
                        .divided = plan->paths.without_diffuse_direct == DIRECT_LEFT_ALL,
                        .reach = rect_intersect(patch->core, picture->block)};
    const struct mixed_share *mixed = &patch->mixed;
    uint64_t count = 0;
    if (mixed_paths_ring_px(plan) == 0) return 0;
    if (mixed->count == 0 || !patch->depth || !patch->normal[0]) return 0;
    surface_view_init(&m.view, plan);
    for (int32_t y = block.y0; y < block.y1; y++) {
        const size_t first = patch_pixel(patch, block.x0, y);
        const size_t end = first + (size_t)rect_width(block);
        size_t last = SIZE_MAX;
        for (uint32_t e = mixed_share_from(mixed, first);
             e < mixed->count && mixed_share_pixel(mixed, e) < end; e++) {
            const size_t i = mixed_share_pixel(mixed, e);
            const int32_t x = block.x0 + (int32_t)(i - first);
            struct covered covered;
            if (i == last) continue;
            last = i;
            if (!predict(&m, x, y, e, &covered)) continue;
            mix(&m, x, y, &covered);
            count++;
        }
    }
    return count;
}
