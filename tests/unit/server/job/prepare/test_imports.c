/* Imports: one run for all who ask for a scene, none for what the store remembers, none that nobody
 * waits for, and none lost for want of memory. A shell script is the importer. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/job/prepare/imports.h"
#include "tests/unit/server/job/prepare/import_case.h"
#include "tests/unit/server/lean_memory.h"
#include "tests/unit/unit.h"

struct bench {
    uv_loop_t loop;
    struct thread_pool *pool;
    struct objects objects;
    struct job_store *store;
    struct import_options options;
    struct imports *imports;
    char dir[64], program[96], runs[96];
    struct job scene;
    struct import_times times;
};

/* What became of a request. */
struct answer {
    unsigned told;
    int code;
    struct digest blob;
    uint64_t cpu_us;
};

/* A run leaves a byte. */
static void importer_does(struct bench *b, const char *script)
{
    char text[256];
    snprintf(text, sizeof text, "printf x >> %s\n%s", b->runs, script);
    import_case_write(b->program, text);
}

#define COPIES                                                                                     \
    "(cat \"$root/$name\"; printf blob) > \"$blob\"\necho '{\"ok\": true, \"cpu_s\": 1.5}'"

static int set_up(void **state)
{
    struct bench *b = calloc(1, sizeof *b);
    *state = b;
    strcpy(b->dir, "/tmp/shearwater-imports-XXXXXX");
    if (!mkdtemp(b->dir) || objects_open(&b->objects, b->dir, false) || uv_loop_init(&b->loop) ||
        thread_pool_create(&b->loop, "test", 2, NULL, &b->pool) ||
        job_store_open(&b->loop, b->dir, false, &b->store))
        return -1;
    snprintf(b->program, sizeof b->program, "%s/importer", b->dir);
    snprintf(b->runs, sizeof b->runs, "%s/runs", b->dir);
    import_case_put(&b->objects, "{\"a\": 1}", &b->scene.scene);
    b->scene.files = calloc(1, sizeof *b->scene.files);
    b->scene.file_count = 1;
    b->scene.files[0].path = strdup("mesh.bin");
    import_case_put(&b->objects, "mesh", &b->scene.files[0].asset);
    b->options = (struct import_options){.loop = &b->loop,
                                         .pool = b->pool,
                                         .objects = &b->objects,
                                         .program = b->program,
                                         .limit_ms = 60000};
    importer_does(b, COPIES);
    return imports_create(&b->options, b->store, &b->imports);
}

static void settle(struct bench *b)
{
    uv_run(&b->loop, UV_RUN_DEFAULT);
}

static int tear_down(void **state)
{
    struct bench *b = *state;
    imports_stop(b->imports);
    job_store_close(&b->store);
    thread_pool_destroy(&b->pool);
    settle(b);
    imports_destroy(&b->imports);
    const int error = uv_loop_close(&b->loop);
    job_fini(&b->scene);
    objects_remove_dir(b->dir);
    free(b);
    return error;
}

EACH_TEST(set_up, tear_down);

static void on_done(void *ctx, const struct fault *fault, const struct digest *blob,
                    uint64_t cpu_us)
{
    struct answer *answer = ctx;
    answer->told++;
    answer->code = fault ? fault->code : 0;
    answer->cpu_us = cpu_us;
    if (!fault) answer->blob = *blob;
}

static struct import_request *ask(struct bench *b, struct answer *answer)
{
    struct import_request *request = NULL;
    *answer = (struct answer){0};
    assert_int_equal(imports_request(b->imports, &b->scene, &b->times, on_done, answer, &request),
                     0);
    assert_non_null(request);
    assert_int_equal(answer->told, 0); /* later, never at once */
    return request;
}

static long runs_of(const struct bench *b)
{
    struct stat st;
    return stat(b->runs, &st) ? 0 : (long)st.st_size;
}

static void expect_blob(const struct bench *b, const struct answer *answer)
{
    struct digest expected;
    digest_of("{\"a\": 1}blob", 12, &expected);
    assert_int_equal(answer->told, 1);
    assert_int_equal(answer->code, 0);
    assert_true(digest_equal(&answer->blob, &expected));
    assert_true(objects_have(&b->objects, &expected, NULL));
}

/* Nothing holds what is on record, or never will be. */
static void expect_no_hold(const struct bench *b)
{
    for (unsigned i = 0; i < OBJECT_STRIPES; i++)
        assert_false(objects_is_held(&b->objects, &(struct digest){{(uint8_t)i}}));
}

#define FRAMES                                                                                     \
    "printf base > $blob; printf zero > $blob.0; printf one > $blob.1\n"                           \
    "echo '{\"ok\": true, \"frames\": 2}'"

static void expect_text(const struct answer *answer, const char *text)
{
    struct digest expected;
    digest_of(text, strlen(text), &expected);
    assert_int_equal(answer->told, 1);
    assert_int_equal(answer->code, 0);
    assert_true(digest_equal(&answer->blob, &expected));
}

/* A run makes later frames on the way: they are found when they are asked for. */
TEST(frames_of_one_run_are_remembered)
{
    struct bench *b = *state;
    struct answer answer;
    importer_does(b, FRAMES);
    b->times = (struct import_times){3, {0, 1, 2}};
    ask(b, &answer);
    settle(b);
    expect_text(&answer, "zero");
    b->times = (struct import_times){2, {1, 2}};
    b->scene.time_s = 1;
    ask(b, &answer);
    settle(b);
    expect_text(&answer, "one");
    assert_int_equal(runs_of(b), 1);
    b->scene.stands = true; /* one that stands is another */
    b->times.count = 0;
    importer_does(b, COPIES);
    ask(b, &answer);
    settle(b);
    expect_blob(b, &answer);
    assert_int_equal(runs_of(b), 2);
}

TEST(one_run_is_for_all_who_ask)
{
    struct bench *b = *state;
    struct answer answers[3];
    for (unsigned i = 0; i < 3; i++) ask(b, &answers[i]);
    settle(b);
    for (unsigned i = 0; i < 3; i++) expect_blob(b, &answers[i]);
    assert_int_equal(runs_of(b), 1);
    assert_int_equal(answers[0].cpu_us, 1500000); /* charged once */
    assert_int_equal(answers[1].cpu_us + answers[2].cpu_us, 0);
    expect_no_hold(b);
}

TEST(what_was_imported_is_remembered)
{
    struct bench *b = *state;
    struct answer first, second;
    ask(b, &first);
    settle(b);
    ask(b, &second);
    settle(b);
    expect_blob(b, &second);
    assert_int_equal(second.cpu_us, 0);
    assert_int_equal(runs_of(b), 1);
    char path[OBJECTS_PATH_BYTES];
    objects_path(&b->objects, &first.blob, path);
    assert_int_equal(unlink(path), 0); /* a memory of what is gone is none */
    ask(b, &second);
    settle(b);
    expect_blob(b, &second);
    assert_int_equal(runs_of(b), 2);
}

TEST(other_files_are_another_scene)
{
    struct bench *b = *state;
    struct answer first, second;
    ask(b, &first);
    b->scene.files[0].path[0] = 'M';
    ask(b, &second);
    settle(b);
    expect_blob(b, &first);
    expect_blob(b, &second);
    assert_int_equal(runs_of(b), 2);
}

TEST(a_failure_is_told_to_all_and_not_remembered)
{
    struct bench *b = *state;
    struct answer answers[2];
    importer_does(b, "exit 3");
    for (unsigned i = 0; i < 2; i++) ask(b, &answers[i]);
    settle(b);
    for (unsigned i = 0; i < 2; i++) {
        assert_int_equal(answers[i].told, 1);
        assert_int_not_equal(answers[i].code, 0);
    }
    importer_does(b, COPIES);
    ask(b, &answers[0]);
    settle(b);
    expect_blob(b, &answers[0]);
}

TEST(who_forgets_is_told_nothing)
{
    struct bench *b = *state;
    struct answer forgotten, kept;
    struct import_request *request = ask(b, &forgotten);
    ask(b, &kept);
    imports_forget(&request);
    assert_null(request);
    settle(b);
    expect_blob(b, &kept);
    assert_int_equal(forgotten.told, 0);
}

/* What waits until the importer runs, and then forgets it. */
struct forgetting {
    uv_timer_t timer;
    const struct bench *bench;
    struct import_request *request;
};

static void forget_when_it_runs(uv_timer_t *timer)
{
    struct forgetting *f = (struct forgetting *)timer;
    if (runs_of(f->bench) == 0) return;
    imports_forget(&f->request);
    uv_close((uv_handle_t *)timer, NULL);
}

/* It would take a minute. */
TEST(what_nobody_waits_for_is_killed)
{
    struct bench *b = *state;
    struct answer answer;
    struct forgetting forgetting = {.bench = b};
    importer_does(b, "exec sleep 50");
    forgetting.request = ask(b, &answer);
    uv_timer_init(&b->loop, &forgetting.timer);
    uv_timer_start(&forgetting.timer, forget_when_it_runs, 10, 10);
    const uint64_t begin_ns = uv_hrtime();
    settle(b);
    assert_true(uv_hrtime() - begin_ns < 40ull * 1000000000);
    assert_int_equal(answer.told, 0);
    assert_null(forgetting.request);
    importer_does(b, COPIES);
    ask(b, &answer);
    settle(b);
    expect_blob(b, &answer);
    expect_no_hold(b);
}

/* Whichever piece is missing as it is asked for: nothing has begun, and nobody is told. */
TEST(without_memory_it_is_refused)
{
    struct bench *b = *state;
    unsigned k = 0;
    bool came;
    do {
        struct answer answer = {0};
        struct import_request *request = NULL;
        until_lack = ++k;
        const int error =
            imports_request(b->imports, &b->scene, &b->times, on_done, &answer, &request);
        came = until_lack == 0;
        until_lack = 0;
        settle(b);
        assert_int_equal(error, came ? ERR_MEMORY : 0);
        assert_int_equal(answer.told, error == 0);
        if (error)
            assert_null(request);
        else
            expect_blob(b, &answer);
    } while (came);
    assert_in_range(k, 6, 50);
    assert_int_equal(runs_of(b), 1);
    expect_no_hold(b);
}

/* Whichever piece of the loop's thread is missing later: who asked is told, once, of the blob or of
 * missing memory; nothing stays held, and the next who asks has it. */
TEST(without_memory_on_the_way_who_asked_is_told)
{
    struct bench *b = *state;
    unsigned k = 0, failed = 0;
    bool came;
    do {
        struct answer answer;
        ask(b, &answer);
        until_lack = ++k;
        settle(b);
        came = until_lack == 0;
        until_lack = 0;
        assert_int_equal(answer.told, 1);
        if (answer.code) {
            assert_int_equal(answer.code, ERR_MEMORY);
            failed++;
        } else {
            expect_blob(b, &answer);
        }
        expect_no_hold(b);
        ask(b, &answer);
        settle(b);
        expect_blob(b, &answer);
        b->scene.files[0].path[0] = (char)('A' + k / 26); /* another scene: nobody remembers it */
        b->scene.files[0].path[1] = (char)('A' + k % 26);
    } while (came);
    assert_in_range(k, 4, 100);
    assert_in_range(failed, 1, k);
}

/* ... and who asked before is not touched by it. */
TEST(a_refusal_leaves_the_others)
{
    struct bench *b = *state;
    struct answer answer, other = {0};
    struct import_request *request = NULL;
    ask(b, &answer);
    until_lack = 1;
    assert_int_equal(imports_request(b->imports, &b->scene, &b->times, on_done, &other, &request),
                     ERR_MEMORY);
    assert_int_equal(until_lack, 0);
    settle(b);
    expect_blob(b, &answer);
    assert_int_equal(other.told, 0);
}
