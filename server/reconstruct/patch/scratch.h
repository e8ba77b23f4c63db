#pragma once
/* Large pieces of memory, taken and given back by the work on one block after another. They are
 * kept from block to block and from frame to frame: fresh pages cost the system's time, and huge
 * pages save the CPU's look-ups.
 *
 * Any thread may call it. It holds no more pieces than were taken at once since it was trimmed. */
#include <stddef.h>

struct scratch;

/* Creates an empty scratch. ERR_MEMORY. */
int scratch_create(struct scratch **out);

/* Frees the scratch and nulls the pointer. Everything taken must have been given back. */
void scratch_destroy(struct scratch **scratch);

/* Takes at least `bytes` of uninitialised memory, aligned to a cache line; from the heap if scratch
 * is NULL. NULL when there is none. */
void *scratch_take(struct scratch *scratch, size_t bytes);

/* Gives memory back to where it was taken from. memory may be NULL. */
void scratch_give(struct scratch *scratch, void *memory);

/* Frees pieces that were given back, the largest first, until `most_bytes` at most are kept. */
void scratch_trim(struct scratch *scratch, size_t most_bytes);
