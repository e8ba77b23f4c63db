// sources: server/store/spool_file.c
/* A spool of tiles as it may lie on disk after anything. The first byte says what the rest is: a
 * whole file (0), what follows a right head (1), or what follows one with the checksums of records
 * set right where they should be (2), so that what is behind them is tried. Whatever it is, the
 * file opens, its records lie in it and read whole or not at all, and one more record can be added
 * and is there when the file is opened again. */
#include <fcntl.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "proto/link/wire_frame.h"
#include "server/store/spool_file.h"

static const struct digest fingerprint = {{1, 2, 3}};
static const struct spool_key added = {.tile = 77, .pass = 3, .count = 4};
static const char payload[] = "what a tile gave";

static void must(bool holds)
{
    if (!holds) abort();
}

static uint32_t read_u32(const uint8_t *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static void put_u32(uint8_t *out, uint32_t v)
{
    for (int i = 0; i < 4; i++) out[i] = (uint8_t)(v >> 8 * i);
}

static void set_checksums_right(uint8_t *at, size_t left)
{
    while (left >= SPOOL_RECORD_HEAD_BYTES) {
        const size_t inside = left - SPOOL_RECORD_HEAD_BYTES;
        uint32_t size_bytes = read_u32(at + 4);
        if (size_bytes > inside) size_bytes = (uint32_t)(size_bytes % (inside + 1));
        memcpy(at, "tile", 4);
        put_u32(at + 4, size_bytes);
        /* Every other one keeps a payload that is not what was written. */
        if (at[8] & 1)
            put_u32(at + 32, wire_frame_crc32c(0, at + SPOOL_RECORD_HEAD_BYTES, size_bytes));
        put_u32(at + 36, wire_frame_crc32c(0, at + 4, 32));
        at += SPOOL_RECORD_HEAD_BYTES + size_bytes;
        left -= SPOOL_RECORD_HEAD_BYTES + size_bytes;
    }
}

static void write_all(int fd, const void *data, size_t size_bytes)
{
    must(write(fd, data, size_bytes) == (ssize_t)size_bytes);
}

static char path[64];

static void forget_file(void)
{
    (void)unlink(path);
}

static int make_file(void)
{
    snprintf(path, sizeof path, "/dev/shm/fuzz-spool-%d", (int)getpid());
    atexit(forget_file);
    const int fd = open(path, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    must(fd >= 0);
    return fd;
}

static void put_file(int fd, const uint8_t *data, size_t size_bytes)
{
    const int mode = data[0] % 3;
    must(ftruncate(fd, 0) == 0 && lseek(fd, 0, SEEK_SET) == 0);
    if (mode > 0) {
        struct spool_file fresh;
        must(spool_file_open(path, &fingerprint, &fresh) == 0); /* writes the head */
        spool_file_close(&fresh);
        must(lseek(fd, 0, SEEK_END) == SPOOL_FILE_HEAD_BYTES);
    }
    uint8_t *rest = malloc(size_bytes);
    must(rest != NULL);
    memcpy(rest, data + 1, size_bytes - 1);
    if (mode == 2) set_checksums_right(rest, size_bytes - 1);
    write_all(fd, rest, size_bytes - 1);
    free(rest);
}

static void read_records(const struct spool_file *file)
{
    for (uint32_t i = 0; i < file->count; i++) {
        const struct spool_record *r = &file->records[i];
        must(r->offset >= SPOOL_FILE_HEAD_BYTES + SPOOL_RECORD_HEAD_BYTES);
        must(r->offset + r->payload_bytes <= file->end_bytes);
        uint8_t *out = malloc(r->payload_bytes + 1u);
        must(out != NULL);
        const int error = spool_file_read(file, r, out);
        must(error == 0 || error == ERR_CHECKSUM);
        must(error != 0 || wire_frame_crc32c(0, out, r->payload_bytes) == r->payload_crc);
        free(out);
        const struct spool_record *found = spool_file_find(file, &r->key);
        must(!found || found->key.tile == r->key.tile);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    static int fd = -1;
    struct spool_file file;
    char got[sizeof payload];
    if (size_bytes == 0) return 0;
    if (fd < 0) fd = make_file();
    put_file(fd, data, size_bytes);
    must(spool_file_open(path, &fingerprint, &file) == 0);
    read_records(&file);
    const uint32_t count = file.count;
    must(spool_file_append(&file, &added, payload, 4, payload + 4, sizeof payload - 4) == 0);
    spool_file_close(&file);
    must(spool_file_open(path, &fingerprint, &file) == 0);
    must(file.count >= 1 && file.count <= count + 1);
    const struct spool_record *record = spool_file_find(&file, &added);
    must(record && record->payload_bytes == sizeof payload);
    must(spool_file_read(&file, record, (uint8_t *)got) == 0);
    must(memcmp(got, payload, sizeof payload) == 0);
    spool_file_close(&file);
    return 0;
}
