#include "server/http/connection/listen.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

union address {
    struct sockaddr any;
    struct sockaddr_in v4;
    struct sockaddr_in6 v6;
};

/* Cuts "HOST:PORT"; host without the brackets of IPv6. */
static int split(const char *text, char host[64], int *port, struct fault *fault)
{
    const char *colon = strrchr(text, ':');
    size_t n = colon ? (size_t)(colon - text) : 0,
           digits = colon ? strspn(colon + 1, "0123456789") : 0;
    bool bracketed = n >= 2 && text[0] == '[' && text[n - 1] == ']';
    if (!colon || digits == 0 || colon[1 + digits] || n == 0 || n >= 64 ||
        (!bracketed && memchr(text, ':', n)))
        return fault_set(fault, ERR_SYNTAX, "listen",
                         "\"%.100s\" is not ADDRESS:PORT (IPv6 in brackets)", text);
    *port = digits <= 5 ? atoi(colon + 1) : 65536;
    if (*port > 65535)
        return fault_set(fault, ERR_RANGE, "listen", "port %.20s is above 65535", colon + 1);
    if (bracketed) {
        text++;
        n -= 2;
    }
    memcpy(host, text, n);
    host[n] = '\0';
    return 0;
}

static int refuse_wide(const char *host, const struct listen_guards *guards, struct fault *fault)
{
    const char *missing = guards->tokens ? "--tls-cert and --tls-key are"
                          : guards->tls  ? "--tokens is"
                                         : "--tokens, --tls-cert and --tls-key are";
    return fault_set(fault, ERR_UNSUPPORTED, "listen",
                     "%.64s is no loopback address: others may ask only with tokens and TLS, "
                     "and %s missing; else use 127.0.0.1 and a tunnel",
                     host, missing);
}

static int resolve(const char *host, int port, const struct listen_guards *guards,
                   union address *out, socklen_t *size_bytes, struct fault *fault)
{
    bool loopback;
    memset(out, 0, sizeof *out);
    if (strcmp(host, "localhost") == 0) host = "127.0.0.1";
    if (inet_pton(AF_INET, host, &out->v4.sin_addr) == 1) {
        out->v4.sin_family = AF_INET;
        out->v4.sin_port = htons((uint16_t)port);
        *size_bytes = sizeof out->v4;
        loopback = (ntohl(out->v4.sin_addr.s_addr) >> 24) == 127;
    } else if (inet_pton(AF_INET6, host, &out->v6.sin6_addr) == 1) {
        out->v6.sin6_family = AF_INET6;
        out->v6.sin6_port = htons((uint16_t)port);
        *size_bytes = sizeof out->v6;
        loopback = IN6_IS_ADDR_LOOPBACK(&out->v6.sin6_addr);
    } else {
        return fault_set(fault, ERR_SYNTAX, "listen",
                         "\"%.64s\" is not an IP address, and the only name taken is localhost",
                         host);
    }
    return loopback || (guards->tokens && guards->tls) ? 0 : refuse_wide(host, guards, fault);
}

static int port_of(int fd)
{
    union address a = {.any = {0}};
    socklen_t size_bytes = sizeof a;
    if (getsockname(fd, &a.any, &size_bytes) != 0) return 0;
    return ntohs(a.any.sa_family == AF_INET6 ? a.v6.sin6_port : a.v4.sin_port);
}

int listen_open(const char *address, const struct listen_guards *guards, int *fd, int *port,
                struct fault *fault)
{
    char host[64];
    union address a;
    socklen_t size_bytes = 0;
    const int on = 1, unsent_bytes = LISTEN_UNSENT_BYTES;
    int error = split(address, host, port, fault);
    if (!error) error = resolve(host, *port, guards, &a, &size_bytes, fault);
    if (error) return error;
    *fd = socket(a.any.sa_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (*fd < 0)
        return fault_set(fault, ERR_IO, "listen", "no socket for %.100s: %s", address,
                         strerror(errno));
    (void)setsockopt(*fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    /* Accepted sockets have it, too. What is on its way over a long line counts beside it. */
    (void)setsockopt(*fd, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &unsent_bytes, sizeof unsent_bytes);
    if (bind(*fd, &a.any, size_bytes) != 0 || listen(*fd, SOMAXCONN) != 0) {
        error = fault_set(fault, ERR_IO, "listen", "cannot listen on %.100s: %s", address,
                          strerror(errno));
        close(*fd);
        return error;
    }
    *port = port_of(*fd);
    return 0;
}
