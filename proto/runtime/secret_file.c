#include "proto/runtime/secret_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static mode_t forbidden(const struct stat *info, enum secret_readers readers)
{
    const bool group_reads = readers == SECRET_READERS_GROUP || info->st_uid != geteuid();
    return S_IRWXO | S_IWGRP | (group_reads ? 0 : S_IRGRP);
}

static int check(int fd, const char *path, enum secret_readers readers, size_t limit_bytes,
                 struct fault *fault)
{
    struct stat info;
    if (fstat(fd, &info) != 0) return fault_set(fault, ERR_IO, path, "%s", strerror(errno));
    if (!S_ISREG(info.st_mode)) return fault_set(fault, ERR_TYPE, path, "is no regular file");
    if (info.st_mode & forbidden(&info, readers))
        return fault_set(fault, ERR_STATE, path,
                         "others may read or change it (mode %03o): chmod 600 it",
                         (unsigned)info.st_mode & 0777u);
    if (info.st_uid != geteuid() && info.st_uid != 0)
        return fault_set(fault, ERR_STATE, path, "belongs to user %u, neither to %u nor to root",
                         (unsigned)info.st_uid, (unsigned)geteuid());
    if (info.st_size < 0 || (size_t)info.st_size > limit_bytes)
        return fault_set(fault, ERR_LIMIT, path, "has more than %zu bytes", limit_bytes);
    return 0;
}

/* Reads at most limit_bytes, whatever the file has become meanwhile. */
static int read_all(int fd, char *text, size_t limit_bytes, size_t *size_bytes)
{
    size_t at = 0;
    while (at < limit_bytes) {
        ssize_t got = read(fd, text + at, limit_bytes - at);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return ERR_IO;
        if (got == 0) break;
        at += (size_t)got;
    }
    text[at] = '\0';
    *size_bytes = at;
    return 0;
}

int secret_file_read(const char *path, enum secret_readers readers, size_t limit_bytes, char **out,
                     size_t *size_bytes, struct fault *fault)
{
    int fd = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0)
        return fault_set(fault, errno == ENOENT ? ERR_NOT_FOUND : ERR_IO, path, "%s",
                         strerror(errno));
    int error = check(fd, path, readers, limit_bytes, fault);
    char *text = error ? NULL : malloc(limit_bytes + 1);
    if (!error && !text) error = fault_set(fault, ERR_MEMORY, path, "memory is exhausted");
    if (text && (error = read_all(fd, text, limit_bytes, size_bytes)) != 0)
        fault_set(fault, error, path, "%s", strerror(errno));
    close(fd);
    if (error)
        free(text);
    else
        *out = text;
    return error;
}

static int write_all(int fd, const char *text, size_t size_bytes)
{
    for (size_t at = 0; at < size_bytes;) {
        ssize_t put = write(fd, text + at, size_bytes - at);
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) return -1;
        at += (size_t)put;
    }
    return fsync(fd);
}

/* Gives the new file the owner, group and mode of the old one, but no access for others. */
static int keep_readers(int fd, const char *path)
{
    struct stat old;
    if (stat(path, &old) != 0) return errno == ENOENT ? 0 : -1;
    if (old.st_uid != geteuid() || old.st_gid != getegid())
        if (fchown(fd, old.st_uid, old.st_gid) != 0) return -1;
    return fchmod(fd, old.st_mode & 0640);
}

int secret_file_write(const char *path, const char *text, size_t size_bytes, struct fault *fault)
{
    char beside[4096];
    int n = snprintf(beside, sizeof beside, "%s.XXXXXX", path);
    if (n < 0 || (size_t)n >= sizeof beside)
        return fault_set(fault, ERR_LIMIT, "", "the file's path is too long");
    int fd = mkostemp(beside, O_CLOEXEC); /* mode 600 */
    if (fd < 0) return fault_set(fault, ERR_IO, path, "%s", strerror(errno));
    int failed = write_all(fd, text, size_bytes) || keep_readers(fd, path);
    failed |= close(fd);
    if (!failed) failed = rename(beside, path);
    if (!failed) return 0;
    int error = fault_set(fault, ERR_IO, path, "%s", strerror(errno));
    unlink(beside);
    return error;
}
