#pragma once
/* Files whose bytes must never change unnoticed. SHEARWATER_WRITE_GOLDEN=1 writes them anew.
 * Run from the root of the sources. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/unit.h"

static inline void golden_write(const char *path, const void *data, size_t size_bytes)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size_bytes, file), size_bytes);
    assert_int_equal(fclose(file), 0);
}

static inline void golden_check(const char *path, const void *data, size_t size_bytes)
{
    static unsigned char golden[1 << 20];
    if (getenv("SHEARWATER_WRITE_GOLDEN")) golden_write(path, data, size_bytes);
    FILE *file = fopen(path, "rb");
    if (!file) fail_msg("%s cannot be opened", path);
    const size_t golden_bytes = fread(golden, 1, sizeof golden, file);
    fclose(file);
    if (golden_bytes != size_bytes || memcmp(golden, data, size_bytes) != 0)
        fail_msg("the bytes of %s have changed: old workers and stored files break", path);
}
