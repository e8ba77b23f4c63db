#include "proto/runtime/blob_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "proto/limits.h"

static int map_open(int fd, const char *path, const void **blob, size_t *size_bytes,
                    struct fault *fault)
{
    struct stat st;
    if (fstat(fd, &st) != 0 || !S_ISREG(st.st_mode))
        return fault_set(fault, ERR_IO, "", "%s is no file", path);
    if (st.st_size <= 0) return fault_set(fault, ERR_TRUNCATED, "", "%s is empty", path);
    if ((uint64_t)st.st_size > LIMIT_BLOB_BYTES)
        return fault_set(fault, ERR_LIMIT, "", "%s has %lld bytes", path, (long long)st.st_size);
    void *data = mmap(NULL, (size_t)st.st_size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (data == MAP_FAILED)
        return fault_set(fault, ERR_IO, "", "%s cannot be mapped: %s", path,
                         strerrordesc_np(errno));
    *blob = data;
    *size_bytes = (size_t)st.st_size;
    return 0;
}

int blob_file_map(const char *path, const void **blob, size_t *size_bytes, struct fault *fault)
{
    *blob = NULL;
    *size_bytes = 0;
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return fault_set(fault, ERR_IO, "", "%s cannot be opened: %s", path,
                         strerrordesc_np(errno));
    const int error = map_open(fd, path, blob, size_bytes, fault);
    close(fd);
    return error;
}

void blob_file_unmap(const void *blob, size_t size_bytes)
{
    if (blob) munmap((void *)(uintptr_t)blob, size_bytes);
}
