#include "server/job/frame/frame.h"

#include <assert.h>
#include <stdlib.h>

#include "server/image/exr_mattes.h"
#include "server/job/frame/frame_work.h"
#include "server/reconstruct/block.h"
#include "server/reconstruct/compose/path_error.h"

/* Pixels in blocks that may wait for the pool before leases pause: their samples stay in memory,
 * about 128 bytes a pixel at 9 spp. However large blocks are, some for each thread may wait. */
#define PIXELS_OUT_MAX 524288
#define BLOCKS_OUT_MIN 32

/* The largest blocks that may be asked for. */
#define BLOCK_MAX_PX 512

/* Passes that may wait for a block to be reconstructed before they are added to their tiles. */
#define PENDING_MAX 64

/* Sums of paths that a frame holds between passes, so that thousands of samples cost the memory of
 * sixteen: tiles are brought to their end a few at a time. Workers that would idle begin more. */
#define SUMS_MAX_BYTES 1048576u

static void destroy(struct frame *f)
{
    frame_files_drop(f);
    frame_spool_destroy(f);
    frame_rounds_destroy(f);
    frame_neighbours_destroy(f);
    frame_denoise_destroy(f);
    motion_drop(&f->motion);
    tile_queue_destroy(&f->tiles);
    frame_views_destroy(f);
    plate_drop(&f->options.plate);
    exr_mattes_drop(&f->options.metadata.mattes);
    scratch_destroy(&f->own_scratch);
    bytes_writer_fini(&f->plan_bytes);
    free(f);
}

/* Tiles between their first pass and their last: as many as keep their sums in SUMS_MAX_BYTES. */
static uint32_t window_tiles(const struct plan *plan)
{
    struct samples_layout layout;
    if (plan_pass_count(plan) == 1) return UINT32_MAX;
    if (plan_has_rounds(plan)) return UINT32_MAX; /* all of them are kept */
    if (samples_layout_init(&layout, plan, 0, plan->tile_px, plan->tile_px) != 0) return 1;
    uint32_t tiles = SUMS_MAX_BYTES / (layout.total_bytes + 1);
    return tiles > 0 ? tiles : 1;
}

/* Returns the side of blocks, the plan's unless a test asks for another. Pixels must not depend on
 * it. It is a multiple of the side of the cells in which errors are estimated. */
static int32_t choose_block_px(const struct plan *plan)
{
    const char *text = getenv("SHEARWATER_BLOCK_PX");
    const long asked = text ? strtol(text, NULL, 10) : 0;
    const bool fits = asked >= 1 && asked <= BLOCK_MAX_PX && asked % PATH_ERROR_CELL_PX == 0;
    return fits ? (int32_t)asked : block_side_px(plan);
}

int frame_create(const struct frame_options *options, struct frame **out)
{
    struct frame *f = calloc(1, sizeof *f);
    if (!f) return ERR_MEMORY;
    f->options = *options;
    f->plan = *options->plan;
    f->motion = motion_hold(options->motion);
    f->options.plate = plate_hold(options->plate);
    exr_mattes_hold(options->metadata.mattes);
    f->options.plan = &f->plan;
    if (options->metadata.job) { /* the job may end before its files are written */
        snprintf(f->fingerprint, sizeof f->fingerprint, "%s", options->metadata.job);
        f->options.metadata.job = f->fingerprint;
    }
    f->state = FRAME_QUEUED;
    bytes_writer_init(&f->plan_bytes);
    plan_encode(&f->plan_bytes, &f->plan);
    f->block_px = choose_block_px(&f->plan);
    int error = f->plan_bytes.failed ? ERR_MEMORY : 0;
    if (!error)
        error = tile_grid_init(&f->grid, f->plan.width_px, f->plan.height_px, f->plan.tile_px);
    if (!error)
        error = tile_queue_create(&f->grid, f->block_px, plan_pass_count(&f->plan),
                                  window_tiles(&f->plan), &f->tiles);
    if (!error && !options->scratch) error = scratch_create(&f->own_scratch);
    f->scratch = options->scratch ? options->scratch : f->own_scratch;
    if (!error) error = frame_views_create(f);
    if (!error && plan_has_rounds(&f->plan)) error = frame_rounds_create(f);
    if (!error && frame_has_neighbours(f)) frame_neighbours_begin(f);
    if (!error) error = frame_denoise_create(f);
    if (!error) frame_costs_create(f);
    if (error) {
        destroy(f);
        return error;
    }
    frame_files_init(f);
    f->begun_us = f->arrived_us = frame_clock_us();
    frame_state_go(&f->state, FRAME_RENDERING);
    *out = f;
    return 0;
}

void frame_drop(struct frame **frame)
{
    struct frame *f = *frame;
    *frame = NULL;
    if (!f) return;
    assert(!atomic_load(&f->dropped));
    atomic_store(&f->dropped, true);
    if (f->tasks == 0) destroy(f);
}

void frame_task_submit(struct frame *f, struct pool_task *task)
{
    f->tasks++;
    thread_pool_submit(f->options.pool, task);
}

bool frame_task_over(struct frame *f)
{
    assert(f->tasks > 0);
    f->tasks--;
    if (!atomic_load(&f->dropped)) return true;
    if (f->tasks == 0) destroy(f);
    return false;
}

void frame_fail(struct frame *f, int code, const char *pointer, const char *detail)
{
    struct fault fault;
    fault_set(&fault, code, pointer, "frame %d: %s", f->options.number, detail);
    f->options.events.failed(f->options.events.ctx, f, &fault);
}

uint64_t frame_id(const struct frame *f)
{
    return f->options.id;
}

int32_t frame_number(const struct frame *f)
{
    return f->options.number;
}

enum frame_state frame_state(const struct frame *f)
{
    return f->state;
}

const struct image *frame_image(const struct frame *f)
{
    return f->image;
}

const struct exr_metadata *frame_metadata(const struct frame *f)
{
    return &f->options.metadata;
}

const struct statistics *frame_statistics(const struct frame *f)
{
    return &f->statistics;
}

uint64_t frame_revision(const struct frame *f)
{
    return f->blocks_drawn + (f->denoise.is_shown ? 1 : 0);
}

uint32_t frame_tiles_total(const struct frame *f)
{
    return tile_queue_count(f->tiles);
}

struct rect frame_tile_rect(const struct frame *f, uint32_t index)
{
    return tile_grid_rect(&f->grid, index);
}

uint32_t frame_tile_count(const struct frame *f)
{
    return tile_grid_count(&f->grid);
}

uint32_t frame_tile_passes(const struct frame *f, uint32_t index)
{
    return tile_queue_pass(f->tiles, index);
}

uint32_t frame_tiles_planned(const struct frame *f)
{
    return tile_grid_count(&f->grid) * plan_pass_count(&f->plan);
}

uint32_t frame_tiles_landed(const struct frame *f)
{
    return tile_queue_landed(f->tiles);
}

uint32_t frame_tiles_waiting(const struct frame *f)
{
    return tile_queue_waiting(f->tiles);
}

uint32_t frame_pass_samples(const struct plan_pass *pass)
{
    const uint32_t count = pass->count + pass->strata * pass->strata;
    return count > 0 ? count : 1;
}

uint64_t frame_pass_work(const struct plan *plan, const struct plan_pass *pass, uint32_t area)
{
    const uint32_t lens = pass->number == 0 ? plan->lens_strata_per_axis : 0;
    const uint32_t field = pass->count + pass->strata * pass->strata;
    uint64_t rays = 0;
    if (!pass->strata_map)
        return (uint64_t)(lens > 0 ? field + lens * lens : frame_pass_samples(pass)) * area;
    for (uint32_t i = 0; i < area; i++) rays += (uint64_t)pass->strata_map[i] * pass->strata_map[i];
    for (uint32_t i = 0; i < area && pass->lobes; i++)
        rays += (uint64_t)pass->lobes[i] * pass->lobes[i];
    return rays;
}

const uint8_t *frame_plan_bytes(const struct frame *f, uint32_t *size_bytes)
{
    *size_bytes = (uint32_t)f->plan_bytes.size_bytes;
    return f->plan_bytes.data;
}

uint32_t frame_blocks_out_max(const struct frame *f)
{
    const int32_t most = PIXELS_OUT_MAX / (f->block_px * f->block_px);
    return (uint32_t)(most > BLOCKS_OUT_MIN ? most : BLOCKS_OUT_MIN);
}

static bool is_behind(const struct frame *f, uint32_t blocks_max, uint32_t pending_max)
{
    return f->blocks_out > blocks_max || frame_pending(f) > pending_max;
}

/* Describes a tile for the worker to which it was leased. */
static void describe(struct frame *f, uint32_t tile, uint32_t generation, struct fleet_tile *out)
{
    const uint32_t number = tile_queue_pass(f->tiles, tile);
    *out = (struct fleet_tile){.frame_id = f->options.id,
                               .index = tile,
                               .generation = generation,
                               .rect = tile_grid_rect(&f->grid, tile)};
    out->pass.number = number;
    if (number >= plan_pass_count(&f->plan)) out->pass = frame_pass(f, tile, number);
    if (out->pass.strata_map) {
        out->counts = f->adaptive.packed.data + f->adaptive.tiles[tile].packed;
        out->counts_bytes = f->adaptive.tiles[tile].packed_bytes;
    }
}

bool frame_is_behind(const struct frame *f)
{
    return is_behind(f, frame_blocks_out_max(f), PENDING_MAX);
}

bool frame_lease(struct frame *f, const struct worker_request *request, struct fleet_tile *out)
{
    uint32_t tile, generation;
    if ((f->plan.capabilities & ~request->capabilities) != 0) return false;
    if (frame_is_behind(f)) {
        f->held = true;
        return false;
    }
    if (!tile_queue_lease(f->tiles, request->worker, &tile, &generation)) return false;
    f->statistics.tiles_reissued = tile_queue_reissued(f->tiles);
    describe(f, tile, generation, out);
    out->alone = tile_queue_is_suspect(f->tiles, tile);
    return true;
}

uint64_t frame_tile_samples(const struct frame *f, const struct fleet_tile *tile)
{
    const uint32_t number = tile->pass.number;
    const struct plan_pass pass =
        number < plan_pass_count(&f->plan) ? plan_scheduled_pass(&f->plan, number) : tile->pass;
    const uint64_t area = (uint64_t)rect_width(tile->rect) * (uint64_t)rect_height(tile->rect);
    return area * ((number == 0 ? 1u : 0u) + pass.count + (uint64_t)pass.strata * pass.strata);
}

bool frame_waits_for_free(const struct frame *f, const struct worker_request *request)
{
    return !request->is_free && (f->plan.capabilities & ~request->capabilities) == 0 &&
           tile_queue_gives_suspect(f->tiles);
}

bool frame_copy(struct frame *f, uint64_t worker, uint32_t capabilities,
                const struct fleet_tile *of, struct fleet_tile *out)
{
    uint32_t generation;
    if ((f->plan.capabilities & ~capabilities) != 0) return false;
    if (!tile_queue_copy(f->tiles, worker, of->index, of->generation, &generation)) return false;
    f->statistics.tiles_copied = tile_queue_copied(f->tiles);
    describe(f, of->index, generation, out);
    return true;
}

/* Blocks that touch the region, and all that these read. */
static struct rect needed_by(const struct frame *f, struct rect region)
{
    const int32_t side = f->block_px;
    const struct rect blocks = {region.x0 / side * side, region.y0 / side * side,
                                (region.x1 + side - 1) / side * side,
                                (region.y1 + side - 1) / side * side};
    return rect_grow(blocks, block_halo_px(&f->plan));
}

void frame_steer(struct frame *f, const struct tile_priority *priority)
{
    struct tile_priority needed = *priority;
    if (!rect_is_empty(priority->region)) needed.region = needed_by(f, priority->region);
    tile_queue_steer(f->tiles, &needed);
}

struct plan_pass frame_pass(const struct frame *f, uint32_t tile, uint32_t number)
{
    if (frame_has_target(f)) return rounds_pass(f->target.rounds, tile, number);
    if (frame_is_adaptive(f)) return frame_adaptive_pass(f, tile, number);
    return plan_scheduled_pass(&f->plan, number);
}

const char *frame_warning(const struct frame *f)
{
    return f->target.warning;
}

bool frame_was_held(struct frame *f)
{
    if (!f->held || is_behind(f, frame_blocks_out_max(f) / 2, PENDING_MAX / 2)) return false;
    f->held = false;
    return true;
}

static void fail_at(struct frame *f, uint32_t tile, enum tile_return why)
{
    const struct rect r = frame_tile_rect(f, tile);
    char text[LIMIT_DETAIL_BYTES];
    if (why == TILE_IS_DEADLY)
        snprintf(text, sizeof text,
                 "the tile at %d,%d of %dx%d pixels ended at least %d workers that traced it, %d "
                 "while it was all that they held; see the workers' logs for what they died of",
                 r.x0, r.y0, rect_width(r), rect_height(r), TILE_QUEUE_DEATHS,
                 TILE_QUEUE_DEATHS - 1);
    else
        snprintf(text, sizeof text,
                 "the tile at %d,%d of %dx%d pixels came back %d times without a result; its "
                 "workers leave or give up",
                 r.x0, r.y0, rect_width(r), rect_height(r), TILE_QUEUE_RETURNS);
    frame_fail(f, ERR_KILLED, "", text);
}

bool frame_returned(struct frame *f, uint64_t worker, const struct fleet_tile *tile,
                    enum fleet_return why)
{
    const uint32_t waiting = tile_queue_waiting(f->tiles);
    static const enum tile_cause causes[] = {[FLEET_GIVEN_BACK] = TILE_GIVEN_BACK,
                                             [FLEET_TAKEN_BACK] = TILE_GIVEN_BACK,
                                             [FLEET_SENT_AWAY] = TILE_INNOCENT,
                                             [FLEET_DIED] = TILE_DIED};
    const enum tile_return next =
        tile_queue_return(f->tiles, worker, tile->index, tile->generation, causes[why]);
    if (next == TILE_GOES_ON) return tile_queue_waiting(f->tiles) > waiting;
    f->given_up = true;
    fail_at(f, tile->index, next);
    return false;
}

void frame_survived(struct frame *f, uint64_t worker)
{
    tile_queue_survived(f->tiles, worker);
}

void frame_faulted(struct frame *f, uint64_t worker, const struct message_tile_fault *fault)
{
    if (tile_queue_fault(f->tiles, worker, fault->index, fault->generation)) return;
    f->given_up = true;
    frame_fail(f, fault->code < 0 ? fault->code : ERR_STATE, "", fault->text);
}

bool frame_was_given_up(const struct frame *f)
{
    return f->given_up;
}

const struct fault *frame_refusal(const struct frame *f)
{
    return &f->refusal;
}
