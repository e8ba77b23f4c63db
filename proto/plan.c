#include "proto/plan.h"

#include <math.h>

#include "proto/samples.h"

#define WRITE_digest(field) bytes_write_raw(w, (field).bytes, DIGEST_BYTES);
#define WRITE_i32(field)    bytes_write_u32(w, (uint32_t)(field));
#define WRITE_u32(field)    bytes_write_u32(w, field);
#define WRITE_u64(field)    bytes_write_u64(w, field);
#define WRITE_f32(field)    bytes_write_f32(w, field);
#define WRITE_f32x3(field)  bytes_write_f32s(w, field, 3);

static void write_light(struct bytes_writer *w, const struct plan_light *light)
{
#define LIGHT(type, name, check, from, to) WRITE_##type(light->name)
#include "proto/plan.def"
}

static void write_pose(struct bytes_writer *w, const struct plan_camera *pose)
{
#define POSE(type, name, check, from, to) WRITE_##type(pose->name)
#include "proto/plan.def"
}

void plan_encode(struct bytes_writer *w, const struct plan *plan)
{
#define FIELD(type, name, check, from, to)  WRITE_##type(plan->name)
#define CAMERA(type, name, check, from, to) WRITE_##type(plan->camera.name)
#include "proto/plan.def"
    for (uint32_t k = 0; k < plan->light_count; k++) write_light(w, &plan->lights[k]);
    for (uint32_t k = 0; k < plan->pose_count; k++) write_pose(w, &plan->poses[k]);
}

#define READ_digest(field) bytes_read_raw(r, (field).bytes, DIGEST_BYTES);
#define READ_i32(field)    field = (int32_t)bytes_read_u32(r);
#define READ_u32(field)    field = bytes_read_u32(r);
#define READ_u64(field)    field = bytes_read_u64(r);
#define READ_f32(field)    field = bytes_read_f32(r);
#define READ_f32x3(field)  bytes_read_f32s(r, field, 3);

static void read_light(struct bytes_reader *r, struct plan_light *light)
{
#define LIGHT(type, name, check, from, to) READ_##type(light->name)
#include "proto/plan.def"
}

static void read_pose(struct bytes_reader *r, struct plan_camera *pose)
{
#define POSE(type, name, check, from, to) READ_##type(pose->name)
#include "proto/plan.def"
}

static void read_head(struct bytes_reader *r, struct plan *plan)
{
#define FIELD(type, name, check, from, to)  READ_##type(plan->name)
#define CAMERA(type, name, check, from, to) READ_##type(plan->camera.name)
#include "proto/plan.def"
}

int plan_decode(const void *data, size_t size_bytes, struct plan *out, struct fault *fault)
{
    struct bytes_reader r;
    bytes_reader_init(&r, data, size_bytes);
    *out = (struct plan){0};
    read_head(&r, out);
    if (out->light_count > LIMIT_LIGHTS)
        return fault_set(fault, ERR_LIMIT, "light_count", "%u lights are above %d",
                         out->light_count, LIMIT_LIGHTS);
    if (out->pose_count != 0 && out->pose_count != SHUTTER_STEPS)
        return fault_set(fault, ERR_RANGE, "pose_count", "%u is neither 0 nor %u", out->pose_count,
                         SHUTTER_STEPS);
    for (uint32_t k = 0; k < out->light_count && !r.failed; k++) read_light(&r, &out->lights[k]);
    for (uint32_t k = 0; k < out->pose_count && !r.failed; k++) {
        out->poses[k] = out->camera;
        read_pose(&r, &out->poses[k]);
    }
    const int error = bytes_finish(&r);
    if (error)
        return fault_set(fault, error, "", "a plan of %u lights does not have %zu bytes",
                         out->light_count, size_bytes);
    return plan_check(out, fault);
}

uint32_t plan_light_planes(const struct plan *plan, uint32_t light)
{
    const uint32_t irradiance = 1u << LIGHT_PLANE_IRRADIANCE;
    if (plan->lights[light].type != LIGHT_RECTANGLE) return plan->light_planes & irradiance;
    return plan->light_planes & (plan->shadow_filter ? ~irradiance : ~0u);
}

/* Computes the image plane's coordinates of a pixel position. */
static void plane_position(const struct plan *plan, const struct plan_camera *c, float px, float py,
                           float *a, float *b)
{
    *a = (2.0f * px / (float)plan->width_px - 1.0f - c->centre_x) * c->half_width;
    *b = (1.0f - 2.0f * py / (float)plan->height_px - c->centre_y) * c->half_height;
}

static void mix(struct shutter_place at, const float *before, const float *after, int count,
                float *out)
{
    for (int i = 0; i < count; i++) out[i] = shutter_mix(at, before[i], after[i]);
}

/* Turned axes lose length between steps; opposite ones would lose all. */
static void mix_axis(struct shutter_place at, const float before[3], const float after[3],
                     float out[3])
{
    float v[3];
    mix(at, before, after, 3, v);
    const float square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    for (int i = 0; i < 3; i++) out[i] = square > 1e-4f ? v[i] / sqrtf(square) : before[i];
}

void plan_camera_at(const struct plan *plan, float time, struct plan_camera *out)
{
    *out = plan->camera;
    if (!plan_has_shutter(plan)) return;
    const struct shutter_place at = shutter_place_of(time);
    const struct plan_camera *a = &plan->poses[at.before], *b = a + 1;
    mix(at, a->eye, b->eye, 3, out->eye);
    mix_axis(at, a->right, b->right, out->right);
    mix_axis(at, a->up, b->up, out->up);
    mix_axis(at, a->forward, b->forward, out->forward);
    mix(at, &a->half_width, &b->half_width, 1, &out->half_width);
    mix(at, &a->half_height, &b->half_height, 1, &out->half_height);
}

void plan_camera_ray(const struct plan *plan, float px, float py, float origin[3],
                     float direction[3])
{
    plan_camera_ray_of(plan, &plan->camera, px, py, origin, direction);
}

void plan_camera_ray_of(const struct plan *plan, const struct plan_camera *c, float px, float py,
                        float origin[3], float direction[3])
{
    float a, b;
    plane_position(plan, c, px, py, &a, &b);
    if (c->type == CAMERA_ORTHOGRAPHIC) {
        for (int i = 0; i < 3; i++) {
            origin[i] = c->eye[i] + a * c->right[i] + b * c->up[i];
            direction[i] = c->forward[i];
        }
        return;
    }
    float d[3];
    for (int i = 0; i < 3; i++) d[i] = c->forward[i] + a * c->right[i] + b * c->up[i];
    /* At least the length of forward, about 1: right and up are orthogonal to it. */
    const float scale = 1.0f / sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (int i = 0; i < 3; i++) {
        origin[i] = c->eye[i];
        direction[i] = d[i] * scale;
    }
}

float plan_pixel_size(const struct plan *plan, float distance)
{
    const struct plan_camera *c = &plan->camera;
    const float size = fmaxf(2.0f * c->half_width / (float)plan->width_px,
                             2.0f * c->half_height / (float)plan->height_px);
    return c->type == CAMERA_ORTHOGRAPHIC ? size : size * distance;
}

/* Passes double the samples until one of them is LIMIT_PASS_SPP long; then all are. */
#define PASS_SPP_FIRST 16u
#define PASSES_GROWING 3u
_Static_assert(PASS_SPP_FIRST << (PASSES_GROWING - 1) == LIMIT_PASS_SPP,
               "the first passes together are as long as one of the others");

uint32_t plan_pass_spp(const struct plan *plan, uint32_t passes)
{
    const uint32_t spp = plan->paths.spp;
    if (passes == 0) return 0;
    if (plan_lens_has_paths(plan)) return spp;
    const uint64_t sum = passes <= PASSES_GROWING
                             ? (uint64_t)PASS_SPP_FIRST << (passes - 1)
                             : (uint64_t)LIMIT_PASS_SPP * (passes - PASSES_GROWING + 1);
    return sum < spp ? (uint32_t)sum : spp;
}

/* Those of one view. */
static uint32_t count_passes(const struct plan *plan)
{
    const uint32_t spp = plan->paths.spp;
    if (plan_lens_has_paths(plan)) return 1;
    if (spp > LIMIT_PASS_SPP)
        return PASSES_GROWING - 1 + (spp + LIMIT_PASS_SPP - 1) / LIMIT_PASS_SPP;
    uint32_t passes = 1;
    while (plan_pass_spp(plan, passes) < spp) passes++;
    return passes;
}

uint32_t plan_pass_count(const struct plan *plan)
{
    return count_passes(plan) * plan_views(plan);
}

void plan_pass_range(const struct plan *plan, uint32_t pass, uint32_t *first, uint32_t *count)
{
    const uint32_t of_view = pass / plan_views(plan);
    *first = plan_pass_spp(plan, of_view);
    *count = plan_pass_spp(plan, of_view + 1) - *first;
}

struct plan_pass plan_scheduled_pass(const struct plan *plan, uint32_t number)
{
    struct plan_pass pass = {.number = number};
    plan_pass_range(plan, number, &pass.first, &pass.count);
    if (number < plan_views(plan)) pass.strata = plan->indirect_strata_per_axis;
    return pass;
}

#define PLANES_BOUNCE_MORE                                                                         \
    (PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(BOUNCE_DISTANCE_MIN) | PLANE_BIT(AMBIENT_VISIBILITY) | \
     PLANE_BIT(AMBIENT_DISTANCE_MIN) | PLANE_BIT(GLOSSY_MEAN) | PLANE_BIT(GLOSSY_HALF) |           \
     PLANE_BIT(GLOSSY_NEARNESS))
/* Distances, and what they ask for, are the first set's. */
#define PLANES_SECOND_SET (PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(AMBIENT_VISIBILITY))

uint64_t plan_pass_planes(const struct plan *plan, uint32_t number)
{
    if (number < plan_views(plan)) return plan->planes;
    if (number < plan_pass_count(plan)) return plan->planes & PLANES_PATH_ALL;
    if (plan->lens_extra > 0) return plan->planes & PLANES_LENS_SECOND_SET;
    if (plan->indirect_filter == INDIRECT_FILTER_ADAPTIVE)
        return plan->planes &
               (PLANES_SECOND_SET | (plan_strata_maps(plan) > 1 ? PLANE_BIT(GLOSSY_MEAN) : 0));
    return plan->planes & (PLANES_PATH_ALL | PLANES_BOUNCE_MORE);
}

bool plan_sky_in_fields(const struct plan *plan)
{
    return plan->lens_relight == LENS_RELIGHT_SKY ||
           plan->paths.without_diffuse_indirect == INDIRECT_LEFT_SKY;
}

bool plan_has_rounds(const struct plan *plan)
{
    return plan->target_error > 0.0f || plan->indirect_filter == INDIRECT_FILTER_ADAPTIVE ||
           plan->lens_extra > 0;
}

uint32_t plan_strata_maps(const struct plan *plan)
{
    if (plan->lens_extra > 0) return 1;
    if (plan->indirect_filter != INDIRECT_FILTER_ADAPTIVE) return 0;
    return plan->planes >> PLANE_GLOSSY_SPAN & 1u ? 2 : 1;
}

/* The second set: so many rays a pixel at most. */
static int check_second_set(const struct plan *plan, const struct plan_pass *pass)
{
    const uint32_t l = plan->indirect_strata_per_axis;
    if (pass->number != plan_pass_count(plan) || pass->first != 0 || pass->count != 0)
        return ERR_RANGE;
    if (pass->strata == 0 || !pass->strata_map) return ERR_RANGE;
    if ((pass->lobes != NULL) != (plan_strata_maps(plan) > 1)) return ERR_RANGE;
    if (plan->lens_extra > 0) return pass->strata == PLAN_LENS_EXTRA_STRATA ? 0 : ERR_RANGE;
    if (pass->strata > PLAN_STRATA_MAX) return ERR_LIMIT;
    return l * l + pass->strata * pass->strata > plan->adaptive.rays_max ? ERR_LIMIT : 0;
}

static uint32_t most_of(const uint8_t *strata_map, size_t area)
{
    uint32_t most = 0;
    for (size_t i = 0; i < area; i++) most = strata_map[i] > most ? strata_map[i] : most;
    return most;
}

int plan_strata_map_check(const struct plan_pass *pass, size_t area)
{
    const uint32_t bounces = most_of(pass->strata_map, area);
    const uint32_t lobes = pass->lobes ? most_of(pass->lobes, area) : 0;
    return (bounces > lobes ? bounces : lobes) == pass->strata ? 0 : ERR_RANGE;
}

int plan_pass_check(const struct plan *plan, const struct plan_pass *pass)
{
    const bool sets = plan->indirect_filter == INDIRECT_FILTER_ADAPTIVE || plan->lens_extra > 0;
    const bool second = sets && pass->number >= plan_pass_count(plan);
    if (pass->number >= LIMIT_PASSES) return ERR_LIMIT;
    if (second) return check_second_set(plan, pass);
    if (pass->strata_map || pass->lobes) return ERR_RANGE;
    if (pass->number < plan_pass_count(plan)) {
        const struct plan_pass own = plan_scheduled_pass(plan, pass->number);
        const bool same =
            own.first == pass->first && own.count == pass->count && own.strata == pass->strata;
        return same ? 0 : ERR_RANGE;
    }
    if (!(plan->target_error > 0.0f)) return ERR_RANGE;
    if (pass->count > LIMIT_PASS_SPP || pass->strata > LIMIT_STRATA_PER_AXIS ||
        pass->strata * pass->strata > LIMIT_PASS_SPP)
        return ERR_LIMIT;
    if (pass->first > LIMIT_SPP || pass->first + pass->count > LIMIT_SPP) return ERR_LIMIT;
    if (pass->count + pass->strata == 0 || pass->strata % 2 != 0) return ERR_RANGE;
    if (pass->count > 0 && plan->paths.spp == 0) return ERR_RANGE;
    return pass->strata > 0 && plan->indirect_strata_per_axis == 0 ? ERR_RANGE : 0;
}

struct plan_split plan_pass_split(const struct plan_pass *pass)
{
    const uint64_t first = pass->first, end = first + pass->count;
    for (uint64_t length = (uint64_t)1 << 31; length > 1; length /= 2) {
        const uint64_t start = (first + length - 1) / length * length;
        if (start + length > end) continue;
        return (struct plan_split){(uint32_t)start, (uint32_t)length,
                                   (uint32_t)((end - start) / length)};
    }
    return (struct plan_split){0};
}
