#pragma once
/* How long a target waits, and a connection that is waited for. */
#include <errno.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdbool.h>
#include <stdlib.h>
#include <sys/socket.h>

/* Longer where targets share a core: tests/fuzz/run. */
static inline int patience_ms(void)
{
    const char *slower = getenv("FUZZ_SLOWER");
    return 20000 * (slower ? atoi(slower) : 1);
}

/* libFuzzer's timer interrupts calls that wait; a connection that is begun goes on being made. */
static inline bool is_connected(int fd, const struct sockaddr_in *address)
{
    struct pollfd made = {.fd = fd, .events = POLLOUT};
    int error = -1;
    if (connect(fd, (const struct sockaddr *)address, sizeof *address) == 0) return true;
    if (errno != EINTR) return false;
    while (poll(&made, 1, patience_ms()) < 0 && errno == EINTR) continue;
    (void)getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &(socklen_t){sizeof error});
    return error == 0 && (made.revents & POLLOUT);
}
