#pragma once
/* File access and error reports of the OpenEXR library. It reads and writes through stream
 * functions, to a file that the caller has opened or from memory, so that it neither names, renames
 * nor deletes files, nor prints. */
#include <OpenEXR/openexr.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/error.h"

struct exr_file {
    int fd;
    bool is_written;       /* set before exr_file_context; else it is read */
    int error;             /* of reading or writing, an ERR_ code; 0: none so far */
    const uint8_t *memory; /* not NULL: the file's bytes, read instead of fd */
    size_t memory_bytes;
    char message[LIMIT_DETAIL_BYTES]; /* the library's first complaint; "" if none */
};

/* Fills *init for reading or writing `file`, which must outlive the context. */
void exr_file_context(struct exr_file *file, exr_context_initializer_t *init);

/* Returns the error code for a result of the library, with the library's message in *fault (which
 * may be NULL); 0 for success. */
int exr_file_fault(const struct exr_file *file, exr_result_t result, const char *path,
                   struct fault *fault);
