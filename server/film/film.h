#pragma once
/* Where a frame's samples land: tiles in, patches out, memory bounded by what is still needed.
 *
 * A tile lands pass by pass (proto/plan.h). Its first pass is kept; the sums of later ones are
 * added to it in their order, so that a tile costs the same memory whatever the samples a pixel,
 * and the sums are the same bytes whatever the order in which tiles arrive.
 *
 * A block is ready as soon as all its tiles have a first pass, and again each time when all of them
 * have a further one: at most once a pass. In between it reads of each tile what has landed. A
 * block is handed out once at a time, and while it is out nobody touches its tiles: what lands for
 * them waits beside them, and is added when the last block that reads them is done. No block is
 * handed out that reads a tile for which something waits, so that this comes soon. After the last
 * pass of its tiles a block is reconstructed a last time, with all of their samples; then it lets
 * go of them, and a tile that no block needs any more is freed.
 *
 * Under a plan that has rounds, what the schedule has is the first of several: blocks keep
 * their tiles, and when all of them are settled, tiles may be asked for further passes. A block is
 * then reconstructed once a round, when all its tiles have what they were asked for, and blocks of
 * which no tile was asked are settled as they are. A frame's tiles stay until film_release.
 *
 * Book-keeping (land, the ready list, release) is for the loop's thread. film_gather reads tiles
 * that have landed and may run on any thread for blocks that were reported ready and are not yet
 * done. */
#include <stdbool.h>

#include "proto/samples.h"
#include "server/film/passes.h"
#include "server/reconstruct/patch/patch.h"

struct film;

/* Blocks of block_px over the plan's image; patches reach halo_px around them and hold all planes
 * core_px around. The plan is borrowed and must outlive the film. */
int film_create(const struct plan *plan, int32_t block_px, int32_t core_px, int32_t halo_px,
                struct film **out);
void film_destroy(struct film **film);

/* Takes the samples of a tile's pass, which must be of this pass's layout; its sides are borrowed
 * for the film's life. Not taken: ERR_EXISTS when the pass has landed before, ERR_RANGE for a tile
 * or a pass that is none or comes before its turn, ERR_MISMATCH for samples of another size. Blocks
 * that are now ready are queued; film_next_ready takes them in order. */
int film_land_pass(struct film *film, uint32_t tile, const struct plan_pass *pass,
                   struct samples *samples);

/* The same of a pass of the plan's schedule. */
int film_land(struct film *film, uint32_t tile, uint32_t pass, struct samples *samples);

/* Of a plan that has rounds, when the film is complete: tile t gets more_passes[t] passes more. */
void film_begin_round(struct film *film, const uint32_t *more_passes);

/* Lets go of all tiles of a film that is complete. */
void film_release(struct film *film);

/* The next block that can be reconstructed; false when there is none. It is out until
 * film_block_done. */
bool film_next_ready(struct film *film, uint32_t *block);
struct rect film_block_rect(const struct film *film, uint32_t block);
uint32_t film_block_count(const struct film *film);

/* From here on patches come from that scratch, which must outlive them; before, from the heap. */
void film_gather_in(struct film *film, struct scratch *scratch);

/* The block's samples with halo, as floats. Owned by the caller. */
int film_gather(const struct film *film, uint32_t block, struct patch **out);

/* The block is reconstructed: what waited for its tiles is added, which may make blocks ready, and
 * tiles that no block needs any more are freed. True when that was its last time, in this round. */
bool film_block_done(struct film *film, uint32_t block);
/* Rows of pixels from the top all of whose blocks are done; of a plan with rounds, in this one. */
int32_t film_rows_done(const struct film *film);
bool film_complete(const struct film *film); /* the last time of all, in this round */

uint64_t film_bytes(const struct film *film);   /* held in tiles now */
uint64_t film_pending(const struct film *film); /* passes that wait to be added */
