#include <stdlib.h>
#include <string.h>

#include "proto/count_map.h"
#include "worker/session/leases_work.h"

/* Logs a job's first frame here, and not each view of a live one. */
static void note_job(struct leases *leases, const struct leased_frame *f)
{
    const struct log_field fields[] = {{"job", f->job, 0}, {"frame_id", NULL, (double)f->id}};
    for (const struct leased_frame *other = leases->frames; other; other = other->next)
        if (strcmp(other->job, f->job) == 0) return;
    worker_log_write_traced(leases->client.worker_log, LOG_INFO, "work for a job", &f->trace,
                            fields, 2);
}

int leases_add_frame(struct leases *leases, const struct message_frame_plan *m)
{
    struct fault fault;
    if (leases_find_frame(leases, m->frame_id)) return 0;
    struct leased_frame *f = calloc(1, sizeof *f);
    if (!f) return ERR_MEMORY;
    int e = plan_decode(m->plan, m->plan_bytes, &f->plan, &fault);
    if (e) {
        free(f);
        return e;
    }
    f->id = m->frame_id;
    memcpy(f->job, m->job, sizeof f->job);
    (void)trace_context_kept(m->trace, &f->trace);
    note_job(leases, f);
    f->next = leases->frames;
    leases->frames = f;
    return 0;
}

/* Returns the pass of a lease. Fields that it leaves out follow the plan's schedule. */
static struct plan_pass pass_of(const struct plan *plan, const struct message_tile *m)
{
    const bool scheduled = m->pass.first == 0 && m->pass.count == 0 && m->pass.strata == 0;
    return scheduled ? plan_scheduled_pass(plan, m->pass.number) : m->pass;
}

static int check_tile(const struct leases *leases, const struct leased_frame *f,
                      const struct message_tile *m, const struct plan_pass *pass)
{
    const struct rect r = m->rect;
    if (!f) return ERR_STATE;
    if (r.x0 < 0 || r.y0 < 0 || r.x1 <= r.x0 || r.y1 <= r.y0 || r.x1 > f->plan.width_px ||
        r.y1 > f->plan.height_px || rect_width(r) > LIMIT_TILE_SIDE_PX ||
        rect_height(r) > LIMIT_TILE_SIDE_PX)
        return ERR_RANGE;
    int e = plan_pass_check(&f->plan, pass);
    if (!e && pass->strata_map) e = plan_strata_map_check(pass, (size_t)rect_area(r));
    if (e) return e;
    return leases->counts.open >= LIMIT_TILES_IN_HAND ? ERR_LIMIT : 0;
}

/* Unpacks the strata maps of a lease's pass, map by map as the plan has them; NULL where it has
 * none. */
static int unpack_strata_maps(const struct plan *plan, const struct message_tile *m, uint8_t **out)
{
    const int32_t width = rect_width(m->rect), height = rect_height(m->rect);
    const uint32_t maps = plan_strata_maps(plan);
    if (m->counts_bytes == 0) return 0;
    if (maps == 0) return ERR_RANGE;
    if (width < 1 || height < 1 || width > LIMIT_TILE_SIDE_PX || height > LIMIT_TILE_SIDE_PX)
        return ERR_RANGE;
    *out = malloc(maps * (size_t)rect_area(m->rect));
    if (!*out) return ERR_MEMORY;
    return count_map_unpack(m->counts, m->counts_bytes, maps, width, height, *out);
}

static int begin_tile(struct leases *leases, struct leased_frame *f, uint64_t request_id,
                      const struct message_tile *m, const struct plan_pass *pass,
                      uint8_t *strata_maps)
{
    const bool held = frame_blobs_take(&f->blobs, leases->cache, &f->plan);
    struct leased_tile *t = held ? calloc(1, sizeof *t) : NULL;
    if (!t) return ERR_MEMORY;
    t->leases = leases;
    t->frame = f;
    t->lease = *m;
    t->lease.pass = *pass;
    t->lease.counts = NULL; /* borrowed from the message */
    t->strata_maps = strata_maps;
    t->request_id = request_id;
    t->state = TILE_WAITING;
    bytes_writer_init(&t->packed);
    leases_append(leases, t);
    f->tiles++;
    f->open++;
    leases->counts.open++;
    leases_go_on(leases, t);
    return 0;
}

int leases_add_tile(struct leases *leases, uint64_t request_id, const struct message_tile *m)
{
    struct leased_frame *f = leases_find_frame(leases, m->frame_id);
    struct plan_pass pass = {0};
    uint8_t *strata_maps = NULL;
    int e = f ? unpack_strata_maps(&f->plan, m, &strata_maps) : ERR_STATE;
    if (!e) pass = pass_of(&f->plan, m);
    pass.strata_map = strata_maps;
    if (!e && strata_maps && plan_strata_maps(&f->plan) > 1)
        pass.lobes = strata_maps + rect_area(m->rect);
    if (!e) e = check_tile(leases, f, m, &pass);
    if (!e) e = begin_tile(leases, f, request_id, m, &pass, strata_maps);
    if (e) free(strata_maps);
    return e;
}
