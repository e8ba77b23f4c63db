#include "server/store/spools.h"

#include <assert.h>
#include <dirent.h>
#include <errno.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "proto/runtime/thread_pool.h"

#define PATH_BYTES 4352

struct removal {
    struct pool_task task; /* first */
    struct spools *spools;
    char job[JOB_ID_BYTES];
    int32_t frame;
};

struct spools {
    struct thread_pool *pool; /* one thread: what is asked for is done in order */
    struct removal spare;     /* for one removal while there is no memory; .spools is NULL: free */
    char dir[4096];
    uint64_t queued_bytes; /* the loop's thread: in memory, to be written */
    uint64_t skipped;
    atomic_uint_fast64_t kept, dropped, size_bytes; /* written by the pool's thread */
};

struct spool {
    struct pool_task task; /* first: opens it, later closes it */
    struct spools *spools;
    char job[JOB_ID_BYTES];
    int32_t frame;
    struct digest fingerprint;
    struct spool_file file;
    int error;  /* of opening it */
    bool ended; /* nothing is written any more */
    spool_opened opened;
    void *ctx;
};

/* -- paths -- */

static void job_path(const struct spools *s, const char *job, char out[PATH_BYTES])
{
    snprintf(out, PATH_BYTES, "%s/%.*s", s->dir, JOB_ID_BYTES, job);
}

static void frame_path(const struct spools *s, const char *job, int32_t frame, char out[PATH_BYTES])
{
    snprintf(out, PATH_BYTES, "%s/%.*s/%d", s->dir, JOB_ID_BYTES, job, frame);
}

static uint64_t size_of(const char *path)
{
    struct stat st;
    return !lstat(path, &st) && S_ISREG(st.st_mode) ? (uint64_t)st.st_size : 0;
}

/* -- on the pool's thread, and before it has work -- */

static void remove_file(struct spools *s, const char *path)
{
    const uint64_t size_bytes = size_of(path);
    if (unlink(path) == 0) atomic_fetch_sub(&s->size_bytes, size_bytes);
}

/* Calls `each` with every file of a job's folder. */
static void for_files(struct spools *s, const char *job,
                      void (*each)(struct spools *s, const char *path))
{
    char folder[PATH_BYTES], path[PATH_BYTES + NAME_MAX + 2];
    job_path(s, job, folder);
    const struct dirent *entry;
    DIR *dir = NULL;
    for (unsigned tries = 3; !dir && tries > 0; tries--) /* memory may be missing for a moment */
        if (!(dir = opendir(folder)) && errno != ENOMEM) return;
    while (dir && (entry = readdir(dir))) {
        if (entry->d_name[0] == '.') continue;
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        each(s, path);
    }
    if (dir) closedir(dir);
}

static void remove_job(struct spools *s, const char *job)
{
    char folder[PATH_BYTES];
    for_files(s, job, remove_file);
    job_path(s, job, folder);
    rmdir(folder);
}

static void count_file(struct spools *s, const char *path)
{
    atomic_fetch_add(&s->size_bytes, size_of(path));
}

static void open_run(struct pool_task *task)
{
    struct spool *spool = (struct spool *)task;
    struct spools *s = spool->spools;
    char path[PATH_BYTES];
    job_path(s, spool->job, path);
    if (mkdir(path, 0700) && errno != EEXIST) {
        spool->error = error_of_errno(errno);
        return;
    }
    frame_path(s, spool->job, spool->frame, path);
    const uint64_t before_bytes = size_of(path);
    spool->error = spool_file_open(path, &spool->fingerprint, &spool->file);
    atomic_fetch_add(&s->size_bytes, size_of(path) - before_bytes); /* also downwards: unsigned */
}

/* Frees the file's disk space at once, although readers may have it open. */
static void end_file(struct spool *spool)
{
    char path[PATH_BYTES];
    frame_path(spool->spools, spool->job, spool->frame, path);
    spool->ended = true;
    atomic_fetch_sub(&spool->spools->size_bytes, size_of(path));
    if (ftruncate(spool->file.fd, 0) == 0) unlink(path);
}

static bool is_room_left(const struct spool *spool)
{
    struct statvfs st;
    if (fstatvfs(spool->file.fd, &st)) return false;
    return (uint64_t)st.f_bavail * st.f_frsize >= LIMIT_SPOOL_SPARE_BYTES;
}

struct append {
    struct pool_task task; /* first */
    struct spool *spool;
    struct spool_key key;
    uint8_t *back; /* owned */
    uint32_t back_bytes, front_bytes;
    uint8_t front[];
};

static void append_run(struct pool_task *task)
{
    struct append *a = (struct append *)task;
    struct spool *spool = a->spool;
    struct spools *s = spool->spools;
    const uint64_t begin_bytes = spool->file.end_bytes;
    int error = spool->ended ? ERR_STATE : 0;
    if (!error && atomic_load(&s->size_bytes) > LIMIT_SPOOL_BYTES) error = ERR_LIMIT;
    if (!error && !is_room_left(spool)) error = ERR_NO_SPACE;
    if (!error)
        error = spool_file_append(&spool->file, &a->key, a->front, a->front_bytes, a->back,
                                  a->back_bytes);
    atomic_fetch_add(&s->size_bytes, spool->file.end_bytes - begin_bytes);
    atomic_fetch_add(error ? &s->dropped : &s->kept, 1);
    if (error == ERR_NO_SPACE || error == ERR_IO) end_file(spool);
}

static void remove_run(struct pool_task *task)
{
    const struct removal *r = (const struct removal *)task;
    char path[PATH_BYTES];
    if (r->frame < 0) {
        remove_job(r->spools, r->job);
        return;
    }
    frame_path(r->spools, r->job, r->frame, path);
    remove_file(r->spools, path);
}

static void close_run(struct pool_task *task)
{
    spool_file_close(&((struct spool *)task)->file);
}

/* -- on the loop's thread -- */

static void free_task(struct pool_task *task)
{
    free(task);
}

int spools_create(uv_loop_t *loop, const char *dir, struct spools **out)
{
    struct spools *s = calloc(1, sizeof *s);
    *out = NULL;
    if (!s) return ERR_MEMORY;
    int error = 0;
    if (snprintf(s->dir, sizeof s->dir, "%s/spool", dir) >= (int)sizeof s->dir) error = ERR_LIMIT;
    if (!error && mkdir(s->dir, 0700) && errno != EEXIST) error = error_of_errno(errno);
    if (!error) error = thread_pool_create(loop, "spool", 1, NULL, &s->pool);
    if (error)
        free(s);
    else
        *out = s;
    return error;
}

void spools_destroy(struct spools **spools)
{
    struct spools *s = *spools;
    *spools = NULL;
    if (!s) return;
    thread_pool_destroy(&s->pool);
    free(s);
}

void spools_sweep(struct spools *s, bool (*is_wanted)(void *ctx, const char *job), void *ctx)
{
    DIR *dir = opendir(s->dir);
    const struct dirent *entry;
    assert(thread_pool_pending(s->pool) == 0);
    while (dir && (entry = readdir(dir))) {
        if (entry->d_name[0] == '.') continue;
        for_files(s, entry->d_name, count_file);
        if (strlen(entry->d_name) >= JOB_ID_BYTES || !is_wanted(ctx, entry->d_name))
            remove_job(s, entry->d_name);
    }
    if (dir) closedir(dir);
}

static void open_done(struct pool_task *task)
{
    struct spool *spool = (struct spool *)task;
    if (!spool->error) {
        spool->opened(spool->ctx, spool);
        return;
    }
    spool->opened(spool->ctx, NULL);
    free(spool);
}

int spool_open(struct spools *spools, const char *job, int32_t frame,
               const struct digest *fingerprint, spool_opened opened, void *ctx)
{
    struct spool *spool = calloc(1, sizeof *spool);
    if (!spool) return ERR_MEMORY;
    *spool = (struct spool){.task = {.run = open_run, .done = open_done},
                            .spools = spools,
                            .frame = frame,
                            .fingerprint = *fingerprint,
                            .file.fd = -1,
                            .opened = opened,
                            .ctx = ctx};
    snprintf(spool->job, sizeof spool->job, "%s", job);
    thread_pool_submit(spools->pool, &spool->task);
    return 0;
}

void spool_close(struct spool **spool)
{
    struct spool *s = *spool;
    *spool = NULL;
    if (!s) return;
    s->task = (struct pool_task){.run = close_run, .done = free_task};
    thread_pool_submit(s->spools->pool, &s->task);
}

const struct spool_record *spool_find(const struct spool *spool, const struct spool_key *key)
{
    return spool_file_find(&spool->file, key);
}

uint32_t spool_count(const struct spool *spool)
{
    return spool->file.count;
}

int spool_read(const struct spool *spool, const struct spool_record *record, uint8_t *out)
{
    return spool_file_read(&spool->file, record, out);
}

static void append_done(struct pool_task *task)
{
    struct append *a = (struct append *)task;
    a->spool->spools->queued_bytes -= a->back_bytes;
    free(a->back);
    free(a);
}

void spool_append(struct spool *spool, const struct spool_key *key, const void *front,
                  uint32_t front_bytes, uint8_t *back, uint32_t back_bytes)
{
    struct spools *s = spool->spools;
    const bool fits = s->queued_bytes + back_bytes <= LIMIT_SPOOL_QUEUE_BYTES;
    struct append *a = fits ? malloc(sizeof *a + front_bytes) : NULL;
    if (!a) {
        s->skipped++;
        free(back);
        return;
    }
    *a = (struct append){.task = {.run = append_run, .done = append_done},
                         .spool = spool,
                         .key = *key,
                         .back = back,
                         .back_bytes = back_bytes,
                         .front_bytes = front_bytes};
    memcpy(a->front, front, front_bytes);
    s->queued_bytes += back_bytes;
    thread_pool_submit(s->pool, &a->task);
}

static void remove_done(struct pool_task *task)
{
    struct removal *r = (struct removal *)task;
    if (r == &r->spools->spare)
        r->spools = NULL;
    else
        free(r);
}

void spools_remove(struct spools *spools, const char *job, int32_t frame)
{
    struct removal *r = calloc(1, sizeof *r);
    if (!r && !spools->spare.spools) r = &spools->spare;
    if (!r) return; /* the next start finds it */
    *r = (struct removal){
        .task = {.run = remove_run, .done = remove_done}, .spools = spools, .frame = frame};
    snprintf(r->job, sizeof r->job, "%s", job);
    thread_pool_submit(spools->pool, &r->task);
}

void spools_totals(const struct spools *spools, struct spools_totals *out)
{
    *out = (struct spools_totals){.kept = atomic_load(&spools->kept),
                                  .skipped = spools->skipped + atomic_load(&spools->dropped),
                                  .size_bytes = atomic_load(&spools->size_bytes)};
}
