#include "server/cli/output_file.h"

#include <errno.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

static int refuse(const char *path, int number, struct fault *fault)
{
    return fault_set(fault, ERR_IO, "", "%s: %s", path, strerror(number));
}

static bool is_special(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && !S_ISREG(info.st_mode);
}

int output_file_check(const char *path, struct fault *fault)
{
    struct stat info;
    char folder[4096];
    const char *slash = strrchr(path, '/');
    bool there = stat(path, &info) == 0;
    if (there && S_ISDIR(info.st_mode)) return refuse(path, EISDIR, fault);
    if (there && !S_ISREG(info.st_mode))
        return access(path, W_OK) == 0 ? 0 : refuse(path, errno, fault);
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path + 1) : 1,
             slash ? path : ".");
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
