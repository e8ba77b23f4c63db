#include "server/http/connection.h"

#include <gnutls/gnutls.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>

#include "server/http/connection_limits.h"
#include "server/http/daemon.h"
#include "server/http/request.h"

void connection_deadline(struct connection *connection, uint64_t ms)
{
    connection->deadline_ms = ms ? uv_now(connection->http->options.loop) + ms : 0;
}

void connection_linger(struct connection *connection)
{
    if (connection->lingers) return;
    connection->lingers = true;
    linger_add(&connection->http->linger, connection->fd);
}

void connection_abort(struct connection *connection, unsigned status)
{
    enum problem_id id = status == 413   ? PROBLEM_TOO_LARGE
                         : status == 503 ? PROBLEM_BUSY
                                         : PROBLEM_TIMEOUT;
    const struct problem *p = problem_of(id);
    connection->deadline_ms = 0;
    if (connection->http->tls.key) { /* plain words would be noise there */
        (void)shutdown(connection->fd, SHUT_RDWR);
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
    (void)send(connection->fd, text, (size_t)text_bytes, MSG_DONTWAIT | MSG_NOSIGNAL);
    connection_linger(connection);
    (void)shutdown(connection->fd, SHUT_RDWR);
}

void connection_expire(struct connection *connection)
{
    struct request *r = connection->request;
    if (r && r->status == 0) {
        r->status = 408;
        connection_abort(connection, 408);
        return;
    }
    (void)shutdown(connection->fd, SHUT_RDWR);
    connection->deadline_ms = 0;
}

static int on_handshake(gnutls_session_t session, unsigned message, unsigned when,
                        unsigned incoming, const gnutls_datum_t *bytes)
{
    const struct connection *connection = gnutls_db_get_ptr(session);
    (void)message;
    (void)when;
    (void)incoming;
    (void)bytes;
    (void)streams_meter(connection->http->options.streams, CPU_METER_OTHER);
    return 0;
}

/* Charges the handshake to CPU_METER_OTHER. It takes milliseconds, and MHD does not announce it, so
 * its time would go to the kind before. The pointer is the one for a database of sessions, which
 * does not exist here. */
static void meter_handshake(struct connection *connection, struct MHD_Connection *mhd)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(mhd, MHD_CONNECTION_INFO_GNUTLS_SESSION);
    if (!info || !info->tls_session) return;
    gnutls_db_set_ptr(info->tls_session, connection);
    gnutls_handshake_set_hook_function(info->tls_session, GNUTLS_HANDSHAKE_ANY, GNUTLS_HOOK_PRE,
                                       on_handshake);
}

static void begin_connection(struct http *http, struct MHD_Connection *mhd, void **context)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(mhd, MHD_CONNECTION_INFO_CONNECTION_FD);
    struct connection *connection = info ? calloc(1, sizeof *connection) : NULL;
    *context = connection;
    (void)streams_meter(http->options.streams, CPU_METER_OTHER);
    if (!connection) return; /* its requests are refused */
    connection->http = http;
    connection->fd = info->connect_fd;
    connection->next = http->open;
    connection->link = &http->open;
    if (connection->next) connection->next->link = &connection->next;
    http->open = connection;
    http->connections++;
    connection_deadline(connection, http->request_ms);
    if (http->tls.key) meter_handshake(connection, mhd);
    connection_limits_make_room(http);
}

static bool has_unread(int fd)
{
    char byte;
    return recv(fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT) > 0;
}

/* Ends a connection. MHD answers and closes at once what it refuses by itself (a request line that
 * is too long). */
static void end_connection(struct http *http, struct connection *connection)
{
    if (!connection) return;
    if (!connection->served || has_unread(connection->fd)) connection_linger(connection);
    if (connection->request) request_done(connection->request);
    *connection->link = connection->next;
    if (connection->next) connection->next->link = connection->link;
    http->connections--;
    free(connection);
}

void connection_changed(void *ctx, struct MHD_Connection *mhd, void **context,
                        enum MHD_ConnectionNotificationCode code)
{
    if (code == MHD_CONNECTION_NOTIFY_STARTED)
        begin_connection(ctx, mhd, context);
    else
        end_connection(ctx, *context);
}
