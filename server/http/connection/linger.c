#include "server/http/connection/linger.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <sys/socket.h>
#include <unistd.h>

#define DRAIN_MAX_BYTES (1u << 18)

/* False: the client has sent all that it will, or is gone. */
static bool drain(int fd)
{
    char waste[16384];
    for (size_t at = 0; at < DRAIN_MAX_BYTES;) {
        ssize_t got = recv(fd, waste, sizeof waste, MSG_DONTWAIT);
        if (got <= 0) return got < 0 && (errno == EAGAIN || errno == EINTR);
        at += (size_t)got;
    }
    return true;
}

static void close_at(struct linger_list *l, unsigned i)
{
    close(l->fd[i]);
    l->count--;
    l->fd[i] = l->fd[l->count];
    l->ticks[i] = l->ticks[l->count];
}

static void close_oldest(struct linger_list *l)
{
    unsigned oldest = 0;
    for (unsigned i = 1; i < l->count; i++)
        if (l->ticks[i] > l->ticks[oldest]) oldest = i;
    close_at(l, oldest);
}

void linger_add(struct linger_list *l, int fd)
{
    if (!drain(fd)) return;
    if (l->count > 0 && l->count >= l->most) close_oldest(l);
    const int own = fcntl(fd, F_DUPFD_CLOEXEC, 0);
    if (own < 0) return;
    (void)shutdown(own, SHUT_WR);
    l->fd[l->count] = own;
    l->ticks[l->count++] = 0;
}

void linger_tick(struct linger_list *l)
{
    for (unsigned i = 0; i < l->count;) {
        if (drain(l->fd[i]) && ++l->ticks[i] < LINGER_TICKS)
            i++;
        else
            close_at(l, i);
    }
}

void linger_close_all(struct linger_list *l)
{
    while (l->count > 0) close(l->fd[--l->count]);
}
