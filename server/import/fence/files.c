#include "server/import/fence/files.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <linux/openat2.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "proto/scene/relative_path.h"

int files_open(struct files *files, const char *root, struct fault *fault)
{
    files->opened = 0;
    files->root_fd = open(root, O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (files->root_fd < 0)
        return fault_set(fault, ERR_IO, root, "cannot be opened: %s", strerror(errno));
    return 0;
}

void files_close(struct files *files)
{
    if (files->root_fd >= 0) close(files->root_fd);
    files->root_fd = -1;
}

/* Opens a path step by step, following no link, on kernels without openat2. The path was checked
 * before. */
static int open_stepwise(int root_fd, const char *path)
{
    int at = dup(root_fd);
    while (at >= 0) {
        char part[LIMIT_PATH_BYTES];
        size_t length = strcspn(path, "/");
        memcpy(part, path, length);
        part[length] = 0;
        bool last = path[length] == 0;
        int flags = last ? O_RDONLY | O_NONBLOCK : O_PATH | O_DIRECTORY;
        int next = openat(at, part, flags | O_NOFOLLOW | O_CLOEXEC);
        int why = errno;
        close(at);
        errno = why;
        if (last) return next;
        at = next;
        path += length + 1;
    }
    return -1;
}

static int open_beneath(int root_fd, const char *path)
{
    struct open_how how = {.flags = O_RDONLY | O_CLOEXEC | O_NONBLOCK,
                           .resolve =
                               RESOLVE_BENEATH | RESOLVE_NO_SYMLINKS | RESOLVE_NO_MAGICLINKS};
    long fd = syscall(SYS_openat2, root_fd, path, &how, sizeof how);
    if (fd < 0 && (errno == ENOSYS || errno == EPERM)) return open_stepwise(root_fd, path);
    return (int)fd;
}

static int map_descriptor(int fd, const char *path, const char *place, struct file_view *out,
                          struct fault *fault)
{
    struct stat st;
    if (fstat(fd, &st) != 0 || !S_ISREG(st.st_mode))
        return fault_set(fault, ERR_IO, place, "\"%s\" is not a regular file", path);
    if ((uint64_t)st.st_size > LIMIT_ASSET_BYTES)
        return fault_set(fault, ERR_LIMIT, place, "\"%s\" has more than %llu bytes", path,
                         LIMIT_ASSET_BYTES);
    *out = (struct file_view){(const uint8_t *)"", 0};
    if (st.st_size == 0) return 0;
    void *data = mmap(NULL, (size_t)st.st_size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (data == MAP_FAILED)
        return fault_set(fault, ERR_MEMORY, place, "no memory for \"%s\"", path);
    *out = (struct file_view){data, (size_t)st.st_size};
    return 0;
}

int files_map(struct files *files, const char *path, const char *place, struct file_view *out,
              struct fault *fault)
{
    if (!relative_path_is_inside(path))
        return fault_set(fault, ERR_RANGE, place, "\"%s\" leaves the scene's folder", path);
    if (files->opened > LIMIT_SCENE_FILES)
        return fault_set(fault, ERR_LIMIT, place, "the scene has more than %d files",
                         LIMIT_SCENE_FILES);
    int fd = open_beneath(files->root_fd, path);
    if (fd < 0 && errno == ENOENT)
        return fault_set(fault, ERR_NOT_FOUND, place, "the file \"%s\" is missing", path);
    if (fd < 0)
        return fault_set(fault, ERR_IO, place, "\"%s\" cannot be opened: %s", path,
                         strerror(errno));
    files->opened++;
    int rc = map_descriptor(fd, path, place, out, fault);
    close(fd);
    return rc;
}

void files_unmap(struct file_view *view)
{
    if (view->size_bytes > 0) munmap((void *)(uintptr_t)view->data, view->size_bytes);
    *view = (struct file_view){(const uint8_t *)"", 0};
}

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

/* Copies `name` to out, decoding %XX. False when it does not fit or an escape is broken. */
static bool decode_name(const char *name, bool decode_percent, char out[LIMIT_PATH_BYTES])
{
    size_t n = 0;
    for (; *name != 0; name++) {
        if (n == LIMIT_PATH_BYTES - 1) return false;
        char c = *name;
        if (decode_percent && c == '%') {
            int high = hex_digit(name[1]), low = high < 0 ? -1 : hex_digit(name[2]);
            if (low < 0 || high * 16 + low == 0) return false;
            c = (char)(high * 16 + low);
            name += 2;
        }
        out[n++] = c;
    }
    out[n] = 0;
    return true;
}

/* Appends the parts of `path` to out, leaving out ".". False when it does not fit. */
static bool append_parts(char out[LIMIT_PATH_BYTES], const char *path)
{
    size_t n = strlen(out);
    while (*path != 0) {
        size_t length = strcspn(path, "/");
        bool dot = length == 1 && path[0] == '.';
        if (!dot) {
            if (n + length + 2 > LIMIT_PATH_BYTES) return false;
            if (n > 0) out[n++] = '/';
            memcpy(out + n, path, length);
            n += length;
            out[n] = 0;
        }
        path += length;
        if (*path == '/') path++;
    }
    return true;
}

int files_resolve(const char *beside, const char *name, bool decode_percent,
                  char out[LIMIT_PATH_BYTES], const char *place, struct fault *fault)
{
    char decoded[LIMIT_PATH_BYTES] = "", folder[LIMIT_PATH_BYTES] = "";
    const char *slash = strrchr(beside, '/');
    size_t folder_length = slash == NULL ? 0 : (size_t)(slash - beside);
    if (folder_length >= LIMIT_PATH_BYTES || !decode_name(name, decode_percent, decoded))
        return fault_set(fault, ERR_SYNTAX, place, "\"%.200s\" is no file name", name);
    if (decoded[0] == '/' || strstr(decoded, "://") != NULL)
        return fault_set(fault, ERR_RANGE, place,
                         "\"%.200s\" is not relative to the scene's folder", decoded);
    memcpy(folder, beside, folder_length);
    folder[folder_length] = 0;
    out[0] = 0;
    if (!append_parts(out, folder) || !append_parts(out, decoded))
        return fault_set(fault, ERR_LIMIT, place, "the name is longer than %d bytes",
                         LIMIT_PATH_BYTES - 1);
    if (!relative_path_is_inside(out))
        return fault_set(fault, ERR_RANGE, place, "\"%.200s\" leaves the scene's folder", decoded);
    return 0;
}
