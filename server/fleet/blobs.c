#include "server/fleet/blobs.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "proto/error.h"

void blob_source_init(struct blob_source *b)
{
    *b = (struct blob_source){.fd = -1};
}

void blob_source_fini(struct blob_source *b)
{
    if (b->fd >= 0) close(b->fd);
    blob_source_init(b);
}

int blob_source_open(struct blob_source *b, const struct digest *digest, const char *path)
{
    blob_source_fini(b);
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY);
    if (fd < 0) return errno == ENOENT ? ERR_NOT_FOUND : ERR_IO;
    struct stat st;
    if (fstat(fd, &st) != 0 || !S_ISREG(st.st_mode)) {
        close(fd);
        return ERR_IO;
    }
    *b = (struct blob_source){.fd = fd, .digest = *digest, .total_bytes = (uint64_t)st.st_size};
    return 0;
}

static int read_fully(int fd, uint8_t *out, size_t size_bytes, uint64_t offset)
{
    while (size_bytes > 0) {
        ssize_t n = pread(fd, out, size_bytes, (off_t)offset);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return ERR_IO; /* shorter than it was when it was opened */
        out += n;
        offset += (uint64_t)n;
        size_bytes -= (size_t)n;
    }
    return 0;
}

int blob_source_read(const struct blob_source *b, uint64_t offset, uint32_t size_bytes, void **part,
                     uint32_t *part_bytes)
{
    if (offset >= b->total_bytes || size_bytes == 0 || size_bytes > LIMIT_BLOB_PART_BYTES)
        return ERR_RANGE;
    uint64_t left = b->total_bytes - offset;
    uint32_t bytes = size_bytes < left ? size_bytes : (uint32_t)left;
    uint8_t *data = malloc(bytes);
    if (!data) return ERR_MEMORY;
    int e = read_fully(b->fd, data, bytes, offset);
    if (e) {
        free(data);
        return e;
    }
    *part = data;
    *part_bytes = bytes;
    return 0;
}
