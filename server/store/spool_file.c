#include "server/store/spool_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include "proto/bytes.h"
#include "proto/link/wire_frame.h"

#define FILE_MAGIC   0x50534853u /* "SHSP" */
#define RECORD_MAGIC 0x656c6974u /* "tile" */
#define VERSION      1u

#define RECORDS_FIRST 1024u

static void put_u32(uint8_t *out, uint32_t v)
{
    for (int i = 0; i < 4; i++) out[i] = (uint8_t)(v >> 8 * i);
}

static void make_file_head(const struct digest *fingerprint, uint8_t out[SPOOL_FILE_HEAD_BYTES])
{
    put_u32(out, FILE_MAGIC);
    put_u32(out + 4, VERSION);
    memcpy(out + 8, fingerprint->bytes, DIGEST_BYTES);
    put_u32(out + 40, wire_frame_crc32c(0, out, 40));
}

static void make_record_head(const struct spool_key *key, const struct iovec payload[2],
                             uint8_t out[SPOOL_RECORD_HEAD_BYTES])
{
    const uint32_t size_bytes = (uint32_t)(payload[0].iov_len + payload[1].iov_len);
    const uint32_t crc = wire_frame_crc32c(0, payload[0].iov_base, payload[0].iov_len);
    const uint32_t numbers[] = {RECORD_MAGIC,
                                size_bytes,
                                key->tile,
                                key->pass,
                                key->first,
                                key->count,
                                key->strata,
                                key->strata_crc,
                                wire_frame_crc32c(crc, payload[1].iov_base, payload[1].iov_len)};
    for (int i = 0; i < 9; i++) put_u32(out + 4 * i, numbers[i]);
    put_u32(out + 36, wire_frame_crc32c(0, out + 4, 32));
}

/* False for bytes that are no head of a record. */
static bool read_record_head(const uint8_t in[SPOOL_RECORD_HEAD_BYTES], struct spool_record *out)
{
    struct bytes_reader r;
    bytes_reader_init(&r, in, SPOOL_RECORD_HEAD_BYTES);
    const uint32_t magic = bytes_read_u32(&r);
    out->payload_bytes = bytes_read_u32(&r);
    out->key.tile = bytes_read_u32(&r);
    out->key.pass = bytes_read_u32(&r);
    out->key.first = bytes_read_u32(&r);
    out->key.count = bytes_read_u32(&r);
    out->key.strata = bytes_read_u32(&r);
    out->key.strata_crc = bytes_read_u32(&r);
    out->payload_crc = bytes_read_u32(&r);
    const uint32_t crc = bytes_read_u32(&r);
    return magic == RECORD_MAGIC && crc == wire_frame_crc32c(0, in + 4, 32) &&
           out->payload_bytes <= LIMIT_FRAME_BYTES;
}

/* ERR_TRUNCATED when the file ends before. */
static int read_at(int fd, uint64_t offset, void *out, size_t size_bytes)
{
    uint8_t *to = out;
    while (size_bytes > 0) {
        ssize_t n = pread(fd, to, size_bytes, (off_t)offset);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return n < 0 ? ERR_IO : ERR_TRUNCATED;
        to += n;
        offset += (uint64_t)n;
        size_bytes -= (size_t)n;
    }
    return 0;
}

/* Writes all bytes of the parts, which it uses up. */
static int write_at(int fd, uint64_t offset, struct iovec *part, int count)
{
    while (count > 0) {
        ssize_t n = pwritev(fd, part, count, (off_t)offset);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return error_of_errno(errno);
        offset += (uint64_t)n;
        for (; count > 0 && (size_t)n >= part->iov_len; part++, count--)
            n -= (ssize_t)part->iov_len;
        if (count == 0) break;
        part->iov_base = (uint8_t *)part->iov_base + n;
        part->iov_len -= (size_t)n;
    }
    return 0;
}

static int add_record(struct spool_file *file, uint32_t *capacity,
                      const struct spool_record *record)
{
    if (file->count == *capacity) {
        const uint32_t more = *capacity ? 2 * *capacity : RECORDS_FIRST;
        struct spool_record *records = realloc(file->records, more * sizeof *records);
        if (!records) return ERR_MEMORY;
        file->records = records;
        *capacity = more;
    }
    file->records[file->count++] = *record;
    return 0;
}

/* Compares by tile and pass. If a pass was written twice, the last comes first. */
static int compare(const void *a, const void *b)
{
    const struct spool_record *p = a, *q = b;
    if (p->key.tile != q->key.tile) return p->key.tile < q->key.tile ? -1 : 1;
    if (p->key.pass != q->key.pass) return p->key.pass < q->key.pass ? -1 : 1;
    return p->offset > q->offset ? -1 : p->offset < q->offset;
}

/* Scans all records up to the first place without one. */
static int scan(struct spool_file *file, uint64_t size_bytes)
{
    uint32_t capacity = 0;
    uint8_t head[SPOOL_RECORD_HEAD_BYTES];
    int error = 0;
    while (!error && file->count < LIMIT_SPOOL_RECORDS &&
           size_bytes - file->end_bytes >= sizeof head) {
        struct spool_record record = {.offset = file->end_bytes + sizeof head};
        error = read_at(file->fd, file->end_bytes, head, sizeof head);
        if (error || !read_record_head(head, &record)) break;
        if (record.payload_bytes > size_bytes - record.offset) break;
        error = add_record(file, &capacity, &record);
        file->end_bytes = record.offset + record.payload_bytes;
    }
    if (!error && file->count > 0)
        qsort(file->records, file->count, sizeof *file->records, compare);
    return error;
}

/* Cuts off what is no record. */
static int cut(struct spool_file *file, uint64_t size_bytes)
{
    if (file->end_bytes == size_bytes) return 0;
    return ftruncate(file->fd, (off_t)file->end_bytes) ? ERR_IO : 0;
}

static int begin(struct spool_file *file, uint8_t head[SPOOL_FILE_HEAD_BYTES])
{
    struct iovec part = {head, SPOOL_FILE_HEAD_BYTES};
    if (ftruncate(file->fd, 0)) return ERR_IO;
    file->end_bytes = SPOOL_FILE_HEAD_BYTES;
    return write_at(file->fd, 0, &part, 1);
}

static int take_up(struct spool_file *file, const struct digest *fingerprint)
{
    struct stat st;
    uint8_t wanted[SPOOL_FILE_HEAD_BYTES], found[SPOOL_FILE_HEAD_BYTES];
    make_file_head(fingerprint, wanted);
    if (fstat(file->fd, &st)) return ERR_IO;
    const uint64_t size_bytes = (uint64_t)st.st_size;
    if (size_bytes < sizeof found) return begin(file, wanted);
    int error = read_at(file->fd, 0, found, sizeof found);
    if (error) return error;
    if (memcmp(found, wanted, sizeof found) != 0) return begin(file, wanted);
    file->end_bytes = sizeof found;
    error = scan(file, size_bytes);
    return error ? error : cut(file, size_bytes);
}

int spool_file_open(const char *path, const struct digest *fingerprint, struct spool_file *out)
{
    struct spool_file file = {.fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600)};
    *out = (struct spool_file){.fd = -1};
    if (file.fd < 0) return error_of_errno(errno);
    int error = take_up(&file, fingerprint);
    if (error)
        spool_file_close(&file);
    else
        *out = file;
    return error;
}

void spool_file_close(struct spool_file *file)
{
    if (file->fd >= 0) close(file->fd);
    free(file->records);
    *file = (struct spool_file){.fd = -1};
}

/* The first record of that tile and pass, or of a later one. */
static uint32_t place_of(const struct spool_file *file, const struct spool_key *key)
{
    const struct spool_record wanted = {.key = *key, .offset = UINT64_MAX};
    uint32_t low = 0, high = file->count;
    while (low < high) {
        const uint32_t middle = low + (high - low) / 2;
        if (compare(&file->records[middle], &wanted) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

const struct spool_record *spool_file_find(const struct spool_file *file,
                                           const struct spool_key *key)
{
    const uint32_t at = place_of(file, key);
    if (at == file->count) return NULL;
    const struct spool_record *found = &file->records[at];
    return memcmp(&found->key, key, sizeof *key) == 0 ? found : NULL;
}

int spool_file_read(const struct spool_file *file, const struct spool_record *record, uint8_t *out)
{
    int error = read_at(file->fd, record->offset, out, record->payload_bytes);
    if (error) return error == ERR_TRUNCATED ? ERR_CHECKSUM : error;
    const uint32_t crc = wire_frame_crc32c(0, out, record->payload_bytes);
    return crc == record->payload_crc ? 0 : ERR_CHECKSUM;
}

int spool_file_append(struct spool_file *file, const struct spool_key *key, const void *front,
                      uint32_t front_bytes, const void *back, uint32_t back_bytes)
{
    uint8_t head[SPOOL_RECORD_HEAD_BYTES];
    const uint64_t payload_bytes = (uint64_t)front_bytes + back_bytes;
    if (payload_bytes > LIMIT_FRAME_BYTES) return ERR_LIMIT;
    struct iovec parts[3] = {{head, sizeof head},
                             {(void *)(uintptr_t)front, front_bytes},
                             {(void *)(uintptr_t)back, back_bytes}};
    make_record_head(key, parts + 1, head);
    const int error = write_at(file->fd, file->end_bytes, parts, 3);
    if (!error)
        file->end_bytes += sizeof head + payload_bytes;
    else if (ftruncate(file->fd, (off_t)file->end_bytes))
        return ERR_IO; /* when the file is opened the tail is cut off, too */
    return error;
}
