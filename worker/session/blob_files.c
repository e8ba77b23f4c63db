#include "worker/session/blob_files.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define PARTS         "parts"
#define HASH_BYTES    (1u << 20)
#define FOLDER_DIGITS 2 /* of the digest name the folder */

static int make_dir(const char *path)
{
    return mkdir(path, 0700) == 0 || errno == EEXIST ? 0 : ERR_IO;
}

/* Makes a folder with those above it. */
static int make_dirs(const char *dir)
{
    char path[4096];
    size_t length = strlen(dir);
    if (length == 0 || length >= sizeof path) return ERR_LIMIT;
    memcpy(path, dir, length + 1);
    for (char *at = path + 1; *at; at++) {
        if (*at != '/') continue;
        *at = '\0';
        if (make_dir(path) != 0) return ERR_IO;
        *at = '/';
    }
    return make_dir(path);
}

static void blob_path(const struct blob_files *c, const struct digest *digest,
                      char out[BLOB_FILES_PATH_BYTES])
{
    char hex[DIGEST_HEX_BYTES];
    digest_to_hex(digest, hex);
    snprintf(out, BLOB_FILES_PATH_BYTES, "%s/%.2s/%s", c->dir, hex, hex + FOLDER_DIGITS);
}

/* ---- walking the folder ---- */

struct blob_file {
    char path[BLOB_FILES_PATH_BYTES];
    uint64_t size_bytes;
    struct timespec used;
    bool is_part;
};

typedef void (*visit)(void *ctx, const struct blob_file *file);

static void walk_folder(const struct blob_files *c, const char *folder, visit see, void *ctx)
{
    char path[BLOB_FILES_PATH_BYTES];
    struct blob_file file = {.is_part = strcmp(folder, PARTS) == 0};
    snprintf(path, sizeof path, "%s/%.8s", c->dir, folder);
    DIR *dir = opendir(path);
    if (!dir) return;
    for (struct dirent *entry; (entry = readdir(dir));) {
        struct stat st;
        if (entry->d_name[0] == '.') continue;
        int n = snprintf(file.path, sizeof file.path, "%s/%s", path, entry->d_name);
        if (n < 0 || (size_t)n >= sizeof file.path) continue;
        if (lstat(file.path, &st) != 0 || !S_ISREG(st.st_mode)) continue;
        file.size_bytes = (uint64_t)st.st_size;
        file.used = st.st_mtim;
        see(ctx, &file);
    }
    closedir(dir);
}

static bool is_folder_name(const char *name)
{
    return strcmp(name, PARTS) == 0 ||
           (strlen(name) == FOLDER_DIGITS && strspn(name, "0123456789abcdef") == FOLDER_DIGITS);
}

static void walk(const struct blob_files *c, visit see, void *ctx)
{
    DIR *dir = opendir(c->dir);
    if (!dir) return;
    for (struct dirent *entry; (entry = readdir(dir));)
        if (is_folder_name(entry->d_name)) walk_folder(c, entry->d_name, see, ctx);
    closedir(dir);
}

static void add_size(void *ctx, const struct blob_file *file)
{
    *(uint64_t *)ctx += file->size_bytes;
}

uint64_t blob_files_used_bytes(const struct blob_files *c)
{
    uint64_t sum = 0;
    walk(c, add_size, &sum);
    return sum;
}

/* ---- removing ---- */

/* Unlinks a file unless it is locked. NFS locks no file exclusively that is open only to be read.
 */
static bool remove_unlocked(const char *path)
{
    int fd = open(path, O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    if (fd < 0) return false;
    bool removed = flock(fd, LOCK_EX | LOCK_NB) == 0 && unlink(path) == 0;
    close(fd);
    return removed;
}

/* Returns whether a part has a process id in its name. It cannot be found again, because its owner
 * had met another writer. */
static bool has_owner(const char *path)
{
    const char *name = strrchr(path, '/');
    return name && strlen(name + 1) != DIGEST_HEX_BYTES - 1;
}

static void sweep_part(void *ctx, const struct blob_file *file)
{
    time_t now = *(time_t *)ctx;
    if (!file->is_part) return;
    if (has_owner(file->path) || now - file->used.tv_sec > BLOB_FILES_PART_AGE_S)
        remove_unlocked(file->path);
}

int blob_files_open(struct blob_files *c, const char *dir, uint64_t limit_bytes,
                    struct fault *fault)
{
    char parts[BLOB_FILES_PATH_BYTES];
    time_t now = time(NULL);
    *c = (struct blob_files){.limit_bytes = limit_bytes};
    if ((size_t)snprintf(c->dir, sizeof c->dir, "%s", dir) >= sizeof c->dir)
        return fault_set(fault, ERR_LIMIT, "--cache", "the path is longer than %zu bytes",
                         sizeof c->dir - 1);
    snprintf(parts, sizeof parts, "%s/%s", c->dir, PARTS);
    if (make_dirs(parts) != 0)
        return fault_set(fault, ERR_IO, dir, "the cache folder cannot be made: %s",
                         strerrordesc_np(errno));
    walk_folder(c, PARTS, sweep_part, &now);
    return 0;
}

/* All whole blobs, to be sorted by their last use. */
struct file_list {
    struct blob_file *files;
    size_t count, capacity;
    uint64_t total_bytes; /* with the parts */
    bool failed;
};

static void collect(void *ctx, const struct blob_file *file)
{
    struct file_list *list = ctx;
    list->total_bytes += file->size_bytes;
    if (list->count == list->capacity) {
        size_t capacity = list->capacity ? 2 * list->capacity : 32;
        struct blob_file *files = realloc(list->files, capacity * sizeof *files);
        list->failed = list->failed || !files;
        if (!files) return;
        list->files = files;
        list->capacity = capacity;
    }
    list->files[list->count++] = *file;
}

static int by_last_use(const void *a, const void *b)
{
    const struct timespec x = ((const struct blob_file *)a)->used;
    const struct timespec y = ((const struct blob_file *)b)->used;
    if (x.tv_sec != y.tv_sec) return x.tv_sec < y.tv_sec ? -1 : 1;
    return x.tv_nsec < y.tv_nsec ? -1 : x.tv_nsec > y.tv_nsec;
}

/* Evicts until `need_bytes` more fit. Parts in work count but are locked, so they stay. */
static int make_room(const struct blob_files *c, uint64_t need_bytes)
{
    struct file_list list = {0};
    if (need_bytes > c->limit_bytes) return ERR_FULL;
    walk(c, collect, &list);
    if (list.count > 0) qsort(list.files, list.count, sizeof list.files[0], by_last_use);
    for (size_t i = 0; i < list.count && list.total_bytes > c->limit_bytes - need_bytes; i++)
        if (remove_unlocked(list.files[i].path)) list.total_bytes -= list.files[i].size_bytes;
    bool fits = list.total_bytes <= c->limit_bytes - need_bytes;
    free(list.files);
    if (list.failed) return ERR_MEMORY;
    return fits ? 0 : ERR_FULL;
}

/* ---- using ---- */

int blob_files_pin(const struct blob_files *c, const struct digest *digest, struct blob_pin *pin,
                   char path[BLOB_FILES_PATH_BYTES])
{
    struct stat st;
    blob_path(c, digest, path);
    pin->fd = open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (pin->fd < 0) return ERR_NOT_FOUND;
    /* Evicted between the two calls: the name is gone, or another file's. */
    if (flock(pin->fd, LOCK_SH) != 0 || fstat(pin->fd, &st) != 0 || st.st_nlink == 0) {
        blob_files_unpin(pin);
        return ERR_NOT_FOUND;
    }
    futimens(pin->fd, NULL);
    return 0;
}

void blob_files_unpin(struct blob_pin *pin)
{
    if (pin->fd >= 0) close(pin->fd);
    pin->fd = -1;
}

/* ---- fetching ---- */

static int open_part(const char *path)
{
    int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (fd < 0) return -1;
    struct stat st;
    if (flock(fd, LOCK_EX | LOCK_NB) == 0 && fstat(fd, &st) == 0 && st.st_nlink > 0) return fd;
    close(fd);
    return -1;
}

int blob_fetch_begin(const struct blob_files *c, const struct digest *digest, struct blob_fetch *f,
                     struct fault *fault)
{
    char hex[DIGEST_HEX_BYTES];
    digest_to_hex(digest, hex);
    *f = (struct blob_fetch){.digest = *digest};
    snprintf(f->path, sizeof f->path, "%s/%s/%s", c->dir, PARTS, hex);
    f->fd = open_part(f->path);
    if (f->fd < 0) { /* another worker is fetching it */
        snprintf(f->path, sizeof f->path, "%s/%s/%s.%ld", c->dir, PARTS, hex, (long)getpid());
        f->fd = open_part(f->path);
    }
    if (f->fd < 0)
        return fault_set(fault, ERR_IO, f->path, "the part cannot be opened: %s",
                         strerrordesc_np(errno));
    struct stat st;
    f->have_bytes = fstat(f->fd, &st) == 0 ? (uint64_t)st.st_size : 0;
    return 0;
}

static int write_fully(int fd, const uint8_t *data, size_t size_bytes, uint64_t offset)
{
    while (size_bytes > 0) {
        ssize_t n = pwrite(fd, data, size_bytes, (off_t)offset);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return ERR_IO;
        data += n;
        offset += (uint64_t)n;
        size_bytes -= (size_t)n;
    }
    return 0;
}

static int learn_total(const struct blob_files *c, struct blob_fetch *f, uint64_t total_bytes,
                       struct fault *fault)
{
    if (total_bytes == 0 || total_bytes > LIMIT_BLOB_BYTES)
        return fault_set(fault, ERR_LIMIT, "blob", "it has %llu bytes, and may have 1 to %llu",
                         (unsigned long long)total_bytes, (unsigned long long)LIMIT_BLOB_BYTES);
    if (f->have_bytes > total_bytes) {
        /* Longer than the blob: no part of it. */
        if (ftruncate(f->fd, 0) != 0) return fault_set(fault, ERR_IO, f->path, "cannot be emptied");
        f->have_bytes = 0;
    }
    int e = make_room(c, total_bytes - f->have_bytes);
    if (e == ERR_FULL)
        return fault_set(fault, e, c->dir,
                         "a scene of %llu bytes does not fit into the cache's %llu: raise "
                         "--cache-bytes",
                         (unsigned long long)total_bytes, (unsigned long long)c->limit_bytes);
    if (e) return fault_set(fault, e, c->dir, "%s", error_text(e));
    f->total_bytes = total_bytes;
    return 0;
}

int blob_fetch_part(const struct blob_files *c, struct blob_fetch *f, uint64_t total_bytes,
                    uint64_t offset, const void *data, uint32_t size_bytes, struct fault *fault)
{
    int e = f->total_bytes ? 0 : learn_total(c, f, total_bytes, fault);
    if (e) return e;
    if (total_bytes != f->total_bytes || offset != f->have_bytes || size_bytes == 0 ||
        size_bytes > f->total_bytes - f->have_bytes)
        return fault_set(
            fault, ERR_MISMATCH, "blob",
            "a part of %u bytes came at %llu of %llu, and was expected at %llu of %llu", size_bytes,
            (unsigned long long)offset, (unsigned long long)total_bytes,
            (unsigned long long)f->have_bytes, (unsigned long long)f->total_bytes);
    if (write_fully(f->fd, data, size_bytes, offset) != 0)
        return fault_set(fault, ERR_IO, f->path, "cannot be written: %s", strerrordesc_np(errno));
    f->have_bytes += size_bytes;
    return 0;
}

bool blob_fetch_is_whole(const struct blob_fetch *f)
{
    return f->total_bytes > 0 && f->have_bytes == f->total_bytes;
}

static int hash_file(int fd, uint64_t size_bytes, _Atomic uint64_t *steps, struct digest *out)
{
    struct digest_state *state = digest_begin();
    uint8_t *buffer = malloc(HASH_BYTES);
    int e = state && buffer ? 0 : ERR_MEMORY;
    for (uint64_t at = 0; e == 0 && at < size_bytes;) {
        ssize_t n = pread(fd, buffer, HASH_BYTES, (off_t)at);
        if (n < 0 && errno == EINTR) continue;
        e = n <= 0 ? ERR_IO : digest_update(state, buffer, (size_t)n);
        if (n > 0) at += (uint64_t)n;
        if (steps) atomic_fetch_add_explicit(steps, 1, memory_order_relaxed);
    }
    free(buffer);
    if (state) digest_finish(&state, out);
    return e;
}

static int put_in_place(const struct blob_files *c, const struct blob_fetch *f)
{
    char path[BLOB_FILES_PATH_BYTES], folder[BLOB_FILES_PATH_BYTES];
    blob_path(c, &f->digest, path);
    snprintf(folder, sizeof folder, "%.*s", (int)(strrchr(path, '/') - path), path);
    if (make_dir(folder) != 0) return ERR_IO;
    futimens(f->fd, NULL);
    /* What stands in its place is never hashed again: it must not be found torn after a crash. */
    if (fdatasync(f->fd) != 0) return ERR_IO;
    return rename(f->path, path) == 0 ? 0 : ERR_IO;
}

int blob_fetch_finish(const struct blob_files *c, struct blob_fetch *f, struct fault *fault)
{
    struct digest found;
    int e = hash_file(f->fd, f->total_bytes, f->steps, &found);
    if (e == 0 && !digest_equal(&found, &f->digest)) e = ERR_CHECKSUM;
    if (e == ERR_CHECKSUM) unlink(f->path);
    if (e == 0) e = put_in_place(c, f);
    if (e)
        fault_set(fault, e, f->path, "%s%s%s", error_text(e), e == ERR_IO ? ": " : "",
                  e == ERR_IO ? strerrordesc_np(errno) : "");
    blob_fetch_abort(f);
    return e;
}

void blob_fetch_abort(struct blob_fetch *f)
{
    if (f->fd >= 0) close(f->fd); /* and the lock with it */
    f->fd = -1;
}
