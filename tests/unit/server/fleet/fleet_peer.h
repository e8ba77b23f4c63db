#pragma once
/* A fleet's peer, a scripted worker in the same thread: a nonblocking socket; waiting turns the
 * fleet's loop. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "proto/link/message.h"
#include "proto/link/wire_frame.h"
#include "proto/runtime/build.h"
#include "tests/unit/server/fleet/fleet_fixture.h"
#include "tests/unit/unit.h"

struct peer {
    struct world *world;
    int fd;
    struct wire_frame_inbox inbox;
    struct bytes_writer w;
};

static inline struct peer peer_open(struct world *w)
{
    struct peer p = {.world = w};
    struct sockaddr_un a = {.sun_family = AF_UNIX};
    memcpy(a.sun_path, w->socket_path, strlen(w->socket_path) + 1);
    p.fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(connect(p.fd, (struct sockaddr *)&a, sizeof a), 0);
    fcntl(p.fd, F_SETFL, O_NONBLOCK);
    wire_frame_inbox_init(&p.inbox, LIMIT_FRAME_BYTES);
    bytes_writer_init(&p.w);
    return p;
}

static inline void peer_close(struct peer *p)
{
    close(p->fd);
    wire_frame_inbox_fini(&p->inbox);
    bytes_writer_fini(&p->w);
}

/* False when the fleet closes the link while we write. */
static inline bool peer_send_raw(struct peer *p, const void *data, size_t size_bytes)
{
    const uint8_t *at = data;
    for (int waited = 0; size_bytes > 0 && waited < PATIENCE_MS; waited++) {
        ssize_t n = send(p->fd, at, size_bytes, MSG_NOSIGNAL);
        if (n < 0 && errno != EAGAIN) return false;
        if (n > 0) at += n, size_bytes -= (size_t)n;
        if (n < 0) turn(p->world);
    }
    return size_bytes == 0;
}

static inline bool peer_send(struct peer *p, uint16_t type, uint64_t id, const void *tail,
                             uint32_t tail_bytes)
{
    uint8_t header[WIRE_FRAME_HEADER_BYTES];
    assert_false(p->w.failed);
    wire_frame_header(header, type, id, p->w.data, (uint32_t)p->w.size_bytes, tail, tail_bytes);
    bool sent = peer_send_raw(p, header, sizeof header) &&
                peer_send_raw(p, p->w.data, p->w.size_bytes) && peer_send_raw(p, tail, tail_bytes);
    p->w.size_bytes = 0;
    return sent;
}

/* Reads what is there: false when the fleet closed the link. */
static inline bool peer_read(struct peer *p)
{
    size_t space_bytes = 0;
    uint8_t *space = wire_frame_inbox_space(&p->inbox, &space_bytes);
    ssize_t n = recv(p->fd, space, space_bytes, 0);
    if (n == 0 || (n < 0 && errno != EAGAIN)) return false;
    if (n > 0) wire_frame_inbox_filled(&p->inbox, (size_t)n);
    return true;
}

static inline void peer_expect(struct peer *p, uint16_t type, struct wire_frame_view *f)
{
    for (int waited = 0; waited < PATIENCE_MS; waited++) {
        int e = wire_frame_inbox_next(&p->inbox, f);
        if (e == 0) {
            if (f->type != type)
                fail_msg("%s, expected %s", message_name(f->type), message_name(type));
            return;
        }
        assert_int_equal(e, ERR_INCOMPLETE);
        turn(p->world);
        if (!peer_read(p)) fail_msg("closed, expected %s", message_name(type));
    }
    fail_msg("nothing, expected %s", message_name(type));
}

static inline void peer_expect_nothing(struct peer *p)
{
    struct wire_frame_view f;
    for (int i = 0; i < 40; i++) {
        turn(p->world);
        assert_true(peer_read(p));
    }
    assert_int_equal(wire_frame_inbox_next(&p->inbox, &f), ERR_INCOMPLETE);
}

static inline int peer_expect_close(struct peer *p)
{
    for (int waited = 0; waited < 2 * PATIENCE_MS; waited++) {
        turn(p->world);
        if (!peer_read(p)) return waited;
    }
    fail_msg("not closed");
    return 0;
}

static inline void fill_hello(struct message_hello *m)
{
    *m = (struct message_hello){.protocol_version = PROTOCOL_VERSION,
                                .capabilities = CAPABILITY_DIRECT,
                                .embree_version = "3.13.5",
                                .name = "peer",
                                .threads = 2,
                                .pid = 1};
    snprintf(m->build_id, sizeof m->build_id, "%s", build_id());
    snprintf(m->isa, sizeof m->isa, "%s", build_isa());
}

static inline void peer_hello(struct peer *p)
{
    struct message_hello m;
    fill_hello(&m);
    message_encode_hello(&p->w, &m);
    assert_true(peer_send(p, MESSAGE_HELLO, 1, NULL, 0));
}

static inline uint64_t peer_join(struct peer *p)
{
    struct wire_frame_view f;
    struct message_welcome m;
    peer_hello(p);
    peer_expect(p, MESSAGE_WELCOME, &f);
    assert_int_equal(message_decode_welcome(f.payload, f.payload_bytes, &m), 0);
    assert_int_equal(m.beat_ms, 50);
    return m.worker_id;
}

static inline void peer_want(struct peer *p, uint32_t tiles)
{
    message_encode_want(&p->w, &(struct message_want){.tiles = tiles});
    assert_true(peer_send(p, MESSAGE_WANT, 2, NULL, 0));
}

static inline void peer_tile(struct peer *p, struct message_tile *m)
{
    struct wire_frame_view f;
    peer_expect(p, MESSAGE_TILE, &f);
    assert_int_equal(message_decode_tile(f.payload, f.payload_bytes, m), 0);
}

/* Joins a fleet that has some tiles, wants some of them, and takes the plan and the first. */
static inline void peer_start(struct peer *p, uint32_t tiles, uint32_t wanted,
                              struct message_tile *first)
{
    struct wire_frame_view f;
    peer_join(p);
    p->world->tiles = tiles;
    peer_want(p, wanted);
    peer_expect(p, MESSAGE_FRAME, &f);
    peer_tile(p, first);
}

static inline bool peer_result(struct peer *p, const struct message_tile *tile, uint32_t size_bytes)
{
    uint8_t *samples = malloc(size_bytes + 1);
    memset(samples, 0xab, size_bytes + 1);
    const struct message_result m = {.frame_id = tile->frame_id,
                                     .index = tile->index,
                                     .generation = tile->generation,
                                     .samples_bytes = size_bytes};
    message_encode_result(&p->w, &m);
    bool sent = peer_send(p, MESSAGE_RESULT, 99, samples, size_bytes);
    free(samples);
    return sent;
}

static inline uint32_t peer_verdict(struct peer *p)
{
    struct wire_frame_view f;
    struct message_ack m;
    peer_expect(p, MESSAGE_ACK, &f);
    assert_int_equal(message_decode_ack(f.payload, f.payload_bytes, &m), 0);
    return m.verdict;
}

static inline bool peer_beat(struct peer *p, uint64_t progress)
{
    message_encode_beat(&p->w, &(struct message_beat){.progress = progress,
                                                      .phase = BEAT_TRACING,
                                                      .peak_rss_bytes = 4096});
    return peer_send(p, MESSAGE_BEAT, 3, NULL, 0);
}

static inline void peer_expect_refusal(struct peer *p, const char *says)
{
    struct wire_frame_view f;
    struct message_refused m;
    peer_expect(p, MESSAGE_REFUSED, &f);
    assert_int_equal(message_decode_refused(f.payload, f.payload_bytes, &m), 0);
    if (!strstr(m.text, says)) fail_msg("\"%s\" does not say \"%s\"", m.text, says);
    peer_expect_close(p);
}
