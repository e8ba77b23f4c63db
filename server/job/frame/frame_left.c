/* How much of a frame is done, and what the rest will cost. */
#include <math.h>

#include "server/job/frame/frame_work.h"

#define RESIDUAL_US  2.5 /* of a pixel, before any is filtered */
#define WINDOW_US    4.0 /* the same, with samples of other frames */
#define OIDN_US      2.6 /* of a pixel, which Open Image Denoise filters when all is drawn */
#define LAST_ROWS    2.0 /* of blocks, which wait for the last tiles */
#define ROUND_GROWTH 4.0

/* Samples that each pixel gets by the schedule. */
static uint32_t scheduled(const struct frame *f)
{
    const struct plan_pass pass = plan_scheduled_pass(&f->plan, 0);
    return plan_views(&f->plan) *
           (frame_pass_samples(&pass) + f->plan.paths.spp - plan_pass_spp(&f->plan, 1));
}

double frame_traced_share(const struct frame *f)
{
    if (frame_has_rounds(f)) return f->rounds.shown;
    return (double)f->samples_landed / ((double)scheduled(f) * tile_grid_count(&f->grid));
}

/* Returns the work of a tile's first set, before others are decided on. */
static double first_set(const struct frame *f, uint32_t area)
{
    uint64_t sum = 0;
    for (uint32_t p = 0; p < plan_pass_count(&f->plan); p++) {
        const struct plan_pass pass = plan_scheduled_pass(&f->plan, p);
        sum += frame_pass_work(&f->plan, &pass, area);
    }
    return (double)sum;
}

static double due(const struct frame *f, uint32_t tile, struct rect rect)
{
    if (frame_has_target(f)) return rounds_due(f->target.rounds, tile);
    if (!frame_is_adaptive(f)) return (double)scheduled(f) * (double)rect_area(rect);
    return f->adaptive.decided ? (double)f->adaptive.tiles[tile].rays
                               : first_set(f, (uint32_t)rect_area(rect));
}

static void note_due(struct frame *f)
{
    for (uint32_t i = 0; i < tile_grid_count(&f->grid); i++) {
        const struct rect rect = tile_grid_rect(&f->grid, i);
        cost_map_due(&f->costs, rect, due(f, i, rect));
    }
}

void frame_costs_foresee(struct frame *f)
{
    cost_map_begin_round(&f->costs);
    note_due(f);
}

void frame_costs_foresee_anew(struct frame *f)
{
    cost_map_foresee_anew(&f->costs);
    note_due(f);
}

void frame_costs_create(struct frame *f)
{
    cost_map_init(&f->costs, f->plan.width_px, f->plan.height_px);
    frame_costs_foresee(f);
}

void frame_costs_land(struct frame *f, uint32_t tile, double samples,
                      const struct counters *counters)
{
    const double us =
        (double)(counters->value[COUNTER_TRACE_CPU_US] + counters->value[COUNTER_PACK_CPU_US]);
    cost_map_land(&f->costs, tile_grid_rect(&f->grid, tile), samples, us);
}

/* Returns by how much that may differ from what is likely: samples cost what those do that are due,
 * or have. */
static double beyond_us(const struct frame *f, double likely_us, enum foreseen which)
{
    const struct rounds_report r = rounds_report(f->target.rounds);
    const double landed = (double)f->samples_landed, due = r.expected[FORESEEN_LIKELY] - landed;
    const double each_us = due > 0.0 && likely_us > 0.0
                               ? likely_us / due
                               : cost_map_done_us(&f->costs) / fmax(1.0, landed);
    return (r.expected[which] - r.expected[FORESEEN_LIKELY]) * each_us;
}

double frame_left_us(const struct frame *f, enum foreseen which)
{
    const double left_us = cost_map_left_us(&f->costs), landed = cost_map_landed(&f->costs);
    if (frame_has_target(f)) return fmax(0.0, left_us + beyond_us(f, left_us, which));
    if (!frame_is_adaptive(f) || f->adaptive.decided || landed <= 0.0) return left_us;
    /* What the first set says of where the second will be comes too late. */
    const double second = frame_rounds_expected(f) - frame_rounds_first(f);
    return left_us + second * cost_map_done_us(&f->costs) / landed;
}

double frame_done_us(const struct frame *f)
{
    return cost_map_done_us(&f->costs);
}

/* Returns the CPU time that filters take of a block, in us. */
static double block_us(const struct frame *f)
{
    const struct statistics *s = &f->statistics;
    const uint64_t us = s->reconstruct_cpu_us + s->shadow_cpu_us + s->indirect_cpu_us +
                        s->glossy_cpu_us + s->lens_cpu_us + s->lens_relight_cpu_us +
                        s->residual_cpu_us;
    if (f->blocks_drawn > 0) return (double)us / (double)f->blocks_drawn;
    const bool filtered = f->plan.residual_filter == RESIDUAL_FILTER_HALVES;
    const double pixel_us = frame_has_neighbours(f) ? WINDOW_US : RESIDUAL_US;
    return filtered ? pixel_us * (double)f->block_px * (double)f->block_px : 0.0;
}

/* Returns how many rounds are thought to follow this one. */
static double rounds_to_come(const struct frame *f, enum foreseen which)
{
    if (!frame_has_target(f)) return 0.0;
    const struct rounds_report r = rounds_report(f->target.rounds);
    const double ratio = r.expected[which] / (double)(r.paths + r.bounces);
    return ratio > 1.02 ? ceil(log(ratio) / log(ROUND_GROWTH)) : 0.0;
}

/* Other blocks are drawn while tiles are traced. */
double frame_filters_left_us(const struct frame *f, enum foreseen which)
{
    const double width = ceil((double)f->plan.width_px / f->block_px);
    const double height = ceil((double)f->plan.height_px / f->block_px);
    const double blocks = fmin(height, LAST_ROWS) * width * plan_views(&f->plan);
    const double rows_left = ceil((double)(f->plan.height_px - frame_rows_done(f)) / f->block_px);
    const double now = fmin(blocks, rows_left * width * plan_views(&f->plan));
    const double pixels = (double)f->plan.width_px * (double)f->plan.height_px;
    const double last = frame_has_denoiser(f) ? OIDN_US * pixels : 0.0;
    return block_us(f) * (fmax(now, f->blocks_out) + rounds_to_come(f, which) * blocks) + last;
}
