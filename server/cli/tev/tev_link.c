#include "server/cli/tev/tev_link.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#define SILENT_S 10 /* so long may a connection, or a packet's next bytes, take */

int tev_link_parse(const char *text, bool anywhere, struct tev_link *link, struct fault *fault)
{
    const char *colon = strrchr(text, ':');
    size_t from = 0, length = colon ? (size_t)(colon - text) : 0;
    *link = (struct tev_link){.anywhere = anywhere, .fd = -1};
    if (length > 2 && text[0] == '[' && text[length - 1] == ']') {
        from = 1;
        length -= 2;
    }
    if (length == 0 || length >= sizeof link->host || !colon[1] || strlen(colon + 1) > 5 ||
        strspn(colon + 1, "0123456789") != strlen(colon + 1))
        return fault_set(fault, ERR_SYNTAX, "", "--tev: \"%.80s\" is not HOST:PORT", text);
    const long port = strtol(colon + 1, NULL, 10);
    if (port < 1 || port > 65535)
        return fault_set(fault, ERR_RANGE, "", "--tev: %ld is no port", port);
    memcpy(link->host, text + from, length);
    memcpy(link->port, colon + 1, strlen(colon + 1));
    return 0;
}

static bool is_loopback(const struct sockaddr *address)
{
    if (address->sa_family == AF_INET) {
        const struct sockaddr_in *v4 = (const struct sockaddr_in *)(const void *)address;
        return ntohl(v4->sin_addr.s_addr) >> 24 == 127;
    }
    const struct sockaddr_in6 *v6 = (const struct sockaddr_in6 *)(const void *)address;
    return address->sa_family == AF_INET6 && IN6_IS_ADDR_LOOPBACK(&v6->sin6_addr);
}

static int open_socket(const struct addrinfo *to)
{
    const struct timeval silent = {.tv_sec = SILENT_S};
    const int one = 1;
    int fd = socket(to->ai_family, to->ai_socktype | SOCK_CLOEXEC, to->ai_protocol);
    if (fd < 0) return -1;
    setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &silent, sizeof silent); /* also of connect */
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    if (connect(fd, to->ai_addr, to->ai_addrlen) == 0) return fd;
    const int why = errno;
    close(fd);
    errno = why;
    return -1;
}

int tev_link_connect(struct tev_link *link, struct fault *fault)
{
    const struct addrinfo hints = {.ai_socktype = SOCK_STREAM};
    struct addrinfo *found = NULL;
    const int unknown = getaddrinfo(link->host, link->port, &hints, &found);
    int error = 0;
    if (unknown)
        return fault_set(fault, ERR_NOT_FOUND, "", "--tev: %s: %s", link->host,
                         gai_strerror(unknown));
    for (const struct addrinfo *a = found; a && !error; a = a->ai_next)
        if (!link->anywhere && !is_loopback(a->ai_addr))
            error = fault_set(fault, ERR_UNSUPPORTED, "",
                              "--tev: %s is not this machine, and pictures would cross the network "
                              "for all to read; --tev-anywhere allows it",
                              link->host);
    for (const struct addrinfo *a = found; a && !error && link->fd < 0; a = a->ai_next)
        link->fd = open_socket(a);
    if (!error && link->fd < 0)
        error = fault_set(fault, ERR_IO, "",
                          "no tev listens at %s:%s (%s): start it, or see its option --host",
                          link->host, link->port, strerror(errno));
    freeaddrinfo(found);
    return error;
}

int tev_link_send(struct tev_link *link, const struct tev_packet *packet)
{
    for (size_t at = 0; at < packet->size_bytes;) {
        const ssize_t sent =
            send(link->fd, packet->data + at, packet->size_bytes - at, MSG_NOSIGNAL);
        if (sent < 0 && errno == EINTR) continue;
        if (sent <= 0) {
            tev_link_close(link);
            return ERR_IO;
        }
        at += (size_t)sent;
    }
    return 0;
}

void tev_link_close(struct tev_link *link)
{
    if (link->fd >= 0) close(link->fd);
    link->fd = -1;
}
