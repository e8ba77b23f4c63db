#pragma once
/* Memory that is missing for the n-th piece that the code under test asks for, and for no other.
 * The program is linked with --wrap for these functions (Makefile: `lean`), so that a library's own
 * calls are not counted, and a sanitizer's allocator stays where it is and tells of leaks. */
#include <stddef.h>

static _Thread_local unsigned until_lack; /* 1: the next; 0: there is enough */

void *__real_malloc(size_t size_bytes);
void *__real_calloc(size_t count, size_t size_bytes);
void *__real_realloc(void *memory, size_t size_bytes);
char *__real_strdup(const char *text);
void *__wrap_malloc(size_t size_bytes);
void *__wrap_calloc(size_t count, size_t size_bytes);
void *__wrap_realloc(void *memory, size_t size_bytes);
char *__wrap_strdup(const char *text);

static int is_lacking(void)
{
    return until_lack > 0 && --until_lack == 0;
}

void *__wrap_malloc(size_t size_bytes)
{
    return is_lacking() ? NULL : __real_malloc(size_bytes);
}

void *__wrap_calloc(size_t count, size_t size_bytes)
{
    return is_lacking() ? NULL : __real_calloc(count, size_bytes);
}

void *__wrap_realloc(void *memory, size_t size_bytes)
{
    return is_lacking() ? NULL : __real_realloc(memory, size_bytes);
}

char *__wrap_strdup(const char *text)
{
    return is_lacking() ? NULL : __real_strdup(text);
}
