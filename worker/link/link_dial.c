#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/un.h>

#include "worker/link/link_state.h"

#define KEEPALIVE_S    30
#define SEAL_MS        10000 /* that the handshake may take */
#define UNIX_PREFIX    "unix:"
#define HOST_MAX_BYTES 253 /* of a name: RFC 1035, 2.3.4, as it is written */

static void try_address(struct link *l);

static void on_failed_address(uv_handle_t *handle)
{
    struct link *l = handle->data;
    l->handle_open = false;
    if (l->closing)
        link_release_if_done(l);
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
        link_open_sealed(l);
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
        status = link_read_start(l);
        l->state = LINK_UP;
    }
    if (status < 0) {
        link_drop_for(l, "the coordinator cannot be reached", status);
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
    if (status < 0) link_drop_for(l, "no socket can be made", status);
}

static void on_resolved(uv_getaddrinfo_t *request, int status, struct addrinfo *found)
{
    struct link *l = request->data;
    l->state = LINK_STOPPED;
    if (l->found) uv_freeaddrinfo(l->found);
    l->found = l->trying = found;
    if (l->closing) {
        link_release_if_done(l);
        return;
    }
    if (status < 0) {
        link_drop_for(l, "the coordinator's name cannot be resolved", status);
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
        link_drop_for(l, "the coordinator's name cannot be resolved", status);
    else
        l->state = LINK_RESOLVING;
}

static void dial_unix(struct link *l)
{
    int status = open_handle(l);
    if (status < 0) {
        link_drop_for(l, "no socket can be made", status);
        return;
    }
    l->state = LINK_CONNECTING;
    uv_pipe_connect(&l->connecting, &l->handle.pipe, l->host, on_connect);
}

void link_dial(struct link *l)
{
    if (l->closing || l->state != LINK_STOPPED) return;
    wire_frame_inbox_fini(&l->inbox);
    wire_frame_inbox_init(&l->inbox, LIMIT_FRAME_BYTES);
    channel_destroy(&l->channel);
    if (l->is_unix)
        dial_unix(l);
    else
        dial_tcp(l);
}

/* ---- addresses ---- */

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
    if (length == 0 || length > HOST_MAX_BYTES) return ERR_SYNTAX;
    l->host = strndup(address, length);
    return l->host ? 0 : ERR_MEMORY;
}

int link_parse_address(struct link *l, const char *address)
{
    size_t prefix = strlen(UNIX_PREFIX);
    if (strncmp(address, UNIX_PREFIX, prefix) != 0) return parse_tcp(l, address);
    size_t length = strlen(address + prefix);
    if (length == 0 || length >= sizeof((struct sockaddr_un *)0)->sun_path) return ERR_LIMIT;
    l->is_unix = true;
    l->host = strdup(address + prefix);
    return l->host ? 0 : ERR_MEMORY;
}
