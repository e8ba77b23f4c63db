#include "worker/link.h"

#include <netdb.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/un.h>

#include "proto/channel.h"

#define KEEPALIVE_S 30
#define CLOSE_MS    1000
#define SEAL_MS     10000 /* that the handshake may take */
#define UNIX_PREFIX "unix:"
#define WHY_BYTES   256

enum link_state {
    LINK_STOPPED,   /* before the first dial, or closed for good */
    LINK_RESOLVING, /* a name is being looked up */
    LINK_CONNECTING,
    LINK_SEALING, /* connected; both show that they have the key */
    LINK_UP,
    LINK_BREAKING, /* the handle closes; then the wait begins */
    LINK_WAITING,
};

struct link {
    uv_loop_t *loop;
    struct link_client client;
    char *host; /* owned: host name, or the socket's path */
    char port[8];
    bool is_unix, is_keyed; /* keyed: over TCP, with `key` */
    struct link_key key;
    struct channel *channel; /* owned; of this connection */
    enum link_state state;
    union {
        uv_handle_t any;
        uv_stream_t stream;
        uv_tcp_t tcp;
        uv_pipe_t pipe;
    } handle;
    uv_connect_t connecting;
    uv_getaddrinfo_t resolving;
    struct addrinfo *found, *trying; /* owned; the one in use */
    uv_timer_t timer;                /* waits between attempts; the end of patience when closing */
    uv_idle_t turn;
    struct frame_inbox inbox;
    struct bytes_writer pending, scratch;
    size_t queued_bytes;
    unsigned attempt;
    int broken; /* a failure that the next turn acts on, so that link_put never calls back */
    bool closing, handle_open;
    unsigned open_handles; /* timer, turn */
    void (*closed)(void *ctx);
    void *closed_ctx;
};

struct link_write {
    uv_write_t request;
    struct link *link;
    uint8_t *data; /* owned */
    struct parcel *parcel;
    size_t size_bytes;
};

/* ---- the end ---- */

static void release_if_done(struct link *l)
{
    if (!l->closing || l->handle_open || l->open_handles > 0 || l->state == LINK_RESOLVING) return;
    void (*closed)(void *ctx) = l->closed;
    void *ctx = l->closed_ctx;
    channel_destroy(&l->channel);
    frame_inbox_fini(&l->inbox);
    bytes_writer_fini(&l->pending);
    bytes_writer_fini(&l->scratch);
    if (l->found) uv_freeaddrinfo(l->found);
    free(l->host);
    free(l);
    if (closed) closed(ctx);
}

static void on_helper_closed(uv_handle_t *handle)
{
    struct link *l = handle->data;
    l->open_handles--;
    release_if_done(l);
}

static void on_broken(uv_handle_t *handle);

static void close_handle(struct link *l)
{
    if (l->handle_open && !uv_is_closing(&l->handle.any)) uv_close(&l->handle.any, on_broken);
}

static void close_helpers(struct link *l)
{
    if (!uv_is_closing((uv_handle_t *)&l->timer))
        uv_close((uv_handle_t *)&l->timer, on_helper_closed);
    if (!uv_is_closing((uv_handle_t *)&l->turn))
        uv_close((uv_handle_t *)&l->turn, on_helper_closed);
}

static void close_all(struct link *l)
{
    if (l->state == LINK_RESOLVING)
        uv_cancel((uv_req_t *)&l->resolving);
    else
        l->state = LINK_STOPPED;
    close_handle(l);
    close_helpers(l);
}

/* ---- waiting ---- */

uint32_t link_wait_ms(unsigned attempt)
{
    uint32_t wait_ms = LINK_RETRY_MS;
    while (attempt-- > 0 && wait_ms < LINK_RETRY_MAX_MS) wait_ms *= 2;
    return wait_ms < LINK_RETRY_MAX_MS ? wait_ms : LINK_RETRY_MAX_MS;
}

static void on_wait_over(uv_timer_t *timer)
{
    struct link *l = timer->data;
    l->state = LINK_STOPPED;
    link_dial(l);
}

static void wait(struct link *l)
{
    l->state = LINK_WAITING;
    uv_timer_start(&l->timer, on_wait_over, link_wait_ms(l->attempt++), 0);
}

static void on_broken(uv_handle_t *handle)
{
    struct link *l = handle->data;
    l->handle_open = false;
    if (l->closing)
        release_if_done(l);
    else
        wait(l);
}

void link_drop(struct link *l, int error, const char *why)
{
    if (l->closing) {
        close_all(l);
        return;
    }
    if (l->state == LINK_BREAKING || l->state == LINK_WAITING) return;
    char text[WHY_BYTES];
    snprintf(text, sizeof text, "%s", why);
    bool was_open = l->handle_open;
    l->state = LINK_BREAKING;
    l->broken = 0;
    uv_idle_stop(&l->turn);
    bytes_writer_fini(&l->pending); /* what it had no memory for is of the lost link, too */
    bytes_writer_init(&l->pending);
    close_handle(l);
    l->client.down(l->client.ctx, error, text, link_wait_ms(l->attempt));
    if (!was_open && !l->closing) wait(l);
}

static void drop_for(struct link *l, const char *what, int status)
{
    char why[WHY_BYTES];
    snprintf(why, sizeof why, "%s: %s", what, uv_strerror(status));
    link_drop(l, ERR_IO, why);
}

/* ---- writing ---- */

static void on_written(uv_write_t *request, int status)
{
    struct link_write *write = (struct link_write *)request;
    struct link *l = write->link;
    l->queued_bytes -= write->size_bytes;
    free(write->data);
    parcel_unref(&write->parcel);
    free(write);
    if (status < 0 && status != UV_ECANCELED) drop_for(l, "writing failed", status);
    if (l->closing && l->queued_bytes == 0) close_all(l);
}

static void on_turn(uv_idle_t *turn);

static void break_later(struct link *l, int error)
{
    if (l->broken == 0) l->broken = error;
    if (!l->closing) uv_idle_start(&l->turn, on_turn);
}

/* What is pending, and the parcel, become what the channel makes of them. */
static int seal(struct link *l, const struct parcel *parcel)
{
    int e = 0;
    if (l->pending.size_bytes > 0)
        e = channel_write(l->channel, l->pending.data, l->pending.size_bytes);
    if (e == 0 && parcel) e = channel_write(l->channel, parcel->data, parcel->size_bytes);
    bytes_writer_fini(&l->pending);
    bytes_writer_init(&l->pending);
    if (e) return e;
    l->pending.data = channel_take(l->channel, &l->pending.size_bytes);
    l->pending.capacity_bytes = l->pending.size_bytes;
    return 0;
}

static void write_out(struct link *l, struct parcel *parcel)
{
    if (l->channel && !l->pending.failed) {
        const int e = seal(l, parcel);
        if (e) break_later(l, e);
        if (e || l->pending.size_bytes == 0) return;
        parcel = NULL;
    }
    struct link_write *write = calloc(1, sizeof *write);
    if (!write || l->pending.failed) {
        free(write);
        break_later(l, ERR_MEMORY);
        return;
    }
    size_t tail_bytes = parcel ? parcel->size_bytes : 0;
    write->link = l;
    write->data = l->pending.data;
    write->parcel = parcel ? parcel_ref(parcel) : NULL;
    write->size_bytes = l->pending.size_bytes + tail_bytes;
    uv_buf_t parts[2] = {uv_buf_init((char *)write->data, (unsigned)l->pending.size_bytes),
                         uv_buf_init(parcel ? (char *)parcel->data : NULL, (unsigned)tail_bytes)};
    bytes_writer_init(&l->pending);
    int status = uv_write(&write->request, &l->handle.stream, parts, parcel ? 2 : 1, on_written);
    if (status == 0) {
        l->queued_bytes += write->size_bytes;
        return;
    }
    free(write->data);
    parcel_unref(&write->parcel);
    free(write);
    break_later(l, ERR_IO);
}

static void on_turn(uv_idle_t *turn)
{
    struct link *l = turn->data;
    uv_idle_stop(turn);
    if (l->state != LINK_UP) return;
    if (l->broken == 0 && (l->pending.size_bytes > 0 || l->pending.failed)) write_out(l, NULL);
    if (l->broken) link_drop(l, l->broken, error_text(l->broken));
}

struct bytes_writer *link_payload(struct link *l)
{
    l->scratch.size_bytes = 0;
    l->scratch.failed = false; /* that was another message */
    return &l->scratch;
}

static bool append(struct link *l, uint16_t type, uint64_t request_id, const struct parcel *parcel)
{
    if (l->state != LINK_UP) return false;
    const struct bytes_writer *head = &l->scratch;
    if (head->failed) {
        break_later(l, ERR_MEMORY);
        return false;
    }
    uint8_t header[FRAME_HEADER_BYTES];
    frame_header(header, type, request_id, head->data, (uint32_t)head->size_bytes,
                 parcel ? parcel->data : NULL, parcel ? (uint32_t)parcel->size_bytes : 0);
    bytes_write_raw(&l->pending, header, sizeof header);
    if (head->size_bytes > 0) bytes_write_raw(&l->pending, head->data, head->size_bytes);
    return true;
}

void link_put(struct link *l, uint16_t type, uint64_t request_id)
{
    if (append(l, type, request_id, NULL)) uv_idle_start(&l->turn, on_turn);
}

void link_put_parcel(struct link *l, uint16_t type, uint64_t request_id, struct parcel *parcel)
{
    if (append(l, type, request_id, parcel)) write_out(l, parcel);
}

/* ---- reading ---- */

/* libuv fills it and calls on_read before anything else is read. */
static char sealed[65536];

static void on_space(uv_handle_t *handle, size_t suggested, uv_buf_t *out)
{
    (void)suggested;
    struct link *l = handle->data;
    if (l->channel) {
        *out = uv_buf_init(sealed, sizeof sealed);
        return;
    }
    size_t space_bytes = 0;
    uint8_t *space = frame_inbox_space(&l->inbox, &space_bytes);
    if (space_bytes > INT32_MAX) space_bytes = INT32_MAX;
    *out = uv_buf_init((char *)space, space ? (unsigned)space_bytes : 0);
}

/* Takes the whole frames that are there. False when the link is not up any more. */
static bool take_frames(struct link *l)
{
    struct frame_view f;
    int e = 0;
    while (l->state == LINK_UP && !l->closing && (e = frame_inbox_next(&l->inbox, &f)) == 0) {
        e = l->client.frame(l->client.ctx, &f);
        if (e) break;
    }
    if (e && e != ERR_INCOMPLETE && l->state == LINK_UP && !l->closing)
        link_drop(l, e, error_text(e));
    return l->state == LINK_UP && !l->closing;
}

static void be_up(struct link *l)
{
    uv_timer_stop(&l->timer);
    l->state = LINK_UP;
    l->client.up(l->client.ctx);
}

static const char no_key[] = "the coordinator does not have this key (--key), or wants none";

/* Goes on with the handshake, then opens what has come. */
static void open_sealed(struct link *l)
{
    do {
        size_t space_bytes = 0, got = 0;
        uint8_t *space = frame_inbox_space(&l->inbox, &space_bytes);
        const int e = space ? channel_read(l->channel, space, space_bytes, &got) : ERR_MEMORY;
        write_out(l, NULL); /* its own words */
        if (l->state == LINK_SEALING && channel_is_up(l->channel)) be_up(l);
        if (e == ERR_INCOMPLETE || l->closing) return;
        if (e) {
            link_drop(l, e, l->state == LINK_SEALING ? no_key : error_text(e));
            return;
        }
        frame_inbox_filled(&l->inbox, got);
    } while (take_frames(l));
}

static void on_read(uv_stream_t *stream, ssize_t size_bytes, const uv_buf_t *buf)
{
    struct link *l = stream->data;
    if (size_bytes == UV_EOF) {
        link_drop(l, ERR_IO, l->state == LINK_SEALING ? no_key : "the coordinator closed the link");
        return;
    }
    if (size_bytes < 0) {
        drop_for(l, "reading failed", (int)size_bytes);
        return;
    }
    if (!l->channel) {
        frame_inbox_filled(&l->inbox, (size_t)size_bytes);
        (void)take_frames(l);
        return;
    }
    int e = channel_feed(l->channel, buf->base, (size_t)size_bytes);
    if (e)
        link_drop(l, e, error_text(e));
    else
        open_sealed(l);
}

/* ---- dialling ---- */

static void try_address(struct link *l);

static void on_failed_address(uv_handle_t *handle)
{
    struct link *l = handle->data;
    l->handle_open = false;
    if (l->closing)
        release_if_done(l);
    else
        try_address(l);
}

static void on_seal_late(uv_timer_t *timer)
{
    link_drop(timer->data, ERR_TIMEOUT, "the coordinator does not answer the handshake");
}

static void begin_seal(struct link *l)
{
    l->state = LINK_SEALING;
    uv_timer_start(&l->timer, on_seal_late, SEAL_MS, 0);
    int e = channel_create(false, &l->key, &l->channel);
    if (e)
        link_drop(l, e, error_text(e));
    else
        open_sealed(l);
}

static void on_connect(uv_connect_t *request, int status)
{
    struct link *l = request->handle->data;
    if (l->state != LINK_CONNECTING) return; /* dropped or closed in between */
    if (status < 0 && l->trying && l->trying->ai_next) {
        l->trying = l->trying->ai_next;
        uv_close(&l->handle.any, on_failed_address);
        return;
    }
    if (status == 0) {
        status = uv_read_start(&l->handle.stream, on_space, on_read);
        l->state = LINK_UP;
    }
    if (status < 0) {
        drop_for(l, "the coordinator cannot be reached", status);
        return;
    }
    if (!l->is_unix) {
        uv_tcp_nodelay(&l->handle.tcp, 1);
        uv_tcp_keepalive(&l->handle.tcp, 1, KEEPALIVE_S);
    }
    if (l->is_keyed)
        begin_seal(l);
    else
        l->client.up(l->client.ctx);
}

static int open_handle(struct link *l)
{
    int status = l->is_unix ? uv_pipe_init(l->loop, &l->handle.pipe, 0)
                            : uv_tcp_init(l->loop, &l->handle.tcp);
    l->handle.any.data = l;
    l->handle_open = status == 0;
    return status;
}

static void try_address(struct link *l)
{
    int status = open_handle(l);
    l->state = LINK_CONNECTING;
    if (status == 0)
        status = uv_tcp_connect(&l->connecting, &l->handle.tcp, l->trying->ai_addr, on_connect);
    if (status < 0) drop_for(l, "no socket can be made", status);
}

static void on_resolved(uv_getaddrinfo_t *request, int status, struct addrinfo *found)
{
    struct link *l = request->data;
    l->state = LINK_STOPPED;
    if (l->found) uv_freeaddrinfo(l->found);
    l->found = l->trying = found;
    if (l->closing) {
        release_if_done(l);
        return;
    }
    if (status < 0) {
        drop_for(l, "the coordinator's name cannot be resolved", status);
        return;
    }
    try_address(l);
}

static void dial_tcp(struct link *l)
{
    const struct addrinfo hints = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM};
    l->resolving.data = l;
    int status = uv_getaddrinfo(l->loop, &l->resolving, on_resolved, l->host, l->port, &hints);
    if (status < 0)
        drop_for(l, "the coordinator's name cannot be resolved", status);
    else
        l->state = LINK_RESOLVING;
}

static void dial_unix(struct link *l)
{
    int status = open_handle(l);
    if (status < 0) {
        drop_for(l, "no socket can be made", status);
        return;
    }
    l->state = LINK_CONNECTING;
    uv_pipe_connect(&l->connecting, &l->handle.pipe, l->host, on_connect);
}

void link_dial(struct link *l)
{
    if (l->closing || l->state != LINK_STOPPED) return;
    frame_inbox_fini(&l->inbox);
    frame_inbox_init(&l->inbox, LIMIT_FRAME_BYTES);
    channel_destroy(&l->channel);
    if (l->is_unix)
        dial_unix(l);
    else
        dial_tcp(l);
}

void link_settle(struct link *l)
{
    l->attempt = 0;
}

/* ---- making and closing ---- */

static int read_port(const char *text, char out[8])
{
    char *end = NULL;
    if (*text < '0' || *text > '9') return ERR_SYNTAX;
    unsigned long port = strtoul(text, &end, 10);
    if (*end != '\0' || port == 0 || port > 65535) return ERR_RANGE;
    snprintf(out, 8, "%lu", port);
    return 0;
}

static int parse_tcp(struct link *l, const char *address)
{
    const char *colon = strrchr(address, ':');
    if (!colon || colon == address || read_port(colon + 1, l->port) != 0) return ERR_SYNTAX;
    size_t length = (size_t)(colon - address);
    if (address[0] == '[' && colon[-1] == ']') {
        address++;
        length -= 2;
    } else if (memchr(address, ':', length)) {
        return ERR_SYNTAX;
    }
    l->host = strndup(address, length);
    return l->host ? 0 : ERR_MEMORY;
}

static int parse_address(struct link *l, const char *address)
{
    size_t prefix = strlen(UNIX_PREFIX);
    if (strncmp(address, UNIX_PREFIX, prefix) != 0) return parse_tcp(l, address);
    size_t length = strlen(address + prefix);
    if (length == 0 || length >= sizeof((struct sockaddr_un *)0)->sun_path) return ERR_LIMIT;
    l->is_unix = true;
    l->host = strdup(address + prefix);
    return l->host ? 0 : ERR_MEMORY;
}

int link_create(uv_loop_t *loop, const char *address, const struct link_key *key,
                const struct link_client *client, struct link **out, struct fault *fault)
{
    struct link *l = calloc(1, sizeof *l);
    int e = l ? parse_address(l, address) : ERR_MEMORY;
    if (e) {
        free(l);
        if (e == ERR_LIMIT)
            return fault_set(fault, e, address, "a socket path has 1 to %zu bytes",
                             sizeof((struct sockaddr_un *)0)->sun_path - 1);
        return fault_set(fault, e, address, "expected unix:PATH or HOST:PORT");
    }
    l->loop = loop;
    l->client = *client;
    l->is_keyed = key && !l->is_unix;
    if (l->is_keyed) l->key = *key;
    uv_timer_init(loop, &l->timer);
    uv_idle_init(loop, &l->turn);
    l->timer.data = l->turn.data = l;
    l->open_handles = 2;
    frame_inbox_init(&l->inbox, LIMIT_FRAME_BYTES);
    bytes_writer_init(&l->pending);
    bytes_writer_init(&l->scratch);
    *out = l;
    return 0;
}

static void on_close_too_slow(uv_timer_t *timer)
{
    close_all(timer->data);
}

void link_close(struct link *l, void (*closed)(void *ctx), void *ctx)
{
    l->closed = closed;
    l->closed_ctx = ctx;
    if (l->state == LINK_UP && l->pending.size_bytes > 0) write_out(l, NULL);
    l->closing = true;
    if (l->state == LINK_UP) uv_read_stop(&l->handle.stream);
    if (l->state == LINK_UP && l->queued_bytes > 0 && l->broken == 0)
        uv_timer_start(&l->timer, on_close_too_slow, CLOSE_MS, 0);
    else
        close_all(l);
}
