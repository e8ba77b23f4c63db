#pragma once
/* Results of one frame's tiles on disk, in the order in which they landed, so that a coordinator
 * that is started again need not have them traced again.
 *
 *   file    offset size
 *              0    4  magic "SHSP"
 *              4    4  version of this layout
 *              8   32  fingerprint of all that the samples depend on; it names the frame
 *             40    4  CRC32C of what precedes
 *   record     0    4  magic "tile"
 *              4    4  payload length in bytes
 *              8   24  tile; pass: number, first, count, strata; CRC32C of its strata maps (plan.h)
 *             32    4  CRC32C of the payload
 *             36    4  CRC32C of bytes 4..35
 *             40       payload
 *
 * Little-endian. A record is one write behind the last; a write that was cut short leaves a tail
 * that is no record, and is cut off when the file is opened. Nothing is synced: bytes outlive the
 * process that wrote them, and what a machine loses with its power is traced again. So a length or
 * a payload may be anything, and counts only when its CRC fits.
 *
 * Calls block and share no state. One thread appends; any may read meanwhile. */
#include <stdint.h>

#include "proto/digest.h"
#include "proto/error.h"
#include "proto/limits.h"

#define SPOOL_FILE_HEAD_BYTES   44u
#define SPOOL_RECORD_HEAD_BYTES 40u

/* The pass of a tile whose result a payload is. */
struct spool_key {
    uint32_t tile;
    uint32_t pass, first, count, strata; /* struct plan_pass */
    uint32_t strata_crc;                 /* 0: it has none */
};

struct spool_record {
    struct spool_key key;
    uint32_t payload_bytes, payload_crc;
    uint64_t offset; /* of the payload */
};

struct spool_file {
    int fd;
    uint64_t end_bytes;           /* where the next record goes */
    struct spool_record *records; /* owned; that were there when it was opened, by tile and pass */
    uint32_t count;
};

/* Opens or creates the file. One of another fingerprint or version, or of another format, begins
 * anew. ERR_IO, ERR_NO_SPACE, ERR_MEMORY. */
int spool_file_open(const char *path, const struct digest *fingerprint, struct spool_file *out);
void spool_file_close(struct spool_file *file);

/* Returns the last record of that tile's pass, borrowed, if it is of this very pass; else NULL. */
const struct spool_record *spool_file_find(const struct spool_file *file,
                                           const struct spool_key *key);

/* Reads a payload; `out` has room for payload_bytes. ERR_CHECKSUM for a payload that is not what
 * was written, ERR_IO. */
int spool_file_read(const struct spool_file *file, const struct spool_record *record, uint8_t *out);

/* Appends a payload in two pieces, either of which may be empty. ERR_LIMIT for one that is too long
 * for a record, ERR_NO_SPACE, ERR_IO; the file is then as it was. */
int spool_file_append(struct spool_file *file, const struct spool_key *key, const void *front,
                      uint32_t front_bytes, const void *back, uint32_t back_bytes);
