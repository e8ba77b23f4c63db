#pragma once
/* The sheared filter's error on scenes of formulas, and brute-force 4D filtering as the truth for
 * its factorisation. */
#include <stdlib.h>
#include <string.h>

#include "server/reconstruct/indirect/v_plane_filter.h"
#include "server/reconstruct/indirect/v_plane_slopes.h"
#include "tests/unit/server/reconstruct/indirect/v_plane_scene.h"
#include "tests/unit/unit.h"

#define TRUTH_SIDE 48 /* 2304 samples */

/* Three channels of a rect, row by row. */
struct v_plane_picture {
    struct rect rect;
    float *channel[3];
};

static inline struct v_plane_picture picture_create(struct rect rect)
{
    struct v_plane_picture p = {rect, {NULL}};
    const size_t area = (size_t)rect_area(rect);
    p.channel[0] = calloc(3 * area, sizeof(float));
    if (!p.channel[0]) abort();
    p.channel[1] = p.channel[0] + area;
    p.channel[2] = p.channel[1] + area;
    return p;
}

static inline void picture_fini(struct v_plane_picture *p)
{
    free(p->channel[0]);
}

static inline size_t picture_index(struct rect rect, int32_t x, int32_t y)
{
    return (size_t)(y - rect.y0) * (size_t)rect_width(rect) + (size_t)(x - rect.x0);
}

/* Pixels whose coordinates are multiples of `stride` are looked at. */
static inline struct v_plane_picture accuracy_truth(const struct v_plane_scene *s, struct rect rect,
                                                    int32_t stride)
{
    struct v_plane_picture p = picture_create(rect);
    for (int32_t y = rect.y0; y < rect.y1; y += stride) {
        for (int32_t x = rect.x0; x < rect.x1; x += stride) {
            const size_t i = picture_index(rect, x, y);
            float out[3] = {0};
            v_plane_reference(s, x, y, TRUTH_SIDE, out);
            for (int c = 0; c < 3; c++) p.channel[c][i] = out[c];
        }
    }
    return p;
}

/* Root of the mean square over the truth's mean; rects are the same. */
static inline double accuracy_rmse(const struct v_plane_picture *truth,
                                   const struct v_plane_picture *a, const struct v_plane_picture *b,
                                   int32_t stride)
{
    const struct rect r = truth->rect;
    double sum = 0.0, mean = 0.0, count = 0.0;
    for (int32_t y = r.y0; y < r.y1; y += stride) {
        for (int32_t x = r.x0; x < r.x1; x += stride) {
            const size_t i = picture_index(r, x, y);
            for (int c = 0; c < 3; c++) {
                const double d = (double)a->channel[c][i] - (double)b->channel[c][i];
                sum += d * d;
                mean += (double)truth->channel[c][i];
                count += 1.0;
            }
        }
    }
    return sqrt(sum / count) / (mean / count);
}

/* The plain average. */
static inline struct v_plane_picture accuracy_plain(const struct v_plane_scene *s,
                                                    const struct patch *patch, struct rect rect)
{
    struct v_plane_picture p = picture_create(rect);
    const uint32_t n = s->plan.indirect_strata_per_axis * s->plan.indirect_strata_per_axis;
    const size_t area = (size_t)rect_area(patch->rect);
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        for (int32_t x = rect.x0; x < rect.x1; x++) {
            const size_t from = picture_index(patch->rect, x, y), to = picture_index(rect, x, y);
            for (uint32_t j = 0; j < n; j++)
                for (uint32_t c = 0; c < 3; c++)
                    p.channel[c][to] += patch->indirect_strata[(4 * j + c) * area + from];
            for (int c = 0; c < 3; c++) p.channel[c][to] /= (float)n;
        }
    }
    return p;
}

/* `rect` of the patch filtered in blocks, each of its own call. */
static inline struct v_plane_picture accuracy_filter(const struct v_plane_scene *s,
                                                     const struct patch *patch, struct rect rect,
                                                     int32_t block_px, float *width_px,
                                                     struct indirect_statistics *statistics)
{
    struct v_plane_picture all = picture_create(patch->rect), p = picture_create(rect);
    struct indirect_statistics ignored = {0};
    for (int32_t y = rect.y0; y < rect.y1; y += block_px) {
        for (int32_t x = rect.x0; x < rect.x1; x += block_px) {
            const struct rect block =
                rect_intersect((struct rect){x, y, x + block_px, y + block_px}, rect);
            if (v_plane_filter(&s->plan, patch, block, all.channel, width_px,
                               statistics ? statistics : &ignored))
                abort();
        }
    }
    for (int32_t y = rect.y0; y < rect.y1; y++)
        for (int c = 0; c < 3; c++)
            memcpy(p.channel[c] + picture_index(rect, rect.x0, y),
                   all.channel[c] + picture_index(patch->rect, rect.x0, y),
                   (size_t)rect_width(rect) * sizeof(float));
    picture_fini(&all);
    return p;
}

/* Of a stratum: v and the weight that it was drawn with, 1 / gamma. */
struct brute_sample {
    float v1, v2, inverse; /* 1 + |v|^2 */
};

static inline uint32_t brute_strata(const struct v_plane_scene *s)
{
    return s->plan.indirect_strata_per_axis * s->plan.indirect_strata_per_axis;
}

/* Fills in the strata of a pixel. */
static inline void brute_samples_init(const struct v_plane_scene *s, int32_t x, int32_t y,
                                      struct brute_sample *out)
{
    const uint32_t l = s->plan.indirect_strata_per_axis;
    float jitter[2], side[V_PLANE_STRATA_MAX], height[V_PLANE_STRATA_MAX];
    pattern_jitter(&s->plan.pattern, x, y, PATTERN_INDIRECT, jitter);
    for (uint32_t a = 0; a < l; a++)
        v_plane_column(pattern_axis(jitter[0], l, a), &side[a], &height[a]);
    for (uint32_t b = 0; b < l; b++) {
        float sine, cosine;
        v_plane_row(pattern_axis(jitter[1], l, b), &sine, &cosine);
        for (uint32_t a = 0; a < l; a++, out++) {
            out->v1 = side[a] / height[a];
            out->v2 = sine / cosine / height[a];
            out->inverse = 1.0f + out->v1 * out->v1 + out->v2 * out->v2;
        }
    }
}

struct brute {
    const struct v_plane_scene *scene;
    const struct v_plane_neighbourhood *around;
    const struct patch *patch;
    struct brute_sample *samples; /* of the patch's pixels, one after the other */
    float shear;                  /* times eta: 1, or 0 for none */
};

/* What pixel q, at `from` of the patch, adds to the sums of p. */
static inline void brute_add(const struct brute *b, size_t p, size_t q, size_t from, double sums[4])
{
    const struct v_plane_source *own = &b->around->sources[p], *other = &b->around->sources[q];
    const uint32_t n = brute_strata(b->scene);
    const size_t area = (size_t)rect_area(b->patch->rect);
    float d[3], y[2], exponent = 0.0f;
    for (int k = 0; k < 3; k++) d[k] = other->point[k] - own->point[k];
    const float off = fabsf(v_plane_dot(d, own->normal)), d2 = v_plane_dot(d, d);
    if (v_plane_dot(own->normal, other->normal) < V_PLANE_COS_NORMALS ||
        !(off <= fmaxf(3.0f * own->pixel, V_PLANE_OFF_SHARE * sqrtf(d2))))
        return;
    for (int axis = 0; axis < 2; axis++) {
        const struct v_plane_walk *w = &b->around->walks[axis][p];
        const float along = v_plane_dot(d, w->tangent);
        y[axis] = -b->shear * w->eta * along;
        if (w->reach == 0 && q != p) return;
        exponent += along * along * w->falloff;
        if (along * along * w->falloff > 2.2f || fabsf(y[axis]) > 1.0f) return;
    }
    const double weight = exp(-(double)exponent);
    const struct brute_sample *s = &b->samples[from * n];
    for (uint32_t j = 0; j < n; j++) {
        const float v1 = s[j].v1 - y[0], v2 = s[j].v2 - y[1];
        const float ratio = s[j].inverse / (1.0f + v1 * v1 + v2 * v2);
        const double w = weight * (double)(ratio * ratio);
        for (uint32_t c = 0; c < 3; c++)
            sums[c] += w * (double)b->patch->indirect_strata[(4 * j + c) * area + from];
        sums[3] += w;
    }
}

static inline void brute_pixel(const struct brute *b, int32_t x, int32_t y, float out[3])
{
    const size_t p = v_plane_index(b->around, x, y);
    double sums[4] = {0};
    for (int32_t v = -V_PLANE_REACH_PX; v <= V_PLANE_REACH_PX; v++) {
        for (int32_t u = -V_PLANE_REACH_PX; u <= V_PLANE_REACH_PX; u++) {
            const size_t q = v_plane_index(b->around, x + u, y + v);
            if (!v_plane_is_source(&b->around->sources[q])) continue;
            brute_add(b, p, q, picture_index(b->patch->rect, x + u, y + v), sums);
        }
    }
    for (int c = 0; c < 3; c++) out[c] = sums[3] > 0.0 ? (float)(sums[c] / sums[3]) : 0.0f;
}

/* `rect` by brute force with the filter's own slopes, times `shear`; pixels of multiples of
 * `stride` only. */
static inline struct v_plane_picture accuracy_brute(const struct v_plane_scene *s,
                                                    const struct patch *patch, struct rect rect,
                                                    float shear, int32_t stride)
{
    struct v_plane_neighbourhood around;
    struct v_plane_picture p = picture_create(rect);
    struct brute brute = {s, &around, patch, NULL, shear};
    const struct rect r = patch->rect;
    const uint32_t n = brute_strata(s);
    brute.samples = malloc((size_t)rect_area(r) * n * sizeof *brute.samples);
    if (!brute.samples ||
        v_plane_neighbourhood_create(&s->plan, patch, rect, KERNELS_BEST(v_plane_kernels),
                                     &around) ||
        v_plane_slopes(&around))
        abort();
    for (int32_t y = r.y0; y < r.y1; y++)
        for (int32_t x = r.x0; x < r.x1; x++)
            brute_samples_init(s, x, y, &brute.samples[picture_index(r, x, y) * n]);
    for (int32_t y = rect.y0; y < rect.y1; y += stride) {
        for (int32_t x = rect.x0; x < rect.x1; x += stride) {
            const size_t i = picture_index(rect, x, y);
            float out[3] = {0};
            if (v_plane_is_source(&around.sources[v_plane_index(&around, x, y)]))
                brute_pixel(&brute, x, y, out);
            for (int c = 0; c < 3; c++) p.channel[c][i] = out[c];
        }
    }
    v_plane_neighbourhood_fini(&around);
    free(brute.samples);
    return p;
}
