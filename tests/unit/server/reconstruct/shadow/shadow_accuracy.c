#include "tests/unit/server/reconstruct/shadow/shadow_accuracy.h"

#define TRUTH_SIDE_COARSE 6
#define TRUTH_SIDE        32 /* 1024 samples in the penumbra */

/* Do coarse samples agree around the pixel? */
static bool truth_is_flat(const struct shadow_truth *t, int32_t x, int32_t y)
{
    const float here = t->seen[(size_t)y * (size_t)t->width + (size_t)x];
    for (int32_t v = y - 2; v <= y + 2; v++) {
        for (int32_t u = x - 2; u <= x + 2; u++) {
            if (u < 0 || v < 0 || u >= t->width || v >= t->height) continue;
            if (t->seen[(size_t)v * (size_t)t->width + (size_t)u] != here) return false;
        }
    }
    return here == 0.0f || here == 1.0f;
}

void truth_fini(struct shadow_truth *t)
{
    free(t->irradiance);
    free(t->seen);
}

void truth_init(struct shadow_truth *t, const struct shadow_scene *s)
{
    const int32_t width = s->plan.width_px, height = s->plan.height_px;
    const size_t area = (size_t)width * (size_t)height;
    *t = (struct shadow_truth){.width = width, .height = height};
    t->irradiance = calloc(area, sizeof(float));
    t->seen = calloc(area, sizeof(float));
    float *fine = malloc(area * sizeof *fine);
    assert_true(t->irradiance && t->seen && fine);
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < area; i++) {
            const int32_t x = (int32_t)(i % (size_t)width), y = (int32_t)(i / (size_t)width);
            float p[3], n[3], e = 0.0f, seen = 1.0f;
            fine[i] = t->seen[i];
            if (pass == 1 && truth_is_flat(t, x, y)) continue;
            if (scene_primary(s, x, y, p, n) > 0.0f)
                scene_reference(s, 0, p, n, pass ? TRUTH_SIDE : TRUTH_SIDE_COARSE,
                                (uint32_t)i * 2 + (uint32_t)pass, &e, &seen);
            t->irradiance[i] = e;
            if (pass == 0)
                t->seen[i] = seen;
            else
                fine[i] = seen;
        }
    }
    memcpy(t->seen, fine, area * sizeof *fine);
    free(fine);
    for (size_t i = 0; i < area; i++) {
        if (t->seen[i] >= 1.0f) t->brightest = fmaxf(t->brightest, t->irradiance[i]);
        t->penumbra += truth_in_penumbra(t, i) ? 1 : 0;
    }
    assert_true(t->penumbra > 0 && t->brightest > 0.0f);
}

double truth_rmse(const struct shadow_truth *t, const float *a, const float *b)
{
    double sum = 0.0;
    for (size_t i = 0; i < (size_t)t->width * (size_t)t->height; i++) {
        const double d = ((double)a[i] - (double)b[i]) / (double)t->brightest;
        if (truth_in_penumbra(t, i)) sum += d * d;
    }
    return sqrt(sum / (double)t->penumbra);
}

struct patch *accuracy_patch(struct shadow_scene *s, uint32_t l)
{
    const struct rect all = {0, 0, s->plan.width_px, s->plan.height_px};
    const uint32_t filter = s->plan.shadow_filter;
    s->plan.lights[0].strata_per_axis = l;
    s->plan.shadow_filter = SHADOW_FILTER_NONE; /* keeps the plain mean's plane */
    struct patch *patch = scene_patch(s, all);
    s->plan.shadow_filter = filter;
    assert_non_null(patch);
    return patch;
}

float *accuracy_filter(struct shadow_scene *s, const struct patch *patch, enum shadow_filter filter,
                       int32_t block_px, struct shadow_statistics *statistics)
{
    const struct rect all = patch->rect;
    struct shadow_statistics ignored = {0};
    float *e = calloc((size_t)rect_area(all), sizeof *e);
    assert_non_null(e);
    s->plan.shadow_filter = filter;
    for (int32_t y = all.y0; y < all.y1; y += block_px) {
        for (int32_t x = all.x0; x < all.x1; x += block_px) {
            const struct rect block =
                rect_intersect((struct rect){x, y, x + block_px, y + block_px}, all);
            assert_int_equal(shadow_filter(&s->plan, 0, patch, block, e, NULL,
                                           statistics ? statistics : &ignored),
                             0);
        }
    }
    return e;
}

#define BRUTE_REACH_PX 20

static float brute_cover(float y, float rho, float delta)
{
    if (rho < 1e-3f) return 1.0f;
    const float a = 1.0f + delta;
    return (gaussian_phi((a - y) / rho) + gaussian_phi((a + y) / rho) - 1.0f) /
           (2.0f * gaussian_phi(a / rho) - 1.0f);
}

/* What the filter by brute force reads of a pixel; strata are those of pixels in the picture. */
struct brute_pixel {
    float point[3], normal[3], u[2], eta, spread;
    float distance, plane_min, distance_most2, gamma[2], falloff[2];
    float jitter[2];
    uint32_t columns[SHADOW_STRATA_MAX];
};

static struct brute_pixel brute_pixel_of(const struct shadow_pixels *p, size_t i)
{
    struct brute_pixel out = {.eta = p->eta[i],
                              .spread = p->spread[i],
                              .distance = p->distance[i],
                              .plane_min = p->plane_min[i],
                              .distance_most2 = p->distance_most2[i]};
    for (int k = 0; k < 3; k++) {
        out.point[k] = p->point[k][i];
        out.normal[k] = p->normal[k][i];
    }
    for (int k = 0; k < 2; k++) {
        out.u[k] = p->u[k][i];
        out.gamma[k] = p->gamma[k][i];
        out.falloff[k] = p->walk[k].falloff[i];
    }
    return out;
}

/* w_i of docs/reconstruction.md, Sample weights, at yhat half-sides. */
static float brute_weight(const struct brute *b, const struct brute_pixel *t, int axis, float y)
{
    if (fabsf(y) > 1.0f) return 0.0f;
    const float profile =
        b->light->rectangle.profile == PROFILE_GAUSSIAN ? expf(-2.0f * y * y) : 1.0f;
    return profile * (1.0f + t->gamma[axis] * y) / brute_cover(y, b->rho[axis], b->delta[axis]);
}

static bool brute_compatible(const struct brute_pixel *p, const struct brute_pixel *q)
{
    float d[3];
    for (int k = 0; k < 3; k++) d[k] = q->point[k] - p->point[k];
    const float d2 = scene_dot(d, d), off = fabsf(scene_dot(d, p->normal));
    return scene_dot(p->normal, q->normal) >= SHADOW_COS_NORMALS && d2 <= p->distance_most2 &&
           off <= fmaxf(p->plane_min, SHADOW_PLANE_SHARE * sqrtf(d2));
}

/* What neighbour q adds to the sums of p. */
static void brute_add(const struct brute *b, const struct brute_pixel *p,
                      const struct brute_pixel *q, double *numerator, double *denominator)
{
    const uint32_t l = b->light->strata;
    float w[2][SHADOW_STRATA_MAX], exponent = 0.0f;
    for (int axis = 0; axis < 2; axis++) {
        const float delta = p->distance * (q->u[axis] - p->u[axis]);
        if (fabsf(delta) * (fabsf(q->eta - p->eta) + q->spread) > 1.5f * b->light->sigma_y[axis])
            return;
        exponent += delta * delta * p->falloff[axis];
        for (uint32_t a = 0; a < l; a++)
            w[axis][a] = brute_weight(b, p, axis,
                                      2.0f * pattern_axis(q->jitter[axis], l, a) - 1.0f +
                                          p->eta * delta / b->light->rectangle.half[axis]);
    }
    const double weight = exp(-(double)exponent);
    for (uint32_t a = 0; a < l; a++) {
        for (uint32_t c = 0; c < l; c++) {
            const double v = weight * (double)w[0][a] * (double)w[1][c];
            *denominator += v;
            if (q->columns[a] >> c & 1u) *numerator += v;
        }
    }
}

/* All pixels that receivers are known of. Owned by the caller. */
static struct brute_pixel *brute_pixels(const struct brute *b)
{
    const struct rect rect = b->receivers->rect, image = b->patch->rect;
    struct brute_pixel *all = calloc((size_t)rect_area(rect), sizeof *all), *out = all;
    assert_non_null(all);
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        for (int32_t x = rect.x0; x < rect.x1; x++, out++) {
            *out = brute_pixel_of(&b->receivers->pixels, (size_t)(out - all));
            if (x < image.x0 || x >= image.x1 || y < image.y0 || y >= image.y1) continue;
            strata_jitters(b->light, &x, &y, 1, &out->jitter[0], &out->jitter[1]);
            strata_columns(b->light, b->patch, patch_pixel(b->patch, x, y), out->columns);
        }
    }
    return all;
}

/* The share of the light that p sees: sums over all pixels around it. */
static float brute_share(struct brute *b, const struct brute_pixel *p, const float steps[2],
                         int32_t width, float otherwise)
{
    double numerator = 0.0, denominator = 0.0;
    for (int k = 0; k < 2; k++) {
        const float half = b->light->rectangle.half[k];
        b->rho[k] = p->eta * sqrtf(0.5f / p->falloff[k]) / half;
        b->delta[k] = fminf(2.0f, 0.5f * p->eta / half / steps[k]);
    }
    for (int32_t v = -BRUTE_REACH_PX; v <= BRUTE_REACH_PX; v++) {
        for (int32_t u = -BRUTE_REACH_PX; u <= BRUTE_REACH_PX; u++) {
            const struct brute_pixel *q = p + (ptrdiff_t)v * width + u;
            if (brute_compatible(p, q)) brute_add(b, p, q, &numerator, &denominator);
        }
    }
    return denominator > 1e-12 ? (float)(numerator / denominator) : otherwise;
}

/* Brute-force 4D filtering of the receivers in penumbrae that have a wedge; others keep what is in
 * e. steps: the longer of |e_i.x|, |e_i.y| of each receiver and axis. */
static void brute_filter(struct brute *b, const struct shadow_truth *truth, const float *steps,
                         float *e)
{
    const struct rect rect = b->receivers->rect, image = b->patch->rect;
    const int32_t width = rect_width(rect);
    struct brute_pixel *all = brute_pixels(b);
    for (int32_t y = image.y0; y < image.y1; y++) {
        for (int32_t x = image.x0; x < image.x1; x++) {
            const size_t at = (size_t)(y - rect.y0) * (size_t)width + (size_t)(x - rect.x0);
            if (all[at].spread < 0.0f || !truth_in_penumbra(truth, patch_pixel(b->patch, x, y)))
                continue;
            e[patch_pixel(b->patch, x, y)] *= brute_share(b, &all[at], &steps[2 * at], width, 1.0f);
        }
    }
    free(all);
}

static float accuracy_unoccluded(const struct receiver_light *light, const struct shadow_pixels *s,
                                 size_t i)
{
    const float *const p[3] = {s->point[0] + i, s->point[1] + i, s->point[2] + i};
    const float *const n[3] = {s->normal[0] + i, s->normal[1] + i, s->normal[2] + i};
    float e;
    KERNELS_BEST(shadow_kernels)->unoccluded(&light->rectangle, 1, p, n, &e);
    return e;
}

float *accuracy_brute(struct shadow_scene *s, const struct patch *patch,
                      const struct shadow_truth *truth, const float *base)
{
    const struct rect rect = rect_grow(patch->rect, BRUTE_REACH_PX);
    const size_t area = (size_t)rect_area(rect), inner = (size_t)rect_area(patch->rect);
    struct receiver_light light;
    struct receivers receivers;
    struct wedges wedges;
    struct coverage coverage;
    float *e = malloc(inner * sizeof *e), *steps = malloc(2 * area * sizeof *steps);
    assert_true(e && steps);
    receiver_light_init(&light, &s->plan, 0);
    assert_int_equal(
        receivers_create(&light, patch, KERNELS_BEST(shadow_kernels), rect, &receivers), 0);
    assert_int_equal(
        wedges_create(&light, patch, &receivers, KERNELS_BEST(shadow_kernels), &wedges), 0);
    assert_int_equal(coverage_create(light.strata, light.rectangle.profile,
                                     wedge_scale(&s->plan, light.strata), &coverage),
                     0);
    for (size_t i = 0; i < area; i++) {
        float e_i[2][2] = {{0}};
        if (receiver_is_lit(&receivers.pixels, i))
            receiver_steps(&light, &receivers.pixels, i, e_i);
        for (size_t k = 0; k < 2; k++)
            steps[2 * i + k] = fmaxf(fmaxf(fabsf(e_i[k][0]), fabsf(e_i[k][1])), 1e-30f);
    }
    assert_int_equal(
        wedges_shear(&light, &wedges, KERNELS_BEST(shadow_kernels), &coverage, &receivers), 0);
    for (size_t i = 0; i < inner; i++) {
        const size_t x = i % (size_t)rect_width(patch->rect);
        const size_t y = i / (size_t)rect_width(patch->rect);
        const size_t at = (y + BRUTE_REACH_PX) * (size_t)rect_width(rect) + x + BRUTE_REACH_PX;
        const bool wedge = receivers.pixels.spread[at] >= 0.0f && truth_in_penumbra(truth, i);
        e[i] = wedge ? accuracy_unoccluded(&light, &receivers.pixels, at) : base[i];
    }
    struct brute brute = {.light = &light, .receivers = &receivers, .patch = patch};
    brute_filter(&brute, truth, steps, e);
    coverage_fini(&coverage);
    wedges_fini(&wedges);
    receivers_fini(&receivers);
    free(steps);
    return e;
}
