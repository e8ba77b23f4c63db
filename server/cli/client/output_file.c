#include "server/cli/client/output_file.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#define LINKS_MAX 40      /* that lead to each other, as the system follows */
#define PART      ".part" /* at the end of a picture's name until it is whole */

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
    char folder[PATH_MAX];
    bool there = stat(path, &info) == 0;
    if (there && S_ISDIR(info.st_mode)) return refuse(path, EISDIR, fault);
    if (there && !S_ISREG(info.st_mode))
        return access(path, W_OK) == 0 ? 0 : refuse(path, errno, fault);
    if (strlen(name_of(path)) > NAME_MAX) return refuse(path, ENAMETOOLONG, fault);
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
    if (strlen(name_of(path)) + strlen(PART) > NAME_MAX) return refuse(path, ENAMETOOLONG, fault);
    return output_file_check(path, fault);
}

/* Resolves links to the file's one name, whether the file is there yet or not. False: it could not
 * be written. */
static bool find_file(const char *path, char out[PATH_MAX])
{
    char folder[PATH_MAX], to[PATH_MAX], real[PATH_MAX], at[PATH_MAX];
    snprintf(at, sizeof at, "%s", path);
    for (int links = 0; links <= LINKS_MAX; links++) {
        folder_of(at, folder, sizeof folder);
        const ssize_t length = readlink(at, to, sizeof to - 1);
        if (length < 0) {
            if (!realpath(folder, real)) return false;
            return snprintf(out, PATH_MAX, "%s/%s", real, name_of(at)) < PATH_MAX;
        }
        to[length] = '\0';
        const char *from = to[0] == '/' ? "" : folder;
        if (snprintf(at, sizeof at, "%s%s", from, to) >= (int)sizeof at) return false;
    }
    return false;
}

static bool is_same(const char *a, const char *b)
{
    struct stat one, other;
    char of_a[PATH_MAX], of_b[PATH_MAX];
    if (stat(a, &one) == 0 && stat(b, &other) == 0) /* two names, too */
        return S_ISREG(one.st_mode) && one.st_dev == other.st_dev && one.st_ino == other.st_ino;
    return find_file(a, of_a) && find_file(b, of_b) && strcmp(of_a, of_b) == 0;
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
        if (snprintf(o->part, sizeof o->part, "%s" PART, path) >= (int)sizeof o->part)
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
