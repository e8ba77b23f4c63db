/* What a worker's session starts from: options, the coordinator's address, the waits between tries
 * to reach it, Embree. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/unit/unit.h"
#include "worker/link/link.h"
#include "worker/process/options.h"
#include "worker/process/worker_name.h"
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
    static char *const wrong[][2] = {{"--threads", "0"},         {"--threads", "1025"},
                                     {"--threads", "2x"},        {"--threads", "-1"},
                                     {"--cache-bytes", "1T"},    {"--tiles-in-hand", "257"},
                                     {"--name", NULL},           {"--idle-exit", "0"},
                                     {"--lifetime", "31622401"}, {"--connect-within", "5m"},
                                     {"--nonsense", "1"},        {"--log-format", "xml"},
                                     {"--pack", "tight"},        {"--cache-bytes", "99999999999G"}};
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

static const char *const engine_variables[] = {
    "SLURM_JOB_ID", "SLURM_ARRAY_JOB_ID", "SLURM_ARRAY_TASK_ID",     "SLURM_PROCID",
    "POD_NAME",     "HOSTNAME",           "KUBERNETES_SERVICE_HOST",
};

/* Sets up to three variables of an engine, and no other one. */
static void in_engine(const char *const set[3][2])
{
    for (size_t i = 0; i < sizeof engine_variables / sizeof engine_variables[0]; i++)
        unsetenv(engine_variables[i]);
    for (size_t i = 0; i < 3; i++)
        if (set[i][0]) setenv(set[i][0], set[i][1], 1);
}

TEST(names_come_from_the_engine)
{
    static const struct {
        const char *set[3][2], *tail; /* no tail: the process id */
    } cases[] = {
        {{{NULL}}, NULL},
        {{{"SLURM_JOB_ID", "77"}}, ":slurm-77"},
        {{{"SLURM_JOB_ID", "78"}, {"SLURM_ARRAY_JOB_ID", "77"}, {"SLURM_ARRAY_TASK_ID", "3"}},
         ":slurm-77_3"},
        {{{"SLURM_JOB_ID", "77"}, {"SLURM_PROCID", "0"}}, ":slurm-77"},
        {{{"SLURM_JOB_ID", "77"}, {"SLURM_PROCID", "2"}}, ":slurm-77.2"},
        {{{"POD_NAME", "worker-5d9-x2"}}, "worker-5d9-x2"},
        {{{"HOSTNAME", "worker-5d9-x3"}, {"KUBERNETES_SERVICE_HOST", "10.0.0.1"}}, "worker-5d9-x3"},
        {{{"HOSTNAME", "elsewhere"}}, NULL},
        {{{"SLURM_JOB_ID", "77\n78"}}, NULL},
        {{{"POD_NAME", ""}}, NULL},
    };
    char name[LIMIT_NAME_BYTES], pid[32];
    snprintf(pid, sizeof pid, ":%ld", (long)getpid());
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        in_engine(cases[i].set);
        const char *tail = cases[i].tail ? cases[i].tail : pid;
        assert_int_equal(worker_name_default(name, sizeof name), 0);
        assert_true(strlen(name) >= strlen(tail));
        assert_string_equal(name + strlen(name) - strlen(tail), tail);
    }
}

TEST(an_engines_word_of_10_kB_is_passed_over)
{
    char word[10001], name[LIMIT_NAME_BYTES];
    memset(word, 'a', 10000);
    word[10000] = '\0';
    in_engine((const char *const[3][2]){{"SLURM_JOB_ID", word}, {"POD_NAME", word}});
    assert_int_equal(worker_name_default(name, sizeof name), 0);
    assert_null(strstr(name, "aaaaaaaa"));
    /* The longest that are taken fit together. */
    word[80] = '\0';
    in_engine((const char *const[3][2]){
        {"SLURM_JOB_ID", word}, {"SLURM_ARRAY_JOB_ID", word}, {"SLURM_ARRAY_TASK_ID", "7"}});
    assert_int_equal(worker_name_default(name, sizeof name), 0);
    assert_non_null(strstr(name, "aaaaaaaa_7"));
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
