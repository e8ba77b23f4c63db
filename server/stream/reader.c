#include "server/stream/reader.h"

#include <errno.h>
#include <linux/sockios.h>
#include <microhttpd.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include "server/stream/streams.h"

#define EVENT_SOCKET_BYTES 32768

static void link_into(struct reader *r, struct reader **list)
{
    r->next = *list;
    r->link = list;
    if (r->next) r->next->link = &r->next;
    *list = r;
}

void reader_join(struct reader *r, struct streams *streams, struct stream *stream,
                 struct reader **list, struct MHD_Connection *connection)
{
    r->streams = streams;
    r->stream = stream;
    r->connection = connection;
    reader_moved(r);
    link_into(r, list);
    streams->readers++;
    streams->rate_limit.readers += r->kind == READER_PIXELS;
}

void reader_leave(struct reader *r)
{
    struct stream *stream = r->stream;
    if (!r->streams) return; /* they went first, and took the lists with them */
    rate_limit_leave(&r->streams->rate_limit, r);
    *r->link = r->next;
    if (r->next) r->next->link = r->link;
    r->streams->readers--;
    r->streams->rate_limit.readers -= r->kind == READER_PIXELS;
    r->stream = NULL;
    if (stream) stream_settle(stream);
}

void reader_moved(struct reader *r)
{
    if (r->streams) r->moved_ms = r->streams->now_ms;
}

ssize_t reader_gives(struct reader *r, size_t bytes)
{
    if (r->streams)
        r->streams->due = r->kind == READER_PIXELS ? CPU_METER_PIXELS : CPU_METER_EVENTS;
    return (ssize_t)bytes;
}

/* Bytes that the other side has not acknowledged; 0 where the system does not tell. */
static int unsent_bytes(const struct reader *r)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(r->connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    int bytes = 0;
    return info && ioctl(info->connect_fd, SIOCOUTQ, &bytes) == 0 ? bytes : 0;
}

bool reader_is_stuck(struct reader *r, uint64_t now_ms, uint64_t after_ms)
{
    if (!r->suspended && !r->cut) {
        const int bytes = unsent_bytes(r);
        if (bytes != r->unsent_bytes) r->moved_ms = now_ms;
        r->unsent_bytes = bytes;
    }
    return !r->suspended && !r->cut && now_ms - r->moved_ms >= after_ms;
}

void reader_cut(struct reader *r)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(r->connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    r->cut = r->ending = true;
    r->streams->cut[r->kind]++;
    if (r->streams->told_cut)
        r->streams->told_cut(r->streams->kick_ctx, r->kind, r->stream ? r->stream->job : "");
    if (info) (void)shutdown(info->connect_fd, SHUT_RDWR);
}

void reader_bound_socket(const struct reader *r)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(r->connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    const int bytes = EVENT_SOCKET_BYTES;
    if (info) (void)setsockopt(info->connect_fd, SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes);
}

ssize_t reader_sleep(struct reader *r)
{
    r->suspended = true;
    MHD_suspend_connection(r->connection);
    return 0;
}

void reader_wake(struct reader *r)
{
    if (!r->suspended) return;
    r->suspended = false;
    reader_moved(r);
    MHD_resume_connection(r->connection);
}

void readers_wake(struct reader *list)
{
    for (struct reader *r = list; r; r = r->next) reader_wake(r);
}

bool reader_is_gone(const struct reader *r)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(r->connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    char byte;
    if (!info) return true;
    ssize_t got = recv(info->connect_fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT);
    return got == 0 || (got < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR);
}
