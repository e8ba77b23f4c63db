#include "server/store/objects.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define READ_BYTES 262144

struct object_writer {
    const struct objects *objects; /* borrowed */
    struct digest_state *hash;     /* owned */
    uint64_t size_bytes;           /* appended so far */
    int fd;
    int error; /* the first failure; sticks */
    char path[OBJECTS_PATH_BYTES];
};

static int sync_folder(const char *path)
{
    int fd = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) return error_of_errno(errno);
    int error = fsync(fd) ? error_of_errno(errno) : 0;
    close(fd);
    return error;
}

static int sync_file(const struct objects *o, int fd)
{
    return !o->ephemeral && fsync(fd) ? error_of_errno(errno) : 0;
}

static int sync_dir(const struct objects *o, const char *path)
{
    return o->ephemeral ? 0 : sync_folder(path);
}

/* The entry of `path` in its folder is on the disk. */
static int sync_parent(const char *path)
{
    char parent[OBJECTS_PATH_BYTES];
    const char *slash = strrchr(path, '/');
    const size_t n = slash ? (size_t)(slash - path) : 0;
    if (n == 0 || n >= sizeof parent) return ERR_LIMIT;
    memcpy(parent, path, n);
    parent[n] = '\0';
    return sync_folder(parent);
}

/* Makes a folder and its missing parents. */
static int make_dirs(const char *path)
{
    char part[OBJECTS_PATH_BYTES];
    size_t length = strlen(path);
    if (length == 0 || length >= sizeof part) return ERR_LIMIT;
    for (size_t i = 1; i <= length; i++) {
        if (i < length && path[i] != '/') continue;
        memcpy(part, path, i);
        part[i] = 0;
        if (mkdir(part, 0777) && errno != EEXIST) return error_of_errno(errno);
    }
    return 0;
}

static int remove_entry(const char *path, const struct stat *st, int type, struct FTW *at)
{
    (void)st;
    (void)type;
    if (at->level > 0) remove(path);
    return 0; /* what cannot be removed stays: it only takes room */
}

/* Tries again where there was no memory to read the folder: what stays lies there until a restart.
 */
static void sweep(const char *dir)
{
    unsigned tries = 3;
    while (tries-- > 0 && nftw(dir, remove_entry, 16, FTW_DEPTH | FTW_PHYS | FTW_MOUNT) != 0)
        if (errno != ENOMEM) return;
}

void objects_remove_dir(const char *dir)
{
    sweep(dir);
    rmdir(dir);
}

static void tmp_path(const struct objects *o, char out[OBJECTS_PATH_BYTES], const char *name)
{
    snprintf(out, OBJECTS_PATH_BYTES, "%s/tmp/%s", o->dir, name);
}

static void init_holds(struct object_holds *h)
{
    for (int i = 0; i < OBJECT_STRIPES; i++) {
        pthread_mutex_init(&h->locks[i], NULL);
        atomic_init(&h->counts[i], 0);
    }
}

int objects_open(struct objects *o, const char *dir, bool ephemeral)
{
    if (snprintf(o->dir, sizeof o->dir, "%s", dir) >= (int)sizeof o->dir) return ERR_LIMIT;
    o->holds = &o->own_holds;
    o->ephemeral = ephemeral;
    init_holds(o->holds);
    char path[OBJECTS_PATH_BYTES];
    snprintf(path, sizeof path, "%s/objects", o->dir);
    int error = make_dirs(path);
    tmp_path(o, path, "");
    path[strlen(path) - 1] = 0; /* no slash at the end */
    if (!error) error = make_dirs(path);
    if (error) return error;
    sweep(path);
    return sync_dir(o, o->dir);
}

void objects_path(const struct objects *o, const struct digest *d, char out[OBJECTS_PATH_BYTES])
{
    char hex[DIGEST_HEX_BYTES];
    digest_to_hex(d, hex);
    snprintf(out, OBJECTS_PATH_BYTES, "%s/objects/%.2s/%s", o->dir, hex, hex + 2);
}

bool objects_have(const struct objects *o, const struct digest *d, uint64_t *size_bytes)
{
    char path[OBJECTS_PATH_BYTES];
    objects_path(o, d, path);
    struct stat st;
    if (stat(path, &st) || !S_ISREG(st.st_mode)) return false;
    if (size_bytes) *size_bytes = (uint64_t)st.st_size;
    return true;
}

bool objects_lack(const struct objects *o, const struct digest *d)
{
    char path[OBJECTS_PATH_BYTES];
    struct stat st;
    objects_path(o, d, path);
    return stat(path, &st) != 0 && errno == ENOENT;
}

/* The folder of a digest's file; made when it is missing. */
static int make_place(const struct objects *o, const struct digest *d, char out[OBJECTS_PATH_BYTES])
{
    char hex[DIGEST_HEX_BYTES];
    digest_to_hex(d, hex);
    snprintf(out, OBJECTS_PATH_BYTES, "%s/objects/%.2s", o->dir, hex);
    if (!mkdir(out, 0777)) {
        char parent[OBJECTS_PATH_BYTES];
        snprintf(parent, sizeof parent, "%s/objects", o->dir);
        return sync_dir(o, parent);
    }
    return errno == EEXIST ? 0 : error_of_errno(errno);
}

/* True when a file of this size is at `path`. A shorter one is none of ours: ours are whole. */
static bool is_there(const char *path, off_t size)
{
    struct stat st;
    return !stat(path, &st) && S_ISREG(st.st_mode) && st.st_size == size;
}

/* Gives the finished and synced file at `from` its name. Two writers of one digest may meet here:
 * the last to rename replaces equal bytes by equal bytes. */
static int place_locked(const struct objects *o, const char *from, const struct digest *d,
                        bool *existed)
{
    char dir[OBJECTS_PATH_BYTES], path[OBJECTS_PATH_BYTES];
    struct stat st;
    objects_path(o, d, path);
    if (stat(from, &st)) return error_of_errno(errno);
    int error = make_place(o, d, dir);
    if (error) return error;
    *existed = is_there(path, st.st_size);
    if (*existed)
        unlink(from);
    else if (rename(from, path))
        return error_of_errno(errno);
    /* Also when it was there: its writer may not have come to this line yet. */
    return sync_dir(o, dir);
}

/* Places a file and holds it before another thread may remove it. */
static int place(const struct objects *o, const char *from, const struct digest *d, bool *existed)
{
    pthread_mutex_lock(&o->holds->locks[d->bytes[0]]);
    const int error = place_locked(o, from, d, existed);
    if (!error) objects_hold(o, d);
    pthread_mutex_unlock(&o->holds->locks[d->bytes[0]]);
    return error;
}

void objects_hold(const struct objects *o, const struct digest *d)
{
    atomic_fetch_add(&o->holds->counts[d->bytes[0]], 1);
}

void objects_release(const struct objects *o, const struct digest *d)
{
    const unsigned before = atomic_fetch_sub(&o->holds->counts[d->bytes[0]], 1);
    assert(before > 0);
}

bool objects_is_held(const struct objects *o, const struct digest *d)
{
    return atomic_load(&o->holds->counts[d->bytes[0]]) > 0;
}

static int remove_locked(const struct objects *o, const struct digest *d, objects_is_free is_free,
                         void *ctx)
{
    char path[OBJECTS_PATH_BYTES];
    if (objects_is_held(o, d)) return ERR_STATE;
    if (!is_free(ctx, d)) return ERR_EXISTS;
    objects_path(o, d, path);
    if (unlink(path) == 0) return o->ephemeral ? 0 : sync_parent(path);
    return errno == ENOENT ? 0 : error_of_errno(errno);
}

int objects_remove(const struct objects *o, const struct digest *d, objects_is_free is_free,
                   void *ctx)
{
    if (objects_is_held(o, d)) return ERR_STATE; /* without waiting for a thread that places it */
    pthread_mutex_lock(&o->holds->locks[d->bytes[0]]);
    const int error = remove_locked(o, d, is_free, ctx);
    pthread_mutex_unlock(&o->holds->locks[d->bytes[0]]);
    return error;
}

static int hash_file(int fd, struct digest *out)
{
    struct digest_state *hash = digest_begin();
    uint8_t *buffer = malloc(READ_BYTES);
    int error = hash && buffer ? 0 : ERR_MEMORY;
    off_t offset = 0;
    while (!error) {
        ssize_t n = pread(fd, buffer, READ_BYTES, offset);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) error = error_of_errno(errno);
        if (n <= 0) break;
        error = digest_update(hash, buffer, (size_t)n);
        offset += n;
    }
    struct digest ignored;
    if (hash) digest_finish(&hash, error ? &ignored : out);
    free(buffer);
    return error;
}

/* Hashes and syncs a file that another program has written. */
static int seal_file(const struct objects *o, const char *path, struct digest *out)
{
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (fd < 0) return errno == ENOENT ? ERR_NOT_FOUND : error_of_errno(errno);
    int error = hash_file(fd, out);
    if (!error) error = sync_file(o, fd);
    close(fd);
    return error;
}

int objects_adopt(const struct objects *o, const char *path, struct digest *out)
{
    bool existed;
    int error = seal_file(o, path, out);
    return error ? error : place(o, path, out, &existed);
}

int objects_make_dir(const struct objects *o, char out[OBJECTS_PATH_BYTES])
{
    tmp_path(o, out, "dir-XXXXXX");
    return mkdtemp(out) ? 0 : error_of_errno(errno);
}

static void writer_free(struct object_writer **writer)
{
    struct object_writer *w = *writer;
    if (w->fd >= 0) close(w->fd);
    struct digest ignored;
    if (w->hash) digest_finish(&w->hash, &ignored);
    free(w);
    *writer = NULL;
}

int object_writer_begin(const struct objects *o, struct object_writer **out)
{
    *out = NULL;
    struct object_writer *w = calloc(1, sizeof *w);
    if (!w) return ERR_MEMORY;
    w->objects = o;
    w->fd = -1;
    w->hash = digest_begin();
    int error = w->hash ? 0 : ERR_MEMORY;
    tmp_path(o, w->path, "object-XXXXXX");
    if (!error) {
        w->fd = mkostemp(w->path, O_CLOEXEC); /* O_EXCL, a name of its own */
        if (w->fd < 0) error = error_of_errno(errno);
    }
    if (error) {
        writer_free(&w);
        return error;
    }
    *out = w;
    return 0;
}

static int write_all(int fd, const uint8_t *data, size_t size_bytes)
{
    while (size_bytes > 0) {
        ssize_t n = write(fd, data, size_bytes);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return error_of_errno(errno);
        data += n;
        size_bytes -= (size_t)n;
    }
    return 0;
}

int object_writer_append(struct object_writer *w, const void *data, size_t size_bytes)
{
    if (size_bytes == 0 || w->error) return w->error;
    w->error = write_all(w->fd, data, size_bytes);
    if (!w->error) w->error = digest_update(w->hash, data, size_bytes);
    w->size_bytes += size_bytes;
    return w->error;
}

const char *object_writer_path(const struct object_writer *w)
{
    return w->path;
}

/* The digest of what was appended, or else of what a library wrote at the path (which may be
 * another file than the one opened, when the library renames). */
static int writer_seal(struct object_writer *w, struct digest *out)
{
    if (w->error) return w->error;
    if (w->size_bytes == 0) return seal_file(w->objects, w->path, out);
    digest_finish(&w->hash, out);
    return sync_file(w->objects, w->fd);
}

int object_writer_seal(struct object_writer *w, const struct digest *expected, struct digest *out)
{
    *out = (struct digest){0};
    const int error = writer_seal(w, out);
    return error || !expected || digest_equal(expected, out) ? error : ERR_MISMATCH;
}

int object_writer_place(struct object_writer **w, const struct digest *d, bool *existed)
{
    bool there = false;
    const int error = place((*w)->objects, (*w)->path, d, &there);
    if (error) unlink((*w)->path);
    if (existed) *existed = there;
    writer_free(w);
    return error;
}

int object_writer_finish(struct object_writer **w, const struct digest *expected,
                         struct digest *out, bool *existed)
{
    const int error = object_writer_seal(*w, expected, out);
    if (!error) return object_writer_place(w, out, existed);
    if (existed) *existed = false;
    object_writer_abort(w);
    return error;
}

void object_writer_abort(struct object_writer **writer)
{
    if (!*writer) return;
    unlink((*writer)->path);
    writer_free(writer);
}

/* Larger than what file systems keep beside a file's name. */
#define PROBE_BYTES 65536u

int objects_probe(const struct objects *o)
{
    static const uint8_t nothing[PROBE_BYTES];
    struct object_writer *w;
    int error = object_writer_begin(o, &w);
    if (error) return error;
    error = object_writer_append(w, nothing, sizeof nothing);
    if (!error) error = sync_file(w->objects, w->fd);
    object_writer_abort(&w);
    return error;
}
