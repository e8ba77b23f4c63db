#include "server/http/peer.h"

#include <gnutls/gnutls.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>

#include "server/http/crowd.h"
#include "server/http/daemon.h"
#include "server/http/request.h"

void peer_deadline(struct peer *peer, uint64_t ms)
{
    peer->deadline_ms = ms ? uv_now(peer->http->options.loop) + ms : 0;
}

void peer_linger(struct peer *peer)
{
    if (peer->lingers) return;
    peer->lingers = true;
    lingering_add(&peer->http->lingering, peer->fd);
}

void peer_abort(struct peer *peer, unsigned status)
{
    enum problem_id id = status == 413   ? PROBLEM_TOO_LARGE
                         : status == 503 ? PROBLEM_BUSY
                                         : PROBLEM_TIMEOUT;
    const struct problem *p = problem_of(id);
    peer->deadline_ms = 0;
    if (peer->http->tls.key) { /* plain words would be noise there */
        (void)shutdown(peer->fd, SHUT_RDWR);
        return;
    }
    char body[256], text[640];
    int body_bytes =
        snprintf(body, sizeof body,
                 "{\"type\":\"urn:shearwater:problem:%s\",\"title\":\"%s\",\"status\":%u}", p->slug,
                 p->title, p->status);
    int text_bytes = snprintf(text, sizeof text,
                              "HTTP/1.1 %u %s\r\nContent-Type: application/problem+json\r\n"
                              "Content-Length: %d\r\nCache-Control: no-store\r\n"
                              "Connection: close\r\n\r\n%s",
                              p->status, p->title, body_bytes, body);
    (void)send(peer->fd, text, (size_t)text_bytes, MSG_DONTWAIT | MSG_NOSIGNAL);
    peer_linger(peer);
    (void)shutdown(peer->fd, SHUT_RDWR);
}

void peer_expire(struct peer *peer)
{
    struct request *r = peer->request;
    if (r && r->status == 0) {
        r->status = 408;
        peer_abort(peer, 408);
        return;
    }
    (void)shutdown(peer->fd, SHUT_RDWR);
    peer->deadline_ms = 0;
}

static int on_handshake(gnutls_session_t session, unsigned message, unsigned when,
                        unsigned incoming, const gnutls_datum_t *bytes)
{
    const struct peer *peer = gnutls_db_get_ptr(session);
    (void)message;
    (void)when;
    (void)incoming;
    (void)bytes;
    (void)streams_meter(peer->http->options.streams, METER_OTHER);
    return 0;
}

/* A handshake takes milliseconds, and MHD tells nobody of it: who had the turn before it would pay.
 * The pointer is that of a database of sessions, which there is none of. */
static void meter_handshake(struct peer *peer, struct MHD_Connection *connection)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_GNUTLS_SESSION);
    if (!info || !info->tls_session) return;
    gnutls_db_set_ptr(info->tls_session, peer);
    gnutls_handshake_set_hook_function(info->tls_session, GNUTLS_HANDSHAKE_ANY, GNUTLS_HOOK_PRE,
                                       on_handshake);
}

static void begin_peer(struct http *http, struct MHD_Connection *connection, void **context)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    struct peer *peer = info ? calloc(1, sizeof *peer) : NULL;
    *context = peer;
    (void)streams_meter(http->options.streams, METER_OTHER);
    if (!peer) return; /* its requests are refused */
    peer->http = http;
    peer->fd = info->connect_fd;
    peer->next = http->peers;
    peer->link = &http->peers;
    if (peer->next) peer->next->link = &peer->next;
    http->peers = peer;
    http->connections++;
    peer_deadline(peer, http->request_ms);
    if (http->tls.key) meter_handshake(peer, connection);
    crowd_make_room(http);
}

static bool has_unread(int fd)
{
    char byte;
    return recv(fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT) > 0;
}

/* What MHD refuses by itself (a request line that is too long) it answers and closes at once. */
static void end_peer(struct http *http, struct peer *peer)
{
    if (!peer) return;
    if (!peer->served || has_unread(peer->fd)) peer_linger(peer);
    if (peer->request) request_done(peer->request);
    *peer->link = peer->next;
    if (peer->next) peer->next->link = peer->link;
    http->connections--;
    free(peer);
}

void peer_changed(void *ctx, struct MHD_Connection *connection, void **context,
                  enum MHD_ConnectionNotificationCode code)
{
    if (code == MHD_CONNECTION_NOTIFY_STARTED)
        begin_peer(ctx, connection, context);
    else
        end_peer(ctx, *context);
}
