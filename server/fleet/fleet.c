#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#include "proto/runtime/build.h"
#include "server/fleet/fleet_work.h"
#include "server/fleet/roster.h"

#define DEFAULT_BEAT_MS     500u
#define DEFAULT_SILENCE_MS  10000u
#define DEFAULT_STALL_MS    10000u
#define TICK_MAX_MS         250u
#define TICK_MIN_MS         10u
#define GREETING_MAX        256u /* TCP links whose HELLO is awaited */
#define WORKER_ID_LIFE_BITS 24

/* ---- sessions ---- */

/* Returns the index of the session, or session_count. */
static size_t find_index(const struct fleet *fleet, uint64_t id)
{
    size_t low = 0, high = fleet->session_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (fleet->sessions[middle]->id < id)
            low = middle + 1;
        else
            high = middle;
    }
    return low < fleet->session_count && fleet->sessions[low]->id == id ? low
                                                                        : fleet->session_count;
}

struct session *fleet_find_session(const struct fleet *fleet, uint64_t id)
{
    size_t at = find_index(fleet, id);
    return at < fleet->session_count ? fleet->sessions[at] : NULL;
}

static int reserve_session(struct fleet *fleet)
{
    if (fleet->session_count < fleet->session_capacity) return 0;
    size_t capacity = fleet->session_capacity ? 2 * fleet->session_capacity : 16;
    /* NOLINTBEGIN(bugprone-sizeof-expression): arrays of pointers */
    struct session **sessions = realloc(fleet->sessions, capacity * sizeof fleet->sessions[0]);
    if (sessions) fleet->sessions = sessions;
    struct schedule_worker *offers = realloc(fleet->offers, capacity * sizeof *offers);
    if (offers) fleet->offers = offers;
    struct session **offered = realloc(fleet->offered, capacity * sizeof fleet->offered[0]);
    if (offered) fleet->offered = offered;
    uint32_t *give = realloc(fleet->give, capacity * sizeof *give);
    if (give) fleet->give = give;
    const struct lease_table **tables = realloc(fleet->tables, capacity * sizeof *tables);
    if (tables) fleet->tables = tables;
    /* NOLINTEND(bugprone-sizeof-expression) */
    if (!sessions || !offers || !offered || !give || !tables) return ERR_MEMORY;
    fleet->session_capacity = capacity;
    return 0;
}

static void release(struct fleet *fleet)
{
    void (*closed)(void *ctx) = fleet->closed;
    void *ctx = fleet->closed_ctx;
    free(fleet->sessions);
    free(fleet->offers);
    free(fleet->offered);
    free(fleet->give);
    free(fleet->tables);
    free(fleet);
    if (closed) closed(ctx);
}

static void release_one(struct fleet *fleet)
{
    fleet->open--;
    if (fleet->closing && fleet->open == 0) release(fleet);
}

static void session_closed(void *ctx, struct session *s)
{
    struct fleet *fleet = ctx;
    size_t at = find_index(fleet, s->id);
    if (at < fleet->session_count) {
        fleet->session_count--;
        memmove(&fleet->sessions[at], &fleet->sessions[at + 1],
                (fleet->session_count - at) * sizeof(struct session *));
    }
    session_destroy(&s);
    release_one(fleet);
}

/* Makes room for new links. A link is unknown until its HELLO, so of too many the oldest goes. */
static void make_room(struct fleet *fleet)
{
    struct session *oldest = NULL;
    unsigned greeting = 0;
    for (size_t i = 0; i < fleet->session_count; i++) {
        struct session *s = fleet->sessions[i];
        if (s->state != SESSION_GREETING || s->local) continue;
        if (!oldest) oldest = s;
        greeting++;
    }
    if (greeting >= GREETING_MAX) session_drop(oldest);
}

static void on_incoming(void *ctx, struct listener *l)
{
    struct fleet *fleet = ctx;
    struct session *s = NULL;
    make_room(fleet);
    if (reserve_session(fleet) != 0 ||
        session_create(fleet->loop, l->tcp, l->tcp && fleet->keyed ? &fleet->key : NULL,
                       fleet->next_id, &fleet->host, &fleet->totals, &s) != 0) {
        l->waits = true; /* until memory is there */
        return;
    }
    fleet->next_id++;
    fleet->open++;
    fleet->sessions[fleet->session_count++] = s;
    if (uv_accept(&l->handle.stream, &s->handle.stream) < 0) {
        session_drop(s);
        return;
    }
    if (l->tcp) uv_tcp_nodelay(&s->handle.tcp, 1);
    session_start(s);
}

unsigned fleet_count(const struct fleet *fleet)
{
    unsigned count = 0;
    for (size_t i = 0; i < fleet->session_count; i++) count += session_may_work(fleet->sessions[i]);
    return count;
}

struct fleet_load fleet_load(const struct fleet *fleet)
{
    struct fleet_load load = {0};
    for (size_t i = 0; i < fleet->session_count; i++) {
        const struct session *s = fleet->sessions[i];
        load.tiles_leased += s->leases.count;
        if (!session_may_work(s)) continue;
        load.workers++;
        load.threads += s->hello.threads;
    }
    return load;
}

/* ---- the turn of the loop ---- */

static void on_turn(uv_idle_t *turn)
{
    struct fleet *fleet = turn->data;
    uv_idle_stop(turn);
    fleet_dispatch(fleet);
    for (size_t i = 0; i < fleet->session_count; i++) session_turn(fleet->sessions[i]);
}

static void take_waiting(struct fleet *fleet, struct listener *l)
{
    if (!l->waits) return;
    l->waits = false;
    on_incoming(fleet, l);
}

static void on_tick(uv_timer_t *tick)
{
    struct fleet *fleet = tick->data;
    uint64_t now = uv_now(fleet->loop);
    take_waiting(fleet, &fleet->local);
    take_waiting(fleet, &fleet->tcp);
    for (size_t i = 0; i < fleet->session_count; i++)
        session_tick(fleet->sessions[i], now, fleet->silence_ms, fleet->stall_ms);
}

/* ---- the contract ---- */

static uint32_t or_default(uint32_t value, uint32_t otherwise)
{
    return value ? value : otherwise;
}

static uint64_t first_id(void)
{
    uint32_t life = 0;
    if (getrandom(&life, sizeof life, 0) != (ssize_t)sizeof life) life = (uint32_t)uv_hrtime();
    life &= (1u << WORKER_ID_LIFE_BITS) - 1u;
    return ((uint64_t)life << WORKER_ID_LIFE_SHIFT) + 1;
}

static uint64_t tick_ms(const struct fleet *fleet)
{
    uint32_t shortest = fleet->silence_ms < fleet->stall_ms ? fleet->silence_ms : fleet->stall_ms;
    uint64_t ms = shortest / 8;
    if (ms < TICK_MIN_MS) return TICK_MIN_MS;
    return ms < TICK_MAX_MS ? ms : TICK_MAX_MS;
}

static struct fleet *allocate(uv_loop_t *loop, const struct fleet_options *o,
                              const struct fleet_client *client)
{
    struct fleet *fleet = calloc(1, sizeof *fleet);
    if (!fleet) return NULL;
    fleet->loop = loop;
    fleet->client = *client;
    fleet->log = o->log;
    fleet->beat_ms = or_default(o->beat_ms, DEFAULT_BEAT_MS);
    fleet->silence_ms = or_default(o->silence_ms, DEFAULT_SILENCE_MS);
    fleet->stall_ms = or_default(o->stall_ms, DEFAULT_STALL_MS);
    fleet->next_id = first_id();
    fleet->host = fleet_host(fleet, session_closed);
    lease_past_init(&fleet->past);
    uv_idle_init(loop, &fleet->turn);
    uv_timer_init(loop, &fleet->tick);
    uv_timer_init(loop, &fleet->speculation);
    fleet->turn.data = fleet->tick.data = fleet->speculation.data = fleet;
    fleet->open = 3;
    return fleet;
}

static int open_listeners(struct fleet *fleet, const struct fleet_options *o, struct fault *fault)
{
    int e = o->key_path ? link_key_read(o->key_path, &fleet->key, fault) : 0;
    fleet->keyed = e == 0 && o->key_path;
    if (e == 0 && o->socket_path)
        e = listener_open_unix(&fleet->local, fleet->loop, o->socket_path, on_incoming, fleet,
                               fault);
    if (e == 0 && o->listen)
        e = listener_open_tcp(&fleet->tcp, fleet->loop, o->listen, fleet->keyed, on_incoming, fleet,
                              fault);
    fleet->open += (unsigned)fleet->local.is_open + (unsigned)fleet->tcp.is_open;
    return e;
}

static unsigned threads_each(const struct fleet_options *o)
{
    unsigned cores = uv_available_parallelism();
    unsigned threads = o->worker_threads ? o->worker_threads : cores / o->local_workers;
    if (threads == 0) threads = 1;
    return threads < LIMIT_THREADS ? threads : LIMIT_THREADS;
}

static int start_processes(struct fleet *fleet, const struct fleet_options *o, struct fault *fault)
{
    if (o->local_workers == 0) return 0;
    if (!o->socket_path)
        return fault_set(fault, ERR_MISSING, "workers", "local workers need a socket path");
    if (o->local_workers > LIMIT_WORKERS)
        return fault_set(fault, ERR_LIMIT, "workers", "%u local workers, at most %d",
                         o->local_workers, LIMIT_WORKERS);
    struct processes_options options = {.program = o->worker_program,
                                        .socket_path = o->socket_path,
                                        .cache_dir = o->cache_dir,
                                        .blob_dir = o->blob_dir,
                                        .count = o->local_workers,
                                        .threads = threads_each(o),
                                        .log = o->log,
                                        .stopped = fleet_note_stopped,
                                        .ctx = fleet};
    int e =
        processes_create(fleet->loop, &options, &fleet->totals.respawned, &fleet->processes, fault);
    if (e == 0) fleet->open++;
    return e;
}

int fleet_create(uv_loop_t *loop, const struct fleet_options *options,
                 const struct fleet_client *client, struct fleet **out, struct fault *fault)
{
    if (build_isa_check(fault) != 0) return fault->code;
    struct fleet *fleet = allocate(loop, options, client);
    if (!fleet) return fault_set(fault, ERR_MEMORY, "fleet", "%s", error_text(ERR_MEMORY));
    int e = open_listeners(fleet, options, fault);
    if (e) goto fail;
    e = start_processes(fleet, options, fault);
    if (e) goto fail;
    uint64_t ms = tick_ms(fleet);
    uv_timer_start(&fleet->tick, on_tick, ms, ms);
    *out = fleet;
    return 0;
fail:
    fleet_close(fleet, NULL, NULL);
    return e;
}

static void on_handle_closed(uv_handle_t *handle)
{
    release_one(handle->data);
}

static void on_listener_closed(uv_handle_t *handle)
{
    struct listener *l = handle->data;
    release_one(l->ctx);
}

static void on_processes_closed(void *ctx)
{
    release_one(ctx);
}

/* A worker that was told to drain knows that the end of the link is meant. */
static void say_goodbye(struct session *s)
{
    if (s->state == SESSION_WORKING) session_drain(s, true);
    if (s->state != SESSION_CLOSING) outbox_flush(&s->outbox);
    session_drop(s);
}

void fleet_close(struct fleet *fleet, void (*closed)(void *ctx), void *ctx)
{
    fleet->closing = true;
    fleet->closed = closed;
    fleet->closed_ctx = ctx;
    listener_close(&fleet->local, on_listener_closed);
    listener_close(&fleet->tcp, on_listener_closed);
    if (fleet->processes) processes_close(fleet->processes, on_processes_closed, fleet);
    for (size_t i = 0; i < fleet->session_count; i++) say_goodbye(fleet->sessions[i]);
    uv_close((uv_handle_t *)&fleet->turn, on_handle_closed);
    uv_close((uv_handle_t *)&fleet->tick, on_handle_closed);
    uv_close((uv_handle_t *)&fleet->speculation, on_handle_closed);
}

void fleet_wake(struct fleet *fleet)
{
    if (!fleet->closing) uv_idle_start(&fleet->turn, on_turn);
}

void fleet_ack(struct fleet *fleet, uint64_t worker, const struct message_ack *ack)
{
    struct session *s = fleet_find_session(fleet, worker);
    if (s) session_ack(s, ack, 0);
}

void fleet_cancel(struct fleet *fleet, uint64_t frame_id)
{
    lease_past_forget_frame(&fleet->past, frame_id);
    for (size_t i = 0; i < fleet->session_count; i++) session_cancel(fleet->sessions[i], frame_id);
}

int fleet_drain(struct fleet *fleet, uint64_t worker, bool drain)
{
    struct session *s = fleet_find_session(fleet, worker);
    if (!s || (s->state != SESSION_WORKING && s->state != SESSION_DRAINING)) return ERR_NOT_FOUND;
    s->quarantined_until_ms = 0; /* from now on it is the operator's word */
    if (!drain) worker_health_forgive(&fleet->health, s->hello.name, s->local);
    session_drain(s, drain);
    return 0;
}

const char *fleet_embree(const struct fleet *fleet)
{
    return fleet->embree_version;
}

const char *fleet_worker_name(const struct fleet *fleet, uint64_t worker)
{
    const struct session *s = fleet_find_session(fleet, worker);
    return s ? s->hello.name : NULL;
}

static bool is_listed(const struct session *s)
{
    return s->state == SESSION_WORKING || s->state == SESSION_DRAINING;
}

bool fleet_worker_is_here(const struct fleet *fleet, uint64_t worker)
{
    const struct session *s = fleet_find_session(fleet, worker);
    return s && is_listed(s);
}

unsigned fleet_work(const struct fleet *fleet, uint64_t worker, struct fleet_work *out,
                    unsigned most)
{
    const struct session *s = fleet_find_session(fleet, worker);
    return s ? roster_work(s, out, most) : 0;
}

int fleet_port(const struct fleet *fleet)
{
    return fleet->tcp.port;
}

json_t *fleet_roster(const struct fleet *fleet)
{
    json_t *roster = json_array();
    for (size_t i = 0; roster && i < fleet->session_count; i++)
        if (is_listed(fleet->sessions[i]))
            json_array_append_new(roster, roster_entry(fleet->sessions[i], &fleet->health));
    return roster;
}

void fleet_totals(const struct fleet *fleet, struct fleet_totals *out)
{
    *out = fleet->totals;
}
