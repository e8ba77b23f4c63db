#include "server/http/static_files.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/http/request.h"

#define FILES_MAX        256u
#define FILE_LIMIT_BYTES (4u << 20)
#define DEPTH_MAX        4

struct static_files {
    size_t count;
    struct static_file file[FILES_MAX];
};

static const struct {
    const char *ending, *type;
} types[] = {
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".mjs", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".ico", "image/x-icon"},
    {".json", "application/json"},
    {".webmanifest", "application/manifest+json"},
    {".txt", "text/plain; charset=utf-8"},
    {".yaml", "application/yaml"},
    {".woff2", "font/woff2"},
};

static const char *type_of(const char *name)
{
    const char *dot = strrchr(name, '.');
    for (size_t i = 0; dot && i < sizeof types / sizeof types[0]; i++)
        if (strcmp(dot, types[i].ending) == 0) return types[i].type;
    return NULL;
}

static int read_whole(int fd, char *data, size_t size_bytes)
{
    for (size_t at = 0; at < size_bytes;) {
        ssize_t got = read(fd, data + at, size_bytes - at);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return ERR_IO;
        at += (size_t)got;
    }
    return 0;
}

/* Takes the descriptor. */
static int add(struct static_files *files, int fd, const char *path, struct fault *fault)
{
    struct static_file *f = &files->file[files->count];
    struct stat info;
    int error = 0;
    if (files->count == FILES_MAX || strlen(path) >= sizeof f->path || fstat(fd, &info) != 0 ||
        !S_ISREG(info.st_mode) || info.st_size > (off_t)FILE_LIMIT_BYTES) {
        close(fd);
        return fault_set(fault, ERR_LIMIT, path,
                         "the page's files are at most %u, each a plain file of at most %u bytes",
                         FILES_MAX, FILE_LIMIT_BYTES);
    }
    f->size_bytes = (size_t)info.st_size;
    f->data = malloc(f->size_bytes + 1);
    error = f->data ? read_whole(fd, f->data, f->size_bytes) : ERR_MEMORY;
    close(fd);
    if (error) {
        free(f->data);
        f->data = NULL;
        return fault_set(fault, error, path, "the file cannot be read");
    }
    memcpy(f->path, path, strlen(path) + 1);
    f->type = type_of(path);
    etag_of_bytes(f->data, f->size_bytes, f->etag);
    files->count++;
    return 0;
}

static int add_folder(struct static_files *files, int dir_fd, const char *prefix, int depth,
                      struct fault *fault);

static int add_entry(struct static_files *files, int dir_fd, const char *name, const char *prefix,
                     int depth, struct fault *fault)
{
    char path[512];
    struct stat info;
    int length = snprintf(path, sizeof path, "%s/%s", prefix, name);
    if (length < 0 || (size_t)length >= sizeof path)
        return fault_set(fault, ERR_LIMIT, prefix, "the path is too long");
    if (name[0] == '.' || fstatat(dir_fd, name, &info, AT_SYMLINK_NOFOLLOW) != 0) return 0;
    bool is_folder = S_ISDIR(info.st_mode);
    if (!is_folder && (!S_ISREG(info.st_mode) || !type_of(name))) return 0;
    int fd = openat(dir_fd, name, O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
    if (fd < 0) return fault_set(fault, ERR_IO, path, "cannot be opened: %s", strerror(errno));
    return is_folder ? add_folder(files, fd, path, depth + 1, fault) : add(files, fd, path, fault);
}

/* Takes the descriptor. */
static int add_folder(struct static_files *files, int dir_fd, const char *prefix, int depth,
                      struct fault *fault)
{
    DIR *dir = depth < DEPTH_MAX ? fdopendir(dir_fd) : NULL;
    int error = 0;
    if (!dir) {
        close(dir_fd);
        return fault_set(fault, ERR_LIMIT, prefix, "folders are too deep or cannot be read");
    }
    for (struct dirent *entry; !error && (entry = readdir(dir));)
        error = add_entry(files, dir_fd, entry->d_name, prefix, depth, fault);
    closedir(dir);
    return error;
}

int static_files_load(const char *web_dir, const char *openapi_path, struct static_files **out,
                      struct fault *fault)
{
    struct static_files *files = calloc(1, sizeof *files);
    int error = 0;
    if (!files) return fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
    if (web_dir) {
        int fd = open(web_dir, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        error = fd < 0
                    ? fault_set(fault, ERR_IO, web_dir, "the viewer's folder: %s", strerror(errno))
                    : add_folder(files, fd, "", 0, fault);
    }
    if (!error && openapi_path) {
        int fd = open(openapi_path, O_RDONLY | O_CLOEXEC);
        error = fd < 0 ? fault_set(fault, ERR_IO, openapi_path, "the contract: %s", strerror(errno))
                       : add(files, fd, "/openapi.yaml", fault);
    }
    if (error) static_files_destroy(&files);
    *out = files;
    return error;
}

void static_files_destroy(struct static_files **files)
{
    if (!*files) return;
    for (size_t i = 0; i < (*files)->count; i++) free((*files)->file[i].data);
    free(*files);
    *files = NULL;
}

const struct static_file *static_files_find(const struct static_files *files, const char *path)
{
    if (strcmp(path, "/") == 0) path = "/index.html";
    for (size_t i = 0; i < files->count; i++)
        if (strcmp(files->file[i].path, path) == 0) return &files->file[i];
    return NULL;
}

void route_static_file(struct request *r)
{
    const struct static_file *f = static_files_find(r->http->files, r->target.path);
    if (!f) {
        request_problem(r, PROBLEM_NOT_FOUND, "this server was started without that file", NULL);
        return;
    }
    if (request_unchanged(r, f->etag)) return;
    struct MHD_Response *response = response_of_borrowed(f->data, f->size_bytes, f->type);
    if (response) {
        response_header(response, "ETag", f->etag);
        response_header(response, "Cache-Control", "no-cache");
    }
    request_answer(r, 200, response);
}

void route_openapi(struct request *r)
{
    route_static_file(r);
}
