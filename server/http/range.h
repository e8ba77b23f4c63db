#pragma once
/* One byte range of a file (RFC 9110, section 14). */
#include <stdbool.h>
#include <stdint.h>

enum range_kind {
    RANGE_WHOLE,         /* no range, one that is malformed, or several: the whole file is right */
    RANGE_PART,          /* first_byte and size_bytes are inside the file */
    RANGE_UNSATISFIABLE, /* nothing of it is in the file */
};

struct range {
    enum range_kind kind;
    uint64_t first_byte, size_bytes;
};

/* Reads a range. header: the Range field, or NULL. */
struct range range_read(const char *header, uint64_t file_bytes);
