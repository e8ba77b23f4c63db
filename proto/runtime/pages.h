#pragma once
/* Pages of memory. */
#include <stddef.h>

#define PAGES_HUGE_BYTES ((size_t)1 << 21)

/* Asks for huge pages where memory holds whole ones. They cost less when they are touched first,
 * and save the CPU's look-ups later. The bytes are the same where the system has none. */
void pages_prefer_huge(void *memory, size_t size_bytes);

/* Takes `size_bytes` of uninitialised memory, aligned to a cache line. Pieces of some megabytes and
 * less share huge pages, which none of them would fill: it is for pieces that are taken and given
 * back together, by any thread. NULL: there is no memory. */
void *pages_take(size_t size_bytes);
void pages_give(void *memory); /* may be NULL */
