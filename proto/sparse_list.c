#include "proto/sparse_list.h"

#include <stdlib.h>

int sparse_list_create(uint32_t values, uint32_t count, struct sparse_list **out)
{
    struct sparse_list *list = calloc(1, sizeof *list);
    if (!list) return ERR_MEMORY;
    list->values = values;
    list->count = count;
    list->words = calloc((size_t)count * (1 + values) + 1, sizeof *list->words);
    if (!list->words) {
        free(list);
        return ERR_MEMORY;
    }
    *out = list;
    return 0;
}

void sparse_list_destroy(struct sparse_list **list)
{
    if (!*list) return;
    free((*list)->words);
    free(*list);
    *list = NULL;
}

size_t sparse_list_bytes(const struct sparse_list *list)
{
    return list ? (size_t)list->count * (1 + list->values) * sizeof *list->words : 0;
}

float *sparse_list_numbers(const struct sparse_list *list, uint32_t value)
{
    return (float *)(void *)(list->words + (size_t)(1 + value) * list->count);
}

int sparse_list_check(const struct sparse_list *list, uint32_t places, const char *name,
                      struct fault *fault)
{
    for (uint32_t e = 0; e < list->count; e++) {
        const uint32_t place = list->words[e];
        if (place >= places)
            return fault_set(fault, ERR_RANGE, name, "place %u of entry %u is not below %u", place,
                             e, places);
        if (e > 0 && place <= list->words[e - 1])
            return fault_set(fault, ERR_RANGE, name, "place %u of entry %u does not ascend", place,
                             e);
    }
    return 0;
}
