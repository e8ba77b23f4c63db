#include "server/stream/reader.h"

#include <errno.h>
#include <microhttpd.h>
#include <sys/socket.h>

#include "server/stream/streams.h"

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
    link_into(r, list);
    streams->readers++;
}

void reader_leave(struct reader *r)
{
    struct stream *stream = r->stream;
    if (!r->streams) return; /* they went first, and took the lists with them */
    *r->link = r->next;
    if (r->next) r->next->link = r->link;
    r->streams->readers--;
    r->stream = NULL;
    if (stream) stream_settle(stream);
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
