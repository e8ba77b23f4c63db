/* What is traced of a block of pixels, stage by stage. */
#include <string.h>

#include "worker/tile/tile_work.h"
#include "worker/trace/hit/block_store.h"
#include "worker/trace/hit/geometry.h"
#include "worker/trace/hit/primary.h"
#include "worker/trace/path/path_leave.h"

/* Marks lanes whose surface reflects something. */
static void mark_lit(const struct surface *s, struct lanes_mask *lit)
{
    for (int i = 0; i < LANES; i++)
        lit->on[i] |= -((s->albedo.x[i] >= ALBEDO_BLACK) | (s->albedo.y[i] >= ALBEDO_BLACK) |
                        (s->albedo.z[i] >= ALBEDO_BLACK));
}

static void add_emission(const struct surface *s, struct lanes3 *sum)
{
    for (int i = 0; i < LANES; i++) {
        sum->x[i] += s->emission.x[i];
        sum->y[i] += s->emission.y[i];
        sum->z[i] += s->emission.z[i];
    }
}

/* Whether samples of a block have met what shines, and what does not. */
struct glow {
    bool bright, dark;
};

static void find_glow(const struct block *b, const struct surface *s, struct glow *glow)
{
    for (int i = 0; i < LANES; i++) {
        const bool shines = s->emission.x[i] + s->emission.y[i] + s->emission.z[i] > 0.0f;
        glow->bright |= b->inside.on[i] && shines;
        glow->dark |= b->inside.on[i] && !shines;
    }
}

/* Sums emission anew over so many samples, at edges of what shines; returns how many. Pixels whose
 * edge only their neighbours show are left to mixed.h. */
static uint32_t sharpen_glow(struct tile_tracer *t, const struct plan *plan,
                             struct counters *counters)
{
    const uint32_t count = mixed_glow_samples(plan);
    memset(&t->emission, 0, sizeof t->emission);
    for (uint32_t k = 0; k < count; k++) {
        primary_trace_sub(&t->queries, plan, &t->block, k, count, &t->camera, &t->beside.surface);
        add_emission(&t->beside.surface, &t->emission);
    }
    counters->value[COUNTER_RAYS_ANTIALIAS] += (uint64_t)lanes_count(&t->block.kept) * count;
    return count;
}

static void store_emission(const struct tile_tracer *t, const struct plan *plan, uint32_t count,
                           struct samples *samples)
{
    float scale = plan->radiance_scale / (float)count;
    block_store_half(&t->block, t->emission.x, scale, samples_u16(samples, PLANE_EMISSION, 0));
    block_store_half(&t->block, t->emission.y, scale, samples_u16(samples, PLANE_EMISSION, 1));
    block_store_half(&t->block, t->emission.z, scale, samples_u16(samples, PLANE_EMISSION, 2));
}

/* Finds a sub-sample's albedo, and that of its glossy lobe. */
static void resolve_sub(struct tile_tracer *t, const struct stages *stages, uint32_t k,
                        struct samples *samples)
{
    struct glossy_lobes lobes;
    if (!stages->glossy) {
        hit_diffuse_albedo(&t->queries, &t->camera, &t->beside.surface);
        return;
    }
    t->beside.active = t->beside.surface.hit;
    path_resolve(&stages->field, &t->camera, &t->beside);
    glossy_lobes_find(&t->beside, &lobes);
    glossy_store_sub(&stages->field, &t->block, k, &lobes, samples);
}

/* Lens samples take the lighting of pixels around what they see, whatever colour these have. */
static void mark_all_lit(struct tile_tracer *t)
{
    t->point.lit = t->bouncing = t->centre.surface.hit;
}

/* Finds what the surfaces at the centres do to light. Lights only need to know how much of it they
 * reflect diffusely. */
static void resolve_centre(struct tile_tracer *t, const struct stages *stages)
{
    if (!stages->vertices) {
        if (stages->albedo) hit_diffuse_albedo(&t->queries, t->seen, &t->centre.surface);
        return;
    }
    t->centre.active = t->centre.surface.hit;
    path_resolve(&stages->field, t->seen, &t->centre);
}

/* Surfaces that light is lent to by their lobes alone: metals. What pixels lend has to be whole, as
 * others around may reflect diffusely. */
static void mark_lobed(struct tile_tracer *t)
{
    struct glossy_lobes lobes;
    glossy_lobes_find(&t->centre, &lobes);
    for (int i = 0; i < LANES; i++) t->bouncing.on[i] |= lobes.on.on[i];
}

/* Of centres whose surface is paths' alone fields want what lights see, which filters ask
 * neighbours for, but no bounce rays. */
static void leave_to_paths(struct tile_tracer *t)
{
    const struct surface *s = &t->centre.surface;
    for (int i = 0; i < LANES; i++) {
        if (!s->hit.on[i] || path_leaves_to_fields(s, i)) continue;
        t->point.lit.on[i] = -1;
        t->bouncing.on[i] = 0;
    }
}

/* Camera rays: geometry, emission, and which lanes reflect light: those whose surface does at the
 * centre or at any sub-sample, because sub-samples take the lighting of the centre. Bounce rays
 * leave those that reflect it diffusely. */
static void trace_camera(struct tile_tracer *t, const struct stages *stages,
                         const struct plan *plan, struct primary_packet *camera,
                         struct samples *samples, struct counters *counters)
{
    const struct block *b = &t->block;
    const bool shines = samples->layout.planes >> PLANE_EMISSION & 1;
    uint32_t pixels = lanes_count(&b->kept);
    for (int i = 0; i < LANES; i++) t->point.lit.on[i] = t->bouncing.on[i] = 0;
    struct surface copy;
    t->seen = &camera->rays;
    hit_resolve(&t->queries, &camera->valid, t->seen, &t->centre.surface);
    t->centre.mirrors.any = false;
    if (stages->field.mirrors) mirrors_follow(&stages->field, NULL, t->seen, &t->centre);
    if (plan->paths.without_diffuse_direct) path_hide_from_fields(&t->centre.surface);
    mark_lit(&t->centre.surface, &t->point.lit);
    resolve_centre(t, stages);
    if (plan->paths.without_diffuse_direct) path_hide_from_fields(&t->centre.surface);
    if (stages->bounces) mark_lit(&t->centre.surface, &t->bouncing);
    geometry_store(&t->queries, b, mirrors_seen(&t->centre, &copy), &t->planes);
    struct glow glow = {false, false};
    if (shines) t->emission = t->centre.surface.emission;
    if (shines) find_glow(b, &t->centre.surface, &glow);
    for (uint32_t k = 0; k < plan->sub_samples; k++) {
        struct surface *sub = &t->beside.surface;
        primary_trace_sub(&t->queries, plan, b, k, plan->sub_samples, &t->camera, sub);
        if (plan->paths.without_diffuse_direct) path_hide_from_fields(sub);
        mark_lit(sub, &t->point.lit);
        resolve_sub(t, stages, k, samples);
        if (plan->paths.without_diffuse_direct) path_hide_from_fields(sub);
        if (stages->bounces) mark_lit(sub, &t->bouncing);
        geometry_store_sub(&t->queries, b, plan->length_unit, &t->centre.surface, sub,
                           &t->planes.sub[k]);
        if (shines) add_emission(sub, &t->emission);
        if (shines) find_glow(b, sub, &glow);
    }
    if (plan->lens_relight == LENS_RELIGHT_DIFFUSE) mark_all_lit(t);
    if (plan->planes & PLANE_BIT(LENS_LOBE)) mark_lobed(t);
    if (plan->paths.without_diffuse_direct) leave_to_paths(t);
    uint32_t emitted = 1 + plan->sub_samples;
    if (glow.bright && glow.dark && plan->sub_samples > 0 && !stages->field.mirrors)
        emitted = sharpen_glow(t, plan, counters);
    if (shines) store_emission(t, plan, emitted, samples);
    counters->value[COUNTER_RAYS_PRIMARY] += pixels;
    counters->value[COUNTER_RAYS_ANTIALIAS] += (uint64_t)pixels * plan->sub_samples;
}

/* Counts the strata of all lights whose field is read. */
static uint64_t light_rays(const struct plan *plan)
{
    uint64_t rays = 0;
    for (uint32_t k = 0; k < plan->light_count; k++)
        if (plan_light_planes(plan, k))
            rays += (uint64_t)plan->lights[k].strata_per_axis * plan->lights[k].strata_per_axis;
    return rays;
}

/* Leaves only lanes with a surface in *lit; counts the tile's own that it does not light, `rays`
 * each. */
static void choose(const struct tile_tracer *t, uint64_t rays, struct lanes_mask *lit,
                   struct counters *counters)
{
    uint64_t black = 0;
    for (int i = 0; i < LANES; i++) {
        int32_t surface = t->block.inside.on[i] & t->centre.surface.hit.on[i];
        black += (uint64_t)(t->block.kept.on[i] & surface & ~lit->on[i] & 1);
        lit->on[i] &= surface;
    }
    counters->value[COUNTER_SKIPPED_BLACK_ALBEDO] += black * rays;
}

static void count_background(const struct tile_tracer *t, struct counters *counters)
{
    const struct block *b = &t->block;
    counters->value[COUNTER_SKIPPED_BACKGROUND] +=
        lanes_count(&b->kept) - lanes_count_both(&b->kept, &t->centre.surface.hit);
}

/* Traces the lights' fields. */
static void trace_lights(struct tile_tracer *t, const struct plan *plan, struct samples *samples,
                         struct counters *counters)
{
    struct shading_point *p = &t->point;
    choose(t, light_rays(plan), &p->lit, counters);
    for (int i = 0; i < LANES; i++) p->counted.on[i] = p->lit.on[i] & t->block.kept.on[i];
    p->lit_count = lanes_count(&p->lit);
    for (uint32_t k = 0; k < plan->light_count; k++) {
        if (!plan_light_planes(plan, k)) continue;
        if (p->lit_count > 0)
            shadow_trace(&t->queries, &t->lights.lights[k], k, p, &t->shadow, samples, counters);
        else
            shadow_store_unlit(k, p, samples);
    }
}

/* The field of indirect light. How open the surroundings are does not depend on a surface's colour:
 * where that is asked for, rays leave black ones too, but bring these no light, so that the picture
 * stays as it is. */
static void trace_bounces(struct tile_tracer *t, const struct stages *stages,
                          const struct plan *plan, struct samples *samples,
                          struct counters *counters)
{
    const uint64_t l = stages->field.strata;
    const bool looks = plan->planes >> PLANE_AMBIENT_VISIBILITY & 1;
    const bool lights = plan->planes & PLANES_BOUNCE_LIGHT;
    struct bounce_lanes lanes = {.lit = t->bouncing};
    if (looks && !lights) lanes.lit = t->centre.surface.hit;
    for (int i = 0; i < LANES && looks && lights; i++)
        lanes.looking.on[i] = t->centre.surface.hit.on[i] & t->block.kept.on[i] & ~lanes.lit.on[i];
    choose(t, looks ? 0 : l * l, &lanes.lit, counters);
    if (lanes_count(&lanes.lit) + lanes_count(&lanes.looking) > 0)
        indirect_trace(&stages->field, &t->block, &t->centre, &lanes,
                       plan->field_halved ? &t->half : NULL, &t->indirect, &t->path, samples);
}

/* Traces the field of glossy lobes, for the lanes in *lobed. */
static void trace_glossy(struct tile_tracer *t, const struct stages *stages,
                         const struct lanes_mask *lobed, struct half_field *half,
                         struct samples *samples)
{
    glossy_lobes_find(&t->centre, &t->glossy.lobes);
    for (int i = 0; i < LANES; i++) t->glossy.lobes.on.on[i] &= lobed->on[i];
    if (lanes_count(&t->glossy.lobes.on) > 0)
        glossy_trace(&stages->field, &t->block, &t->centre, half, &t->glossy, &t->path, samples);
}

/* Finds which of the kept lanes have strata in the pass's map; the map may be NULL. */
static void find_asked(const struct block *b, const uint8_t *strata_map, struct lanes_mask *asked)
{
    for (int i = 0; i < LANES; i++)
        asked->on[i] = strata_map && b->kept.on[i] && strata_map[b->element[i]] > 0 ? -1 : 0;
}

/* A second set of bounce rays, from pixels that reflect something, and of rays of glossy lobes:
 * only such have any. */
static void trace_second_set(struct tile_tracer *t, const struct stages *stages,
                             const struct plan *plan, struct samples *samples,
                             struct counters *counters)
{
    const struct block *b = &t->block;
    struct lanes_mask asked, lobed, either;
    find_asked(b, stages->pass.strata_map, &asked);
    find_asked(b, stages->pass.lobes, &lobed);
    for (int i = 0; i < LANES; i++) either.on[i] = asked.on[i] | lobed.on[i];
    const uint32_t pixels = lanes_count(&either);
    counters->value[COUNTER_SKIPPED_ENOUGH] += lanes_count(&b->kept) - pixels;
    if (pixels == 0) return;
    t->seen = &t->camera;
    primary_trace(&t->queries, plan, b, t->seen, &t->centre.surface);
    resolve_centre(t, stages);
    counters->value[COUNTER_RAYS_PRIMARY] += lanes_count(&b->kept);
    struct bounce_lanes lanes = {.lit = asked};
    for (int i = 0; i < LANES; i++) lanes.lit.on[i] &= t->centre.surface.hit.on[i];
    if (lanes_count(&lanes.lit) > 0)
        indirect_trace(&stages->field, b, &t->centre, &lanes, NULL, &t->indirect, &t->path,
                       samples);
    if (lanes_count(&lobed) > 0) trace_glossy(t, stages, &lobed, NULL, samples);
}

/* Traces what is seen through pixel centres: surfaces and their light fields. */
static void trace_centres(struct tile_tracer *t, const struct stages *stages,
                          const struct plan *plan, struct primary_packet *camera,
                          struct samples *samples, struct counters *counters)
{
    trace_camera(t, stages, plan, camera, samples, counters);
    count_background(t, counters);
    t->point.plan = plan;
    t->point.block = &t->block;
    t->point.surface = &t->centre.surface;
    t->point.vertex = NULL;
    if (plan->paths.without_diffuse_direct)
        shading_point_see(stages->paths.kernels, &t->centre, &t->point);
    if (stages->lights) trace_lights(t, plan, samples, counters);
    if (plan->field_halved)
        half_field_ring_see(&t->queries, plan, &t->block, &t->camera, &t->half.ring, counters);
    if (stages->bounces) trace_bounces(t, stages, plan, samples, counters);
    if (!stages->glossy) return;
    if (plan->field_halved)
        trace_glossy(t, stages, &t->block.inside, &t->half, samples);
    else
        trace_glossy(t, stages, &t->block.kept, NULL, samples);
}

bool tile_sees_centres(const struct stages *stages)
{
    return stages->centres && !stages->more && !stages->pass.strata_map;
}

void tile_trace_block(struct tile_tracer *t, const struct stages *stages, const struct plan *plan,
                      struct primary_packet *camera, struct samples *samples,
                      struct counters *counters)
{
    if (stages->more)
        lens_second_set_trace(&stages->whole, &t->block, stages->pass.strata_map, &t->more,
                              &t->path, samples);
    else if (stages->pass.strata_map)
        trace_second_set(t, stages, plan, samples, counters);
    else if (tile_sees_centres(stages))
        trace_centres(t, stages, plan, camera, samples, counters);
    if (stages->lens)
        lens_trace(&stages->through_lens, &t->block, &t->lens, &t->path, &t->sums, samples);
}
