/* A frame whose light is looked up from pixel centres and then filtered over the lens, beside what
 * it stands for: every sample's light found by itself, and of each pixel the sum over all samples
 * of the picture around it and of the lens, in four dimensions (lens_brute.h); no cells, no blocks,
 * no rows. */
#include <math.h>
#include <stdlib.h>

#include "proto/half.h"
#include "proto/job/job.h"
#include "proto/octahedron.h"
#include "proto/pattern_path.h"
#include "proto/shared_exponent.h"
#include "tests/unit/server/reconstruct/film_picture.h"
#include "tests/unit/server/reconstruct/lens/lens_brute.h"
#include "tests/unit/server/reconstruct/lighting/lens_wall.h"
#include "tests/unit/unit.h"

/* A near wall to the left of an edge, a far one behind it; the focus lies between them. Slopes are
 * 6.5 and -3.2 pixels. */
#define SIDE_PX 56
#define EDGE    (0.5f * SIDE_PX)
#define PI      3.14159265f

#define SHARE_PX 3.5f   /* points that the middle does not see share light so far */
#define RMSE_MAX 0.025f /* of the picture's mean */

static const float color[3] = {3, 2, 1};

/* What the sum over picture and lens is made of, and what it is if that is wrong. */
enum twin { TWIN, TWIN_LOOKS_AT_ITS_PIXEL, TWIN_LOOKS_BACKWARDS, TWIN_WEIGHS_SLOPES_WRONG, TWINS };

static void init_plan(struct plan *plan)
{
    wall_plan(plan, LENS_FILTER_SHEARED);
    plan->width_px = plan->height_px = SIDE_PX;
    plan->camera.aperture_radius = 0.36f;
}

static float slope_of(const struct plan *plan, float z)
{
    const float scale = plan->camera.aperture_radius * (float)SIDE_PX;
    return half_to_float(half_from_float(scale * (1.0f / z - 1.0f / plan->camera.focus_distance)));
}

/* Of what the middle of the lens sees at (x, y) of the wall: both differ from wall to wall. */
static float irradiance_at(float z, float x, float y)
{
    return z < 4.0f ? 1.5f + sinf(0.25f * x) * cosf(0.2f * y) : 0.8f + 0.5f * sinf(0.3f * y);
}

static void albedo_at(float z, float x, float y, float out[3])
{
    const float wave = 0.5f + 0.35f * sinf(0.7f * x) * sinf(0.6f * y + z);
    out[0] = wave;
    out[1] = z < 4.0f ? 0.25f : 0.5f;
    out[2] = 0.9f - wave;
}

/* Where sample k of a pixel lies on the lens, and where the middle sees its point; which wall it
 * shows. */
static float place(const struct plan *plan, int32_t x, int32_t y, uint32_t k, float q[2])
{
    float u[2], p[2];
    lens_pattern_point(plan, x, y, k / L, k % L, u);
    path_pair(path_key(plan->pattern.seed, plan->pattern.frame, x, y), k, PATH_PIXEL, &p[0], &p[1]);
    const bool near = (float)x + p[0] + slope_of(plan, NEAR_Z) * u[0] < EDGE;
    const float z = near ? NEAR_Z : FAR_Z, s = slope_of(plan, z);
    q[0] = (float)x + p[0] + s * u[0];
    q[1] = (float)y + p[1] + s * u[1];
    return z;
}

/* Its own path finds 0 or twice the light there. */
static float found_at(int32_t x, int32_t y, uint32_t k)
{
    return (7 * x + 13 * y + 5 * (int32_t)k) % 11 < 5 ? 2.0f * 11.0f / 10.0f : 0.0f;
}

static void put_sample(const struct plan *plan, struct samples *s, int32_t x, int32_t y, uint32_t k,
                       size_t at)
{
    static const float normal[3] = {0, 0, 1};
    float q[2], albedo[3], own[3];
    const float z = place(plan, x, y, k, q);
    albedo_at(z, q[0], q[1], albedo);
    for (int c = 0; c < 3; c++)
        own[c] =
            plan->radiance_scale * found_at(x, y, k) * irradiance_at(z, q[0], q[1]) * color[c] / PI;
    samples_u16(s, PLANE_LENS_COVERAGE, 0)[at] = half_from_float(1.0f);
    samples_u16(s, PLANE_LENS_SLOPE, k)[at] = half_from_float(slope_of(plan, z));
    samples_u16(s, PLANE_LENS_DEPTH, k)[at] = half_from_float(z);
    samples_u16(s, PLANE_LENS_NORMAL, k)[at] = octahedron_pack8(normal);
    samples_u32(s, PLANE_LENS_ALBEDO, k)[at] = shared_exponent_pack(albedo, SHARED_EXPONENT_9);
    samples_u32(s, PLANE_LENS_OWN_LIGHT, k)[at] = shared_exponent_pack(own, SHARED_EXPONENT_8);
}

/* Centres see the near wall up to the edge. */
static float wall_at(float x)
{
    return x < EDGE ? NEAR_Z : FAR_Z;
}

static void put_pixel(struct samples *s, const struct plan *plan, int32_t x, int32_t y, size_t at,
                      const void *ctx)
{
    (void)ctx;
    static const float normal[3] = {0, 0, 1};
    const float cx = (float)x + 0.5f, cy = (float)y + 0.5f, z = wall_at(cx);
    float from[3], d[3];
    plan_camera_ray(plan, cx, cy, from, d);
    samples_f32(s, PLANE_DEPTH, 0)[at] = z / -d[2];
    samples_u32(s, PLANE_NORMAL, 0)[at] = octahedron_pack16(normal);
    samples_light_irradiance(s, 0)[at] = irradiance_at(z, cx, cy);
    for (uint32_t k = 0; k < N; k++) put_sample(plan, s, x, y, k, at);
}

static struct image *picture(const struct plan *plan)
{
    struct film *film = picture_film(plan, 64, 0);
    struct image *image;
    assert_int_equal(image_create(LAYER_BEAUTY, SIDE_PX, SIDE_PX, &image), 0);
    picture_land_pixels(plan, film, put_pixel, NULL);
    picture_draw(plan, film, image, NULL);
    film_destroy(&film);
    return image;
}

/* Irradiance between those of the four centres around q that show wall z; false where none does. */
static bool look_up(float z, const float q[2], float *out)
{
    const int32_t x0 = (int32_t)floorf(q[0] - 0.5f), y0 = (int32_t)floorf(q[1] - 0.5f);
    const float right = q[0] - 0.5f - (float)x0, down = q[1] - 0.5f - (float)y0;
    float sum = 0.0f, weights = 0.0f;
    for (int32_t k = 0; k < 4; k++) {
        const int32_t x = x0 + (k & 1), y = y0 + (k >> 1);
        const float cx = (float)x + 0.5f, cy = (float)y + 0.5f;
        if (x < 0 || y < 0 || x >= SIDE_PX || y >= SIDE_PX || wall_at(cx) != z) continue;
        const float weight = (k & 1 ? right : 1.0f - right) * (k >> 1 ? down : 1.0f - down);
        sum += weight * irradiance_at(z, cx, cy);
        weights += weight;
    }
    if (weights < 1e-3f) return false;
    *out = sum / weights;
    return true;
}

/* Samples whose points no centre shows. */
struct hidden {
    struct {
        float z, q[2], light;
    } * list;
    size_t count;
};

/* The mean of what their paths find around q. */
static float share(const struct hidden *h, float z, const float q[2])
{
    float sum = 0.0f, count = 0.0f;
    for (size_t i = 0; i < h->count; i++) {
        const float dx = h->list[i].q[0] - q[0], dy = h->list[i].q[1] - q[1];
        if (h->list[i].z != z || dx * dx + dy * dy > SHARE_PX * SHARE_PX) continue;
        sum += h->list[i].light;
        count += 1.0f;
    }
    return sum / count; /* it is one of them */
}

static struct hidden hidden_of(const struct plan *plan)
{
    struct hidden out = {.list = malloc((size_t)SIDE_PX * SIDE_PX * N * sizeof *out.list)};
    assert_non_null(out.list);
    for (int32_t y = 0; y < SIDE_PX; y++)
        for (int32_t x = 0; x < SIDE_PX; x++)
            for (uint32_t k = 0; k < N; k++) {
                float q[2], unused;
                const float z = place(plan, x, y, k, q);
                if (look_up(z, q, &unused)) continue;
                out.list[out.count].z = z;
                out.list[out.count].q[0] = q[0];
                out.list[out.count].q[1] = q[1];
                out.list[out.count++].light = found_at(x, y, k) * irradiance_at(z, q[0], q[1]);
            }
    return out;
}

/* Radiance of sample k of a pixel; `as`: looked up where it is, or somewhere else. */
static void shade(const struct plan *plan, const struct hidden *hidden, enum twin as, int32_t x,
                  int32_t y, uint32_t k, float out[3])
{
    float q[2], at[2], light, albedo[3];
    const float z = place(plan, x, y, k, q), centre[2] = {(float)x + 0.5f, (float)y + 0.5f};
    for (int c = 0; c < 2; c++) {
        at[c] = q[c];
        if (as == TWIN_LOOKS_AT_ITS_PIXEL) at[c] = centre[c];
        if (as == TWIN_LOOKS_BACKWARDS) at[c] = 2.0f * centre[c] - q[c];
    }
    if (!look_up(z, q, &light))
        light = share(hidden, z, q);
    else if (as == TWIN_LOOKS_AT_ITS_PIXEL || as == TWIN_LOOKS_BACKWARDS)
        light = irradiance_at(z, at[0], at[1]);
    albedo_at(z, q[0], q[1], albedo);
    for (int c = 0; c < 3; c++) out[c] = light * color[c] / PI * albedo[c];
}

/* The sum over picture and lens; planes of the caller's. */
static float *sum_up(const struct plan *plan, enum twin as)
{
    const size_t area = (size_t)SIDE_PX * SIDE_PX;
    struct lens_picture p = {.plan = *plan};
    struct hidden hidden = hidden_of(plan);
    p.patch.rect = p.patch.core = (struct rect){0, 0, SIDE_PX, SIDE_PX};
    p.patch.lens_radiance = malloc(3 * N * area * sizeof(float));
    p.patch.lens_slope = malloc(N * area * sizeof(float));
    p.out[0] = calloc(4 * area, sizeof(float));
    assert_true(p.patch.lens_radiance && p.patch.lens_slope && p.out[0]);
    for (size_t k = 1; k < 4; k++) p.out[k] = p.out[0] + k * area;
    for (int32_t y = 0; y < SIDE_PX; y++)
        for (int32_t x = 0; x < SIDE_PX; x++)
            for (uint32_t k = 0; k < N; k++) {
                const size_t at = (size_t)y * SIDE_PX + (size_t)x;
                float q[2], rgb[3];
                const float s = slope_of(plan, place(plan, x, y, k, q));
                shade(plan, &hidden, as, x, y, k, rgb);
                p.patch.lens_slope[k * area + at] = as == TWIN_WEIGHS_SLOPES_WRONG ? -s : s;
                for (size_t c = 0; c < 3; c++)
                    p.patch.lens_radiance[(k * 3 + c) * area + at] = rgb[c];
            }
    assert_int_equal(lens_brute(&p), 0);
    free(hidden.list);
    free(p.patch.lens_radiance);
    free(p.patch.lens_slope);
    return p.out[0];
}

/* Root of the mean squared difference over the mean. */
static float difference(const struct image *image, const float *sum)
{
    static const char *const names[] = {"R", "G", "B"};
    double squares = 0.0, mean = 0.0;
    for (int c = 0; c < 3; c++)
        for (int32_t y = 0; y < SIDE_PX; y++)
            for (int32_t x = 0; x < SIDE_PX; x++) {
                const double a = (double)*plane_at(image_plane(image, names[c]), x, y);
                const double b = (double)sum[(c * SIDE_PX + y) * SIDE_PX + x];
                squares += (a - b) * (a - b);
                mean += b;
            }
    return (float)(sqrt(squares * 3.0 * SIDE_PX * SIDE_PX) / mean);
}

static float twin_of(uint32_t blades, enum twin as)
{
    struct plan plan;
    init_plan(&plan);
    plan.camera.blade_count = blades;
    struct image *image = picture(&plan);
    float *sum = sum_up(&plan, as);
    const float out = difference(image, sum);
    image_destroy(&image);
    free(sum);
    return out;
}

TEST(frames_are_the_sum_over_picture_and_lens)
{
    static const uint32_t blades[] = {0, 6};
    for (size_t k = 0; k < sizeof blades / sizeof *blades; k++) {
        const float apart = twin_of(blades[k], TWIN);
        print_message("%u blades: %.2f %% apart\n", blades[k], (double)(100.0f * apart));
        assert_true(apart < RMSE_MAX);
    }
}

/* Light from elsewhere, or samples weighed where their slopes do not take them, would be seen. */
TEST(what_is_wrong_is_far_apart)
{
    static const char *const names[TWINS] = {"", "light of its pixel", "light of the other side",
                                             "slopes negated"};
    for (int as = TWIN + 1; as < TWINS; as++) {
        const float apart = twin_of(0, (enum twin)as);
        print_message("%s: %.2f %% apart\n", names[as], (double)(100.0f * apart));
        assert_true(apart > 2.0f * RMSE_MAX);
    }
}
