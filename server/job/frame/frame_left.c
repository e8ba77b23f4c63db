/* How much of a frame is done, and what the rest will cost. */
#include "server/job/frame/frame_work.h"

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

/* Other rounds than those of a target are decided on too late to tell where samples will be. */
static double due(const struct frame *f, uint32_t tile, struct rect rect)
{
    if (frame_has_target(f)) return rounds_due(f->target.rounds, tile);
    return frame_has_rounds(f) ? 0.0 : (double)scheduled(f) * (double)rect_area(rect);
}

void frame_costs_foresee(struct frame *f)
{
    cost_map_begin_round(&f->costs);
    for (uint32_t i = 0; i < tile_grid_count(&f->grid); i++) {
        const struct rect rect = tile_grid_rect(&f->grid, i);
        cost_map_due(&f->costs, rect, due(f, i, rect));
    }
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

double frame_left_us(const struct frame *f)
{
    const double landed = cost_map_landed(&f->costs);
    if (!frame_has_rounds(f) || frame_has_target(f)) return cost_map_left_us(&f->costs);
    const double left = frame_rounds_expected(f) - (double)f->samples_landed;
    return left > 0.0 && landed > 0.0 ? left * cost_map_done_us(&f->costs) / landed : 0.0;
}

double frame_done_us(const struct frame *f)
{
    return cost_map_done_us(&f->costs);
}

double frame_filters_left_us(const struct frame *f)
{
    const struct statistics *s = &f->statistics;
    const uint64_t us = s->reconstruct_cpu_us + s->shadow_cpu_us + s->indirect_cpu_us +
                        s->glossy_cpu_us + s->lens_cpu_us + s->lens_relight_cpu_us +
                        s->residual_cpu_us;
    if (f->blocks_drawn == 0) return 0.0;
    return (double)us / (double)f->blocks_drawn * (double)f->blocks_out;
}
