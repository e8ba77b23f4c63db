/* What sessions ask of the fleet: session_host's functions. */
#include <stdlib.h>
#include <string.h>

#include "proto/runtime/build.h"
#include "server/fleet/admission.h"
#include "server/fleet/fleet_work.h"

static bool greet(void *ctx, struct session *s, struct message_welcome *welcome,
                  struct message_refused *refused)
{
    struct fleet *fleet = ctx;
    const struct admission rules = {.build_id = build_id(),
                                    .isa = build_isa(),
                                    .embree_version = fleet->embree_version,
                                    .workers = fleet_count(fleet)};
    if (!admission_check(&rules, &s->hello, refused)) return false;
    if (!fleet->embree_version[0])
        memcpy(fleet->embree_version, s->hello.embree_version, sizeof fleet->embree_version);
    *welcome = (struct message_welcome){.worker_id = s->id, .beat_ms = fleet->beat_ms};
    const struct worker_health_record *record =
        worker_health_quarantine(&fleet->health, s->hello.name, s->local, uv_now(fleet->loop));
    fleet_note_joined(fleet, s);
    if (record) s->quarantined_until_ms = record->until_ms;
    return true;
}

static void note_refused(void *ctx, const struct session *s, const struct message_refused *refused)
{
    const struct fleet *fleet = ctx;
    const struct log_field fields[] = {{"worker", s->hello.name, 0}, {"detail", refused->text, 0}};
    log_write(fleet->log, LOG_WARNING, "worker refused", NULL, fields, 2);
}

static void wake(void *ctx)
{
    fleet_wake(ctx);
}

static void tile_returned(void *ctx, struct session *s, const struct fleet_tile *tile,
                          enum fleet_return why)
{
    struct fleet *fleet = ctx;
    fleet->totals.returned++;
    lease_past_add(&fleet->past, tile->frame_id, tile->index, tile->generation);
    if (fleet->closing) return;
    fleet->client.returned(fleet->client.ctx, s->id, tile, why);
    fleet_wake(fleet);
}

static void tile_faulted(void *ctx, struct session *s, const struct message_tile_fault *fault)
{
    struct fleet *fleet = ctx;
    lease_past_add(&fleet->past, fault->frame_id, fault->index, fault->generation);
    if (fleet->closing) return;
    fleet->client.faulted(fleet->client.ctx, s->id, fault);
    fleet_wake(fleet);
}

static bool blob_path(void *ctx, const struct digest *digest, char *out, size_t capacity)
{
    struct fleet *fleet = ctx;
    return !fleet->closing && fleet->client.blob_path(fleet->client.ctx, digest, out, capacity);
}

/* What a result belongs to: nothing that is known; the past, which the client judges (the tile in
 * another generation, or a lease of any worker that ended lately); or a lease of this session. */
enum result_of { RESULT_OF_NOTHING, RESULT_OF_THE_PAST, RESULT_OF_A_LEASE };

/* Ends the session's lease. `tile` becomes the tile that it was of. */
static enum result_of end_lease(struct fleet *fleet, struct session *s,
                                const struct message_result *r, struct fleet_tile *tile)
{
    uint32_t at = lease_find(&s->leases, r->frame_id, r->index, r->generation);
    if (at == LEASE_NONE)
        return lease_has_tile(&s->leases, r->frame_id, r->index) ||
                       lease_past_has(&fleet->past, r->frame_id, r->index, r->generation)
                   ? RESULT_OF_THE_PAST
                   : RESULT_OF_NOTHING;
    *tile = s->leases.at[at].tile;
    lease_answer(&s->leases, at, uv_now(fleet->loop));
    lease_past_add(&fleet->past, r->frame_id, r->index, r->generation);
    return RESULT_OF_A_LEASE;
}

static uint32_t offer_result(struct fleet *fleet, struct session *s, uint64_t request_id,
                             const struct message_result *r, int *error)
{
    uint8_t *bytes = malloc(r->samples_bytes ? r->samples_bytes : 1);
    *error = bytes ? session_add_unacked(s, request_id, r) : ERR_MEMORY;
    if (*error) {
        free(bytes);
        return 0;
    }
    memcpy(bytes, r->samples, r->samples_bytes);
    struct message_result owned = *r;
    owned.samples = bytes;
    uint8_t *given = bytes;
    uint32_t verdict =
        fleet->client.result(fleet->client.ctx, s->id, &owned, &given, r->samples_bytes);
    if (verdict != 0) free(bytes);
    return verdict;
}

static int take_result(void *ctx, struct session *s, uint64_t request_id,
                       const struct message_result *r)
{
    struct fleet *fleet = ctx;
    struct message_ack ack = {.frame_id = r->frame_id,
                              .index = r->index,
                              .generation = r->generation,
                              .verdict = VERDICT_FOREIGN};
    struct fleet_tile tile;
    int error = 0;
    if (fleet->closing) return 0;
    fleet->totals.results++;
    fleet_wake(fleet);
    const enum result_of of = end_lease(fleet, s, r, &tile);
    if (of != RESULT_OF_NOTHING) ack.verdict = offer_result(fleet, s, request_id, r, &error);
    if (ack.verdict != 0 && error == 0) session_ack(s, &ack, request_id);
    /* The session ends with that, but the lease is no longer among those that it gives back. */
    if (error && of == RESULT_OF_A_LEASE) tile_returned(fleet, s, &tile, FLEET_GIVEN_BACK);
    return error;
}

struct session_host fleet_host(struct fleet *fleet, void (*closed)(void *ctx, struct session *s))
{
    return (struct session_host){.ctx = fleet,
                                 .greet = greet,
                                 .refused = note_refused,
                                 .result = take_result,
                                 .returned = tile_returned,
                                 .gone = fleet_note_gone,
                                 .silent = fleet_note_silent,
                                 .struck = fleet_struck,
                                 .faulted = tile_faulted,
                                 .blob_path = blob_path,
                                 .unacked_bytes = &fleet->unacked_bytes,
                                 .wake = wake,
                                 .closed = closed};
}
