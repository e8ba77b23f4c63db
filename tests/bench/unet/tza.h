#pragma once
/* Reads TZA files, archives of tensors in which Open Image Denoise's trained weights come.
 *
 * Numbers are little-endian. The head is a u16 magic, bytes of major and minor version, and a u64
 * place of the table. The table is a u32 count, and of each tensor: a u16 length and the name; a
 * byte of rank; u32 sizes; a letter of the layout for each size; a letter of the type, 'h' or 'f';
 * the u64 place of its numbers. */
#include <stddef.h>
#include <stdint.h>

#include "proto/error.h"

#define TZA_TENSORS_MAX 64
#define TZA_NAME_BYTES  64
#define TZA_RANK_MAX    4
#define TZA_SIZE_MAX    4096 /* of each of a tensor's sizes */
#define TZA_FILE_BYTES  ((size_t)64 << 20)

struct tza_tensor {
    char name[TZA_NAME_BYTES];
    uint32_t rank, sizes[TZA_RANK_MAX];
    char layout[TZA_RANK_MAX + 1];
    size_t count;
    float *values; /* owned by the archive */
};

struct tza {
    uint32_t count;
    struct tza_tensor tensors[TZA_TENSORS_MAX];
};

/* Reads an archive of `size_bytes` bytes. ERR_MAGIC, ERR_VERSION, ERR_TRUNCATED, ERR_LIMIT,
 * ERR_TYPE or ERR_MEMORY, with a sentence in *fault. What was read is to be freed even after an
 * error. */
int tza_parse(const void *data, size_t size_bytes, struct tza *out, struct fault *fault);

/* Reads a file; also ERR_IO. */
int tza_read(const char *path, struct tza *out, struct fault *fault);
void tza_fini(struct tza *tza);

/* Returns NULL where there is none of that name. */
const struct tza_tensor *tza_find(const struct tza *tza, const char *name);
