/* The listening socket: what an accepted one takes for a client that never reads. */
#include <arpa/inet.h>
#include <errno.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "server/http/connection/listen.h"
#include "tests/unit/unit.h"

static int dial(int port)
{
    const struct sockaddr_in to = {.sin_family = AF_INET,
                                   .sin_port = htons((uint16_t)port),
                                   .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_true(fd >= 0);
    assert_int_equal(connect(fd, (const struct sockaddr *)&to, sizeof to), 0);
    return fd;
}

/* Until nothing more is taken for a tenth of a second. */
static size_t fill(int fd)
{
    static const char bytes[65536];
    struct pollfd p = {.fd = fd, .events = POLLOUT};
    size_t taken_bytes = 0;
    while (poll(&p, 1, 100) == 1) {
        const ssize_t n = send(fd, bytes, sizeof bytes, MSG_DONTWAIT | MSG_NOSIGNAL);
        assert_true(n > 0 || errno == EAGAIN);
        if (n > 0) taken_bytes += (size_t)n;
    }
    return taken_bytes;
}

TEST(little_is_taken_for_who_reads_nothing)
{
    const struct listen_guards none = {0};
    struct fault fault;
    int fd = -1, port = 0;
    assert_int_equal(listen_open("127.0.0.1:0", &none, &fd, &port, &fault), 0);
    const int client = dial(port), accepted = accept4(fd, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
    assert_true(accepted >= 0);
    const size_t taken_bytes = fill(accepted);
    print_message("# %zu bytes are taken for who reads nothing\n", taken_bytes);
    assert_in_range(taken_bytes, LISTEN_UNSENT_BYTES, 4 * LISTEN_UNSENT_BYTES);
    close(accepted);
    close(client);
    close(fd);
}
