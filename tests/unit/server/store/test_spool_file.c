/* Spools: what was written is read again; what is torn, flipped or another frame's never is. */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/store/spool_file.h"
#include "tests/unit/unit.h"

#define RECORDS 5u

static char path[64];
static const struct digest here = {{1, 2, 3}}, elsewhere = {{1, 2, 4}};

static int set_up(void **state)
{
    (void)state;
    strcpy(path, "/tmp/shearwater-spool-XXXXXX");
    const int fd = mkstemp(path);
    return fd < 0 || close(fd);
}

static int tear_down(void **state)
{
    (void)state;
    return unlink(path);
}

EACH_TEST(set_up, tear_down);

static struct spool_key key_of(uint32_t i)
{
    return (struct spool_key){
        .tile = 7 * (RECORDS - i), .pass = i % 2, .first = 16 * i, .count = 16, .strata_crc = i};
}

/* Payloads of 0, 37, 74... bytes that tell of themselves. */
static uint32_t payload_of(uint32_t i, uint8_t out[256])
{
    for (uint32_t k = 0; k < 37 * i; k++) out[k] = (uint8_t)(31 * i + k);
    return 37 * i;
}

static void append(struct spool_file *file, uint32_t i)
{
    uint8_t payload[256];
    const struct spool_key key = key_of(i);
    const uint32_t size_bytes = payload_of(i, payload), front_bytes = size_bytes / 3;
    assert_int_equal(spool_file_append(file, &key, payload, front_bytes, payload + front_bytes,
                                       size_bytes - front_bytes),
                     0);
}

static void write_all(void)
{
    struct spool_file file;
    unlink(path);
    assert_int_equal(spool_file_open(path, &here, &file), 0);
    for (uint32_t i = 0; i < RECORDS; i++) append(&file, i);
    spool_file_close(&file);
}

/* Whether record i is there, as it was written; anything else it may not be. */
static bool has(const struct spool_file *file, uint32_t i)
{
    uint8_t wanted[256], found[256];
    const struct spool_key key = key_of(i);
    const struct spool_record *record = spool_file_find(file, &key);
    if (!record || record->payload_bytes > sizeof found) return false;
    if (spool_file_read(file, record, found) != 0) return false;
    assert_int_equal(record->payload_bytes, payload_of(i, wanted));
    assert_memory_equal(found, wanted, record->payload_bytes);
    return true;
}

static uint64_t size_of_file(void)
{
    struct stat st;
    assert_int_equal(stat(path, &st), 0);
    return (uint64_t)st.st_size;
}

/* Where record i begins; of RECORDS: the end. */
static uint64_t begin_of(uint32_t i)
{
    uint64_t at = SPOOL_FILE_HEAD_BYTES;
    for (uint32_t k = 0; k < i; k++) at += SPOOL_RECORD_HEAD_BYTES + 37 * k;
    return at;
}

TEST(what_was_written_is_read)
{
    struct spool_file file;
    write_all();
    assert_true(size_of_file() == begin_of(RECORDS));
    assert_int_equal(spool_file_open(path, &here, &file), 0);
    assert_int_equal(file.count, RECORDS);
    for (uint32_t i = 0; i < RECORDS; i++) assert_true(has(&file, i));
    spool_file_close(&file);
}

TEST(another_pass_is_none)
{
    struct spool_file file;
    write_all();
    assert_int_equal(spool_file_open(path, &here, &file), 0);
    for (unsigned member = 0; member < sizeof(struct spool_key) / sizeof(uint32_t); member++) {
        struct spool_key key = key_of(2);
        ((uint32_t *)&key)[member]++;
        assert_null(spool_file_find(&file, &key));
    }
    spool_file_close(&file);
}

TEST(another_frame_begins_anew)
{
    struct spool_file file;
    write_all();
    assert_int_equal(spool_file_open(path, &elsewhere, &file), 0);
    assert_int_equal(file.count, 0);
    append(&file, 3);
    spool_file_close(&file);
    assert_int_equal(spool_file_open(path, &here, &file), 0);
    assert_int_equal(file.count, 0);
    spool_file_close(&file);
}

/* Cut at every byte: whole records before the cut are there, and what is appended then. */
TEST(torn_tails_are_cut)
{
    for (uint64_t end = begin_of(RECORDS); end-- > 0;) {
        struct spool_file file;
        write_all();
        assert_int_equal(truncate(path, (off_t)end), 0);
        assert_int_equal(spool_file_open(path, &here, &file), 0);
        for (uint32_t i = 0; i < RECORDS; i++)
            assert_int_equal(has(&file, i), begin_of(i + 1) <= end);
        append(&file, 4);
        spool_file_close(&file);
        assert_int_equal(spool_file_open(path, &here, &file), 0);
        assert_true(has(&file, 4));
        spool_file_close(&file);
    }
}

/* A bit is another one, wherever: a record is there as it was written, or is not. */
TEST(flipped_bits_count_for_nothing)
{
    for (uint64_t at = 0; at < begin_of(RECORDS); at++) {
        struct spool_file file;
        uint8_t byte;
        write_all();
        const int fd = open(path, O_RDWR);
        assert_int_equal(pread(fd, &byte, 1, (off_t)at), 1);
        byte ^= (uint8_t)(1u << at % 8);
        assert_int_equal(pwrite(fd, &byte, 1, (off_t)at), 1);
        close(fd);
        assert_int_equal(spool_file_open(path, &here, &file), 0);
        for (uint32_t i = 0; i < RECORDS; i++) {
            const bool before = begin_of(i + 1) <= at && at >= SPOOL_FILE_HEAD_BYTES;
            const bool touched = begin_of(i) <= at && at < begin_of(i + 1);
            if (before) assert_true(has(&file, i));
            if (touched) assert_false(has(&file, i));
            if (!before && !touched) has(&file, i);
        }
        spool_file_close(&file);
    }
}

/* A record that turned out damaged is written once more: the later one counts. */
TEST(the_last_of_a_pass_counts)
{
    struct spool_file file;
    uint8_t found[8];
    const struct spool_key key = key_of(1);
    write_all();
    assert_int_equal(spool_file_open(path, &here, &file), 0);
    assert_int_equal(spool_file_append(&file, &key, "new", 3, NULL, 0), 0);
    spool_file_close(&file);
    assert_int_equal(spool_file_open(path, &here, &file), 0);
    const struct spool_record *record = spool_file_find(&file, &key);
    assert_non_null(record);
    assert_int_equal(record->payload_bytes, 3);
    assert_int_equal(spool_file_read(&file, record, found), 0);
    assert_memory_equal(found, "new", 3);
    spool_file_close(&file);
}

TEST(too_long_is_refused)
{
    struct spool_file file;
    const struct spool_key key = key_of(0);
    assert_int_equal(spool_file_open(path, &here, &file), 0);
    assert_int_equal(spool_file_append(&file, &key, "", 1, "", LIMIT_FRAME_BYTES), ERR_LIMIT);
    spool_file_close(&file);
    assert_int_equal(spool_file_open("/nowhere/spool", &here, &file), ERR_IO);
}
