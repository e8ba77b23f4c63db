#include "worker/trace/field/indirect.h"

#include <math.h>
#include <string.h>

#include "proto/half.h"
#include "proto/pattern_path.h"
#include "proto/v_plane.h"
#include "worker/shade/lambert.h"
#include "worker/trace/hit/block_store.h"
#include "worker/trace/path/diffuse_weight.h"
#include "worker/trace/path/path_kernels.h"

/* What one block's rays share. */
struct bounce {
    struct bounce_lanes lanes;
    struct lanes_mask counted; /* of the lanes to trace, the tile's own */
    struct lanes3 tangent, bitangent;
    const struct path_context *context;
    const struct block *block;
    const struct path_vertex *from;
    float reach; /* of the first rays */
    uint32_t key[LANES];
    uint32_t rays[LANES];          /* of each lane to trace */
    uint32_t most;                 /* of these */
    const struct field_pack *pack; /* of the lanes, which are its slots; or NULL */
    bool sheared;                  /* strata of the v-plane, not of the disc */
    bool light;                    /* rays go on as paths; else they only look how far they come */
    struct layers layers;          /* of the block, where it has surfaces with a bsdf */
};

void indirect_tangents(const struct plan_camera *camera, const struct lanes3 *normal,
                       struct lanes3 *tangent, struct lanes3 *bitangent)
{
    const float *right = camera->right, *up = camera->up, *forward = camera->forward;
    for (int i = 0; i < LANES; i++) {
        float nx = normal->x[i], ny = normal->y[i], nz = normal->z[i];
        float x = nx * right[0] + ny * right[1] + nz * right[2];
        float y = nx * up[0] + ny * up[1] + nz * up[2];
        float z = -(nx * forward[0] + ny * forward[1] + nz * forward[2]);
        float t[3], s[3];
        v_plane_tangents(x, y, z, t, s);
        tangent->x[i] = t[0] * right[0] + t[1] * up[0] - t[2] * forward[0];
        tangent->y[i] = t[0] * right[1] + t[1] * up[1] - t[2] * forward[1];
        tangent->z[i] = t[0] * right[2] + t[1] * up[2] - t[2] * forward[2];
        bitangent->x[i] = s[0] * right[0] + s[1] * up[0] - s[2] * forward[0];
        bitangent->y[i] = s[0] * right[1] + s[1] * up[1] - s[2] * forward[1];
        bitangent->z[i] = s[0] * right[2] + s[1] * up[2] - s[2] * forward[2];
    }
}

/* Directions of the samples of a row around +z. */
static void sample_directions(const struct bounce *b, const struct indirect_scratch *s,
                              uint32_t row, struct lanes3 *local)
{
    _Alignas(LANES_ALIGN) float u[LANES], v[LANES];
    const uint32_t l = s->strata.l, i = row;
    if (b->pack) {
        for (int k = 0; k < LANES; k++) {
            const uint32_t sample = field_pack_sample(b->pack, row, k);
            u[k] = s->strata.column[sample % l][k];
            v[k] = s->strata.row[sample / l % l][k];
        }
        lambert_sample(u, v, local);
        return;
    }
    if (l == 0) {
        strata_at(&s->strata, i, u, v);
        lambert_sample(u, v, local);
        return;
    }
    if (!b->sheared) {
        lambert_sample(strata_u(&s->strata, i), strata_v(&s->strata, i), local);
        return;
    }
    const uint32_t column = i % l, line = i / l;
    for (int k = 0; k < LANES; k++) {
        float d[3];
        v_plane_direction(s->side[column][k], s->height[column][k], s->sine[line][k],
                          s->cosine[line][k], d);
        local->x[k] = d[0];
        local->y[k] = d[1];
        local->z[k] = d[2];
    }
}

/* Turns directions from the shading frame to the world. Lanes whose direction lies below the facet
 * leave *valid. */
static void turn_directions(const struct bounce *b, const struct lanes3 *local,
                            struct lanes_mask *valid, struct lanes3 *out)
{
    const struct lanes3 *t = &b->tangent, *s = &b->bitangent, *n = &b->from->surface.normal;
    const struct lanes3 *facet = &b->from->surface.facet;
    for (int i = 0; i < LANES; i++) {
        out->x[i] = local->x[i] * t->x[i] + local->y[i] * s->x[i] + local->z[i] * n->x[i];
        out->y[i] = local->x[i] * t->y[i] + local->y[i] * s->y[i] + local->z[i] * n->y[i];
        out->z[i] = local->x[i] * t->z[i] + local->y[i] * s->z[i] + local->z[i] * n->z[i];
        valid->on[i] &=
            -(out->x[i] * facet->x[i] + out->y[i] * facet->y[i] + out->z[i] * facet->z[i] > 0.0f);
    }
}

/* Makes a packet of all lanes of the block, as of Lambert surfaces, as path_pool_begin does. */
static void begin_block(const struct bounce *b, uint32_t row, uint32_t slot,
                        const struct lanes3 *direction, struct path_packet *p)
{
    const struct surface *s = &b->from->surface;
    struct RTCRay16 *r = &p->rays.ray;
    for (int i = 0; i < LANES; i++) {
        const struct vector start =
            surface_start(s, i, direction->x[i], direction->y[i], direction->z[i]);
        r->org_x[i] = start.x;
        r->org_y[i] = start.y;
        r->org_z[i] = start.z;
    }
    memcpy(r->dir_x, direction->x, sizeof r->dir_x);
    memcpy(r->dir_y, direction->y, sizeof r->dir_y);
    memcpy(r->dir_z, direction->z, sizeof r->dir_z);
    memset(r->tnear, 0, sizeof r->tnear);
    memset(p->pdf, 0, sizeof p->pdf);
    memcpy(p->key, b->key, sizeof p->key);
    for (uint32_t i = 0; i < LANES; i++) {
        r->tfar[i] = b->reach;
        p->throughput.x[i] = p->throughput.y[i] = p->throughput.z[i] = 1.0f;
        p->sample[i] = field_pack_sample(b->pack, row, (int)i);
        p->slot[i] = slot + i;
        p->promise[i] = 1.0f;
        p->colored[i] = p->from_object[i] = 0;
        p->part[i] = PATH_PART_NONE;
    }
    p->count = LANES;
}

/* Begins the first rays of a row of samples, in slots from `slot` on. */
static void begin_row(const struct bounce *b, const struct indirect_scratch *s, uint32_t row,
                      uint32_t slot, struct path_pool *pool)
{
    struct lanes_mask asked = b->counted, valid;
    struct lanes3 local, direction;
    _Alignas(LANES_ALIGN) float weight[LANES];
    for (int i = 0; i < LANES; i++)
        asked.on[i] &= -(field_pack_sample(b->pack, row, i) < b->rays[i]);
    valid = asked;
    sample_directions(b, s, row, &local);
    turn_directions(b, &local, &valid, &direction);
    b->context->counters->value[COUNTER_SKIPPED_BOUNCE_BELOW_HORIZON] +=
        lanes_count(&asked) - lanes_count(&valid);
    if (!b->from->any_general && pool->count % LANES == 0 && lanes_count(&valid) == LANES) {
        begin_block(b, row, slot, &direction, &pool->packets[pool->count / LANES]);
        pool->count += LANES;
        return;
    }
    diffuse_weigh(b->context->kernels, b->from, &b->layers, &direction, &valid, weight);
    for (int i = 0; i < LANES; i++) {
        if (!valid.on[i]) continue;
        path_pool_begin(pool,
                        &(struct path_start){.surface = &b->from->surface,
                                             .direction = &direction,
                                             .weight = {weight[i], weight[i], weight[i]},
                                             .reach = b->reach,
                                             .key = b->key[i],
                                             .sample = field_pack_sample(b->pack, row, i),
                                             .slot = slot + (uint32_t)i},
                        i);
    }
}

/* Rays that only look whether anything is near. */
static void look_around(const struct bounce *b, struct path_pool *pool, struct path_radiance *h)
{
    const struct path_context *c = b->context;
    for (uint32_t k = 0; k < path_pool_packets(pool); k++) {
        struct path_packet *p = &pool->packets[k];
        struct lanes_mask valid;
        path_packet_lanes(p, &valid);
        if (c->blended) c->kernels->ray_keys(p, PATH_FIELD_DEPTH, PATH_RAY_OCCLUSION, &p->rays.ray);
        queries_sanitise(c->queries, &valid, &p->rays.ray);
        c->counters->value[COUNTER_RAYS_OCCLUSION] += lanes_count(&valid);
        queries_closest(c->queries, QUERY_BOUNCE, &valid, &p->rays);
        path_note_reach(p, &valid, h);
    }
}

/* Samples that are not finite count as black. Nothing is negative. */
static void reject(struct lanes3 *radiance, struct counters *counters)
{
    uint32_t rejected = 0;
    float *r = radiance->x, *g = radiance->y, *b = radiance->z;
    for (int i = 0; i < LANES; i++) {
        int finite = (r[i] < INFINITY) & (g[i] < INFINITY) & (b[i] < INFINITY);
        rejected += !finite;
        r[i] = finite ? r[i] : 0.0f;
        g[i] = finite ? g[i] : 0.0f;
        b[i] = finite ? b[i] : 0.0f;
    }
    counters->value[COUNTER_REJECTED_NOT_FINITE] += rejected;
}

/* Returns the half of a sample. Halves alternate over the strata like the fields of a chessboard,
 * so that both see light from all directions. Pixels with different strata have no halves. */
static uint32_t field_of(uint32_t l, uint32_t sample)
{
    return l > 0 ? sample % l + sample / l : sample;
}

static void store_sample(const struct bounce *b, const struct field_sample *from, uint32_t sample,
                         struct samples *samples)
{
    _Alignas(LANES_ALIGN) float distance[LANES];
    const struct plan *plan = b->context->plan;
    const float *planes[3] = {from->radiance.x, from->radiance.y, from->radiance.z};
    for (uint32_t c = 0; c < 3; c++)
        block_store_half(b->block, planes[c], plan->radiance_scale,
                         samples_u16(samples, PLANE_INDIRECT_STRATA, 4 * sample + c));
    for (int i = 0; i < LANES; i++)
        distance[i] = from->distance[i] < INFINITY ? from->distance[i] : 0.0f;
    block_store_positive_half(b->block, distance, 1.0f / plan->length_unit,
                              samples_u16(samples, PLANE_INDIRECT_STRATA, 4 * sample + 3));
}

static void strata_of_plane(struct indirect_scratch *s)
{
    for (uint32_t k = 0; k < s->strata.l; k++) {
        for (int i = 0; i < LANES; i++)
            v_plane_column(s->strata.column[k][i], &s->side[k][i], &s->height[k][i]);
        v_plane_rows(s->strata.row[k], LANES, s->sine[k], s->cosine[k]);
    }
}

/* Sets the strata, and how many rays leave each lane. */
static void deal_rays(struct bounce *b, const struct pattern *pattern, struct strata *strata)
{
    const struct path_context *c = b->context;
    uint32_t l[LANES];
    b->most = 0;
    for (int i = 0; i < LANES; i++) {
        l[i] = c->strata;
        if (c->strata_map) l[i] = b->block->kept.on[i] ? c->strata_map[b->block->element[i]] : 0;
        b->rays[i] = l[i] * l[i];
        if (b->counted.on[i] && b->rays[i] > b->most) b->most = b->rays[i];
    }
    if (c->strata_map)
        strata_init_per_pixel(strata, pattern, b->block, PATTERN_INDIRECT, l);
    else
        strata_init(strata, c->light_kernels, pattern, NULL, b->block, PATTERN_INDIRECT, c->strata);
}

static void bounce_init(const struct path_context *c, const struct block *block,
                        const struct path_vertex *from, const struct bounce_lanes *lanes,
                        struct indirect_scratch *s, struct bounce *b)
{
    const struct plan *plan = c->plan;
    const struct pattern pattern = path_pass_pattern(c);
    b->context = c;
    b->block = block;
    b->from = from;
    b->lanes = *lanes;
    b->pack = NULL;
    for (int i = 0; i < LANES; i++) {
        b->counted.on[i] = lanes->lit.on[i] & block->kept.on[i];
        b->key[i] =
            path_field_key(path_key(pattern.seed, pattern.frame, block->x_px[i], block->y_px[i]));
    }
    if (from->any_general) layers_see(c->kernels, from, &b->layers);
    b->light = (plan->planes & PLANES_BOUNCE_LIGHT) != 0;
    b->reach = b->light || !(plan->occlusion_distance > 0.0f) ? INFINITY : plan->occlusion_distance;
    indirect_tangents(&plan->camera, &from->surface.normal, &b->tangent, &b->bitangent);
    deal_rays(b, &pattern, &s->strata);
    b->sheared = plan->indirect_filter == INDIRECT_FILTER_SHEARED &&
                 c->strata <= LIMIT_PLANE_STRATA_PER_AXIS;
    if (b->sheared) strata_of_plane(s);
    indirect_sums_clear(&s->sums);
}

/* Adds what sample `part` of a row has brought, whose slots begin at `first`. */
static void add_sample(const struct bounce *b, const struct path_radiance *h, uint32_t row,
                       uint32_t first, uint32_t part, struct indirect_scratch *s,
                       struct samples *samples)
{
    const struct plan *plan = b->context->plan;
    const uint32_t sample = row * field_pack_replicas(b->pack) + part;
    struct field_sample brought;
    field_pack_take(b->pack, h, first, part, &brought);
    reject(&brought.radiance, b->context->counters);
    indirect_sums_add(&brought, plan->occlusion_distance, field_of(s->strata.l, sample), &s->sums);
    if (b->light && (plan->planes >> PLANE_INDIRECT_STRATA & 1))
        store_sample(b, &brought, sample, samples);
}

/* Rows first .. first + count - 1. */
static void trace_batch(const struct bounce *b, uint32_t first, uint32_t count,
                        struct indirect_scratch *s, struct path_scratch *paths,
                        struct samples *samples)
{
    struct path_radiance *h = &paths->radiance;
    struct path_pool *pool = &paths->pools[0];
    pool->count = 0;
    path_radiance_clear_field(h, count);
    if (b->context->mirrors) path_radiance_mirrors(h, count, b->from);
    for (uint32_t k = 0; k < count; k++) begin_row(b, s, first + k, k * LANES, pool);
    if (b->light)
        path_trace_field(b->context, paths);
    else
        look_around(b, pool, h);
    for (uint32_t k = 0; k < count; k++)
        for (uint32_t part = 0; part < field_pack_replicas(b->pack); part++)
            add_sample(b, h, first + k, k * LANES, part, s, samples);
}

/* Traces all samples of the counted lanes; false if the tile was stopped. */
static bool trace_counted(const struct bounce *b, struct indirect_scratch *s,
                          struct path_scratch *paths, struct samples *samples)
{
    const uint32_t rows = field_pack_rows(b->pack, b->most);
    for (uint32_t done = 0; done < rows;) {
        uint32_t left = rows - done, n = left < PATH_SAMPLES ? left : PATH_SAMPLES;
        if (done > 0 && !path_goes_on(b->context)) return false;
        trace_batch(b, done, n, s, paths, samples);
        done += n;
    }
    return true;
}

/* Jitters run as a lattice over nodes as they do over pixels at full resolution. */
static void deal_half(const struct bounce *b, struct strata *strata)
{
    const struct path_context *c = b->context;
    const struct pattern pattern = path_pass_pattern(c);
    struct block nodes = *b->block;
    for (int i = 0; i < LANES; i++) {
        if (!half_field_is_node(nodes.x_px[i], nodes.y_px[i])) continue;
        nodes.x_px[i] >>= 1;
        nodes.y_px[i] >>= 1;
    }
    strata_init(strata, c->light_kernels, &pattern, NULL, &nodes, PATTERN_INDIRECT, c->strata);
}

/* Traces some lanes of a block side by side, as few as they may be. */
static bool trace_packed(const struct bounce *b, const struct lanes_mask *lanes,
                         struct indirect_scratch *s, struct path_scratch *paths,
                         struct samples *samples)
{
    const struct path_context *c = b->context;
    struct bounce packed = {.context = c, .reach = b->reach, .light = b->light};
    if (lanes_count(lanes) == 0) return true;
    field_pack_init(b->block, b->from, lanes, &s->pack);
    packed.pack = &s->pack;
    packed.block = &s->pack.block;
    packed.from = &s->pack.vertex;
    packed.counted = s->pack.on;
    packed.most = c->strata * c->strata;
    for (int i = 0; i < LANES; i++) {
        packed.rays[i] = packed.most;
        packed.key[i] = b->key[s->pack.lane[i]];
    }
    if (packed.from->any_general) layers_see(c->kernels, packed.from, &packed.layers);
    indirect_tangents(&c->plan->camera, &packed.from->surface.normal, &packed.tangent,
                      &packed.bitangent);
    deal_half(&packed, &s->strata);
    return trace_counted(&packed, s, paths, samples);
}

/* Traces the lanes that nodes do not stand for. All others are left as if nothing was there. */
static bool trace_half(struct bounce *b, struct half_field *half, struct indirect_scratch *s,
                       struct path_scratch *paths, struct samples *samples)
{
    const struct path_context *c = b->context;
    struct lanes_mask more;
    half_field_init(b->block, &b->from->surface, &b->lanes.lit, half);
    if (!trace_packed(b, &half->traced, s, paths, samples)) return false;
    half_field_refine(s->sums.nearest, c->strata, half, &more, c->counters);
    b->lanes.lit = half->traced;
    return trace_packed(b, &more, s, paths, samples);
}

/* Traces the lanes that only look around, nodes or not. */
static bool look(const struct bounce *b, bool halved, struct indirect_scratch *s,
                 struct path_scratch *paths, struct samples *samples)
{
    struct bounce looking = *b;
    looking.counted = b->lanes.looking;
    looking.light = false;
    looking.most = b->context->strata * b->context->strata;
    if (halved) return trace_packed(&looking, &looking.counted, s, paths, samples);
    return lanes_count(&looking.counted) == 0 || trace_counted(&looking, s, paths, samples);
}

void indirect_trace(const struct path_context *c, const struct block *block,
                    const struct path_vertex *from, const struct bounce_lanes *lanes,
                    struct half_field *half, struct indirect_scratch *s, struct path_scratch *paths,
                    struct samples *samples)
{
    struct bounce b;
    bounce_init(c, block, from, lanes, s, &b);
    const bool done =
        half ? trace_half(&b, half, s, paths, samples) : trace_counted(&b, s, paths, samples);
    if (done && look(&b, half != NULL, s, paths, samples))
        indirect_sums_store(c->plan, block, &b.lanes, b.rays, &s->sums, samples);
}
