/* The importer's supervisor against importers that work, refuse, crash, hang and babble: shell
 * scripts in its place. */
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/job/prepare/import_process.h"
#include "tests/unit/server/job/prepare/import_case.h"
#include "tests/unit/unit.h"

struct bench {
    uv_loop_t loop;
    struct thread_pool *pool;
    struct objects objects;
    char dir[64], program[96];
    struct job scene;
    struct import_process *process;
    unsigned told;
    struct fault fault; /* code 0: a blob came */
    struct digest blob;
    struct import_blobs blobs;
    struct import_times times;
    uint64_t cpu_us;
};

static int set_up(void **state)
{
    struct bench *b = calloc(1, sizeof *b);
    *state = b;
    strcpy(b->dir, "/tmp/shearwater-import-XXXXXX");
    if (!mkdtemp(b->dir) || objects_open(&b->objects, b->dir, false) || uv_loop_init(&b->loop) ||
        thread_pool_create(&b->loop, "test", 2, NULL, &b->pool))
        return -1;
    import_case_put(&b->objects, "{\"asset\": 1}", &b->scene.scene);
    b->scene.files = calloc(2, sizeof *b->scene.files);
    b->scene.file_count = 2;
    b->scene.files[0].path = strdup("textures/wood.png");
    b->scene.files[1].path = strdup("mesh.bin");
    import_case_put(&b->objects, "wood", &b->scene.files[0].asset);
    import_case_put(&b->objects, "mesh", &b->scene.files[1].asset);
    return 0;
}

static int remove_entry(const char *path, const struct stat *info, int kind, struct FTW *where)
{
    (void)info, (void)kind, (void)where;
    return remove(path);
}

static int tear_down(void **state)
{
    struct bench *b = *state;
    thread_pool_destroy(&b->pool);
    uv_run(&b->loop, UV_RUN_DEFAULT);
    int error = uv_loop_close(&b->loop);
    job_fini(&b->scene);
    nftw(b->dir, remove_entry, 8, FTW_DEPTH | FTW_PHYS);
    free(b);
    return error;
}

EACH_TEST(set_up, tear_down);

static void on_done(void *ctx, const struct fault *fault, const struct import_blobs *blobs,
                    uint64_t cpu_us)
{
    struct bench *b = ctx;
    b->told++;
    b->process = NULL;
    b->fault = fault ? *fault : (struct fault){0};
    b->blobs = *blobs;
    b->blob = blobs->list[0];
    b->cpu_us = cpu_us;
}

static void begin(struct bench *b, const char *script, uint64_t limit_ms)
{
    snprintf(b->program, sizeof b->program, "%s/importer", b->dir);
    import_case_write(b->program, script);
    struct import_options options = {.loop = &b->loop,
                                     .pool = b->pool,
                                     .objects = &b->objects,
                                     .program = b->program,
                                     .limit_ms = limit_ms};
    assert_int_equal(import_process_start(&options, &b->scene, &b->times, on_done, b, &b->process),
                     0);
}

static bool tmp_is_empty(const struct bench *b)
{
    char path[80];
    snprintf(path, sizeof path, "%s/tmp", b->dir);
    return rmdir(path) == 0 && mkdir(path, 0700) == 0;
}

static void run(struct bench *b, const char *script, uint64_t limit_ms)
{
    begin(b, script, limit_ms);
    uv_run(&b->loop, UV_RUN_DEFAULT);
    assert_int_equal(b->told, 1);
    assert_true(tmp_is_empty(b));
}

TEST(finds_its_files_and_keeps_the_blob)
{
    struct bench *b = *state;
    struct digest expected;
    run(b,
        "cat \"$root/$name\" \"$root/textures/wood.png\" \"$root/mesh.bin\" > \"$blob\"\n"
        "[ \"$name\" = scene.gltf ] && echo '{\"ok\": true, \"cpu_s\": 1.5}'",
        10000);
    assert_int_equal(b->fault.code, 0);
    digest_of("{\"asset\": 1}woodmesh", 20, &expected);
    assert_true(digest_equal(&b->blob, &expected));
    assert_true(objects_have(&b->objects, &expected, NULL));
    assert_int_equal(b->cpu_us, 1500000);
}

/* Whether a text was kept, as a blob that is held. */
static void expect_kept(const struct bench *b, const struct digest *blob, const char *text)
{
    struct digest expected;
    digest_of(text, strlen(text), &expected);
    assert_true(digest_equal(blob, &expected));
    assert_true(objects_have(&b->objects, blob, NULL) && objects_is_held(&b->objects, blob));
    objects_release(&b->objects, blob);
}

TEST(keeps_frames_and_what_they_stand_on)
{
    struct bench *b = *state;
    b->times = (struct import_times){3, {0, .5, -1}};
    run(b,
        "printf base > $blob; printf \"first $7 $8\" > $blob.0; printf second > $blob.1\n"
        "echo '{\"ok\": true, \"frames\": 2}'",
        10000);
    assert_int_equal(b->fault.code, 0);
    assert_int_equal(b->blobs.count, 2);
    expect_kept(b, &b->blobs.base, "base");
    expect_kept(b, &b->blobs.list[0], "first --times 0,0.5,-1");
    expect_kept(b, &b->blobs.list[1], "second");
}

TEST(frames_that_are_not_there_are_a_fault)
{
    struct bench *b = *state;
    b->times = (struct import_times){2, {0, 1}};
    run(b, "printf base > $blob; printf first > $blob.0\necho '{\"ok\": true, \"frames\": 2}'",
        10000);
    assert_int_not_equal(b->fault.code, 0);
    assert_int_equal(b->blobs.count, 0);
    for (int i = 0; i < 256; i++) /* nothing is held */
        assert_false(objects_is_held(&b->objects, &(struct digest){{(uint8_t)i}}));
}

TEST(says_what_the_importer_says)
{
    struct bench *b = *state;
    run(b,
        "echo '{\"ok\":false,\"code\":\"RANGE\",\"pointer\":\"meshes[3]\",\"detail\":\"-1 is "
        "negative\"}'\nexit 1",
        10000);
    assert_int_equal(b->fault.code, ERR_RANGE);
    assert_string_equal(b->fault.pointer, "/scene/asset");
    assert_string_equal(b->fault.detail, "meshes[3]: -1 is negative");
}

TEST(survives_a_crash)
{
    struct bench *b = *state;
    run(b, "kill -SEGV $$", 10000);
    assert_int_equal(b->fault.code, ERR_KILLED);
    assert_non_null(strstr(b->fault.detail, "signal 11"));
}

TEST(kills_what_hangs)
{
    struct bench *b = *state;
    run(b, "exec sleep 60", 300);
    assert_int_equal(b->fault.code, ERR_TIMEOUT);
}

TEST(cuts_off_what_babbles)
{
    struct bench *b = *state;
    run(b, "exec yes '{\"ok\": true}' 2>/dev/null", 2000);
    assert_int_not_equal(b->fault.code, 0);
}

TEST(distrusts_success_without_a_blob)
{
    struct bench *b = *state;
    run(b, "echo '{\"ok\": true}'", 10000);
    assert_int_not_equal(b->fault.code, 0);
}

TEST(needs_an_importer)
{
    struct bench *b = *state;
    begin(b, "exit 0", 10000);
    unlink(b->program);
    uv_run(&b->loop, UV_RUN_DEFAULT);
    assert_int_equal(b->told, 1);
    assert_int_equal(b->fault.code, ERR_UNSUPPORTED);
}

TEST(misses_an_asset)
{
    struct bench *b = *state;
    char path[OBJECTS_PATH_BYTES];
    objects_path(&b->objects, &b->scene.files[0].asset, path);
    unlink(path);
    run(b, "exit 0", 10000);
    assert_int_equal(b->fault.code, ERR_NOT_FOUND);
    assert_string_equal(b->fault.pointer, "/scene/files/textures/wood.png");
}

static void stop_soon(uv_timer_t *timer)
{
    struct bench *b = timer->data;
    import_process_cancel(&b->process);
    uv_close((uv_handle_t *)timer, NULL);
}

TEST(is_silent_when_cancelled)
{
    struct bench *b = *state;
    uv_timer_t timer;
    begin(b, "exec sleep 60", 60000);
    uv_timer_init(&b->loop, &timer);
    timer.data = b;
    uv_timer_start(&timer, stop_soon, 200, 0);
    uv_run(&b->loop, UV_RUN_DEFAULT);
    assert_int_equal(b->told, 0);
    assert_true(tmp_is_empty(b));
}
