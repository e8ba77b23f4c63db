#include "server/reconstruct/patch/half_fill.h"

#include <string.h>

#include "proto/half_field.h"
#include "server/reconstruct/patch/surface.h"

#define NODES_MAX  4
#define WEIGHT_MIN 1e-3f /* of a node of the same object that hardly looks like the pixel */

/* The nodes beside a pixel that lend it light. Weights add up to 1. */
struct nodes {
    uint32_t count;
    size_t at[NODES_MAX];
    float weight[NODES_MAX];
};

struct filling {
    struct patch *patch;
    struct surface_view view;
    struct rect lobes; /* where the patch has lobes; empty: nowhere */
};

static float mean(const struct nodes *n, const float *array)
{
    const float first = array[n->at[0]];
    float more = 0.0f; /* 0 where all are alike */
    for (uint32_t k = 1; k < n->count; k++) more += n->weight[k] * (array[n->at[k]] - first);
    return first + more;
}

static void normalise(struct nodes *n)
{
    float sum = 0.0f;
    for (uint32_t k = 0; k < n->count; k++) sum += n->weight[k];
    for (uint32_t k = 0; k < n->count; k++) n->weight[k] /= sum; /* at least WEIGHT_MIN */
}

/* Returns the weight of node j, 0 if it shows another object. */
static float weigh(const struct filling *f, const struct shown_surface *pixel, size_t j)
{
    struct shown_surface node;
    if (!surface_of_pixel(&f->view, f->patch, j, &node) || node.id != pixel->id) return 0.0f;
    return surface_match(&f->view, pixel, &node) + WEIGHT_MIN;
}

static bool is_in(struct rect r, int32_t x, int32_t y)
{
    return x >= r.x0 && y >= r.y0 && x < r.x1 && y < r.y1;
}

/* Finds the nodes of `r` beside image pixel (x, y), by which `lends` light. */
static void find_nodes(const struct filling *f, struct rect r, int32_t x, int32_t y,
                       const struct shown_surface *pixel,
                       bool (*lends)(const struct patch *, size_t), struct nodes *out)
{
    const int32_t across = x & 1 ? 0 : 1, down = y & 1 ? 0 : 1;
    out->count = 0;
    for (int32_t v = y - down; v <= y + down; v += 2)
        for (int32_t u = x - across; u <= x + across; u += 2) {
            if (!is_in(r, u, v)) continue;
            const size_t j = patch_pixel(f->patch, u, v);
            const float weight = lends(f->patch, j) ? weigh(f, pixel, j) : 0.0f;
            if (!(weight > 0.0f)) continue;
            out->at[out->count] = j;
            out->weight[out->count++] = weight;
        }
    normalise(out);
}

/* -- bounce rays -- */

/* Leaves of both halves the one that the pixel tells of errors by, so that others take the same. */
static void take_half(struct patch *p, int32_t x, int32_t y)
{
    const size_t i = patch_pixel(p, x, y);
    for (int c = 0; c < 3 && p->indirect_even[c]; c++) {
        float *const even = p->indirect_even[c], *const odd = p->indirect_odd[c];
        even[i] = odd[i] = half_field_part(x, y) ? odd[i] : even[i];
    }
}

/* Black pixels have rays of their own that look around. */
static void fill_occlusion(struct patch *p, size_t i, const struct nodes *n)
{
    if (p->ambient_distance_min) {
        if (p->ambient_distance_min[i] > 0.0f) return;
        p->ambient_distance_min[i] = p->bounce_distance_min[i];
    }
    if (p->ambient_visibility) p->ambient_visibility[i] = mean(n, p->ambient_visibility);
}

static void fill_bounces(const struct filling *f, size_t i, const struct nodes *n)
{
    struct patch *p = f->patch;
    float nearest = p->bounce_distance_min[n->at[0]];
    p->lent[i] |= PATCH_LENT_BOUNCES;
    for (uint32_t k = 1; k < n->count; k++)
        if (p->bounce_distance_min[n->at[k]] < nearest) nearest = p->bounce_distance_min[n->at[k]];
    p->bounce_distance_min[i] = nearest;
    for (int c = 0; c < 3 && p->indirect[c]; c++) p->indirect[c][i] = mean(n, p->indirect[c]);
    for (int c = 0; c < 3 && p->indirect_even[c]; c++)
        p->indirect_even[c][i] = p->indirect_odd[c][i] = mean(n, p->indirect_even[c]);
    fill_occlusion(p, i, n);
}

/* -- glossy lobes -- */

static bool has_lobe_light(const struct patch *p, size_t i)
{
    return patch_is_glossy(p, i) && p->glossy_weight[i] > 0.0f;
}

static struct half_field_lobe lobe_of(const struct filling *f, size_t i)
{
    const struct patch *p = f->patch;
    struct half_field_lobe lobe = {.alpha = p->glossy_alpha[i],
                                   .stretch = p->glossy_stretch ? p->glossy_stretch[i] : 0.0f,
                                   .nearness = p->glossy_nearness[i]};
    surface_of_pixel(&f->view, p, i, &lobe.surface);
    return lobe;
}

/* Nodes count by how alike lobes see what they see. */
static void weigh_lobes(const struct filling *f, size_t i, struct nodes *n)
{
    const struct half_field_lobe own = lobe_of(f, i);
    for (uint32_t k = 0; k < n->count; k++) {
        const struct half_field_lobe node = lobe_of(f, n->at[k]);
        const float apart2 = half_field_apart2(&f->view, &own, &node);
        const float alike = 1.0f / (1.0f + apart2);
        n->weight[k] *= alike > WEIGHT_MIN ? alike : WEIGHT_MIN;
    }
    normalise(n);
}

static void fill_lobe(const struct filling *f, size_t i, struct nodes *n)
{
    struct patch *p = f->patch;
    weigh_lobes(f, i, n);
    p->lent[i] |= PATCH_LENT_LOBE;
    for (int c = 0; c < 3; c++) p->glossy[c][i] = mean(n, p->glossy[c]);
    p->glossy_weight[i] = mean(n, p->glossy_weight);
    p->glossy_nearness[i] = mean(n, p->glossy_nearness);
    for (int c = 0; c < 3 && p->glossy_half[c]; c++)
        p->glossy_half[c][i] = mean(n, p->glossy_half[c]);
    if (p->glossy_half_weight) p->glossy_half_weight[i] = mean(n, p->glossy_half_weight);
}

static void fill_pixel(const struct filling *f, int32_t x, int32_t y)
{
    struct patch *p = f->patch;
    const size_t i = patch_pixel(p, x, y);
    const bool bounces = !patch_is_measured(p, i);
    const bool lobe =
        is_in(f->lobes, x, y) && patch_is_glossy(p, i) && !(p->glossy_weight[i] > 0.0f);
    struct shown_surface pixel;
    struct nodes nodes;
    if ((!bounces && !lobe) || !surface_of_pixel(&f->view, p, i, &pixel)) return;
    if (bounces) {
        find_nodes(f, p->rect, x, y, &pixel, patch_is_measured, &nodes);
        if (nodes.count > 0) fill_bounces(f, i, &nodes);
    }
    if (lobe) {
        find_nodes(f, f->lobes, x, y, &pixel, has_lobe_light, &nodes);
        if (nodes.count > 0) fill_lobe(f, i, &nodes);
    }
}

void half_fill(const struct plan *plan, struct patch *patch)
{
    struct filling f = {.patch = patch};
    if (!plan->field_halved) return;
    if (patch->glossy_alpha) f.lobes = patch_has_far_lobes(plan) ? patch->rect : patch->core;
    surface_view_init(&f.view, plan);
    memset(patch->lent, 0, (size_t)rect_area(patch->rect));
    for (int32_t y = patch->rect.y0; y < patch->rect.y1; y++)
        for (int32_t x = patch->rect.x0; x < patch->rect.x1; x++) take_half(patch, x, y);
    for (int32_t y = patch->rect.y0; y < patch->rect.y1; y++)
        for (int32_t x = patch->rect.x0; x < patch->rect.x1; x++)
            if (!half_field_is_node(x, y)) fill_pixel(&f, x, y);
}
