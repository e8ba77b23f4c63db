#include "server/image/exr_file.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Ignores errors of a file that is written. The library reports them with its lock held, which a
 * query for the user data takes, too. Errors of the disk are kept where they occur (keep_errno). */
static void pass_over(exr_const_context_t context, exr_result_t code, const char *message)
{
    (void)context, (void)code, (void)message;
}

static void on_error(exr_const_context_t context, exr_result_t code, const char *message)
{
    void *data = NULL;
    (void)code;
    if (!context || exr_get_user_data(context, &data) != EXR_ERR_SUCCESS || !data) return;
    struct exr_file *file = data;
    if (!file->message[0]) snprintf(file->message, sizeof file->message, "%s", message);
}

static int64_t keep_errno(struct exr_file *file, const char *doing)
{
    file->error = error_of_errno(errno);
    snprintf(file->message, sizeof file->message, "%s failed: %s", doing, strerror(errno));
    return -1;
}

static int64_t copy_at(const struct exr_file *file, void *buffer, uint64_t size_bytes,
                       uint64_t offset)
{
    if (offset >= file->memory_bytes) return 0;
    const uint64_t left = file->memory_bytes - offset;
    const uint64_t part = size_bytes < left ? size_bytes : left;
    memcpy(buffer, file->memory + offset, part);
    return (int64_t)part;
}

static int64_t read_at(exr_const_context_t context, void *data, void *buffer, uint64_t size_bytes,
                       uint64_t offset, exr_stream_error_func_ptr_t error)
{
    struct exr_file *file = data;
    uint64_t done = 0;
    (void)context, (void)error;
    if (file->memory) return copy_at(file, buffer, size_bytes, offset);
    while (done < size_bytes) {
        ssize_t n =
            pread(file->fd, (char *)buffer + done, size_bytes - done, (off_t)(offset + done));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return keep_errno(file, "reading");
        if (n == 0) break;
        done += (uint64_t)n;
    }
    return (int64_t)done;
}

static int64_t write_at(exr_const_context_t context, void *data, const void *buffer,
                        uint64_t size_bytes, uint64_t offset, exr_stream_error_func_ptr_t error)
{
    struct exr_file *file = data;
    uint64_t done = 0;
    (void)context, (void)error;
    while (done < size_bytes) {
        ssize_t n = pwrite(file->fd, (const char *)buffer + done, size_bytes - done,
                           (off_t)(offset + done));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return keep_errno(file, "writing");
        done += (uint64_t)n;
    }
    return (int64_t)done;
}

static int64_t file_size(exr_const_context_t context, void *data)
{
    const struct exr_file *file = data;
    struct stat st;
    (void)context;
    if (file->memory) return (int64_t)file->memory_bytes;
    return fstat(file->fd, &st) ? -1 : (int64_t)st.st_size;
}

void exr_file_context(struct exr_file *file, exr_context_initializer_t *init)
{
    *init = (exr_context_initializer_t)EXR_DEFAULT_CONTEXT_INITIALIZER;
    init->error_handler_fn = file->is_written ? pass_over : on_error;
    init->user_data = file;
    init->read_fn = read_at;
    init->write_fn = write_at;
    init->size_fn = file_size;
    init->max_image_width = LIMIT_IMAGE_SIDE_PX;
    init->max_image_height = LIMIT_IMAGE_SIDE_PX;
    init->max_tile_width = LIMIT_IMAGE_SIDE_PX;
    init->max_tile_height = LIMIT_IMAGE_SIDE_PX;
    init->flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
}

static int error_code(exr_result_t result)
{
    switch (result) {
    case EXR_ERR_SUCCESS:
        return 0;
    case EXR_ERR_OUT_OF_MEMORY:
        return ERR_MEMORY;
    case EXR_ERR_FILE_ACCESS:
    case EXR_ERR_READ_IO:
    case EXR_ERR_WRITE_IO:
        return ERR_IO;
    case EXR_ERR_FEATURE_NOT_IMPLEMENTED:
        return ERR_UNSUPPORTED;
    default:
        return ERR_CORRUPT;
    }
}

int exr_file_fault(const struct exr_file *file, exr_result_t result, const char *path,
                   struct fault *fault)
{
    if (result == EXR_ERR_SUCCESS) return 0;
    const char *text = file->message[0] ? file->message : exr_get_default_error_message(result);
    const int code = file->error ? file->error : error_code(result);
    return fault_set(fault, code, path, "OpenEXR: %s", text);
}
