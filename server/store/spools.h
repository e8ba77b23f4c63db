#pragma once
/* The spools of all frames in work (spool_file.h), and the one thread that writes them.
 *
 *   DIR/spool/JOB/FRAME      a file a frame, there until the frame has its files or its job ends
 *
 * A spool saves time and promises nothing: what does not fit (the disk, LIMIT_SPOOL_BYTES, the
 * memory of LIMIT_SPOOL_QUEUE_BYTES that may wait for the disk) is not kept, and is traced again
 * after a restart. On a disk that is nearly full a spool is the first to go.
 *
 * Everything but spool_read is for the loop's thread; callbacks come on it. */
#include <stdbool.h>
#include <uv.h>

#include "server/store/job_store.h"
#include "server/store/spool_file.h"

struct spools;
struct spool; /* a frame's */

/* Makes the folder. ERR_IO, ERR_NO_SPACE, ERR_MEMORY, ERR_LIMIT. */
int spools_create(uv_loop_t *loop, const char *dir, struct spools **out);
/* Lets what waits be written. Nulls the pointer; the loop must run once more. All spools must have
 * been closed, or be closed by callbacks of this. */
void spools_destroy(struct spools **spools);

/* Start-up, blocking: removes what is of no wanted job, and counts the rest. */
void spools_sweep(struct spools *spools, bool (*is_wanted)(void *ctx, const char *job), void *ctx);

/* Opens a frame's, or makes it; no two of a frame at a time, but for one that is being closed. The
 * callback gets NULL where there cannot be one. ERR_MEMORY: there will be no callback. */
typedef void (*spool_opened)(void *ctx, struct spool *spool);
int spool_open(struct spools *spools, const char *job, int32_t frame,
               const struct digest *fingerprint, spool_opened opened, void *ctx);
/* Nulls the pointer; NULL is fine. The file stays. */
void spool_close(struct spool **spool);

/* Of what was there when it was opened; borrowed until it is closed. NULL: nothing. */
const struct spool_record *spool_find(const struct spool *spool, const struct spool_key *key);
uint32_t spool_count(const struct spool *spool);

/* As spool_file_read; any thread, until the spool is closed. */
int spool_read(const struct spool *spool, const struct spool_record *record, uint8_t *out);

/* Keeps a result, soon. The payload is `front`, which is copied, and `back`, which is taken (to be
 * freed with free) whatever becomes of it. */
void spool_append(struct spool *spool, const struct spool_key *key, const void *front,
                  uint32_t front_bytes, uint8_t *back, uint32_t back_bytes);

/* Removes a frame's file, or with a negative number all of a job's, after all that was asked for
 * before. */
void spools_remove(struct spools *spools, const char *job, int32_t frame);

struct spools_totals {
    uint64_t kept, skipped; /* results, since the start */
    uint64_t size_bytes;    /* of all files now */
};
void spools_totals(const struct spools *spools, struct spools_totals *out);
