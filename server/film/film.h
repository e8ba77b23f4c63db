#pragma once
/* Collects a frame's samples: tiles go in, patches come out, and memory is bounded by what is still
 * needed.
 *
 * A tile lands pass by pass (proto/plan.h). Its first pass is kept, and later passes are added to
 * its sums in their order. A tile thus costs the same memory whatever the samples a pixel, and the
 * sums are the same bytes whatever the order of arrival.
 *
 * A block is ready when all its tiles have a first pass, and again each time that all of them have
 * a further one: at most once a pass. It reads whatever has landed of each tile. A block is handed
 * out once at a time. While it is out its tiles do not change: passes that land for them stay
 * pending, and are added when the last block that reads the tile is done. A block that reads a tile
 * with a pending pass is not handed out, so that this happens soon. After the last pass of its
 * tiles a block is reconstructed a last time, with all samples. Then it releases its tiles, and a
 * tile without a reading block is freed.
 *
 * A picture that forms costs a filter's time for each time that a block is drawn. So a block may
 * rest: times before its last that would come while it does are left out, and the next pass brings
 * it again. What the last time reads does not depend on that.
 *
 * Under a plan with rounds the schedule is the first round: blocks keep their tiles, and when all
 * blocks are settled, tiles may be asked for further passes. A block is then reconstructed once a
 * round, when all its tiles have the passes asked for; blocks without such tiles are settled as
 * they are. A frame's tiles stay until film_release.
 *
 * Book-keeping (land, the ready list, release) belongs to the loop's thread. film_gather reads
 * landed tiles and may run on any thread, for blocks reported ready and not yet done. */
#include <stdbool.h>

#include "proto/samples.h"
#include "server/film/passes.h"
#include "server/reconstruct/patch/patch.h"

struct film;

/* Creates a film of blocks of block_px over the plan's image. Patches reach halo_px around them and
 * hold all planes core_px around. The plan is borrowed and must outlive the film. */
int film_create(const struct plan *plan, int32_t block_px, int32_t core_px, int32_t halo_px,
                struct film **out);
void film_destroy(struct film **film);

/* Takes the samples of a tile's pass, which must have this pass's layout; its strata maps are
 * borrowed for the film's life. On an error they are not taken: ERR_EXISTS when the pass has landed
 * before, ERR_RANGE for an unknown tile or pass or one before its turn, ERR_MISMATCH for samples of
 * another size. Blocks that become ready are queued; film_next_ready takes them in order. */
int film_land_pass(struct film *film, uint32_t tile, const struct plan_pass *pass,
                   struct samples *samples);

/* Does the same for a pass of the plan's schedule. */
int film_land(struct film *film, uint32_t tile, uint32_t pass, struct samples *samples);

/* Begins a round of a complete film under a plan with rounds: tile t gets more_passes[t] further
 * passes. */
void film_begin_round(struct film *film, const uint32_t *more_passes);

/* Frees all tiles of a complete film. */
void film_release(struct film *film);

/* Holds all blocks back, or hands them out from now on. Held blocks keep their tiles. */
void film_hold(struct film *film, bool held);

/* Tells the film the time, of any clock. It is 0 until then. */
void film_tell_time(struct film *film, uint64_t now_us);
/* Lets a block rest until then on this clock. Its last time, in each round, is never left out. */
void film_rest(struct film *film, uint32_t block, uint64_t until_us);

/* Takes the next ready block that does not rest. Returns false if there is none. It is out until
 * film_block_done. */
bool film_next_ready(struct film *film, uint32_t *block);
struct rect film_block_rect(const struct film *film, uint32_t block);
uint32_t film_block_count(const struct film *film);

/* Makes patches come from that scratch, which must outlive them, instead of from the heap. */
void film_gather_in(struct film *film, struct scratch *scratch);

/* Gathers the block's samples with halo, as floats. The caller owns the patch. */
int film_gather(const struct film *film, uint32_t block, struct patch **out);

/* Does the same for a block of which only surfaces are wanted (PLANE_PATH_COVERAGE). The patch ends
 * margin_px around those that the block or its halo shows. *shown becomes a part of the block, or
 * is empty, and there is no patch: nothing shows surfaces beyond it. */
int film_gather_shown(const struct film *film, uint32_t block, int32_t margin_px,
                      struct rect *shown, struct patch **out);

/* Gathers the samples of a rect alone, where all tiles have landed: on any thread while blocks are
 * held, else on the loop's. */
int film_gather_rect(const struct film *film, struct rect rect, struct patch **out);

/* Ends a block's reconstruction: adds pending passes of its tiles, which may make blocks ready, and
 * frees tiles that no block reads any more. Returns whether it was the block's last time in this
 * round. */
bool film_block_done(struct film *film, uint32_t block);
/* Returns the rows of pixels from the top whose blocks are all done, in this round under a plan
 * with rounds. */
int32_t film_rows_done(const struct film *film);
bool film_complete(const struct film *film); /* every block's last time, in this round, is over */

uint64_t film_bytes(const struct film *film);   /* held in tiles now */
uint64_t film_pending(const struct film *film); /* passes that wait to be added */
