/* The time left, on simulated schedules whose end is known: it is right within a third from the
 * tenth per cent of the time on. */
#include <math.h>
#include <stdlib.h>

#include "server/job/frame/cost_map.h"
#include "server/job/frame/tile_order.h"
#include "server/job/pace.h"
#include "tests/unit/unit.h"

#define TILES_MAX 1024

/* A picture whose tiles are traced in the order of the server by some threads. */
struct farm {
    struct tile_grid grid;
    double cost_us[TILES_MAX]; /* of each tile */
    unsigned threads, frames;
    double slow_from, slow_by; /* from this share of all work on tiles take so many times longer */
};

struct landing {
    double at_us;
    uint32_t tile;
};

static int by_time(const void *a, const void *b)
{
    const struct landing *p = a, *q = b;
    return (p->at_us > q->at_us) - (p->at_us < q->at_us);
}

/* Fills in when each tile of all frames lands. Returns the end. */
static double run(const struct farm *f, struct landing *landings)
{
    uint32_t order[TILES_MAX];
    const uint32_t count = tile_grid_count(&f->grid);
    double free_us[64] = {0}, end_us = 0.0;
    assert_int_equal(tile_order_by_rows(&f->grid, 128, order), 0);
    for (uint32_t i = 0; i < f->frames * count; i++) {
        unsigned next = 0;
        for (unsigned k = 1; k < f->threads; k++)
            if (free_us[k] < free_us[next]) next = k;
        const bool slow = i >= f->slow_from * f->frames * count;
        free_us[next] += f->cost_us[order[i % count]] * (slow ? f->slow_by : 1.0);
        landings[i] = (struct landing){free_us[next], order[i % count]};
        if (free_us[next] > end_us) end_us = free_us[next];
    }
    qsort(landings, f->frames * count, sizeof *landings, by_time);
    return end_us;
}

static void begin_frame(const struct farm *f, struct cost_map *m)
{
    cost_map_init(m, f->grid.width_px, f->grid.height_px);
    for (uint32_t i = 0; i < tile_grid_count(&f->grid); i++)
        cost_map_due(m, tile_grid_rect(&f->grid, i), 1.0);
}

struct judgement {
    double worst; /* error after a share of the time, as a share of what is truly left */
    unsigned told, right;
};

static struct judgement judge(const struct farm *f, double from)
{
    const uint32_t count = tile_grid_count(&f->grid), all = f->frames * count;
    struct landing *landings = calloc(all, sizeof *landings);
    const double end_us = run(f, landings);
    struct cost_map m;
    struct pace pace;
    double spent_us = 0.0, before_us = 0.0;
    struct judgement j = {0};
    begin_frame(f, &m);
    pace_start(&pace, 1, 0.0);
    for (uint32_t i = 0; i < all; i++) {
        if (i > 0 && i % count == 0) {
            begin_frame(f, &m);
            before_us = spent_us;
        }
        const double us = f->cost_us[landings[i].tile];
        cost_map_land(&m, tile_grid_rect(&f->grid, landings[i].tile), 1.0, us);
        spent_us += us;
        pace_note(&pace, 1 + (uint64_t)landings[i].at_us, spent_us);
        const uint32_t begun = i / count + 1;
        const double mean_us = begun > 1 ? before_us / (begun - 1) : 0.0;
        double left_us = pace_frame_left_us(cost_map_left_us(&m), spent_us - before_us,
                                            (i % count + 1.0) / count, mean_us);
        left_us += (f->frames - begun) * ((spent_us + left_us) / begun);
        const double truly_s = (end_us - landings[i].at_us) * 1e-6;
        const double error =
            fabs(pace_time_s(&pace, 1 + (uint64_t)landings[i].at_us, left_us) - truly_s) - 0.5;
        if (!(landings[i].at_us > from * end_us && truly_s > 0.0)) continue;
        j.worst = fmax(j.worst, error / truly_s);
        j.told++;
        j.right += error / truly_s <= 1.0 / 3.0;
    }
    free(landings);
    return j;
}

static double worst_error(const struct farm *f, double from)
{
    return judge(f, from).worst;
}

static struct farm make_farm(int32_t width, int32_t height, unsigned threads)
{
    struct farm f = {.threads = threads, .frames = 1, .slow_from = 1.0, .slow_by = 1.0};
    assert_int_equal(tile_grid_init(&f.grid, width, height, 64), 0);
    assert_true(tile_grid_count(&f.grid) <= TILES_MAX);
    for (uint32_t i = 0; i < tile_grid_count(&f.grid); i++) f.cost_us[i] = 1e5;
    return f;
}

TEST(even_work)
{
    struct farm f = make_farm(1024, 1024, 2);
    assert_true(worst_error(&f, 0.1) < 0.1);
}

TEST(sky_above_and_glass_below)
{
    struct farm f = make_farm(1024, 1024, 2);
    for (uint32_t i = 0; i < tile_grid_count(&f.grid); i++)
        if (tile_grid_rect(&f.grid, i).y0 >= 512) f.cost_us[i] *= 12.0;
    assert_true(worst_error(&f, 0.1) < 1.0 / 3.0);
    for (uint32_t i = 0; i < tile_grid_count(&f.grid); i++) /* and the other way round */
        f.cost_us[i] = tile_grid_rect(&f.grid, i).y0 >= 512 ? 1e5 : 12e5;
    assert_true(worst_error(&f, 0.1) < 1.0 / 3.0);
}

/* A thing before a backdrop that costs next to nothing, in few large tiles. */
TEST(a_product_in_few_tiles)
{
    static const int32_t sizes[][2] = {{384, 384}, {512, 320}, {448, 448}, {768, 512}};
    unsigned told = 0, right = 0;
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++)
        for (double radius = 0.2; radius < 0.45; radius += 0.05) {
            const double width = sizes[k][0], height = sizes[k][1];
            struct farm f = make_farm(sizes[k][0], sizes[k][1], 1);
            for (uint32_t i = 0; i < tile_grid_count(&f.grid); i++) {
                const struct rect r = tile_grid_rect(&f.grid, i);
                const double x = (r.x0 + r.x1) / 2.0 / width, y = (r.y0 + r.y1) / 2.0 / height;
                if (hypot(x - 0.5, y - 0.5) < radius) f.cost_us[i] *= 12.0;
            }
            const struct judgement j = judge(&f, 0.1);
            told += j.told;
            right += j.right;
        }
    if (right < 0.75 * told) fail_msg("%u of %u", right, told);
}

/* Reading a scene is no pace. */
TEST(a_slow_start_is_forgotten)
{
    struct pace pace;
    pace_start(&pace, 1, 0.0);
    for (uint64_t t = 1; t <= 8; t++) pace_note(&pace, 10000001 + t * 500000, (double)t * 500000.0);
    assert_true(fabs(pace_time_s(&pace, 14000001, 3e6) - 3.0) < 0.1);
    assert_true(fabs(pace_time_s(&pace, 15000001, 3e6) - 2.0) < 0.1); /* counts down */
    pace_rest(&pace, 19000001);
    assert_true(fabs(pace_time_s(&pace, 19000001, 3e6) - 3.0) < 0.1);
}

TEST(several_frames_of_uneven_scenes)
{
    struct farm f = make_farm(1024, 768, 4);
    f.frames = 6;
    for (uint32_t i = 0; i < tile_grid_count(&f.grid); i++)
        if (tile_grid_rect(&f.grid, i).y0 >= 400) f.cost_us[i] *= 8.0;
    assert_true(worst_error(&f, 0.1) < 1.0 / 3.0);
}

/* Half of the workers leave: soon after, the time left is right again. */
TEST(a_farm_that_slows_down)
{
    struct farm f = make_farm(2048, 1024, 2);
    f.slow_from = 0.3;
    f.slow_by = 2.0;
    assert_true(worst_error(&f, 0.6) < 1.0 / 3.0);
}

TEST(nothing_is_told_before_the_first_result)
{
    struct pace pace;
    struct cost_map m;
    pace_start(&pace, 1, 5e6);
    cost_map_init(&m, 64, 64);
    cost_map_due(&m, (struct rect){0, 0, 64, 64}, 9.0);
    assert_true(pace_time_s(&pace, 9, cost_map_left_us(&m)) < 0.0);
    pace_note(&pace, 400001, 5.2e6);
    assert_true(fabs(pace_time_s(&pace, 400001, 1e6) - 1.0) < 1e-6);
}
