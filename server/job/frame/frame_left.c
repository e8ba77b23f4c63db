/* How much of a frame is done, and what the rest will cost. */
#include "server/job/frame/frame_work.h"

/* Samples that each pixel gets by the schedule. */
static uint32_t scheduled(const struct frame *f)
{
    const struct plan_pass pass = plan_scheduled_pass(&f->plan, 0);
    return frame_pass_samples(&pass) + f->plan.paths.spp - plan_pass_spp(&f->plan, 1);
}

double frame_traced_share(const struct frame *f)
{
    if (frame_has_rounds(f)) return f->rounds.shown;
    return (double)f->samples_landed / ((double)scheduled(f) * tile_grid_count(&f->grid));
}

void frame_costs_create(struct frame *f)
{
    const double each = frame_has_rounds(f) ? 0.0 : scheduled(f);
    cost_map_init(&f->costs, f->plan.width_px, f->plan.height_px);
    for (uint32_t i = 0; i < tile_grid_count(&f->grid); i++) {
        const struct rect rect = tile_grid_rect(&f->grid, i);
        cost_map_due(&f->costs, rect, each * (double)rect_area(rect));
    }
}

void frame_costs_land(struct frame *f, uint32_t tile, double samples,
                      const struct counters *counters)
{
    const double us =
        (double)(counters->value[COUNTER_TRACE_CPU_US] + counters->value[COUNTER_PACK_CPU_US]);
    cost_map_land(&f->costs, tile_grid_rect(&f->grid, tile), samples, us);
}

/* Rounds decide as they go how many samples there will be. */
double frame_left_us(const struct frame *f)
{
    const double landed = cost_map_landed(&f->costs);
    if (!frame_has_rounds(f)) return cost_map_left_us(&f->costs);
    const double due = frame_rounds_expected(f) - (double)f->samples_landed;
    return due > 0.0 && landed > 0.0 ? due * cost_map_done_us(&f->costs) / landed : 0.0;
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
