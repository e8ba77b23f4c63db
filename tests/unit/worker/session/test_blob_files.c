/* The blob cache: what comes in is verified, stays bounded, and what is in use is not evicted. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "tests/unit/unit.h"
#include "worker/session/blob_files.h"

#define BLOB_BYTES 10000u

/* As NFS has it (flock(2)): an exclusive lock needs a file that may be written, a shared one a file
 * that may be read. It is this flock that the cache calls. */
int flock(int fd, int operation)
{
    const int access = fcntl(fd, F_GETFL) & O_ACCMODE, kind = operation & ~LOCK_NB;
    if ((kind == LOCK_EX && access == O_RDONLY) || (kind == LOCK_SH && access == O_WRONLY)) {
        errno = EBADF;
        return -1;
    }
    return (int)syscall(SYS_flock, fd, operation);
}

static char dir[64];

static struct blob_files open_files(uint64_t limit_bytes)
{
    struct blob_files c;
    struct fault fault = {0};
    if (blob_files_open(&c, dir, limit_bytes, &fault) != 0)
        fail_msg("%s: %s", fault.pointer, fault.detail);
    return c;
}

/* Blob number n: all of one byte. */
static void fill_blob(uint8_t n, uint8_t *data, struct digest *digest)
{
    memset(data, n, BLOB_BYTES);
    digest_of(data, BLOB_BYTES, digest);
}

static int fetch(const struct blob_files *c, uint8_t n, struct fault *fault)
{
    uint8_t data[BLOB_BYTES];
    struct digest digest;
    struct blob_fetch f;
    fill_blob(n, data, &digest);
    int e = blob_fetch_begin(c, &digest, &f, fault);
    if (e) return e;
    while (e == 0 && !blob_fetch_is_whole(&f)) {
        uint64_t left = BLOB_BYTES - f.have_bytes;
        uint32_t part = left < 4096 ? (uint32_t)left : 4096;
        e = blob_fetch_part(c, &f, BLOB_BYTES, f.have_bytes, data + f.have_bytes, part, fault);
    }
    if (e == 0) return blob_fetch_finish(c, &f, fault);
    blob_fetch_abort(&f);
    return e;
}

static bool has(const struct blob_files *c, uint8_t n)
{
    uint8_t data[BLOB_BYTES];
    char path[BLOB_FILES_PATH_BYTES];
    struct digest digest;
    struct blob_pin pin;
    fill_blob(n, data, &digest);
    if (blob_files_pin(c, &digest, &pin, path) != 0) return false;
    blob_files_unpin(&pin);
    return true;
}

/* The file system's clock is coarse: uses must differ in it. */
static void let_time_pass(void)
{
    usleep(12000);
}

/* A fetch of blob 1 that has begun. */
struct begun {
    struct blob_files c;
    struct fault fault;
    struct blob_fetch f;
    uint8_t data[BLOB_BYTES];
    struct digest digest;
};

static void begin(struct begun *b)
{
    b->c = open_files(1 << 20);
    b->fault = (struct fault){0};
    fill_blob(1, b->data, &b->digest);
    assert_int_equal(blob_fetch_begin(&b->c, &b->digest, &b->f, &b->fault), 0);
}

static int add_part(struct begun *b, uint64_t offset, uint32_t size_bytes)
{
    return blob_fetch_part(&b->c, &b->f, BLOB_BYTES, offset, b->data + offset, size_bytes,
                           &b->fault);
}

TEST(what_is_fetched_can_be_used)
{
    struct blob_files c = open_files(1 << 20);
    struct fault fault = {0};
    uint8_t data[BLOB_BYTES], found[BLOB_BYTES];
    char path[BLOB_FILES_PATH_BYTES];
    struct digest digest;
    struct blob_pin pin;
    assert_false(has(&c, 1));
    assert_int_equal(fetch(&c, 1, &fault), 0);
    fill_blob(1, data, &digest);
    assert_int_equal(blob_files_pin(&c, &digest, &pin, path), 0);
    FILE *file = fopen(path, "rb");
    assert_int_equal(fread(found, 1, BLOB_BYTES, file), BLOB_BYTES);
    fclose(file);
    assert_memory_equal(found, data, BLOB_BYTES);
    blob_files_unpin(&pin);
    assert_int_equal(blob_files_used_bytes(&c), BLOB_BYTES);
}

TEST(the_longest_unused_goes_first)
{
    struct blob_files c = open_files(3 * BLOB_BYTES);
    struct fault fault = {0};
    for (uint8_t n = 1; n <= 3; n++) {
        assert_int_equal(fetch(&c, n, &fault), 0);
        let_time_pass();
    }
    assert_true(has(&c, 1)); /* a use */
    let_time_pass();
    assert_int_equal(fetch(&c, 4, &fault), 0);
    assert_false(has(&c, 2));
    assert_true(has(&c, 1));
    assert_true(has(&c, 3));
    assert_true(has(&c, 4));
    assert_int_equal(blob_files_used_bytes(&c), 3 * BLOB_BYTES);
}

TEST(what_is_pinned_stays)
{
    struct blob_files c = open_files(2 * BLOB_BYTES);
    struct fault fault = {0};
    uint8_t data[BLOB_BYTES];
    char path[BLOB_FILES_PATH_BYTES];
    struct digest digest;
    struct blob_pin one, two;
    assert_int_equal(fetch(&c, 1, &fault), 0);
    assert_int_equal(fetch(&c, 2, &fault), 0);
    fill_blob(1, data, &digest);
    assert_int_equal(blob_files_pin(&c, &digest, &one, path), 0);
    assert_int_equal(fetch(&c, 3, &fault), 0); /* in place of 2 */
    fill_blob(3, data, &digest);
    assert_int_equal(blob_files_pin(&c, &digest, &two, path), 0);
    assert_int_equal(fetch(&c, 4, &fault), ERR_FULL);
    assert_non_null(strstr(fault.detail, "--cache-bytes"));
    blob_files_unpin(&one);
    assert_int_equal(fetch(&c, 4, &fault), 0);
    assert_true(has(&c, 3));
    assert_false(has(&c, 1));
    blob_files_unpin(&two);
}

TEST(a_blob_above_the_bound_is_refused)
{
    struct blob_files c = open_files(BLOB_BYTES - 1);
    struct fault fault = {0};
    assert_int_equal(fetch(&c, 1, &fault), ERR_FULL);
    assert_false(has(&c, 1));
}

TEST(damaged_bytes_are_not_kept)
{
    struct begun b;
    begin(&b);
    b.data[77] ^= 1;
    assert_int_equal(add_part(&b, 0, BLOB_BYTES), 0);
    assert_int_equal(blob_fetch_finish(&b.c, &b.f, &b.fault), ERR_CHECKSUM);
    assert_false(has(&b.c, 1));
    assert_int_equal(blob_files_used_bytes(&b.c), 0);
    assert_int_equal(fetch(&b.c, 1, &b.fault), 0); /* from the start */
}

TEST(parts_that_do_not_fit_are_refused)
{
    static const struct {
        uint64_t total_bytes, offset;
        uint32_t size_bytes;
        int error;
    } parts[] = {
        {LIMIT_BLOB_BYTES + 1, 0, 100, ERR_LIMIT},   {BLOB_BYTES, 0, 100, 0},
        {BLOB_BYTES, 50, 100, ERR_MISMATCH},         {BLOB_BYTES + 1, 100, 100, ERR_MISMATCH},
        {BLOB_BYTES, 100, BLOB_BYTES, ERR_MISMATCH}, {BLOB_BYTES, 100, 0, ERR_MISMATCH}};
    struct begun b;
    begin(&b);
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        assert_int_equal(blob_fetch_part(&b.c, &b.f, parts[i].total_bytes, parts[i].offset, b.data,
                                         parts[i].size_bytes, &b.fault),
                         parts[i].error);
    blob_fetch_abort(&b.f);
}

TEST(a_broken_transfer_is_taken_up)
{
    struct begun b;
    begin(&b);
    assert_int_equal(add_part(&b, 0, 4096), 0);
    blob_fetch_abort(&b.f);
    begin(&b); /* another process */
    assert_int_equal(b.f.have_bytes, 4096);
    assert_int_equal(add_part(&b, 4096, BLOB_BYTES - 4096), 0);
    assert_int_equal(blob_fetch_finish(&b.c, &b.f, &b.fault), 0);
    assert_true(has(&b.c, 1));
}

TEST(two_may_fetch_the_same)
{
    struct begun b;
    begin(&b);
    assert_int_equal(add_part(&b, 0, BLOB_BYTES), 0);
    assert_int_equal(fetch(&b.c, 1, &b.fault), 0);
    assert_true(has(&b.c, 1));
    assert_int_equal(blob_fetch_finish(&b.c, &b.f, &b.fault), 0);
    assert_true(has(&b.c, 1));
    assert_int_equal(blob_files_used_bytes(&b.c), BLOB_BYTES);
}

TEST(old_parts_are_swept)
{
    struct begun b;
    char old[BLOB_FILES_PATH_BYTES], lost[BLOB_FILES_PATH_BYTES + 8];
    begin(&b);
    assert_int_equal(add_part(&b, 0, 4096), 0);
    snprintf(old, sizeof old, "%s", b.f.path);
    snprintf(lost, sizeof lost, "%s.123", b.f.path);
    const struct timespec times[2] = {{.tv_sec = time(NULL) - 2 * BLOB_FILES_PART_AGE_S},
                                      {.tv_sec = time(NULL) - 2 * BLOB_FILES_PART_AGE_S}};
    utimensat(AT_FDCWD, old, times, 0);
    open_files(1 << 20);
    assert_int_equal(access(old, F_OK), 0); /* somebody writes it */
    blob_fetch_abort(&b.f);
    fclose(fopen(lost, "wb"));
    open_files(1 << 20);
    assert_int_not_equal(access(old, F_OK), 0);
    assert_int_not_equal(access(lost, F_OK), 0);
}

static int make_dir(void **state)
{
    (void)state;
    snprintf(dir, sizeof dir, "/tmp/shearwater-test-cache-XXXXXX");
    return mkdtemp(dir) ? 0 : -1;
}

static int remove_dir(void **state)
{
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", dir);
    return system(command);
}

EACH_TEST(make_dir, remove_dir);
