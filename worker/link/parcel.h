#pragma once
/* Bytes that are sent without being copied: a tile's samples, from the thread that packed them to
 * the socket and until they are acknowledged. Counted references; loop thread only. */
#include <stddef.h>
#include <stdint.h>

#include "proto/bytes.h"

struct parcel {
    unsigned refs;
    size_t size_bytes;
    uint8_t *data; /* owned */
};

/* Takes over w's bytes; one reference, the caller's. NULL on failed allocation (w is freed, too).
 */
struct parcel *parcel_take(struct bytes_writer *w);
struct parcel *parcel_ref(struct parcel *p);
void parcel_unref(struct parcel **p);
