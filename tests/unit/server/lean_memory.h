#pragma once
/* Memory that is missing for the n-th piece that the program asks for, and for no other. A
 * sanitizer's allocator stays in place: `memory_can_lack` is false there. */
#include <stdbool.h>
#include <stddef.h>

#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__
static const bool memory_can_lack = false;
static unsigned until_lack;
#else
static const bool memory_can_lack = true;
static _Thread_local unsigned until_lack; /* 1: the next; 0: there is enough */

void *__libc_malloc(size_t size_bytes);
void *__libc_calloc(size_t count, size_t size_bytes);
void *malloc(size_t size_bytes);
void *calloc(size_t count, size_t size_bytes);

void *malloc(size_t size_bytes)
{
    return until_lack > 0 && --until_lack == 0 ? NULL : __libc_malloc(size_bytes);
}

void *calloc(size_t count, size_t size_bytes)
{
    return until_lack > 0 && --until_lack == 0 ? NULL : __libc_calloc(count, size_bytes);
}
#endif
