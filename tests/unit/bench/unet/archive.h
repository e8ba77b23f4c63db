#pragma once
/* Writes archives of weights, for tests of what reads them. The table stands before the numbers, so
 * that an archive that is cut off anywhere lacks some. */
#include "proto/bytes.h"

struct archive_tensor {
    const char *name, *layout;
    uint32_t sizes[4]; /* as many as the layout has letters */
    char type;         /* 'h' or 'f' */
    const float *values;
};

void archive_write(const struct archive_tensor *tensors, uint32_t count, struct bytes_writer *out);
