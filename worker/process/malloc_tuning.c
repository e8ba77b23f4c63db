#include "worker/process/malloc_tuning.h"

#include <malloc.h>

/* The largest block that glibc takes from its heaps; it maps and unmaps larger ones. */
#define MAPPED_FROM_BYTES (32 << 20)
#define KEPT_BYTES        (64 << 20)

void malloc_tuning_apply(void)
{
    mallopt(M_MMAP_THRESHOLD, MAPPED_FROM_BYTES);
    mallopt(M_TRIM_THRESHOLD, KEPT_BYTES);
}
