#include "server/store/marks.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static bool path_of(const struct objects *o, const char *kind, const struct digest *d,
                    char out[OBJECTS_PATH_BYTES])
{
    char hex[DIGEST_HEX_BYTES];
    digest_to_hex(d, hex);
    int n = snprintf(out, OBJECTS_PATH_BYTES, "%s/%s/%.2s/%s", o->dir, kind, hex, hex + 2);
    return n > 0 && n < OBJECTS_PATH_BYTES;
}

/* The folders above the file that are not there yet, each durable before the next. */
static int make_parents(char *path, size_t from)
{
    int error = 0;
    for (char *slash = path + from; !error && (slash = strchr(slash + 1, '/'));) {
        *slash = '\0';
        if (mkdir(path, 0700) == 0)
            error = objects_sync_parent(path);
        else if (errno != EEXIST)
            error = error_of_errno(errno);
        *slash = '/';
    }
    return error;
}

int marks_add(const struct objects *o, const char *kind, const struct digest *d, bool *existed)
{
    char path[OBJECTS_PATH_BYTES];
    *existed = false;
    if (!path_of(o, kind, d, path)) return ERR_LIMIT;
    int error = make_parents(path, strlen(o->dir));
    if (error) return error;
    int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (fd < 0) {
        *existed = errno == EEXIST;
        return *existed ? 0 : error_of_errno(errno);
    }
    close(fd);
    return objects_sync_parent(path);
}

int marks_remove(const struct objects *o, const char *kind, const struct digest *d)
{
    char path[OBJECTS_PATH_BYTES];
    if (!path_of(o, kind, d, path)) return ERR_LIMIT;
    if (unlink(path) == 0) return objects_sync_parent(path);
    return errno == ENOENT ? ERR_NOT_FOUND : error_of_errno(errno);
}

bool marks_have(const struct objects *o, const char *kind, const struct digest *d)
{
    char path[OBJECTS_PATH_BYTES];
    return path_of(o, kind, d, path) && access(path, F_OK) == 0;
}

/* One of the 256 folders: names are what is left of the digests, `first` the two digits before. */
static int each_in_folder(const char *path, const char *first, marks_found each, void *ctx)
{
    const struct dirent *entry;
    struct digest digest;
    DIR *dir = opendir(path);
    if (!dir) return ERR_IO;
    while ((entry = readdir(dir))) {
        char hex[DIGEST_HEX_BYTES];
        const int n = snprintf(hex, sizeof hex, "%.2s%s", first, entry->d_name);
        if (n == DIGEST_HEX_BYTES - 1 && digest_from_hex(hex, &digest) == 0) each(ctx, &digest);
    }
    closedir(dir);
    return 0;
}

int marks_each(const struct objects *o, const char *kind, marks_found each, void *ctx)
{
    char path[OBJECTS_PATH_BYTES];
    const struct dirent *entry;
    int n = snprintf(path, sizeof path, "%s/%s/", o->dir, kind), error = 0;
    if (n < 0 || (size_t)n + 3 > sizeof path) return ERR_LIMIT;
    DIR *dir = opendir(path);
    if (!dir) return errno == ENOENT ? 0 : ERR_IO;
    while (!error && (entry = readdir(dir))) {
        if (strspn(entry->d_name, "0123456789abcdef") != 2 || entry->d_name[2]) continue;
        memcpy(path + n, entry->d_name, 3);
        error = each_in_folder(path, entry->d_name, each, ctx);
    }
    closedir(dir);
    return error;
}
