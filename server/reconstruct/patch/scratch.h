#pragma once
/* Large pieces of memory that work on one block after another takes and gives back. Kept from one
 * block to the next, and from one frame to the next: fresh pages cost the system's time, and huge
 * ones spare the CPU's look-ups.
 *
 * Any thread. It holds no more pieces than were taken at once since it was trimmed. */
#include <stddef.h>

struct scratch;

/* ERR_MEMORY. */
int scratch_create(struct scratch **out);

/* Everything taken must have been given back. Nulls the pointer. */
void scratch_destroy(struct scratch **scratch);

/* At least `bytes` of memory that holds anything, on a cache line; NULL when there is none. From
 * the heap if scratch is NULL. */
void *scratch_take(struct scratch *scratch, size_t bytes);

/* To where it was taken from. memory may be NULL. */
void scratch_give(struct scratch *scratch, void *memory);

/* Of what was given back by now it goes on holding `most_bytes` at most: the largest pieces go
 * first. */
void scratch_trim(struct scratch *scratch, size_t most_bytes);
