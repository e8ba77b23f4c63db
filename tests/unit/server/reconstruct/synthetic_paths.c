#include "tests/unit/server/reconstruct/synthetic_paths.h"

void synthetic_paths_plan(struct plan *plan, int32_t width, int32_t height, int32_t tile_px,
                          uint32_t spp)
{
    synthetic_plan(plan, width, height, tile_px);
    plan->planes = PLANES_PATH | PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ID);
    plan->light_planes = 0;
    plan->sub_samples = 0;
    plan->indirect_strata_per_axis = 0;
    plan->paths = (struct plan_paths){.spp = spp};
    plan->occlusion_distance = 1;
}

void synthetic_beside_plan(struct plan *plan, int32_t width, int32_t height, int32_t tile_px,
                           uint32_t spp)
{
    synthetic_plan(plan, width, height, tile_px);
    plan->planes |= PLANES_PATH | PLANE_BIT(BOUNCE_DISTANCE_MIN) | PLANE_BIT(AMBIENT_VISIBILITY);
    plan->planes &= ~(PLANE_BIT(EMISSION) | PLANE_BIT(PATH_DIFFUSE_INDIRECT) |
                      PLANE_BIT(PATH_VISIBILITY) | PLANE_BIT(PATH_M2));
    plan->light_planes = 0;
    plan->paths = (struct plan_paths){.spp = spp, .without_diffuse_indirect = 1};
    plan->occlusion_distance = 1;
}

float synthetic_random(int32_t x, int32_t y, uint32_t sample, uint32_t what)
{
    uint32_t h = (uint32_t)x * 0x8da6b343u ^ (uint32_t)y * 0xd8163841u ^ sample * 0xcb1ab31fu ^
                 what * 0x165667b1u;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return (float)((h ^ h >> 15) >> 8) * 0x1p-24f;
}

static bool synthetic_path_hits(int32_t x, int32_t y, uint32_t sample)
{
    return synthetic_random(x, y, sample, 1) < (float)((x + 2 * y) % 5) * 0.25f;
}

/* Light of a path that hits. */
static float synthetic_light(enum plane_id plane, int32_t x, int32_t y, uint32_t sample, uint32_t c)
{
    return synthetic_random(x, y, sample, 8 * plane + c);
}

float synthetic_path(enum plane_id plane, int32_t x, int32_t y, uint32_t sample, uint32_t c)
{
    const bool hits = synthetic_path_hits(x, y, sample);
    switch (plane) {
    case PLANE_PATH_RADIANCE:
        if (!hits) return 0.25f * (float)(c + 1);
        return synthetic_light(PLANE_PATH_DIRECT, x, y, sample, c) +
               synthetic_light(PLANE_PATH_INDIRECT, x, y, sample, c);
    case PLANE_PATH_COVERAGE:
        return hits ? 1.0f : 0.0f;
    case PLANE_PATH_VISIBILITY:
        return !hits || synthetic_random(x, y, sample, 2) < 0.5f ? 1.0f : 0.0f;
    case PLANE_PATH_EMISSION:
        return hits ? 0.0f : 0.25f * (float)(c + 1);
    default:
        return hits ? synthetic_light(plane, x, y, sample, c) : 0.0f;
    }
}

static uint32_t synthetic_path_components(enum plane_id plane)
{
    return plane == PLANE_PATH_COVERAGE || plane == PLANE_PATH_VISIBILITY ? 1 : 3;
}

double synthetic_spread(int32_t x, int32_t y, uint32_t first, uint32_t count, uint32_t c)
{
    double sum = 0, squares = 0;
    for (uint32_t s = first; s < first + count; s++)
        sum += (double)synthetic_path(PLANE_PATH_RADIANCE, x, y, s, c);
    for (uint32_t s = first; s < first + count; s++) {
        const double d =
            (double)synthetic_path(PLANE_PATH_RADIANCE, x, y, s, c) - sum / (double)count;
        squares += d * d;
    }
    return squares;
}

float synthetic_path_sum(enum plane_id plane, int32_t x, int32_t y, uint32_t first, uint32_t count,
                         uint32_t c)
{
    float sum = 0.0f;
    if (plane == PLANE_PATH_M2) return (float)synthetic_spread(x, y, first, count, c);
    for (uint32_t s = first; s < first + count; s++) sum += synthetic_path(plane, x, y, s, c);
    return sum;
}

float synthetic_passes_sum(const struct plan *plan, enum plane_id plane, int32_t x, int32_t y,
                           uint32_t passes, uint32_t c)
{
    float sum = 0.0f;
    for (uint32_t p = 0; p < passes; p++) {
        uint32_t first, count;
        plan_pass_range(plan, p, &first, &count);
        sum += synthetic_path_sum(plane, x, y, first, count, c);
    }
    return sum;
}

static void synthetic_put_paths(struct samples *s, const struct plan *plan, uint32_t pass, size_t i,
                                int32_t x, int32_t y)
{
    uint32_t first, count;
    plan_pass_range(plan, pass, &first, &count);
    for (uint32_t p = PLANE_PATH_RADIANCE; p <= PLANE_PATH_VISIBILITY; p++)
        for (uint32_t c = 0; c < synthetic_path_components(p); c++)
            if (samples_f32(s, p, c))
                samples_f32(s, p, c)[i] = synthetic_path_sum(p, x, y, first, count, c);
    if (pass > 0) return;
    const struct synthetic_pixel pixel = synthetic_pixel(plan, x, y);
    if (plan->planes >> PLANE_ALBEDO & 1u) {
        synthetic_put(s, plan, i, &pixel);
        return;
    }
    if (plan->planes >> PLANE_AMBIENT_VISIBILITY & 1u) synthetic_put_bounces(s, plan, i, &pixel);
    samples_f32(s, PLANE_DEPTH, 0)[i] = pixel.depth;
    samples_u32(s, PLANE_ID, 0)[i] = pixel.id;
    samples_u32(s, PLANE_NORMAL, 0)[i] = pixel.depth > 0.0f ? octahedron_pack16(pixel.normal) : 0;
}

/* Squared differences of halves, as plan_pass_split has them. */
static float synthetic_split(const struct plan_pass *pass, int32_t x, int32_t y)
{
    const struct plan_split parts = plan_pass_split(pass);
    float sum = 0.0f;
    for (uint32_t k = 0; k < parts.count; k++)
        for (uint32_t c = 0; c < 3; c++) {
            const uint32_t first = parts.first + k * parts.length, half = parts.length / 2;
            const float d = synthetic_path_sum(PLANE_PATH_RADIANCE, x, y, first, half, c) -
                            synthetic_path_sum(PLANE_PATH_RADIANCE, x, y, first + half, half, c);
            sum += d * d;
        }
    return sum;
}

static uint16_t synthetic_half(const struct plan *plan, uint32_t pass, int32_t x, int32_t y,
                               uint32_t c)
{
    const float noise = 0.5f * synthetic_random(x, y, pass, 900 + c);
    return half_from_float((1.0f + noise) * plan->radiance_scale);
}

/* What a second set brings: its number of rays shows in it. */
static void synthetic_put_second(struct samples *s, const struct plan *plan,
                                 const struct plan_pass *pass, size_t i, int32_t x, int32_t y)
{
    const float noise = synthetic_random(x, y, pass->strata_map[i], 950);
    for (uint32_t c = 0; c < 3 && pass->strata_map[i] > 0; c++)
        samples_u16(s, PLANE_INDIRECT_MEAN, c)[i] =
            half_from_float((0.5f + noise) * plan->radiance_scale);
    if (samples_u16(s, PLANE_AMBIENT_VISIBILITY, 0) && pass->strata_map[i] > 0)
        samples_u16(s, PLANE_AMBIENT_VISIBILITY, 0)[i] = half_from_float(0.5f * noise);
}

/* What a pass beyond the schedule brings, and halves of any. */
static void synthetic_put_more(struct samples *s, const struct plan *plan,
                               const struct plan_pass *pass, size_t i, int32_t x, int32_t y)
{
    const struct synthetic_pixel pixel = synthetic_pixel(plan, x, y);
    if (samples_f32(s, PLANE_PATH_HALF_DIFFERENCE2, 0))
        samples_f32(s, PLANE_PATH_HALF_DIFFERENCE2, 0)[i] = synthetic_split(pass, x, y);
    for (uint32_t p = PLANE_PATH_RADIANCE; p <= PLANE_PATH_VISIBILITY && pass->count > 0; p++)
        for (uint32_t c = 0; c < synthetic_path_components(p); c++)
            if (samples_f32(s, p, c))
                samples_f32(s, p, c)[i] = synthetic_path_sum(p, x, y, pass->first, pass->count, c);
    if (pass->strata == 0) return;
    for (uint32_t c = 0; c < 6 && samples_u16(s, PLANE_INDIRECT_HALVES, c); c++)
        samples_u16(s, PLANE_INDIRECT_HALVES, c)[i] = synthetic_half(plan, pass->number, x, y, c);
    if (pass->strata_map)
        synthetic_put_second(s, plan, pass, i, x, y);
    else
        synthetic_put_bounces(s, plan, i, &pixel);
}

struct samples *synthetic_pass_of(const struct plan *plan, uint32_t tile,
                                  const struct plan_pass *pass)
{
    struct tile_grid grid;
    struct samples_layout layout;
    struct samples *s = NULL;
    if (tile_grid_init(&grid, plan->width_px, plan->height_px, plan->tile_px)) return NULL;
    struct rect r = tile_grid_rect(&grid, tile);
    if (samples_layout_init(&layout, plan, pass->number, rect_width(r), rect_height(r)))
        return NULL;
    if (samples_create(&layout, &s)) return NULL;
    size_t i = 0;
    for (int32_t y = r.y0; y < r.y1; y++)
        for (int32_t x = r.x0; x < r.x1; x++, i++) {
            if (pass->number == 0) synthetic_put_paths(s, plan, 0, i, x, y);
            synthetic_put_more(s, plan, pass, i, x, y);
        }
    return s;
}

void synthetic_target_plan(struct plan *plan, int32_t width, int32_t height, int32_t tile_px,
                           float target)
{
    synthetic_beside_plan(plan, width, height, tile_px, 9);
    plan->planes &= ~PLANE_BIT(INDIRECT_MEAN);
    plan->planes |=
        PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(PATH_M2) | PLANE_BIT(PATH_HALF_DIFFERENCE2);
    plan->indirect_filter = INDIRECT_FILTER_CONSTANT;
    plan->target_error = target;
    plan->spp_max = 256;
}

void synthetic_rate_plan(struct plan *plan, int32_t width, int32_t height, int32_t tile_px,
                         uint32_t spp)
{
    if (spp > 0)
        synthetic_beside_plan(plan, width, height, tile_px, spp);
    else
        synthetic_plan(plan, width, height, tile_px);
    plan->planes |= PLANE_BIT(BOUNCE_DISTANCE_MIN) | PLANE_BIT(BOUNCE_DISTANCE_MAX);
    plan->indirect_strata_per_axis = 4;
    plan->indirect_filter = INDIRECT_FILTER_ADAPTIVE;
    plan->adaptive = (struct plan_adaptive){.mu = 1.0f, .rays_max = 100};
}

struct samples *synthetic_pass(const struct plan *plan, uint32_t tile, uint32_t pass)
{
    struct tile_grid grid;
    struct samples_layout layout;
    struct samples *s = NULL;
    if (tile_grid_init(&grid, plan->width_px, plan->height_px, plan->tile_px)) return NULL;
    struct rect r = tile_grid_rect(&grid, tile);
    if (samples_layout_init(&layout, plan, pass, rect_width(r), rect_height(r))) return NULL;
    if (samples_create(&layout, &s)) return NULL;
    size_t i = 0;
    for (int32_t y = r.y0; y < r.y1; y++)
        for (int32_t x = r.x0; x < r.x1; x++) synthetic_put_paths(s, plan, pass, i++, x, y);
    return s;
}
