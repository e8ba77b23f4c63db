#include "tests/unit/bench/unet/archive.h"

#include <string.h>

#include "proto/half.h"

#define HEAD_BYTES 12

static size_t count_of(const struct archive_tensor *t)
{
    size_t count = 1;
    for (size_t i = 0; i < strlen(t->layout); i++) count *= t->sizes[i];
    return count;
}

static size_t bytes_of(const struct archive_tensor *t)
{
    return count_of(t) * (t->type == 'h' ? 2 : 4);
}

static size_t row_bytes(const struct archive_tensor *t)
{
    return 2 + strlen(t->name) + 1 + 5 * strlen(t->layout) + 1 + 8;
}

static void write_row(const struct archive_tensor *t, uint64_t place, struct bytes_writer *out)
{
    const size_t rank = strlen(t->layout);
    bytes_write_string(out, t->name);
    bytes_write_u8(out, (uint8_t)rank);
    for (size_t i = 0; i < rank; i++) bytes_write_u32(out, t->sizes[i]);
    bytes_write_raw(out, t->layout, rank);
    bytes_write_u8(out, (uint8_t)t->type);
    bytes_write_u64(out, place);
}

static void write_values(const struct archive_tensor *t, struct bytes_writer *out)
{
    for (size_t i = 0; i < count_of(t); i++) {
        if (t->type == 'h')
            bytes_write_u16(out, half_from_float(t->values[i]));
        else
            bytes_write_f32(out, t->values[i]);
    }
}

void archive_write(const struct archive_tensor *tensors, uint32_t count, struct bytes_writer *out)
{
    uint64_t place = HEAD_BYTES + 4;
    for (uint32_t i = 0; i < count; i++) place += row_bytes(&tensors[i]);
    bytes_writer_init(out);
    bytes_write_u16(out, 0x41d7);
    bytes_write_u8(out, 2);
    bytes_write_u8(out, 0);
    bytes_write_u64(out, HEAD_BYTES);
    bytes_write_u32(out, count);
    for (uint32_t i = 0; i < count; place += bytes_of(&tensors[i++]))
        write_row(&tensors[i], place, out);
    for (uint32_t i = 0; i < count; i++) write_values(&tensors[i], out);
}
