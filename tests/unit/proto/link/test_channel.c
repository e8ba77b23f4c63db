/* Sealed links: only two with one key come together, and nothing but their own bytes comes through.
 */
#include <stdlib.h>
#include <string.h>

#include "proto/link/channel.h"
#include "tests/unit/unit.h"

#define TURNS 4

static const struct link_key key = {{1, 2, 3}}, other = {{1, 2, 4}};

/* Carries what one has to send to the other; flips a bit of its byte `flip` unless that is beyond.
 */
static size_t carry(struct channel *from, struct channel *to, size_t flip)
{
    size_t n = 0;
    uint8_t *data = channel_take(from, &n);
    if (flip < n) data[flip] ^= 0x10;
    if (data) assert_int_equal(channel_feed(to, data, n), 0);
    free(data);
    return n;
}

static void meet(struct channel *server, struct channel *client, int *server_end, int *client_end)
{
    uint8_t nothing[8];
    size_t n;
    for (int i = 0; i < TURNS; i++) {
        *client_end = channel_read(client, nothing, sizeof nothing, &n);
        carry(client, server, SIZE_MAX);
        *server_end = channel_read(server, nothing, sizeof nothing, &n);
        carry(server, client, SIZE_MAX);
        if (*server_end != ERR_INCOMPLETE) return;
    }
}

static void make(struct channel **server, struct channel **client, const struct link_key *theirs)
{
    assert_int_equal(channel_create(true, &key, server), 0);
    assert_int_equal(channel_create(false, theirs, client), 0);
}

TEST(one_key_carries_bytes_both_ways)
{
    static uint8_t sent[300000], got[sizeof sent];
    struct channel *server, *client;
    int a, b;
    size_t n, all = 0;
    make(&server, &client, &key);
    assert_int_equal(channel_write(client, sent, 1), ERR_STATE);
    meet(server, client, &a, &b);
    assert_true(channel_is_up(server) && channel_is_up(client));
    for (size_t i = 0; i < sizeof sent; i++) sent[i] = (uint8_t)(i * 7 + i / 256);
    for (int way = 0; way < 2; way++) {
        struct channel *from = way ? server : client, *to = way ? client : server;
        assert_int_equal(channel_write(from, sent, sizeof sent), 0);
        assert_true(carry(from, to, SIZE_MAX) > sizeof sent);
        for (all = 0; channel_read(to, got + all, sizeof got - all, &n) == 0;) all += n;
        assert_int_equal(all, sizeof sent);
        assert_memory_equal(sent, got, sizeof sent);
    }
    channel_destroy(&server);
    channel_destroy(&client);
}

TEST(another_key_is_refused)
{
    struct channel *server, *client;
    int a, b;
    make(&server, &client, &other);
    meet(server, client, &a, &b);
    assert_int_equal(a, ERR_STATE);
    assert_false(channel_is_up(server) || channel_is_up(client));
    channel_destroy(&server);
    channel_destroy(&client);
}

TEST(a_flipped_bit_is_found)
{
    uint8_t text[100] = {0};
    size_t n;
    for (size_t flip = 0; flip < 122; flip += 11) {
        struct channel *server, *client;
        int a, b;
        make(&server, &client, &key);
        meet(server, client, &a, &b);
        assert_int_equal(channel_write(client, text, sizeof text), 0);
        assert_true(carry(client, server, flip) > flip);
        /* A length that has grown waits for more; the bytes themselves never come through. */
        const int e = channel_read(server, text, sizeof text, &n);
        assert_true(e == ERR_STATE || e == ERR_INCOMPLETE);
        assert_int_equal(n, 0);
        channel_destroy(&server);
        channel_destroy(&client);
    }
}

TEST(noise_is_refused)
{
    static uint8_t noise[70000];
    uint8_t out[8];
    size_t n;
    struct channel *server;
    for (size_t i = 0; i < sizeof noise; i++) noise[i] = (uint8_t)(i * 31);
    assert_int_equal(channel_create(true, &key, &server), 0);
    assert_int_equal(channel_feed(server, noise, 600), 0);
    assert_int_equal(channel_read(server, out, sizeof out, &n), ERR_STATE);
    channel_destroy(&server);
    assert_int_equal(channel_create(true, &key, &server), 0);
    assert_int_equal(channel_feed(server, noise, sizeof noise), ERR_LIMIT);
    channel_destroy(&server);
}
