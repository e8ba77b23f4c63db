#include "server/job/prepare/import_folder.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define HEAD_BYTES 4096

/* Text may begin with a byte order mark. */
static const uint8_t *skip_mark(const uint8_t *at, const uint8_t *end)
{
    bool mark = end - at >= 3 && at[0] == 0xef && at[1] == 0xbb && at[2] == 0xbf;
    return mark ? at + 3 : at;
}

const char *import_folder_sniff(const void *head, size_t size_bytes)
{
    const uint8_t *at = head, *end = at + size_bytes;
    if (size_bytes >= 4 && !memcmp(head, "glTF", 4)) return ".glb";
    if (size_bytes >= 4 && !memcmp(head, "\x76\x2f\x31\x01", 4)) return ".exr";
    if (size_bytes >= 2 && !memcmp(head, "#?", 2)) return ".hdr"; /* "#?RADIANCE", "#?RGBE" */
    if (size_bytes >= 8 && !memcmp(head, "\x89PNG\r\n\x1a\n", 8)) return ".png";
    if (size_bytes >= 3 && !memcmp(head, "\xff\xd8\xff", 3)) return ".jpg";
    if (size_bytes >= 12 && !memcmp(head, "RIFF", 4) && !memcmp(at + 8, "WEBP", 4)) return ".webp";
    at = skip_mark(at, end);
    while (at < end && (*at == ' ' || *at == '\t' || *at == '\r' || *at == '\n')) at++;
    if (at < end && *at == '{') return ".gltf";
    /* OBJ has no mark of its own: a line that starts with one of its words, and no binary. */
    if (at < end && strchr("#vfogmuslp", *at) && !memchr(head, 0, size_bytes)) return ".obj";
    return NULL;
}

static int io_fault(struct fault *fault, const char *pointer, const char *doing, const char *name)
{
    return fault_set(fault, errno == ENOENT ? ERR_NOT_FOUND : error_of_errno(errno), pointer,
                     "%s %.200s: %s", doing, name, strerror(errno));
}

static int copy_all(int in, int out)
{
    for (;;) {
        ssize_t n = copy_file_range(in, NULL, out, NULL, 1 << 30, 0);
        if (n <= 0) return (int)n;
    }
}

static int copy(const char *from, const char *to)
{
    int in = open(from, O_RDONLY | O_CLOEXEC), out = -1, result = -1;
    if (in >= 0) out = open(to, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0400);
    if (out >= 0) result = copy_all(in, out);
    int saved = errno;
    if (in >= 0) close(in);
    if (out >= 0) close(out);
    errno = saved;
    return result;
}

/* Gives the object's bytes a second name, or copies them where the file system has no links. */
static int place(const struct objects *objects, const struct digest *asset, const char *to,
                 const char *pointer, struct fault *fault)
{
    char from[OBJECTS_PATH_BYTES];
    objects_path(objects, asset, from);
    if (link(from, to) == 0) return 0;
    if (errno == EEXIST) return fault_set(fault, ERR_EXISTS, pointer, "two files have this name");
    if (errno != ENOENT && copy(from, to) == 0) return 0;
    return io_fault(fault, pointer, "asset", from);
}

/* Makes the folders of `path` beneath root. */
static int make_parents(char *path, size_t root_length)
{
    for (char *slash = path + root_length + 1; (slash = strchr(slash, '/')); *slash++ = '/') {
        *slash = '\0';
        if (mkdir(path, 0700) != 0 && errno != EEXIST) return -1;
    }
    return 0;
}

static int place_file(const struct objects *objects, const struct job_file *file,
                      const struct import_folder *folder, struct fault *fault)
{
    char path[sizeof folder->root + LIMIT_PATH_BYTES + 2];
    char pointer[LIMIT_POINTER_BYTES];
    snprintf(pointer, sizeof pointer, "/scene/files/%.200s", file->path);
    if (!relative_path_is_inside(file->path))
        return fault_set(fault, ERR_RANGE, pointer, "this path leaves the scene's folder");
    snprintf(path, sizeof path, "%s/%s", folder->root, file->path);
    if (make_parents(path, strlen(folder->root)) != 0)
        return io_fault(fault, pointer, "folders of", file->path);
    return place(objects, &file->asset, path, pointer, fault);
}

/* The main file stands beside the others, under a name that none of them has. */
static int place_main(const struct objects *objects, const struct digest *scene,
                      struct import_folder *folder, struct fault *fault)
{
    char from[OBJECTS_PATH_BYTES], to[sizeof folder->root + 80];
    uint8_t head[HEAD_BYTES];
    struct stat info;
    objects_path(objects, scene, from);
    int fd = open(from, O_RDONLY | O_CLOEXEC);
    if (fd < 0) return io_fault(fault, "/scene/asset", "asset", from);
    ssize_t n = read(fd, head, sizeof head);
    close(fd);
    const char *suffix = n > 0 ? import_folder_sniff(head, (size_t)n) : NULL;
    if (!suffix)
        return fault_set(
            fault, ERR_MAGIC, "/scene/asset",
            "this file is neither glTF (binary or JSON) nor OBJ, nor a map (.hdr, .exr) or a "
            "photograph (.jpg, .png, .webp)");
    snprintf(folder->main_name, sizeof folder->main_name, "scene%s", suffix);
    for (int i = 1; i < 1000; i++) {
        snprintf(to, sizeof to, "%s/%s", folder->root, folder->main_name);
        if (lstat(to, &info) != 0) break;
        snprintf(folder->main_name, sizeof folder->main_name, "scene-%d%s", i, suffix);
    }
    return place(objects, scene, to, "/scene/asset", fault);
}

int import_folder_make(const struct objects *objects, const struct digest *scene,
                       const struct job_file *files, uint32_t file_count, struct import_folder *out,
                       struct fault *fault)
{
    memset(out, 0, sizeof *out);
    int error = objects_make_dir(objects, out->dir);
    if (error) return fault_set(fault, error, "", "no folder for the importer");
    snprintf(out->root, sizeof out->root, "%s/in", out->dir);
    snprintf(out->blob, sizeof out->blob, "%s/out", out->dir);
    if (mkdir(out->root, 0700) != 0 || mkdir(out->blob, 0700) != 0)
        error = io_fault(fault, "", "folders in", out->dir);
    snprintf(out->blob, sizeof out->blob, "%s/out/scene.blob", out->dir);
    for (uint32_t i = 0; !error && i < file_count; i++)
        error = place_file(objects, &files[i], out, fault);
    if (!error) error = place_main(objects, scene, out, fault);
    if (error) import_folder_remove(out);
    return error;
}

void import_folder_remove(struct import_folder *folder)
{
    if (folder->dir[0]) objects_remove_dir(folder->dir);
    folder->dir[0] = '\0';
}
