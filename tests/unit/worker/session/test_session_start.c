/* What a worker's session starts from: options, the coordinator's address, the waits between tries
 * to reach it, Embree. */
#include "tests/unit/unit.h"
#include "worker/link/link.h"
#include "worker/process/options.h"
#include "worker/session/session.h"

TEST(options_are_checked)
{
    struct options o;
    struct fault fault = {0};
    char *good[] = {"worker", "--connect", "unix:/x", "--threads", "3", "--cache-bytes", "2G"};
    assert_int_equal(options_read(7, good, &o, &fault), 0);
    assert_int_equal(o.threads, 3);
    assert_int_equal(o.tiles_in_hand, 6);
    assert_int_equal(o.cache_bytes, 2ull << 30);
    static char *const wrong[][2] = {{"--threads", "0"},
                                     {"--threads", "1025"},
                                     {"--threads", "2x"},
                                     {"--threads", "-1"},
                                     {"--cache-bytes", "1T"},
                                     {"--tiles-in-hand", "257"},
                                     {"--name", NULL},
                                     {"--nonsense", "1"},
                                     {"--log-format", "xml"},
                                     {"--pack", "tight"},
                                     {"--cache-bytes", "99999999999G"}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        char *argv[] = {"worker", "--connect", "unix:/x", wrong[i][0], wrong[i][1]};
        assert_true(options_read(wrong[i][1] ? 5 : 4, argv, &o, &fault) < 0);
        assert_string_equal(fault.pointer, wrong[i][0]);
    }
    assert_int_equal(options_read(1, good, &o, &fault), ERR_MISSING);
}

TEST(samples_are_packed_for_their_way)
{
    static const struct {
        const char *address, *pack;
        enum packing packing;
    } ways[] = {
        {"unix:/x", NULL, PACKING_QUICK},          {"127.0.0.1:7", NULL, PACKING_QUICK},
        {"localhost:7", NULL, PACKING_QUICK},      {"[::1]:7", NULL, PACKING_QUICK},
        {"10.0.0.5:7", NULL, PACKING_SMALL},       {"farm.example:7", NULL, PACKING_SMALL},
        {"localhost.farm:7", NULL, PACKING_SMALL}, {"[fe80::1]:7", NULL, PACKING_SMALL},
        {"unix:/x", "small", PACKING_SMALL},       {"farm.example:7", "quick", PACKING_QUICK}};
    struct options o;
    struct fault fault = {0};
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; i++) {
        char *argv[] = {"worker", "--connect", (char *)(uintptr_t)ways[i].address, "--pack",
                        (char *)(uintptr_t)ways[i].pack};
        assert_int_equal(options_read(ways[i].pack ? 5 : 3, argv, &o, &fault), 0);
        assert_int_equal(o.packing, ways[i].packing);
    }
}

TEST(addresses_are_checked)
{
    static const char *const wrong[] = {"unix:",  "host",       "host:", ":7",
                                        "host:0", "host:70000", "a:b:7", "host:7x"};
    uv_loop_t loop;
    uv_loop_init(&loop);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        const struct link_client client = {0};
        struct link *link = NULL;
        struct fault fault = {0};
        assert_true(link_create(&loop, wrong[i], NULL, &client, &link, &fault) < 0);
        assert_string_equal(fault.pointer, wrong[i]);
    }
    assert_int_equal(uv_loop_close(&loop), 0);
}

TEST(waits_double_up_to_five_seconds)
{
    static const uint32_t waits[] = {100, 200, 400, 800, 1600, 3200, 5000, 5000};
    for (unsigned i = 0; i < sizeof waits / sizeof waits[0]; i++)
        assert_int_equal(link_wait_ms(i), waits[i]);
    assert_int_equal(link_wait_ms(UINT32_MAX), 5000);
}

static const char *no_version(void *ctx)
{
    (void)ctx;
    return NULL;
}

TEST(without_embree_there_is_no_worker)
{
    uv_loop_t loop;
    struct session *session = NULL;
    struct fault fault = {0};
    const struct options options = {.connect = "unix:/nowhere", .threads = 1, .cache_dir = "/tmp"};
    const struct session_client client = {0};
    const struct tracing broken = {.embree_version = no_version};
    uv_loop_init(&loop);
    assert_int_equal(session_create(&loop, &options, &broken, &client, &session, &fault),
                     ERR_MEMORY);
    assert_string_equal(fault.pointer, "embree");
    assert_null(session);
    assert_int_equal(uv_loop_close(&loop), 0);
}
