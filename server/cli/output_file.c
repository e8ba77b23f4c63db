#include "server/cli/output_file.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

/* What may be added to a name: a frame's number, and what stands at its end until it is whole. */
#define ADDED_BYTES sizeof(".2147483647.part")

static int refuse(const char *path, int number, struct fault *fault)
{
    return fault_set(fault, ERR_IO, "", "%s: %s", path, strerror(number));
}

static bool is_special(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && !S_ISREG(info.st_mode);
}

static const char *name_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* "./" for a name alone. */
static void folder_of(const char *path, char *out, size_t capacity)
{
    const int length = (int)(name_of(path) - path);
    snprintf(out, capacity, "%.*s", length > 0 ? length : 2, length > 0 ? path : "./");
}

int output_file_check(const char *path, struct fault *fault)
{
    struct stat info;
    char folder[4096];
    bool there = stat(path, &info) == 0;
    if (there && S_ISDIR(info.st_mode)) return refuse(path, EISDIR, fault);
    if (there && !S_ISREG(info.st_mode))
        return access(path, W_OK) == 0 ? 0 : refuse(path, errno, fault);
    if (strlen(name_of(path)) + ADDED_BYTES > NAME_MAX) return refuse(path, ENAMETOOLONG, fault);
    folder_of(path, folder, sizeof folder);
    return access(folder, W_OK | X_OK) == 0 ? 0 : refuse(folder, errno, fault);
}

int output_file_check_picture(const char *path, const char *ending, struct fault *fault)
{
    static const char *const endings[] = {"exr", "png",  "jpg", "jpeg", "hdr",
                                          "tif", "tiff", "bmp", "webp"};
    const char *dot = strrchr(path, '.');
    for (size_t i = 0; dot && i < sizeof endings / sizeof *endings; i++)
        if (strcasecmp(dot + 1, endings[i]) == 0 && strcmp(endings[i], ending) != 0)
            return fault_set(fault, ERR_RANGE, "",
                             "%s: it would be no .%s file: --output writes OpenEXR (.exr), "
                             "--png writes PNG",
                             path, endings[i]);
    return output_file_check(path, fault);
}

/* Are both there and one, or would one be where the other is? */
static bool is_same(const char *a, const char *b)
{
    struct stat one, other;
    char folder[4096], of_a[PATH_MAX], of_b[PATH_MAX];
    if (stat(a, &one) == 0 && stat(b, &other) == 0)
        return S_ISREG(one.st_mode) && one.st_dev == other.st_dev && one.st_ino == other.st_ino;
    folder_of(a, folder, sizeof folder);
    if (strcmp(name_of(a), name_of(b)) != 0 || !realpath(folder, of_a)) return false;
    folder_of(b, folder, sizeof folder);
    return realpath(folder, of_b) && strcmp(of_a, of_b) == 0;
}

int output_files_check_apart(const char *const *paths, size_t count, struct fault *fault)
{
    for (size_t i = 0; i < count; i++)
        for (size_t k = i + 1; k < count; k++)
            if (paths[i] && paths[k] && is_same(paths[i], paths[k]))
                return fault_set(fault, ERR_EXISTS, "",
                                 "%s: two outputs are this file: give each a name of its own",
                                 paths[k]);
    return 0;
}

int output_file_open(struct output_file *o, const char *path, struct fault *fault)
{
    *o = (struct output_file){.path = path};
    if (is_special(path)) {
        o->file = tmpfile();
    } else {
        if (snprintf(o->part, sizeof o->part, "%s.part", path) >= (int)sizeof o->part)
            return fault_set(fault, ERR_LIMIT, "", "%.200s...: the name is too long", path);
        o->file = fopen(o->part, "w+b");
    }
    return o->file ? 0 : refuse(path, errno, fault);
}

/* Into what is there under the name already. */
static int pour(FILE *from, const char *path, struct fault *fault)
{
    char bytes[65536];
    size_t n;
    FILE *to = fopen(path, "wb");
    if (!to) return refuse(path, errno, fault);
    rewind(from);
    while ((n = fread(bytes, 1, sizeof bytes, from)) > 0 && fwrite(bytes, 1, n, to) == n) {
    }
    bool failed = ferror(from) || ferror(to);
    int number = errno;
    if (fclose(to) == 0 && !failed) return 0;
    return refuse(path, failed ? number : errno, fault);
}

int output_file_close(struct output_file *o, bool keep, struct fault *fault)
{
    int error = 0;
    if (keep && fflush(o->file) != 0) error = refuse(o->path, errno, fault);
    if (keep && !error && !o->part[0]) error = pour(o->file, o->path, fault);
    if (fclose(o->file) != 0 && keep && !error) error = refuse(o->path, errno, fault);
    o->file = NULL;
    if (keep && !error && o->part[0] && rename(o->part, o->path) != 0)
        error = refuse(o->path, errno, fault);
    if ((error || !keep) && o->part[0]) unlink(o->part);
    return error;
}
