#include "server/import/scene/blob_writer.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdbool.h>
#include <string.h>
#include <unistd.h>

/* Embree reads up to 16 bytes beyond an array's last element. */
#define SECTION_SLACK_BYTES 16u

struct blob_layout {
    struct scene_header header;
    struct scene_section_entry table[SCENE_SECTION_COUNT];
};

static uint64_t align_up(uint64_t n)
{
    return (n + SCENE_ALIGN_BYTES - 1) / SCENE_ALIGN_BYTES * SCENE_ALIGN_BYTES;
}

static void lay_out(const struct builder *b, struct blob_layout *layout)
{
    memset(layout, 0, sizeof *layout);
    uint64_t offset = align_up(sizeof *layout);
    for (uint32_t s = 0; s < SCENE_SECTION_COUNT; s++) {
        const struct builder_array *a = &b->sections[s];
        layout->table[s] = (struct scene_section_entry){
            .offset = offset, .count = a->count, .record_bytes = a->record_bytes};
        offset = align_up(offset + a->count * a->record_bytes + SECTION_SLACK_BYTES);
    }
    memcpy(layout->header.magic, SCENE_MAGIC, sizeof SCENE_MAGIC);
    layout->header.version = SCENE_VERSION;
    layout->header.section_count = SCENE_SECTION_COUNT;
    layout->header.total_bytes = offset;
}

static bool write_all(int fd, const void *data, uint64_t size_bytes)
{
    const uint8_t *at = data;
    while (size_bytes > 0) {
        size_t part = size_bytes < (1u << 30) ? (size_t)size_bytes : (1u << 30);
        ssize_t n = write(fd, at, part);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        at += n;
        size_bytes -= (uint64_t)n;
    }
    return true;
}

/* Zeros from *offset up to `until`; at most alignment and slack. */
static bool write_padding(int fd, uint64_t *offset, uint64_t until)
{
    static const uint8_t zeros[2 * SCENE_ALIGN_BYTES + SECTION_SLACK_BYTES];
    bool ok = write_all(fd, zeros, until - *offset);
    *offset = until;
    return ok;
}

static bool write_sections(int fd, const struct builder *b, const struct blob_layout *layout)
{
    if (!write_all(fd, layout, sizeof *layout)) return false;
    uint64_t offset = sizeof *layout;
    for (uint32_t s = 0; s < SCENE_SECTION_COUNT; s++) {
        const struct scene_section_entry *entry = &layout->table[s];
        uint64_t size_bytes = entry->count * entry->record_bytes;
        if (!write_padding(fd, &offset, entry->offset)) return false;
        if (!write_all(fd, b->sections[s].data, size_bytes)) return false;
        offset += size_bytes;
    }
    return write_padding(fd, &offset, layout->header.total_bytes);
}

/* Negative when it cannot be. */
static int create_file(const char *path, struct fault *fault)
{
    int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0644);
    if (fd < 0)
        fault_set(fault, error_of_errno(errno), path, "cannot be written: %s", strerror(errno));
    return fd;
}

/* Closes the file. If not `ok`, errno says why. The store that keeps the file syncs it (objects.h).
 */
static int close_file(int fd, const char *path, bool ok, struct fault *fault)
{
    int why = errno;
    if (close(fd) != 0 && ok) {
        ok = false;
        why = errno;
    }
    if (ok) return 0;
    unlink(path);
    return fault_set(fault, error_of_errno(why), path, "cannot be written: %s", strerror(why));
}

int blob_write(const struct builder *b, const char *path, struct fault *fault)
{
    struct blob_layout layout;
    lay_out(b, &layout);
    if (layout.header.total_bytes > LIMIT_BLOB_BYTES)
        return fault_set(fault, ERR_LIMIT, "blob", "it would have %" PRIu64 " bytes",
                         layout.header.total_bytes);
    int fd = create_file(path, fault);
    if (fd < 0) return fault->code;
    return close_file(fd, path, write_sections(fd, b, &layout), fault);
}

/* Writes sentences, or with fd -1 only counts their bytes into *size_bytes. */
static bool write_warnings(int fd, const struct warnings *warnings, uint32_t *size_bytes)
{
    bool ok = true;
    *size_bytes = 0;
    for (uint32_t i = 0; i < warnings->count && ok; i++) {
        char text[WARNING_TEXT_BYTES];
        warnings_text(warnings, i, text);
        const size_t length = strlen(text) + 1;
        *size_bytes += (uint32_t)length;
        if (fd >= 0) ok = write_all(fd, text, length);
    }
    return ok;
}

int blob_write_environment(const struct environment_header *header, const float *texels,
                           const struct warnings *warnings, const char *path, struct fault *fault)
{
    struct environment_header whole = *header;
    write_warnings(-1, warnings, &whole.warning_bytes);
    const uint64_t texel_bytes =
        (uint64_t)header->width_px * header->height_px * 3 * sizeof *texels;
    int fd = create_file(path, fault);
    if (fd < 0) return fault->code;
    bool ok = write_all(fd, &whole, sizeof whole) && write_all(fd, texels, texel_bytes) &&
              write_warnings(fd, warnings, &whole.warning_bytes);
    return close_file(fd, path, ok, fault);
}
