#pragma once
/* Bytes that are sent without being copied: a tile's samples, from the thread that packed them
 * until the coordinator acknowledges them. The references are counted, on the loop's thread only.
 */
#include <stddef.h>
#include <stdint.h>

#include "proto/bytes.h"

struct shared_buffer {
    unsigned refs;
    size_t size_bytes;
    uint8_t *data; /* owned */
};

/* Takes over w's bytes and returns the caller's reference. NULL on failed allocation; w is then
 * freed, too. */
struct shared_buffer *shared_buffer_take(struct bytes_writer *w);
struct shared_buffer *shared_buffer_ref(struct shared_buffer *p);
void shared_buffer_unref(struct shared_buffer **p);
