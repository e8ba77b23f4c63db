#include "tests/bench/unet/tza.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/bytes.h"
#include "proto/half.h"

#define TZA_MAGIC 0x41d7
#define TZA_MAJOR 2

struct archive {
    const uint8_t *data;
    size_t size_bytes;
    struct fault *fault;
};

static uint8_t read_byte(struct bytes_reader *r)
{
    uint8_t v = 0;
    bytes_read_raw(r, &v, 1);
    return v;
}

static int truncated(const struct archive *a, const char *what)
{
    return fault_set(a->fault, ERR_TRUNCATED, what, "the archive ends within %s", what);
}

/* Reads name, sizes and layout. */
static int read_shape(const struct archive *a, struct bytes_reader *r, struct tza_tensor *t)
{
    bytes_read_string(r, t->name, sizeof t->name);
    t->rank = read_byte(r);
    if (t->rank > TZA_RANK_MAX)
        return fault_set(a->fault, ERR_LIMIT, t->name, "its rank %u is above %d", t->rank,
                         TZA_RANK_MAX);
    t->count = 1;
    for (uint32_t i = 0; i < t->rank; i++) {
        t->sizes[i] = bytes_read_u32(r);
        if (!r->failed && (t->sizes[i] == 0 || t->sizes[i] > TZA_SIZE_MAX))
            return fault_set(a->fault, ERR_LIMIT, t->name, "its size %u is not between 1 and %d",
                             t->sizes[i], TZA_SIZE_MAX);
        t->count *= t->sizes[i];
    }
    bytes_read_raw(r, t->layout, t->rank);
    return r->failed ? truncated(a, "the table") : 0;
}

static int read_values(const struct archive *a, struct tza_tensor *t, uint8_t type, uint64_t place)
{
    if (type != 'h' && type != 'f')
        return fault_set(a->fault, ERR_TYPE, t->name, "its type %u is neither h nor f", type);
    const size_t bytes = type == 'h' ? 2 : 4;
    if (place > a->size_bytes || t->count > (a->size_bytes - place) / bytes)
        return truncated(a, t->name);
    t->values = malloc(t->count * sizeof *t->values);
    if (!t->values) return fault_set(a->fault, ERR_MEMORY, t->name, "no memory for its numbers");
    struct bytes_reader r;
    bytes_reader_init(&r, a->data + place, t->count * bytes);
    if (type == 'f') bytes_read_f32s(&r, t->values, t->count);
    for (size_t i = 0; type == 'h' && i < t->count; i++)
        t->values[i] = half_to_float(bytes_read_u16(&r));
    return 0;
}

static int read_tensor(const struct archive *a, struct bytes_reader *r, struct tza_tensor *t)
{
    int rc = read_shape(a, r, t);
    if (rc) return rc;
    const uint8_t type = read_byte(r);
    const uint64_t place = bytes_read_u64(r);
    return r->failed ? truncated(a, "the table") : read_values(a, t, type, place);
}

/* Finds the table. */
static int read_head(const struct archive *a, struct bytes_reader *table)
{
    struct bytes_reader r;
    bytes_reader_init(&r, a->data, a->size_bytes);
    const uint16_t magic = bytes_read_u16(&r);
    const uint8_t major = read_byte(&r);
    read_byte(&r);
    const uint64_t place = bytes_read_u64(&r);
    if (r.failed) return truncated(a, "the head");
    if (magic != TZA_MAGIC)
        return fault_set(a->fault, ERR_MAGIC, "", "it begins with %04x, an archive with %04x",
                         magic, TZA_MAGIC);
    if (major != TZA_MAJOR)
        return fault_set(a->fault, ERR_VERSION, "", "its version is %u, not %d", major, TZA_MAJOR);
    if (place > a->size_bytes) return truncated(a, "the table");
    bytes_reader_init(table, a->data + place, a->size_bytes - place);
    return 0;
}

int tza_parse(const void *data, size_t size_bytes, struct tza *out, struct fault *fault)
{
    const struct archive a = {data, size_bytes, fault};
    struct bytes_reader table;
    memset(out, 0, sizeof *out);
    int rc = read_head(&a, &table);
    if (rc) return rc;
    const uint32_t count = bytes_read_u32(&table);
    if (table.failed) return truncated(&a, "the table");
    if (count > TZA_TENSORS_MAX)
        return fault_set(fault, ERR_LIMIT, "", "its %u tensors are above %d", count,
                         TZA_TENSORS_MAX);
    while (out->count < count && !rc) rc = read_tensor(&a, &table, &out->tensors[out->count++]);
    return rc;
}

int tza_read(const char *path, struct tza *out, struct fault *fault)
{
    memset(out, 0, sizeof *out);
    FILE *file = fopen(path, "rb");
    if (!file) return fault_set(fault, ERR_IO, path, "%s", strerror(errno));
    uint8_t *data = malloc(TZA_FILE_BYTES);
    const size_t size_bytes = data ? fread(data, 1, TZA_FILE_BYTES, file) : 0;
    int rc = 0;
    if (!data) rc = fault_set(fault, ERR_MEMORY, path, "no memory to read it");
    if (ferror(file)) rc = fault_set(fault, ERR_IO, path, "%s", strerror(errno));
    fclose(file);
    if (!rc) rc = tza_parse(data, size_bytes, out, fault);
    free(data);
    return rc;
}

void tza_fini(struct tza *tza)
{
    for (uint32_t i = 0; i < tza->count; i++) free(tza->tensors[i].values);
    tza->count = 0;
}

const struct tza_tensor *tza_find(const struct tza *tza, const char *name)
{
    for (uint32_t i = 0; i < tza->count; i++)
        if (strcmp(tza->tensors[i].name, name) == 0) return &tza->tensors[i];
    return NULL;
}
