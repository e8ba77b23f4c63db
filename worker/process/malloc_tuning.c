#include "worker/process/malloc_tuning.h"

#include <malloc.h>

/* The most that glibc takes from its heaps; larger blocks are mapped and unmapped. */
#define MAPPED_FROM_BYTES (32 << 20)
#define KEPT_BYTES        (64 << 20)

void malloc_tuning_apply(void)
{
    mallopt(M_MMAP_THRESHOLD, MAPPED_FROM_BYTES);
    mallopt(M_TRIM_THRESHOLD, KEPT_BYTES);
}
