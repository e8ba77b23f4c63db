#include "tests/unit/server/reconstruct/residual/residual_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/random.h"
#include "tests/unit/server/reconstruct/synthetic_paths.h"

float residual_random(int32_t x, int32_t y, uint32_t sample, uint32_t what)
{
    struct random r = {(uint64_t)(uint32_t)x << 40 ^ (uint64_t)(uint32_t)y << 20 ^ sample};
    r.state = random_bits(&r) ^ what;
    return random_unit(&r);
}

float residual_noise(int32_t x, int32_t y, uint32_t sample, uint32_t what)
{
    return -logf(1.0f - residual_random(x, y, sample, what));
}

struct plan residual_scene_plan(const struct residual_scene *s)
{
    struct plan plan;
    synthetic_paths_plan(&plan, s->width, s->height, 64, s->spp);
    plan.planes = PLANES_RESIDUAL_READ;
    if (!s->no_indirect)
        plan.planes |= PLANE_BIT(PATH_HALF_INDIRECT) | PLANE_BIT(PATH_DIFFUSE_INDIRECT);
    plan.occlusion_distance = 0;
    plan.residual_filter = RESIDUAL_FILTER_HALVES;
    if (s->temporal > 0) { /* a pixel is a unit wide, and the picture begins at the frame's pan */
        plan.temporal = s->temporal;
        plan.planes |= PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ID);
        plan.camera.type = CAMERA_ORTHOGRAPHIC;
        plan.camera.half_width = 0.5f * (float)s->width;
        plan.camera.half_height = 0.5f * (float)s->height;
        plan.camera.eye[0] = (float)(s->pan * s->frame) + plan.camera.half_width;
    }
    if (s->lens_strata == 0) return plan;
    plan.planes |= PLANE_BIT(LENS_RADIANCE) | PLANE_BIT(LENS_SLOPE);
    plan.lens_strata_per_axis = s->lens_strata;
    plan.camera.aperture_radius = 1;
    plan.camera.focus_distance = 4;
    return plan;
}

/* A pixel's: a patch's planes are a multiple of pages apart, so that adding to all of them pixel by
 * pixel leaves none in the cache. */
struct sums {
    float radiance[3], emission[3], direct[3], indirect[3], albedo[3], normal[3], tint[3];
    float alpha, distance, coverage;
    float half_scattered[3], half_direct[3], half_indirect[3];
};

static void add(float sum[3], const float value[3])
{
    for (int c = 0; c < 3; c++) sum[c] += value[c];
}

static void add_sample(struct sums *sums, const struct residual_sample *s, bool half)
{
    float scattered[3], radiance[3];
    for (int c = 0; c < 3; c++) {
        scattered[c] = s->albedo[c] * (s->direct[c] + s->indirect[c]) + s->rest[c];
        radiance[c] = s->emission[c] + scattered[c];
    }
    add(sums->radiance, radiance);
    add(sums->emission, s->emission);
    add(sums->direct, s->direct);
    add(sums->indirect, s->indirect);
    if (s->hits) {
        add(sums->albedo, s->albedo);
        add(sums->normal, s->normal);
        add(sums->tint, s->tint);
        sums->alpha += s->alpha;
        sums->distance += s->distance;
        sums->coverage += 1.0f;
    }
    if (!half) return;
    add(sums->half_scattered, scattered);
    add(sums->half_direct, s->direct);
    add(sums->half_indirect, s->indirect);
}

static void put(float *const plane[3], size_t i, const float value[3])
{
    for (int c = 0; c < 3 && plane[c]; c++) plane[c][i] = value[c];
}

static void put_sums(struct patch *p, size_t i, const struct sums *sums)
{
    put(p->path_radiance, i, sums->radiance);
    put(p->path_emission, i, sums->emission);
    put(p->path_diffuse_direct, i, sums->direct);
    put(p->path_diffuse_indirect, i, sums->indirect);
    put(p->path_albedo, i, sums->albedo);
    put(p->path_normal, i, sums->normal);
    put(p->path_tint, i, sums->tint);
    p->path_alpha[i] = sums->alpha;
    p->path_distance[i] = sums->distance;
    p->path_coverage[i] = sums->coverage;
    put(p->path_half_scattered, i, sums->half_scattered);
    put(p->path_half_direct, i, sums->half_direct);
    put(p->path_half_indirect, i, sums->half_indirect);
}

/* Of sample k through a lens. */
static void set_lens_sample(struct patch *p, size_t i, uint32_t k, const struct residual_sample *s)
{
    const size_t area = (size_t)rect_area(p->rect);
    p->lens_slope[k * area + i] = s->slope;
    for (size_t c = 0; c < 3; c++)
        p->lens_radiance[(k * 3 + c) * area + i] =
            s->emission[c] + (s->albedo[c] * (s->direct[c] + s->indirect[c]) + s->rest[c]);
}

static void set_centre(struct patch *p, size_t i, const struct residual_sample *s)
{
    for (int c = 0; c < 3; c++) p->normal[c][i] = s->hits ? s->normal[c] : 0.0f;
    p->depth[i] = s->hits ? s->distance : 0.0f;
    p->id[i] = s->hits ? s->id : 0;
}

static void add_pixel(const struct residual_scene *s, struct patch *p, size_t i, int32_t x,
                      int32_t y)
{
    const struct plan_pass pass = {.count = s->spp_of ? s->spp_of(x, y) : s->spp};
    const struct plan_split parts = plan_pass_split(&pass);
    const uint32_t end = parts.first + parts.count * parts.length;
    struct sums sums = {.coverage = 0};
    p->paths.spp[i] = (float)pass.count;
    p->paths.split_spp[i] =
        (float)(s->lens_strata > 0 ? pass.count / 2 * 2 : parts.count * parts.length);
    p->paths.split_length[i] = (float)parts.length;
    for (uint32_t k = 0; k < pass.count; k++) {
        struct residual_sample sample = {.hits = true,
                                         .id = 1,
                                         .normal = {0, 0, 1},
                                         .distance = 5,
                                         .albedo = {0.5f, 0.5f, 0.5f}};
        if (s->show) s->show(s, x, y, k, &sample);
        if (k == 0 && s->temporal > 0) set_centre(p, i, &sample);
        const bool inside = k >= parts.first && k < end;
        const bool first = inside && (k - parts.first) % parts.length < parts.length / 2;
        add_sample(&sums, &sample, s->lens_strata ? plan_lens_half(s->lens_strata, k) : first);
        if (s->lens_strata > 0) set_lens_sample(p, i, k, &sample);
    }
    put_sums(p, i, &sums);
}

struct patch *residual_scene_patch(const struct residual_scene *s, struct rect rect)
{
    const struct plan plan = residual_scene_plan(s);
    struct patch *patch;
    assert_int_equal(patch_create(&plan, rect, &patch), 0);
    memset(patch->memory, 0, patch_bytes(&plan, (size_t)rect_area(rect)));
    for (int32_t y = rect.y0; y < rect.y1; y++)
        for (int32_t x = rect.x0; x < rect.x1; x++)
            add_pixel(s, patch, patch_pixel(patch, x, y), x, y);
    return patch;
}

struct residual_picture residual_scene_filter(const struct residual_scene *s, struct rect block)
{
    const struct plan plan = residual_scene_plan(s);
    const struct rect all = {0, 0, s->width, s->height};
    struct residual_picture picture;
    struct residual_statistics statistics = {0};
    struct patch *patch =
        residual_scene_patch(s, rect_intersect(rect_grow(block, residual_halo_px(&plan)), all));
    assert_int_equal(residual_filter(patch, block, NULL, &picture, &statistics), 0);
    assert_true(statistics.pixels <= (uint64_t)rect_area(block));
    patch_destroy(&patch);
    return picture;
}

struct residual_picture residual_scene_filter_all(const struct residual_scene *s)
{
    return residual_scene_filter(s, (struct rect){0, 0, s->width, s->height});
}

float residual_scene_mean(const struct patch *patch, int channel, int32_t x, int32_t y)
{
    const size_t i = patch_pixel(patch, x, y);
    return patch->path_radiance[channel][i] / patch->paths.spp[i];
}

struct residual_told residual_scene_tell(const struct residual_scene *s, struct rect block,
                                         residual_plain *plain)
{
    return residual_scene_tell_within(s, block, block, plain);
}

struct residual_told residual_scene_tell_within(const struct residual_scene *s, struct rect lit,
                                                struct rect block, residual_plain *plain)
{
    struct plan plan = residual_scene_plan(s);
    struct residual_statistics statistics = {0};
    struct residual_told told;
    plan.planes |= PLANE_BIT(PATH_M2);
    const struct rect near = rect_grow(lit, residual_halo_px(&plan));
    const struct rect whole = {0, 0, s->width, s->height};
    struct patch *patch = residual_scene_patch(s, rect_intersect(near, whole));
    const size_t area = (size_t)rect_area(block);
    told.variance[0] = malloc(3 * area * sizeof(float));
    assert_non_null(told.variance[0]);
    told.variance[1] = told.variance[0] + area, told.variance[2] = told.variance[1] + area;
    for (size_t i = 0; i < area; i++)
        for (int c = 0; c < 3; c++)
            told.variance[c][i] = plain(s, block.x0 + (int32_t)i % rect_width(block),
                                        block.y0 + (int32_t)i / rect_width(block));
    const struct residual_variance known = {block, told.variance};
    assert_int_equal(residual_filter(patch, lit, &known, &told.picture, &statistics), 0);
    patch_destroy(&patch);
    return told;
}

void residual_told_fini(struct residual_told *told)
{
    residual_picture_fini(&told->picture);
    free(told->variance[0]);
}
