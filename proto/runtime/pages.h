#pragma once
/* Pages of memory. */
#include <stddef.h>

#define PAGES_HUGE_BYTES ((size_t)1 << 21)

/* Asks for huge pages where memory holds whole ones. They cost less when they are touched first,
 * and save the CPU's look-ups later. The bytes are the same where the system has none. */
void pages_prefer_huge(void *memory, size_t size_bytes);
