#include "server/store/asset_owners.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/store/job_store.h"

bool asset_owners_is_name(const char *owner)
{
    size_t n = strspn(owner, "abcdefghijklmnopqrstuvwxyz0123456789-_");
    return n > 0 && n < JOB_OWNER_BYTES && owner[n] == '\0';
}

static bool path_of(const struct objects *o, const char *owner, const struct digest *d,
                    char out[OBJECTS_PATH_BYTES])
{
    char hex[DIGEST_HEX_BYTES];
    digest_to_hex(d, hex);
    if (!asset_owners_is_name(owner)) return false;
    int n = snprintf(out, OBJECTS_PATH_BYTES, "%s/owners/%s/%.2s/%s", o->dir, owner, hex, hex + 2);
    return n > 0 && n < OBJECTS_PATH_BYTES;
}

/* The entry of `path` in its folder is on the disk. */
static int sync_parent(const char *path)
{
    char parent[OBJECTS_PATH_BYTES];
    size_t n = (size_t)(strrchr(path, '/') - path);
    memcpy(parent, path, n);
    parent[n] = '\0';
    int fd = open(parent, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) return error_of_errno(errno);
    int error = fsync(fd) ? error_of_errno(errno) : 0;
    close(fd);
    return error;
}

/* The folders above the file that are not there yet, each durable before the next. */
static int make_parents(char *path, size_t from)
{
    int error = 0;
    for (char *slash = path + from; !error && (slash = strchr(slash + 1, '/'));) {
        *slash = '\0';
        if (mkdir(path, 0700) == 0)
            error = sync_parent(path);
        else if (errno != EEXIST)
            error = error_of_errno(errno);
        *slash = '/';
    }
    return error;
}

int asset_owners_add(const struct objects *o, const char *owner, const struct digest *d,
                     bool *existed)
{
    char path[OBJECTS_PATH_BYTES];
    *existed = false;
    if (!path_of(o, owner, d, path)) return ERR_LIMIT;
    int error = make_parents(path, strlen(o->dir));
    if (error) return error;
    int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (fd < 0) {
        *existed = errno == EEXIST;
        return *existed ? 0 : error_of_errno(errno);
    }
    close(fd);
    return sync_parent(path);
}

bool asset_owners_have(const struct objects *o, const char *owner, const struct digest *d)
{
    char path[OBJECTS_PATH_BYTES];
    return path_of(o, owner, d, path) && access(path, F_OK) == 0;
}

/* One of the 256 folders: names are what is left of the digests, `first` the two digits before. */
static int sum_folder(const struct objects *o, const char *path, const char *first, uint64_t *bytes)
{
    const struct dirent *entry;
    struct digest digest;
    uint64_t size_bytes;
    DIR *dir = opendir(path);
    if (!dir) return ERR_IO;
    while ((entry = readdir(dir))) {
        char hex[DIGEST_HEX_BYTES];
        const int n = snprintf(hex, sizeof hex, "%.2s%s", first, entry->d_name);
        if (n == DIGEST_HEX_BYTES - 1 && digest_from_hex(hex, &digest) == 0 &&
            objects_have(o, &digest, &size_bytes))
            *bytes += size_bytes;
    }
    closedir(dir);
    return 0;
}

int asset_owners_sum(const struct objects *o, const char *owner, uint64_t *bytes)
{
    char path[OBJECTS_PATH_BYTES];
    const struct dirent *entry;
    *bytes = 0;
    if (!asset_owners_is_name(owner)) return ERR_LIMIT;
    int n = snprintf(path, sizeof path, "%s/owners/%s/", o->dir, owner), error = 0;
    if (n < 0 || (size_t)n + 3 > sizeof path) return ERR_LIMIT;
    DIR *dir = opendir(path);
    if (!dir) return errno == ENOENT ? 0 : ERR_IO;
    while (!error && (entry = readdir(dir))) {
        if (strspn(entry->d_name, "0123456789abcdef") != 2 || entry->d_name[2]) continue;
        memcpy(path + n, entry->d_name, 3);
        error = sum_folder(o, path, entry->d_name, bytes);
    }
    closedir(dir);
    return error;
}
