#include "server/fleet/listener.h"

#include <arpa/inet.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#define BACKLOG 128

static void on_incoming(uv_stream_t *stream, int status)
{
    struct listener *l = stream->data;
    if (status == 0) l->incoming(l->ctx, l); /* else: out of descriptors; the dialler tries again */
}

static int give_up(struct fault *fault, const char *place, const char *what, int status)
{
    return fault_set(fault, ERR_IO, place, "%s: %s", what, uv_strerror(status));
}

static int start(struct listener *l, struct fault *fault, const char *place)
{
    int status = uv_listen(&l->handle.stream, BACKLOG, on_incoming);
    if (status < 0) return give_up(fault, place, "cannot listen there", status);
    return 0;
}

/* ---- Unix ---- */

/* Returns 1 if a process listens on the socket, 0 if none does, -1 when the path holds something
 * else. */
static int is_answered(const struct sockaddr_un *address)
{
    struct stat st;
    if (lstat(address->sun_path, &st) != 0) return 0;
    if (!S_ISSOCK(st.st_mode)) return -1;
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0) return 1;
    int status = connect(fd, (const struct sockaddr *)address, sizeof *address);
    int error = errno;
    close(fd);
    return status == 0 || error != ECONNREFUSED;
}

static int check_path(const char *path, struct fault *fault)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    size_t length = strlen(path);
    if (length == 0 || length >= sizeof address.sun_path)
        return fault_set(fault, ERR_LIMIT, path, "a socket path has 1 to %zu bytes, this has %zu",
                         sizeof address.sun_path - 1, length);
    memcpy(address.sun_path, path, length + 1);
    int answered = is_answered(&address);
    if (answered < 0)
        return fault_set(fault, ERR_EXISTS, path, "there is a file of that name, not a socket");
    if (answered > 0)
        return fault_set(fault, ERR_EXISTS, path, "another coordinator listens on this socket");
    unlink(path);
    return 0;
}

int listener_open_unix(struct listener *l, uv_loop_t *loop, const char *path,
                       void (*incoming)(void *ctx, struct listener *l), void *ctx,
                       struct fault *fault)
{
    *l = (struct listener){.incoming = incoming, .ctx = ctx};
    int e = check_path(path, fault);
    if (e) return e;
    if (uv_pipe_init(loop, &l->handle.pipe, 0) < 0)
        return fault_set(fault, ERR_IO, path, "no socket can be made");
    l->is_open = true;
    l->handle.any.data = l;
    int status = uv_pipe_bind(&l->handle.pipe, path);
    if (status < 0) return give_up(fault, path, "cannot bind a socket there", status);
    /* No client can connect before the listen call, so rights are never wider. */
    if (chmod(path, S_IRUSR | S_IWUSR) != 0)
        return give_up(fault, path, "cannot make the socket private", -errno);
    return start(l, fault, path);
}

/* ---- TCP ---- */

union address {
    struct sockaddr any;
    struct sockaddr_in v4;
    struct sockaddr_in6 v6;
};

static int parse_host(const char *host, int port, union address *out)
{
    if (strcmp(host, "localhost") == 0) host = "127.0.0.1";
    if (uv_ip4_addr(host, port, &out->v4) == 0) return 0;
    return uv_ip6_addr(host, port, &out->v6) == 0 ? 0 : ERR_SYNTAX;
}

/* HOST:PORT with IPv6 in brackets. */
static int parse_address(const char *text, union address *out)
{
    char host[64];
    const char *colon = strrchr(text, ':');
    if (!colon || colon == text || colon[1] < '0' || colon[1] > '9') return ERR_SYNTAX;
    char *end = NULL;
    unsigned long port = strtoul(colon + 1, &end, 10);
    if (*end != '\0' || port > 65535) return ERR_RANGE;
    size_t length = (size_t)(colon - text);
    bool bracketed = text[0] == '[' && colon[-1] == ']';
    if (bracketed) {
        text++;
        length -= 2;
    }
    if (length >= sizeof host) return ERR_SYNTAX;
    memcpy(host, text, length);
    host[length] = '\0';
    if (!bracketed && strchr(host, ':')) return ERR_SYNTAX;
    return parse_host(host, (int)port, out);
}

static bool is_loopback(const union address *a)
{
    if (a->any.sa_family == AF_INET) return ntohl(a->v4.sin_addr.s_addr) >> 24 == 127;
    return IN6_IS_ADDR_LOOPBACK(&a->v6.sin6_addr);
}

static int bound_port(const uv_tcp_t *tcp)
{
    union {
        union address address;
        struct sockaddr_storage room;
    } name;
    int bytes = sizeof name;
    if (uv_tcp_getsockname(tcp, (struct sockaddr *)&name, &bytes) < 0) return 0;
    return ntohs(name.address.any.sa_family == AF_INET ? name.address.v4.sin_port
                                                       : name.address.v6.sin6_port);
}

int listener_open_tcp(struct listener *l, uv_loop_t *loop, const char *address, bool keyed,
                      void (*incoming)(void *ctx, struct listener *l), void *ctx,
                      struct fault *fault)
{
    union address a;
    *l = (struct listener){.incoming = incoming, .ctx = ctx, .tcp = true};
    if (parse_address(address, &a) != 0)
        return fault_set(fault, ERR_SYNTAX, address,
                         "expected ADDRESS:PORT with a numeric address, such as 127.0.0.1:7000");
    if (!keyed && !is_loopback(&a))
        return fault_set(fault, ERR_UNSUPPORTED, address,
                         "without --worker-key worker links are neither encrypted nor "
                         "authenticated: only loopback addresses are allowed");
    if (uv_tcp_init(loop, &l->handle.tcp) < 0)
        return fault_set(fault, ERR_IO, address, "no socket can be made");
    l->is_open = true;
    l->handle.any.data = l;
    int status = uv_tcp_bind(&l->handle.tcp, &a.any, 0);
    if (status < 0) return give_up(fault, address, "cannot bind that address", status);
    int e = start(l, fault, address);
    if (e == 0) l->port = bound_port(&l->handle.tcp);
    return e;
}

bool listener_close(struct listener *l, void (*closed)(uv_handle_t *handle))
{
    if (!l->is_open) return false;
    l->is_open = false;
    uv_close(&l->handle.any, closed);
    return true;
}
