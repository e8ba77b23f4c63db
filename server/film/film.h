#pragma once
/* Where a frame's samples land: tiles in, patches out, memory bounded by what is still needed.
 *
 * Book-keeping (land, the ready list, release) is for the loop's thread. film_gather reads tiles
 * that have landed and may run on any thread for blocks that were reported ready and are not yet
 * done. */
#include <stdbool.h>

#include "proto/samples.h"
#include "server/reconstruct/patch.h"

struct film;

/* Blocks of block_px and halos of halo_px over the plan's image. The plan is borrowed and must
 * outlive the film. */
int film_create(const struct plan *plan, int32_t block_px, int32_t halo_px, struct film **out);
void film_destroy(struct film **film);

/* Takes the samples of a tile. Not taken: ERR_EXISTS when the tile has landed before, ERR_RANGE for
 * a tile that is none, ERR_MISMATCH for samples of another size. Blocks whose every tile is now
 * there are queued; film_next_ready takes them in order. */
int film_land(struct film *film, uint32_t tile, struct samples *samples);

/* The next block that can be reconstructed; false when there is none. */
bool film_next_ready(struct film *film, uint32_t *block);
struct rect film_block_rect(const struct film *film, uint32_t block);
uint32_t film_block_count(const struct film *film);

/* The block's samples with halo, as floats. Owned by the caller. */
int film_gather(const struct film *film, uint32_t block, struct patch **out);

/* The block is reconstructed: tiles that no other block waits for are freed. */
void film_block_done(struct film *film, uint32_t block);
bool film_complete(const struct film *film);

uint64_t film_bytes(const struct film *film); /* held in tiles now */
