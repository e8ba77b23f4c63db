#include "server/reconstruct/lens_light.h"

#include <math.h>
#include <string.h>

#include "proto/half.h"
#include "proto/lens_pattern.h"
#include "proto/octahedron.h"
#include "proto/pattern_path.h"
#include "proto/samples.h"
#include "proto/shared_exponent.h"
#include "server/reconstruct/lens_axis_aligned.h"
#include "server/reconstruct/lens_field.h"
#include "server/reconstruct/lens_residual.h"
#include "server/reconstruct/surface.h"

#define AROUND_PX 2 /* between q and the pixels that lend */

/* Less than this of the pixels around is nobody's surface. */
#define WEIGHT_MIN 1e-3f

#define ROUNDING 0.999f

int32_t lens_light_ring_px(const struct plan *plan)
{
    if (plan->lens_light == LENS_LIGHT_OWN) return 0;
    if (plan->lens_filter == LENS_FILTER_AXIS_ALIGNED)
        return LENS_AXIS_ALIGNED_REACH_PX + (int32_t)LENS_LIGHT_SLOPE_MOST + AROUND_PX;
    /* Pixels look at points of a layer that lie as far from them as its cells reach: half of what
     * samples of such points do. Averages are compared a little around. */
    return lens_reach_px(LENS_SLOPE_MOST) / 2 + lens_residual_reach_px(plan) + AROUND_PX;
}

/* Of the rows of `seen`, one at a time: where samples lie. */
struct rows {
    float *along, *across;         /* jitters of the pixels' lens points */
    float *height, *left, *length; /* of the line at hand */
    float *x, *y;                  /* q */
    float *depth;                  /* z, scene units */
    uint32_t *key;
};
#define ROW_ARRAYS 9

struct lit_lens {
    const struct plan *plan;
    const struct patch *patch;
    const struct lighting *lighting;
    struct surface_view view;
    struct lens_pattern pattern;
    struct rect lit, seen, block;
    struct surface *pixels; /* of `lit`, in the world's axes; distance 0: they have no lighting */
    struct rows rows;
    float *radiance;
    uint16_t last; /* normal that was unpacked last, and what it is */
    float normal[3];
    struct lens_light_statistics *statistics;
    void *memory;
};

static void carve_rows(struct rows *rows, float *at, size_t width)
{
    float **const arrays[] = {&rows->along,  &rows->across, &rows->height, &rows->left,
                              &rows->length, &rows->x,      &rows->y,      &rows->depth};
    for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++) *arrays[k] = at + k * width;
    rows->key = (uint32_t *)(void *)(at + (ROW_ARRAYS - 1) * width);
}

static bool has_lighting(const struct patch *patch, size_t i)
{
    return patch->depth[i] > 0.0f && (!patch->reflector || patch->reflector[i] > 0.0f);
}

/* Surfaces of the pixels that may lend. A row of points is placed at once. */
static void place_pixels(struct lit_lens *f)
{
    const struct patch *p = f->patch;
    const size_t width = (size_t)rect_width(f->lit);
    float *px = f->rows.along, *py = f->rows.across, *pz = f->rows.height;
    for (int32_t y = f->lit.y0; y < f->lit.y1; y++) {
        const size_t first = patch_pixel(p, f->lit.x0, y);
        struct surface *out = f->pixels + (size_t)(y - f->lit.y0) * width;
        surface_points(&f->view, f->lit.x0, y, (uint32_t)width, p->depth + first, px, py, pz);
        for (size_t x = 0; x < width; x++) {
            const size_t i = first + x;
            out[x] = (struct surface){.point = {px[x], py[x], pz[x]},
                                      .normal = {p->normal[0][i], p->normal[1][i], p->normal[2][i]},
                                      .distance = has_lighting(p, i) ? p->depth[i] : 0.0f};
        }
    }
}

static int create(const struct plan *plan, const struct patch *patch, struct rect lit,
                  struct rect seen, struct lit_lens *f)
{
    const size_t area = (size_t)rect_area(lit);
    const size_t width =
        (size_t)(rect_width(lit) > rect_width(seen) ? rect_width(lit) : rect_width(seen));
    const size_t bytes = area * sizeof *f->pixels + ROW_ARRAYS * width * sizeof(float);
    f->memory = scratch_take(patch->scratch, bytes);
    if (!f->memory) return ERR_MEMORY;
    f->pixels = f->memory;
    carve_rows(&f->rows, (float *)(void *)(f->pixels + area), width);
    surface_view_init(&f->view, plan);
    lens_pattern_init(&f->pattern, plan);
    octahedron_unpack8(f->last = 0, f->normal);
    place_pixels(f);
    return 0;
}

/* The surface of a sample that the middle of the lens sees at (x, y), z ahead. */
static void place_sample(struct lit_lens *f, float x, float y, float z, uint16_t normal,
                         struct surface *out)
{
    const struct plan_camera *c = f->view.camera;
    const float a = f->view.a_start + f->view.a_step * x, b = f->view.b_start + f->view.b_step * y;
    if (normal != f->last) octahedron_unpack8(f->last = normal, f->normal);
    for (int k = 0; k < 3; k++) {
        out->point[k] = z * (a * c->right[k] + b * c->up[k] + c->forward[k]);
        out->normal[k] = f->normal[k];
    }
    out->distance = z * sqrtf(1.0f + a * a + b * b);
    out->id = 0;
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* surface_match, which is 1 of nearly all pixels: seen without a root. `allowed` is a little less
 * than what any point may be off a pixel's plane. */
static float match(const struct lit_lens *f, const struct surface *sample,
                   const struct surface *pixel, float allowed)
{
    const float d[3] = {sample->point[0] - pixel->point[0], sample->point[1] - pixel->point[1],
                        sample->point[2] - pixel->point[2]};
    const bool same = fabsf(dot(d, pixel->normal)) <= allowed &&
                      dot(sample->normal, pixel->normal) >= SURFACE_COS_FULL;
    return same ? 1.0f : surface_match(&f->view, sample, pixel);
}

/* The lighting around q of pixels that show the sample's surface; false: none does. */
static bool look_up(const struct lit_lens *f, float x, float y, const struct surface *sample,
                    float light[3])
{
    const float left = floorf(x - 0.5f), top = floorf(y - 0.5f);
    const float across = x - 0.5f - left, down = y - 0.5f - top;
    const float allowed =
        ROUNDING * SURFACE_PLANE_PX * surface_pixel_size(&f->view, sample->distance);
    float sum = 0.0f;
    light[0] = light[1] = light[2] = 0.0f;
    for (int32_t k = 0; k < 4; k++) {
        const int32_t px = (int32_t)left + (k & 1), py = (int32_t)top + (k >> 1);
        if (px < f->lit.x0 || px >= f->lit.x1 || py < f->lit.y0 || py >= f->lit.y1) continue;
        const struct surface *pixel =
            f->pixels + (size_t)(py - f->lit.y0) * (size_t)rect_width(f->lit) + (px - f->lit.x0);
        if (!(pixel->distance > 0.0f)) continue;
        const float weight = (k & 1 ? across : 1.0f - across) * (k >> 1 ? down : 1.0f - down) *
                             match(f, sample, pixel, allowed);
        if (!(weight > 0.0f)) continue;
        const size_t i = patch_pixel(f->patch, px, py);
        for (int c = 0; c < 3; c++) light[c] += weight * f->lighting->total[c][i];
        sum += weight;
    }
    if (!(sum > WEIGHT_MIN)) return false;
    for (int c = 0; c < 3; c++) light[c] /= sum;
    return true;
}

/* Samples whose q no pixel could show stay out of reach: floors of numbers that large have no
 * place among integers. */
static bool is_near(const struct lit_lens *f, float x, float y, float slope)
{
    return fabsf(slope) <= LENS_LIGHT_SLOPE_MOST && x >= (float)f->lit.x0 - 1.0f &&
           x <= (float)f->lit.x1 + 1.0f && y >= (float)f->lit.y0 - 1.0f &&
           y <= (float)f->lit.y1 + 1.0f;
}

static void count(const struct lit_lens *f, int32_t x, int32_t y, bool lit)
{
    const struct rect b = f->block;
    if (x < b.x0 || x >= b.x1 || y < b.y0 || y >= b.y1) return;
    f->statistics->samples_lit += lit ? 1 : 0;
    f->statistics->samples_own += lit ? 0 : 1;
}

static void light_row(struct lit_lens *f, uint32_t sample, int32_t y)
{
    const struct patch *p = f->patch;
    const size_t area = (size_t)rect_area(p->rect), first = patch_pixel(p, f->seen.x0, y);
    const float own_scale = 1.0f / f->plan->radiance_scale;
    const uint32_t *albedos = p->lens_albedo + sample * area + first;
    const uint32_t *own = p->lens_light + sample * area + first;
    const uint16_t *normals = p->lens_normal + sample * area + first;
    const float *slope = p->lens_slope + sample * area + first, *z = f->rows.depth;
    float *const out = f->radiance + sample * 3 * area + first;
    for (int32_t i = 0; i < rect_width(f->seen); i++) {
        const float qx = f->rows.x[i], qy = f->rows.y[i];
        struct surface at;
        float albedo[3], light[3];
        shared_exponent_unpack(albedos[i], SHARED_EXPONENT_9, albedo);
        if (!(albedo[0] + albedo[1] + albedo[2] > 0.0f)) continue;
        bool lit = z[i] > 0.0f && is_near(f, qx, qy, slope[i]);
        if (lit) place_sample(f, qx, qy, z[i], normals[i], &at);
        lit = lit && look_up(f, qx, qy, &at, light);
        if (!lit) {
            shared_exponent_unpack(own[i], SHARED_EXPONENT_8, light);
            for (int c = 0; c < 3; c++) light[c] *= own_scale;
        }
        count(f, f->seen.x0 + i, y, lit);
        for (size_t c = 0; c < 3; c++) {
            const float sum = out[c * area + (size_t)i] + albedo[c] * light[c];
            out[c * area + (size_t)i] = fminf(sum, LENS_RADIANCE_MAX);
        }
    }
}

/* Where the middle of the lens sees what sample k of line i shows. */
static void place_row(struct lit_lens *f, uint32_t i, uint32_t k, int32_t y)
{
    const struct patch *p = f->patch;
    struct rows *r = &f->rows;
    const uint32_t l = f->pattern.l, sample = i * l + k;
    const int32_t width = rect_width(f->seen);
    const size_t at = sample * (size_t)rect_area(p->rect) + patch_pixel(p, f->seen.x0, y);
    const float *slope = p->lens_slope + at;
    half_to_floats(p->lens_depth + at, r->depth, (size_t)width);
    for (int32_t x = 0; x < width; x++) {
        float across, down;
        path_pair(r->key[x], sample, PATH_PIXEL, &across, &down);
        const float u = r->left[x] + r->length[x] * pattern_axis(r->along[x], l, k);
        r->x[x] = (float)(f->seen.x0 + x) + across + slope[x] * u;
        r->y[x] = (float)y + down + slope[x] * r->height[x];
        r->depth[x] *= f->plan->length_unit;
    }
}

static void light_rows(struct lit_lens *f, int32_t y)
{
    const struct pattern *p = &f->plan->pattern;
    struct rows *r = &f->rows;
    const uint32_t width = (uint32_t)rect_width(f->seen), l = f->pattern.l;
    lens_pattern_jitters(&f->pattern, f->seen.x0, y, width, r->along, r->across);
    for (uint32_t x = 0; x < width; x++)
        r->key[x] = path_key(p->seed, p->frame, f->seen.x0 + (int32_t)x, y);
    for (uint32_t i = 0; i < l; i++) {
        lens_aperture_lines(&f->pattern.aperture, l, i, width, r->across, r->height, r->left,
                            r->length);
        for (uint32_t k = 0; k < l; k++) {
            place_row(f, i, k, y);
            light_row(f, i * l + k, y);
        }
    }
}

static void copy_radiance(const struct lit_lens *f)
{
    const struct patch *p = f->patch;
    const size_t area = (size_t)rect_area(p->rect);
    const size_t bytes = (size_t)rect_width(f->seen) * sizeof(float);
    const uint32_t planes = f->pattern.l * f->pattern.l * 3;
    for (uint32_t k = 0; k < planes; k++)
        for (int32_t y = f->seen.y0; y < f->seen.y1; y++) {
            const size_t at = k * area + patch_pixel(p, f->seen.x0, y);
            memcpy(f->radiance + at, p->lens_radiance + at, bytes);
        }
}

int lens_light_take(const struct plan *plan, const struct patch *patch,
                    const struct lighting *lighting, struct rect lit, struct rect seen,
                    struct rect block, float *radiance, struct lens_light_statistics *statistics)
{
    struct lit_lens f = {.plan = plan,
                         .patch = patch,
                         .lighting = lighting,
                         .lit = lit,
                         .seen = seen,
                         .block = block,
                         .radiance = radiance,
                         .statistics = statistics};
    if (!patch->lens_radiance || !patch->lens_slope || !patch->lens_depth || !patch->depth ||
        !patch->normal[0])
        return ERR_RANGE;
    const int error = create(plan, patch, lit, seen, &f);
    if (error) return error;
    copy_radiance(&f);
    for (int32_t y = seen.y0; y < seen.y1; y++) light_rows(&f, y);
    scratch_give(patch->scratch, f.memory);
    return 0;
}
