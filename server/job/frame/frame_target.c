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
    t->seen = calloc(film_block_count(f->film), sizeof *t->seen);
    t->seen_px = calloc(film_block_count(f->film), sizeof *t->seen_px);
    if (!t->pixels || !t->errors || !t->seen || !t->seen_px) return ERR_MEMORY;
    return rounds_create(&f->plan, &t->rounds);
}

void frame_target_destroy(struct frame *f)
{
    struct frame_target *t = &f->target;
    rounds_destroy(&t->rounds);
    free(t->pixels);
    free(t->errors);
    free(t->seen);
    free(t->seen_px);
}

static float *plane_of(const struct frame *f, uint32_t k)
{
    return f->target.pixels + (size_t)k * (size_t)f->plan.width_px * (size_t)f->plan.height_px;
}

/* Foresees anew whenever a quarter more of the picture is seen. */
static void glance(struct frame *f, struct rect rect, const struct block_measure *measure)
{
    struct frame_target *t = &f->target;
    const size_t area = (size_t)rect_area(rect);
    if (rounds_report(t->rounds).rounds > 0 || t->seen_count == film_block_count(f->film)) return;
    struct rounds_error *seen = &t->seen[t->seen_count];
    for (size_t i = 0; i < area; i++) {
        for (uint32_t k = 0; k < ERROR_SOURCE_COUNT; k++)
            seen->variance[k] += (double)measure->variance[k][i];
        seen->luminance += (double)measure->luminance[i];
    }
    t->seen_px[t->seen_count++] = (uint32_t)area;
    if (t->seen_count < t->seen_next) return;
    t->seen_next = t->seen_count + t->seen_count / 4 + 1;
    rounds_glance(t->rounds, t->seen, t->seen_px, t->seen_count);
    frame_costs_foresee_anew(f);
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
    glance(f, rect, measure);
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

bool frame_target_decide(struct frame *f)
{
    for (uint32_t i = 0; i < tile_grid_count(&f->grid); i++) {
        const struct rect rect = tile_grid_rect(&f->grid, i);
        for (uint32_t k = 0; k < ERROR_SOURCE_COUNT; k++)
            f->target.errors[i].variance[k] = sum_over(f, k, rect);
        f->target.errors[i].luminance = sum_over(f, ERROR_SOURCE_COUNT, rect);
    }
    return rounds_decide(f->target.rounds, f->target.errors, f->rounds.more_passes);
}

void frame_target_count(struct frame *f)
{
    const struct rounds_report report = rounds_report(f->target.rounds);
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
