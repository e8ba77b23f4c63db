// sources: server/import/[!m]*.c server/import/*/*.c server/import/*/*.cc
// sources: server/image/exr_file.c server/image/exr_read.c server/image/image.c
// libs: -lassimp -lOpenEXRCore-3_1 -lpng -lturbojpeg -lwebp -lmeshoptimizer -ldraco -lstdc++
/* The importer as a whole, behind no fence: scene files and what stands beside them, pictures and
 * environment maps. Input: "@NAME" and the bytes of the main file, then more files, each after a
 * line "@@NAME". What is refused says why and leaves no blob; what is taken is a blob that opens;
 * no descriptor stays open; the address sanitizer watches.
 *
 * OBJ files go through assimp, whose own faults end the importer in its fence: here they are read
 * where FUZZ_ASSIMP is set, for one who tells assimp's faults from ours. */
#include <dirent.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/import/import.h"

#define FILES_MAX 8

static char home[48], root[64], out[64];

static void must(bool holds)
{
    if (!holds) abort();
}

static void forget_files(void)
{
    DIR *folder = opendir(root);
    const struct dirent *entry;
    while (folder && (entry = readdir(folder)))
        if (entry->d_name[0] != '.') (void)unlinkat(dirfd(folder), entry->d_name, 0);
    if (folder) closedir(folder);
}

static void forget_folders(void)
{
    forget_files();
    (void)unlink(out);
    (void)rmdir(root);
    (void)rmdir(home);
}

static void make_folders(void)
{
    snprintf(home, sizeof home, "/dev/shm/fuzz-import-XXXXXX");
    must(mkdtemp(home) != NULL);
    snprintf(root, sizeof root, "%s/root", home);
    snprintf(out, sizeof out, "%s/blob", home);
    must(mkdir(root, 0700) == 0);
    atexit(forget_folders);
}

static bool is_name(const char *name)
{
    const size_t length = strlen(name);
    return length > 0 && length < 64 && name[0] != '.' &&
           strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-") ==
               length;
}

static void put_file(const char *name, const uint8_t *data, size_t size_bytes)
{
    char path[192];
    snprintf(path, sizeof path, "%s/%s", root, name);
    const int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    must(fd >= 0 && write(fd, data, size_bytes) == (ssize_t)size_bytes);
    close(fd);
}

/* The part's bytes up to the next "\n@@", or all. */
static size_t part_bytes(const uint8_t *data, size_t size_bytes)
{
    const uint8_t *next = size_bytes ? memmem(data, size_bytes, "\n@@", 3) : NULL;
    return next ? (size_t)(next - data) : size_bytes;
}

/* Puts down the files; the main one's name in *name, "" when there is none. */
static void put_files(const uint8_t *data, size_t size_bytes, char name[64])
{
    name[0] = '\0';
    if (size_bytes == 0 || data[0] != '@') return;
    const uint8_t *at = data + 1, *const end = data + size_bytes;
    for (int i = 0; i < FILES_MAX && at < end; i++) {
        const uint8_t *line = memchr(at, '\n', (size_t)(end - at));
        char text[64] = "";
        if (!line || line - at >= (ptrdiff_t)sizeof text) return;
        memcpy(text, at, (size_t)(line - at));
        if (!is_name(text)) return;
        const size_t bytes = part_bytes(line + 1, (size_t)(end - line - 1));
        put_file(text, line + 1, bytes);
        if (i == 0) memcpy(name, text, sizeof text);
        at = line + 1 + bytes + 3;
    }
}

static int lowest_descriptor(void)
{
    const int fd = dup(STDERR_FILENO);
    if (fd >= 0) close(fd);
    return fd;
}

/* As import.c tells them apart; a file without an ending is none when it begins as glTF does. */
static bool is_for_assimp(const char *name)
{
    const char *dot = strrchr(name, '.');
    return !dot || strcasecmp(dot, ".obj") == 0;
}

static void check(const char *name, const struct scene_choice *choice)
{
    static struct warnings warnings;
    struct import_stats stats;
    struct fault fault = {0};
    char text[WARNING_TEXT_BYTES];
    const int free_before = lowest_descriptor();
    const int error = import_scene(root, name, choice, out, &warnings, &stats, &fault);
    must(lowest_descriptor() == free_before);
    must(warnings.count <= LIMIT_WARNINGS);
    for (uint32_t i = 0; i < warnings.count; i++) warnings_text(&warnings, i, text);
    if (error) {
        must(fault.code == error && fault.detail[0] != '\0');
        must(access(out, F_OK) != 0);
        return;
    }
    must(stats.width_px > 0 ? stats.height_px > 0 : stats.placed_triangles >= 1);
    must(unlink(out) == 0);
    for (uint32_t i = 0; i < stats.frames; i++) {
        char path[sizeof out + 16];
        snprintf(path, sizeof path, "%s.%u", out, i);
        must(unlink(path) == 0);
    }
}

/* A file with animations is imported at one time, and at several. */
static void check_times(const char *name, bool moves)
{
    static const double times[] = {0.4, 2, -1};
    check(name, &(struct scene_choice){.time_s = 0.4});
    if (moves) check(name, &(struct scene_choice){.times = times, .time_count = 3});
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    char name[64];
    if (!home[0]) make_folders();
    put_files(data, size_bytes, name);
    if (name[0] && (!is_for_assimp(name) || getenv("FUZZ_ASSIMP")))
        check_times(name, memmem(data, size_bytes, "animations", 10) != NULL);
    forget_files();
    return 0;
}
