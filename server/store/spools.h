#pragma once
/* The spools of all frames in work (spool_file.h), and the one thread that writes them. A frame's
 * file is DIR/spool/JOB/FRAME, until the frame has its files or its job ends.
 *
 * A spool saves time and promises nothing. A result that does not fit (the disk, LIMIT_SPOOL_BYTES,
 * the LIMIT_SPOOL_QUEUE_BYTES of memory that may wait for the disk) is not kept, and is traced
 * again after a restart. When a disk is nearly full, spools stop before all else.
 *
 * All but spool_read is for the loop's thread, and callbacks come on it. */
#include <stdbool.h>
#include <uv.h>

#include "server/store/job_store.h"
#include "server/store/spool_file.h"

struct spools;
struct spool; /* a frame's */

/* Creates the folder. ERR_IO, ERR_NO_SPACE, ERR_MEMORY, ERR_LIMIT. */
int spools_create(uv_loop_t *loop, const char *dir, struct spools **out);
/* Writes what waits, and nulls the pointer. The loop must run once more. All spools must be closed
 * before, or by callbacks of this call. */
void spools_destroy(struct spools **spools);

/* Removes the files of unwanted jobs, and counts the rest. Blocking, at start-up. */
void spools_sweep(struct spools *spools, bool (*is_wanted)(void *ctx, const char *job), void *ctx);

/* Opens or creates a frame's spool. A frame has one at a time, but for one that is being closed.
 * The callback gets NULL when there cannot be one. ERR_MEMORY: there will be no callback. */
typedef void (*spool_opened)(void *ctx, struct spool *spool);
int spool_open(struct spools *spools, const char *job, int32_t frame,
               const struct digest *fingerprint, spool_opened opened, void *ctx);
/* Closes a spool and nulls the pointer; NULL is fine. The file stays. */
void spool_close(struct spool **spool);

/* Finds a record that was there when the spool was opened, borrowed until it is closed. NULL: there
 * is none. */
const struct spool_record *spool_find(const struct spool *spool, const struct spool_key *key);
uint32_t spool_count(const struct spool *spool);

/* Reads a record as spool_file_read does; any thread, until the spool is closed. */
int spool_read(const struct spool *spool, const struct spool_record *record, uint8_t *out);

/* Keeps a result, soon. The payload is `front`, which is copied, and `back`, which is taken (to be
 * freed with free) whatever becomes of it. */
void spool_append(struct spool *spool, const struct spool_key *key, const void *front,
                  uint32_t front_bytes, uint8_t *back, uint32_t back_bytes);

/* Removes a frame's file, or all of a job's when `frame` is negative, after all earlier calls. */
void spools_remove(struct spools *spools, const char *job, int32_t frame);

struct spools_totals {
    uint64_t kept, skipped; /* results, since the start */
    uint64_t size_bytes;    /* of all files now */
};
void spools_totals(const struct spools *spools, struct spools_totals *out);
