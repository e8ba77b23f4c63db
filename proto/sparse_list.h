#pragma once
/* A sparse list beside the planes of a tile: of lone sub-samples (lone.h) or mixed pixels
 * (mixed.h). */
#include <stddef.h>
#include <stdint.h>

#include "proto/error.h"

/* The list as it is sent: `count` places, strictly ascending, then value by value `count` numbers
 * (f32). The pixel of a place is an element of the tile's planes. */
struct sparse_list {
    uint32_t parts;  /* bits of enum lone_part; of mixed pixels 0 */
    uint32_t values; /* numbers of an entry */
    uint32_t count;  /* > 0 */
    uint32_t *words;
};

/* Creates a list of zeros. ERR_MEMORY. sparse_list_destroy nulls the pointer, which may be NULL. */
int sparse_list_create(uint32_t values, uint32_t count, struct sparse_list **out);
void sparse_list_destroy(struct sparse_list **list);

/* Returns the size of a list, which may be NULL. */
size_t sparse_list_bytes(const struct sparse_list *list);

/* Returns `count` numbers of a value. */
float *sparse_list_numbers(const struct sparse_list *list, uint32_t value);

/* Checks that places ascend below `places`. ERR_RANGE; *fault names the list and the entry. */
int sparse_list_check(const struct sparse_list *list, uint32_t places, const char *name,
                      struct fault *fault);
