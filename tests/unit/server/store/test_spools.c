/* Spools of frames on disk: what is asked for is done in order, and what was removed is gone, also
 * where memory is missing. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "server/store/objects.h"
#include "server/store/spools.h"
#include "tests/unit/server/lean_memory.h"
#include "tests/unit/unit.h"

#define PAYLOAD_BYTES 300u

static const char here[] = "01JOBHERE", elsewhere[] = "01JOBELSEWHERE";
static const struct digest fingerprint = {{1, 2, 3}};

struct bench {
    uv_loop_t loop;
    struct spools *spools;
    char dir[64];
};

static int set_up(void **state)
{
    struct bench *b = calloc(1, sizeof *b);
    *state = b;
    strcpy(b->dir, "/tmp/shearwater-spools-XXXXXX");
    return !mkdtemp(b->dir) || uv_loop_init(&b->loop) ||
           spools_create(&b->loop, b->dir, &b->spools);
}

static void settle(struct bench *b)
{
    uv_run(&b->loop, UV_RUN_DEFAULT);
}

static int tear_down(void **state)
{
    struct bench *b = *state;
    spools_destroy(&b->spools);
    settle(b);
    const int error = uv_loop_close(&b->loop);
    objects_remove_dir(b->dir);
    free(b);
    return error;
}

EACH_TEST(set_up, tear_down);

static void on_opened(void *ctx, struct spool *spool)
{
    *(struct spool **)ctx = spool;
}

static struct spool *open_one(struct bench *b, const char *job, int32_t frame)
{
    struct spool *spool = NULL;
    assert_int_equal(spool_open(b->spools, job, frame, &fingerprint, on_opened, &spool), 0);
    settle(b);
    assert_non_null(spool);
    return spool;
}

static void append(struct spool *spool, uint32_t tile)
{
    const struct spool_key key = {.tile = tile, .count = 16};
    uint8_t *back = malloc(PAYLOAD_BYTES);
    assert_non_null(back);
    memset(back, (int)tile, PAYLOAD_BYTES);
    spool_append(spool, &key, "head", 4, back, PAYLOAD_BYTES);
}

/* A frame's file with three results. */
static void fill(struct bench *b, const char *job, int32_t frame)
{
    struct spool *spool = open_one(b, job, frame);
    for (uint32_t tile = 0; tile < 3; tile++) append(spool, tile);
    spool_close(&spool);
    settle(b);
}

static bool is_there(const struct bench *b, const char *job, int32_t frame)
{
    char path[160];
    if (frame < 0)
        snprintf(path, sizeof path, "%s/spool/%s", b->dir, job);
    else
        snprintf(path, sizeof path, "%s/spool/%s/%d", b->dir, job, frame);
    return access(path, F_OK) == 0;
}

static struct spools_totals totals_of(const struct bench *b)
{
    struct spools_totals totals;
    spools_totals(b->spools, &totals);
    return totals;
}

static uint64_t bytes_of_files(uint64_t files)
{
    return files * (SPOOL_FILE_HEAD_BYTES + 3 * (SPOOL_RECORD_HEAD_BYTES + 4 + PAYLOAD_BYTES));
}

TEST(what_was_kept_is_there_again)
{
    struct bench *b = *state;
    uint8_t read[4 + PAYLOAD_BYTES];
    fill(b, here, 0);
    struct spool *spool = open_one(b, here, 0);
    assert_int_equal(spool_count(spool), 3);
    const struct spool_record *record =
        spool_find(spool, &(struct spool_key){.tile = 2, .count = 16});
    assert_non_null(record);
    assert_int_equal(record->payload_bytes, sizeof read);
    assert_int_equal(spool_read(spool, record, read), 0);
    assert_memory_equal(read, "head\2\2", 6);
    spool_close(&spool);
    settle(b);
    assert_int_equal(totals_of(b).kept, 3);
    assert_int_equal(totals_of(b).skipped, 0);
    assert_int_equal(totals_of(b).size_bytes, bytes_of_files(1));
}

TEST(a_frame_s_goes_alone_and_a_job_s_all)
{
    struct bench *b = *state;
    for (int32_t frame = 0; frame < 3; frame++) fill(b, here, frame);
    fill(b, elsewhere, 1);
    spools_remove(b->spools, here, 1);
    settle(b);
    assert_true(is_there(b, here, 0) && !is_there(b, here, 1) && is_there(b, here, 2));
    assert_int_equal(totals_of(b).size_bytes, bytes_of_files(3));
    spools_remove(b->spools, here, -1);
    settle(b);
    assert_false(is_there(b, here, -1));
    assert_true(is_there(b, elsewhere, 1));
    assert_int_equal(totals_of(b).size_bytes, bytes_of_files(1));
    spools_remove(b->spools, here, -1); /* what is not there is as good as removed */
    spools_remove(b->spools, here, 7);
    settle(b);
    assert_int_equal(totals_of(b).size_bytes, bytes_of_files(1));
}

/* Results that wait for the disk come before what removes them. */
TEST(removing_comes_after_what_was_asked_for_before)
{
    struct bench *b = *state;
    struct spool *spool = open_one(b, here, 0);
    for (uint32_t tile = 0; tile < 50; tile++) append(spool, tile);
    spool_close(&spool);
    spools_remove(b->spools, here, -1);
    settle(b);
    assert_false(is_there(b, here, -1));
    assert_int_equal(totals_of(b).kept, 50);
    assert_int_equal(totals_of(b).size_bytes, 0);
}

TEST(a_removal_needs_no_memory)
{
    struct bench *b = *state;
    for (int32_t frame = 0; frame < 3; frame++) fill(b, here, frame);
    for (int32_t frame = 0; frame < 3; frame++) { /* again and again: what it used comes back */
        until_lack = 1;
        spools_remove(b->spools, here, frame);
        assert_int_equal(until_lack, 0);
        settle(b);
        assert_false(is_there(b, here, frame));
    }
    assert_int_equal(totals_of(b).size_bytes, 0);
}

static bool is_elsewhere(void *ctx, const char *job)
{
    (void)ctx;
    return strcmp(job, elsewhere) == 0;
}

/* There is room for one; the next start, which sweeps, finds the second. */
TEST(a_second_one_meanwhile_is_left_to_the_sweep)
{
    struct bench *b = *state;
    fill(b, here, 0);
    fill(b, here, 1);
    fill(b, elsewhere, 0);
    for (int32_t frame = 0; frame < 2; frame++) {
        until_lack = 1;
        spools_remove(b->spools, here, frame);
        assert_int_equal(until_lack, 0);
    }
    settle(b);
    assert_false(is_there(b, here, 0));
    assert_true(is_there(b, here, 1));
    spools_sweep(b->spools, is_elsewhere, NULL);
    assert_false(is_there(b, here, -1));
    assert_true(is_there(b, elsewhere, 0));
}

TEST(without_memory_nothing_is_opened_or_kept)
{
    struct bench *b = *state;
    struct spool *none = NULL;
    until_lack = 1;
    assert_int_equal(spool_open(b->spools, here, 0, &fingerprint, on_opened, &none), ERR_MEMORY);
    struct spool *spool = open_one(b, here, 0);
    until_lack = 2; /* the first is the test's own */
    append(spool, 0);
    append(spool, 1);
    spool_close(&spool);
    settle(b);
    assert_int_equal(totals_of(b).kept, 1);
    assert_int_equal(totals_of(b).skipped, 1);
}
