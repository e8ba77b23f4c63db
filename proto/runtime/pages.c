#include "proto/runtime/pages.h"

#include <stdint.h>
#include <sys/mman.h>

void pages_prefer_huge(void *memory, size_t size_bytes)
{
    const uintptr_t unit = PAGES_HUGE_BYTES, at = (uintptr_t)memory;
    const uintptr_t first = (at + unit - 1) / unit * unit, end = (at + size_bytes) / unit * unit;
    if (first < end) madvise((char *)memory + (first - at), end - first, MADV_HUGEPAGE);
}
