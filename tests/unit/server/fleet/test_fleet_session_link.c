/* Links to a fleet: where it listens, which workers it refuses, and what ends a session. */
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "server/fleet/session.h"
#include "tests/unit/server/fleet/fleet_fixture.h"
#include "tests/unit/server/fleet/fleet_peer.h"
#include "tests/unit/unit.h"

ALL_TESTS(ignore_broken_pipes, NULL);

TEST(mismatches_are_refused_with_advice)
{
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer good = peer_open(w);
    peer_join(&good);
    for (int i = 0; i < 4; i++) {
        struct peer p = peer_open(w);
        struct message_hello m;
        fill_hello(&m);
        if (i == 0) snprintf(m.build_id, sizeof m.build_id, "0.0.1+other");
        if (i == 1) m.protocol_version = 77;
        if (i == 2) snprintf(m.isa, sizeof m.isa, "%s", strcmp(m.isa, "avx2") ? "avx2" : "sse4.2");
        if (i == 3) snprintf(m.embree_version, sizeof m.embree_version, "3.12.0");
        message_encode_hello(&p.w, &m);
        assert_true(peer_send(&p, MESSAGE_HELLO, 1, NULL, 0));
        static const char *const says[] = {"install the same build on both machines",
                                           "install the same build",
                                           "SHEARWATER_ISA=", "install the same Embree"};
        peer_expect_refusal(&p, says[i]);
        peer_close(&p);
    }
    assert_int_equal(totals(w).refused, 4);
    assert_int_equal(fleet_count(w->fleet), 1);
    peer_close(&good);
    world_close(w);
}

/* A HELLO of another version, whatever follows the number. */
TEST(an_unknown_hello_is_refused)
{
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    bytes_write_u32(&p.w, 1234);
    bytes_write_u64(&p.w, 0x1122334455667788u);
    assert_true(peer_send(&p, MESSAGE_HELLO, 1, NULL, 0));
    peer_expect_refusal(&p, "protocol 1234");
    peer_close(&p);
    world_close(w);
}

/* Workers' own HELLOs have a name of a few words; those of others may hold what they like. */
static void send_named(struct peer *p, const char *name)
{
    struct message_hello m;
    fill_hello(&m);
    bytes_write_u32(&p->w, m.protocol_version);
    bytes_write_u32(&p->w, m.capabilities);
    bytes_write_string(&p->w, m.build_id);
    bytes_write_string(&p->w, m.embree_version);
    bytes_write_string(&p->w, m.isa);
    bytes_write_string(&p->w, name);
    bytes_write_u32(&p->w, m.threads);
    bytes_write_u64(&p->w, m.pid);
    peer_send(p, MESSAGE_HELLO, 1, NULL, 0);
}

static void expect_refusal_of(struct world *w, const char *name, const char *says)
{
    struct peer p = peer_open(w);
    send_named(&p, name);
    peer_expect_refusal(&p, says);
    peer_close(&p);
}

TEST(names_that_are_no_names_are_refused_with_advice)
{
    static char name[10001];
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer longest = peer_open(w);
    struct wire_frame_view f;
    memset(name, 'a', LIMIT_NAME_BYTES - 1);
    send_named(&longest, name);
    peer_expect(&longest, MESSAGE_WELCOME, &f);
    name[LIMIT_NAME_BYTES - 1] = 'a';
    expect_refusal_of(w, name, "a shorter --name");
    memset(name, 'a', 10000); /* more than any HELLO has */
    expect_refusal_of(w, name, "a shorter --name");
    expect_refusal_of(w, "two\nlines", "another --name");
    expect_refusal_of(w, "\xff\xfe", "another --name");
    assert_int_equal(totals(w).refused, 4);
    assert_int_equal(totals(w).corrupt, 0);
    assert_int_equal(fleet_count(w->fleet), 1);
    peer_close(&longest);
    world_close(w);
}

TEST(refusals_are_logged)
{
    char path[] = "/tmp/shearwater-test-refused-XXXXXX", line[1024] = "";
    struct log log = {.fd = mkstemp(path)};
    struct world *w = world_open_logged(LONG_MS, LONG_MS, &log);
    expect_refusal_of(w, "two\nlines", "another --name");
    world_close(w);
    assert_true(pread(log.fd, line, sizeof line - 1, 0) > 0);
    assert_non_null(strstr(line, "warning worker refused"));
    assert_non_null(strstr(line, "another --name"));
    close(log.fd);
    unlink(path);
}

TEST(out_of_state_and_damaged_messages_end_the_session)
{
    struct world *w = world_open(LONG_MS, LONG_MS);
    for (int i = 0; i < 6; i++) {
        struct peer p = peer_open(w);
        uint8_t big[LIMIT_HELLO_BYTES + 100] = {0};
        if (i >= 3) peer_join(&p);
        switch (i) {
        case 0: /* before HELLO */
            message_encode_want(&p.w, &(struct message_want){.tiles = 1});
            peer_send(&p, MESSAGE_WANT, 1, NULL, 0);
            break;
        case 1: /* no HELLO, and too large for one */
            peer_send_raw(&p, big, sizeof big);
            break;
        case 2:
            peer_send_raw(&p, "GET / HTTP/1.1\r\n\r\n", 18);
            break;
        case 3: /* twice */
            peer_hello(&p);
            break;
        case 4: /* a coordinator's message */
            message_encode_drain(&p.w, &(struct message_drain){0});
            peer_send(&p, MESSAGE_DRAIN, 1, NULL, 0);
            break;
        default: /* short */
            bytes_write_u8(&p.w, 1);
            peer_send(&p, MESSAGE_RESULT, 1, NULL, 0);
        }
        peer_expect_close(&p);
        peer_close(&p);
    }
    assert_int_equal(totals(w).corrupt, 6);
    assert_int_equal(fleet_count(w->fleet), 0);
    world_close(w);
}

TEST(silence_ends_a_session)
{
    struct world *w = world_open(200, LONG_MS);
    struct peer p = peer_open(w);
    struct wire_frame_view f;
    peer_join(&p);
    w->tiles = 1;
    peer_want(&p, 1);
    peer_expect(&p, MESSAGE_FRAME, &f);
    peer_expect_close(&p);
    assert_int_equal(w->returned, 1);
    assert_int_equal(w->why, FLEET_TAKEN_BACK);
    assert_int_equal(fleet_count(w->fleet), 0);
    peer_close(&p);
    world_close(w);
}

TEST(a_late_hello_is_not_awaited)
{
    struct world *w = world_open(LONG_MS, LONG_MS);
    struct peer p = peer_open(w);
    uint64_t before = uv_hrtime();
    peer_expect_close(&p);
    uint64_t ms = (uv_hrtime() - before) / 1000000u;
    assert_in_range(ms, SESSION_HELLO_MS - 200, SESSION_HELLO_MS + 2000);
    peer_close(&p);
    world_close(w);
}

TEST(refuses_to_listen_where_it_must_not)
{
    static const char *const wrong[] = {"0.0.0.0:0",       "192.168.1.1:80", "[::]:0", "127.0.0.1",
                                        "127.0.0.1:99999", "nowhere:7",      ":7"};
    uv_loop_t loop;
    uv_loop_init(&loop);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        const struct fleet_options options = {.listen = wrong[i]};
        struct fault fault = {0};
        struct fleet *fleet = NULL;
        assert_true(fleet_create(&loop, &options, &client_of_world, &fleet, &fault) < 0);
        assert_string_equal(fault.pointer, wrong[i]);
        assert_null(fleet);
        uv_run(&loop, UV_RUN_DEFAULT);
    }
    assert_int_equal(uv_loop_close(&loop), 0);
}

TEST(the_socket_is_private_and_replaces_a_dead_one)
{
    struct stat st;
    struct world *w = world_open(LONG_MS, LONG_MS);
    assert_int_equal(stat(w->socket_path, &st), 0);
    assert_int_equal(st.st_mode & 0777, 0600);
    assert_true(fleet_port(w->fleet) > 0);
    char path[100];
    snprintf(path, sizeof path, "%s", w->socket_path);
    const struct fleet_options options = {.socket_path = path};
    struct fault fault = {0};
    struct fleet *second = NULL;
    assert_int_equal(fleet_create(&w->loop, &options, &client_of_world, &second, &fault),
                     ERR_EXISTS);
    world_close(w);
    assert_int_not_equal(stat(path, &st), 0);
    /* A socket that its owner left behind. */
    make_socket_dir();
    struct sockaddr_un a = {.sun_family = AF_UNIX};
    memcpy(a.sun_path, path, strlen(path) + 1);
    int fd = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(bind(fd, (struct sockaddr *)&a, sizeof a), 0);
    close(fd);
    world_close(world_open_with(&options));
}
