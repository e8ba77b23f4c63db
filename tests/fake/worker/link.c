#include "tests/fake/worker/link.h"

#include <errno.h>
#include <netdb.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#define END_MS 50 /* after damage, until the link is ended from here */

static int dial_unix(const char *path)
{
    struct sockaddr_un a = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof a.sun_path) return -1;
    memcpy(a.sun_path, path, strlen(path) + 1);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd >= 0 && connect(fd, (const struct sockaddr *)&a, sizeof a) == 0) return fd;
    if (fd >= 0) close(fd);
    return -1;
}

static int dial_tcp(const char *address)
{
    char host[256];
    const char *colon = strrchr(address, ':');
    const struct addrinfo hints = {.ai_socktype = SOCK_STREAM};
    struct addrinfo *found = NULL;
    if (!colon || (size_t)(colon - address) >= sizeof host) return -1;
    memcpy(host, address, (size_t)(colon - address));
    host[colon - address] = '\0';
    if (getaddrinfo(host, colon + 1, &hints, &found) != 0) return -1;
    int fd = socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd >= 0 && connect(fd, found->ai_addr, found->ai_addrlen) != 0) {
        close(fd);
        fd = -1;
    }
    freeaddrinfo(found);
    return fd;
}

int link_dial(const char *address)
{
    return strncmp(address, "unix:", 5) == 0 ? dial_unix(address + 5) : dial_tcp(address);
}

void link_lose(struct fake *f)
{
    if (f->fd >= 0) close(f->fd);
    f->fd = -1;
}

void link_end_soon(struct fake *f)
{
    struct pollfd p = {.fd = f->fd, .events = POLLIN};
    uint8_t ignored[4096];
    while (f->fd >= 0 && poll(&p, 1, END_MS) > 0)
        if (recv(f->fd, ignored, sizeof ignored, 0) <= 0) break;
    if (f->fd >= 0) link_lose(f);
}

void link_send(struct fake *f, const void *data, size_t size_bytes)
{
    const uint8_t *at = data;
    while (size_bytes > 0 && f->fd >= 0) {
        ssize_t n = send(f->fd, at, size_bytes, MSG_NOSIGNAL);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) {
            link_lose(f);
            return;
        }
        at += n;
        size_bytes -= (size_t)n;
    }
}

void link_send_message(struct fake *f, uint16_t type, uint64_t request_id,
                       struct bytes_writer *head, const void *tail, size_t tail_bytes)
{
    uint8_t header[WIRE_FRAME_HEADER_BYTES];
    wire_frame_header(header, type, request_id, head->data, (uint32_t)head->size_bytes, tail,
                      (uint32_t)tail_bytes);
    link_send(f, header, sizeof header);
    link_send(f, head->data, head->size_bytes);
    link_send(f, tail, tail_bytes);
    bytes_writer_fini(head);
}

void link_send_want(struct fake *f, uint32_t tiles)
{
    struct bytes_writer w;
    bytes_writer_init(&w);
    message_encode_want(&w, &(struct message_want){.tiles = tiles});
    link_send_message(f, MESSAGE_WANT, f->next_request++, &w, NULL, 0);
}
