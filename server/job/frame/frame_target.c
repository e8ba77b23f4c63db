/* Which tiles of a frame with a target get how many more samples, and what is told of it. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/job/frame/frame_work.h"

int frame_target_create(struct frame *f)
{
    struct frame_target *t = &f->target;
    const size_t area = (size_t)f->plan.width_px * (size_t)f->plan.height_px;
    t->pixels = calloc(area * (ERROR_SOURCE_COUNT + 1), sizeof *t->pixels);
    t->errors = calloc(tile_grid_count(&f->grid), sizeof *t->errors);
    t->squares = calloc(tile_grid_count(&f->grid), sizeof *t->squares);
    t->order = calloc(tile_grid_count(&f->grid), sizeof *t->order);
    if (!t->pixels || !t->errors || !t->squares || !t->order) return ERR_MEMORY;
    return rounds_create(&f->plan, &t->rounds);
}

void frame_target_destroy(struct frame *f)
{
    struct frame_target *t = &f->target;
    rounds_destroy(&t->rounds);
    free(t->pixels);
    free(t->errors);
    free(t->squares);
    free(t->order);
}

static float *plane_of(const struct frame *f, uint32_t k)
{
    return f->target.pixels + (size_t)k * (size_t)f->plan.width_px * (size_t)f->plan.height_px;
}

void frame_target_keep(struct frame *f, struct rect rect, const struct block_measure *measure)
{
    const size_t width = (size_t)rect_width(rect), stride = (size_t)f->plan.width_px;
    for (uint32_t k = 0; k <= ERROR_SOURCE_COUNT; k++) {
        const float *from = k < ERROR_SOURCE_COUNT ? measure->variance[k] : measure->luminance;
        float *to = plane_of(f, k) + (size_t)rect.y0 * stride + (size_t)rect.x0;
        for (int32_t y = rect.y0; y < rect.y1; y++, from += width, to += stride)
            memcpy(to, from, width * sizeof *from);
    }
}

/* Pixel by pixel and row by row, whatever the blocks were. */
static double sum_over(const struct frame *f, uint32_t k, struct rect rect)
{
    double sum = 0.0;
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const float *row = plane_of(f, k) + (size_t)y * (size_t)f->plan.width_px;
        for (int32_t x = rect.x0; x < rect.x1; x++) sum += (double)row[x];
    }
    return sum;
}

static struct rounds_error error_of(const struct frame *f, struct rect rect)
{
    struct rounds_error error;
    for (uint32_t k = 0; k < ERROR_SOURCE_COUNT; k++) error.variance[k] = sum_over(f, k, rect);
    error.luminance = sum_over(f, ERROR_SOURCE_COUNT, rect);
    return error;
}

bool frame_target_decide(struct frame *f, int *error)
{
    struct frame_target *t = &f->target;
    for (uint32_t i = 0; i < tile_grid_count(&f->grid); i++) {
        t->errors[i] = error_of(f, tile_grid_rect(&f->grid, i));
        t->squares[i] = 0.0;
        for (uint32_t k = 0; k < ERROR_SOURCE_COUNT; k++) t->squares[i] += t->errors[i].variance[k];
    }
    *error =
        tile_order_by_errors(&f->grid, f->block_px, block_halo_px(&f->plan), t->squares, t->order);
    return rounds_decide(t->rounds, t->errors, f->rounds.more_passes);
}

void frame_target_see(struct frame *f, struct rect rect)
{
    struct frame_target *t = &f->target;
    const int32_t side = f->grid.side_px;
    for (int32_t row = rect.y0 / side; row * side < rect.y1; row++)
        for (int32_t column = rect.x0 / side; column * side < rect.x1; column++) {
            const uint32_t tile = (uint32_t)(row * f->grid.columns + column);
            const struct rect part = rect_intersect(tile_grid_rect(&f->grid, tile), rect);
            const struct rounds_error error = error_of(f, part);
            rounds_see(t->rounds, tile, &error, (uint32_t)rect_area(part));
        }
    if (++t->seen < t->seen_next) return;
    t->seen_next = t->seen + t->seen / 4 + 1;
    rounds_foresee(t->rounds);
    frame_costs_foresee_anew(f);
}

void frame_target_glanced(struct frame *f, uint32_t tile, const struct rounds_error *error)
{
    rounds_glance(f->target.rounds, tile, error);
    rounds_foresee(f->target.rounds);
    frame_costs_foresee_anew(f);
}

void frame_target_count(struct frame *f)
{
    const struct rounds_report report = rounds_report(f->target.rounds);
    f->target.seen = f->target.seen_next = f->target.glances = 0;
    f->statistics.target_rounds = report.rounds;
    f->statistics.target_paths = report.paths;
    f->statistics.target_bounces = report.bounces;
    frame_costs_foresee(f);
}

static uint64_t millionths(double v)
{
    return v < 1e9 ? (uint64_t)(1e6 * v + 0.5) : UINT64_C(1000000000000000);
}

static void warn(struct frame *f, const struct rounds_report *report)
{
    const double target = (double)f->plan.target_error;
    if (report->met) return;
    if (report->fixed > target &&
        2.0 * report->fixed * report->fixed > report->reached * report->reached)
        snprintf(
            f->target.warning, sizeof f->target.warning,
            "frame %d: sampling ended at an estimated error of %.3g, above the target of %.3g: "
            "%.3g of it lies in edges within pixels, which more samples do not change",
            f->options.number, report->reached, target, report->fixed);
    else
        snprintf(
            f->target.warning, sizeof f->target.warning,
            "frame %d: sampling ended at an estimated error of %.3g, above the target of %.3g: "
            "%s",
            f->options.number, report->reached, target,
            "pixels have the most samples that sampling.max_spp and the passes of a frame allow");
}

void frame_target_end(struct frame *f)
{
    const struct rounds_report report = rounds_report(f->target.rounds);
    f->statistics.target_error = millionths(report.reached);
    f->statistics.target_threshold = millionths(report.threshold);
    warn(f, &report);
}
