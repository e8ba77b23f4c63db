#include "server/fleet/fleet_work.h"
#include "server/fleet/speculation.h"

/* How often late tiles are looked for while workers idle. */
#define SPECULATE_EVERY_MS 25u

static size_t gather_offers(struct fleet *fleet)
{
    size_t count = 0;
    for (size_t i = 0; i < fleet->session_count; i++) {
        struct session *s = fleet->sessions[i];
        if (!session_may_work(s)) continue;
        fleet->offered[count] = s;
        fleet->offers[count++] =
            (struct schedule_worker){.threads = s->hello.threads,
                                     .want = s->want,
                                     .in_hand = s->leases.count,
                                     .pace_ms = lease_pace_ms(&s->leases, uv_now(fleet->loop))};
    }
    return count;
}

/* Sends a lease to the worker, or gives it back to the client. Returns false if the worker gets no
 * more this turn. */
static bool send_lease(struct fleet *fleet, struct session *s, const struct fleet_tile *tile)
{
    const struct fleet_client *client = &fleet->client;
    if (!session_knows_frame(s, tile->frame_id)) {
        struct message_frame_plan plan = {0};
        if (!client->plan(client->ctx, tile->frame_id, &plan) || !session_may_work(s)) {
            client->returned(client->ctx, s->id, tile, FLEET_GIVEN_BACK);
            return false;
        }
        if (session_send_plan(s, &plan) != 0) goto fail;
    }
    if (session_send_tile(s, tile, uv_now(fleet->loop)) != 0) goto fail;
    return true;
fail:
    client->returned(client->ctx, s->id, tile, FLEET_GIVEN_BACK);
    session_end(s, SESSION_BROKE);
    return false;
}

/* Whether there was no tile this turn, and for which capabilities: of workers that hold tiles, and
 * of free ones. */
struct dryness {
    bool is_dry;
    uint32_t capabilities;
};

static bool is_vain(const struct dryness dry[2], const struct worker_request *request)
{
    for (unsigned is_free = request->is_free; is_free < 2; is_free++)
        if (dry[is_free].is_dry && (request->capabilities & ~dry[is_free].capabilities) == 0)
            return true;
    return false;
}

/* Hands one tile to one worker. Returns false if it gets no more this turn. */
static bool hand_one(struct fleet *fleet, struct session *s, struct dryness dry[2])
{
    struct fleet_tile tile;
    const struct worker_request request = {
        .worker = s->id, .capabilities = s->hello.capabilities, .is_free = s->leases.count == 0};
    if (fleet->closing || !session_takes_more(s) || is_vain(dry, &request)) return false;
    if (fleet->client.next_tile(fleet->client.ctx, &request, &tile))
        return send_lease(fleet, s, &tile);
    dry[request.is_free] = (struct dryness){true, request.capabilities};
    return false;
}

/* Tiles go round one by one, so that an unknown supply ends evenly, too. The client may call the
 * fleet from inside; sessions stay in memory until the loop has turned. */
static void hand_tiles(struct fleet *fleet, size_t count, uint64_t supply)
{
    schedule_share(fleet->offers, count, supply, fleet->give);
    struct dryness dry[2] = {{0}};
    for (bool any = true; any;) {
        any = false;
        for (size_t i = 0; i < count; i++) {
            if (fleet->give[i] == 0) continue;
            fleet->give[i] = hand_one(fleet, fleet->offered[i], dry) ? fleet->give[i] - 1 : 0;
            any = any || fleet->give[i] > 0;
        }
    }
}

/* ---- copies ---- */

static bool is_idle(const struct session *s)
{
    return session_takes_more(s) && s->leases.count < s->hello.threads;
}

/* Gives one copy to the session at `idle`; false when none pays now. */
static bool hand_copy(struct fleet *fleet, size_t idle)
{
    const struct fleet_client *client = &fleet->client;
    struct session *s = fleet->sessions[idle];
    struct speculation late;
    struct fleet_tile tile;
    while (
        speculation_find(fleet->tables, fleet->session_count, idle, uv_now(fleet->loop), &late)) {
        struct lease *lease = &fleet->sessions[late.holder]->leases.at[late.at];
        lease->copied = true;
        if (client->copy_tile(client->ctx, s->id, s->hello.capabilities, &lease->tile, &tile))
            return send_lease(fleet, s, &tile);
    }
    return false;
}

static void on_late(uv_timer_t *timer)
{
    fleet_wake(timer->data);
}

/* Sessions that end here are not released before the loop has turned; their tables are empty. */
static void hand_copies(struct fleet *fleet)
{
    for (size_t i = 0; i < fleet->session_count; i++)
        fleet->tables[i] = &fleet->sessions[i]->leases;
    for (size_t i = 0; i < fleet->session_count; i++)
        while (is_idle(fleet->sessions[i]) && hand_copy(fleet, i)) continue;
}

/* Looks again soon while a worker idles beside busy ones. Time alone then changes what is right:
 * others become late, or so slow that the idle worker should get a tile that was left to them. */
static void look_again(struct fleet *fleet)
{
    bool idles = false, works = false;
    for (size_t i = 0; i < fleet->session_count; i++) {
        works = works || fleet->sessions[i]->leases.count > 0;
        idles = idles || is_idle(fleet->sessions[i]);
    }
    if (idles && works) uv_timer_start(&fleet->speculation, on_late, SPECULATE_EVERY_MS, 0);
}

void fleet_dispatch(struct fleet *fleet)
{
    const size_t count = gather_offers(fleet);
    if (count == 0) return;
    const struct fleet_client *client = &fleet->client;
    const uint64_t supply = client->tiles_left ? client->tiles_left(client->ctx) : UINT64_MAX;
    hand_tiles(fleet, count, supply);
    if (!client->copy_tile || !client->tiles_left || fleet->closing) return;
    if (client->tiles_left(client->ctx) == 0) hand_copies(fleet);
    look_again(fleet);
}
