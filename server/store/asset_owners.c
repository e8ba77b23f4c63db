#include "server/store/asset_owners.h"

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

int asset_owners_add(const struct objects *o, const char *owner, const struct digest *d)
{
    char path[OBJECTS_PATH_BYTES];
    if (!path_of(o, owner, d, path)) return ERR_LIMIT;
    int error = make_parents(path, strlen(o->dir));
    if (error) return error;
    int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (fd < 0) return errno == EEXIST ? 0 : error_of_errno(errno);
    close(fd);
    return sync_parent(path);
}

bool asset_owners_have(const struct objects *o, const char *owner, const struct digest *d)
{
    char path[OBJECTS_PATH_BYTES];
    return path_of(o, owner, d, path) && access(path, F_OK) == 0;
}
