#include "server/reconstruct/residual/residual_pass.h"

#include "server/reconstruct/residual/residual_guide_kernels.h"
#include "server/reconstruct/residual/residual_probe.h"

#include <pthread.h>
#include <string.h>

/* Taps of each pass: points of rotated square lattices, of which no grid shows in the picture.
 * `slant` dx + dy is a multiple of `modulus`, and both lie within `reach`, or the way is no longer
 * than the root of `round`. */
static const struct lattice {
    enum residual_kind kind;
    int32_t reach_px, slant, modulus, round;
    int32_t patch_px[RESIDUAL_COMPONENTS];
    float k[RESIDUAL_COMPONENTS]; /* how many standard deviations of noise apart is far: indirect
                                     light has few edges, highlights have edges that no feature
                                     tells */
    bool smooth[RESIDUAL_COMPONENTS];
} lattices[RESIDUAL_PASSES] = {
    {RESIDUAL_CROSS, 2, 0, 1, 8, {3, 3, 3}, {0.7f, 1.1f, 0.7f}, {[RESIDUAL_DIRECT] = true}},
    {RESIDUAL_JOINT, 7, 2, 5, 50, {1, 1, 1}, {1.1f, 1.7f, 0.7f}, {false}},
    {RESIDUAL_MEAN, 13, 5, 13, 180, {3, 3, 1}, {1.0f, 1.6f, 0.7f}, {false}},
};

static struct residual_pass passes[RESIDUAL_PASSES];
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void make_pass(const struct lattice *l, struct residual_pass *pass)
{
    *pass = (struct residual_pass){
        .kind = l->kind, .probes = l->kind == RESIDUAL_MEAN ? RESIDUAL_PROBES : RESIDUAL_SIGNED};
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++) {
        pass->sharpness[c] = 1.0f / (l->k[c] * l->k[c]);
        pass->patch_px[c] = l->patch_px[c];
        pass->smooth[c] = l->smooth[c];
    }
    for (int32_t y = -l->reach_px; y <= l->reach_px; y++)
        for (int32_t x = -l->reach_px; x <= l->reach_px; x++)
            if ((x != 0 || y != 0) && (l->slant * x + y) % l->modulus == 0 &&
                x * x + y * y <= l->round)
                pass->taps[pass->tap_count++] = (struct residual_tap){x, y};
}

static void make_passes(void)
{
    for (int k = 0; k < RESIDUAL_PASSES; k++) make_pass(&lattices[k], &passes[k]);
}

static const struct residual_pass *pass_of(int number)
{
    pthread_once(&once, make_passes);
    return &passes[number];
}

/* Taps, their patches, and the pixels that variances and smooth guides are found of. */
int32_t residual_reach_px(int number)
{
    const struct lattice *l = &lattices[number];
    int32_t most = 0;
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++) {
        const int32_t px = l->patch_px[c] + l->smooth[c];
        most = px > most ? px : most;
    }
    return l->reach_px + most + 1;
}

struct job {
    const struct residual_pass *pass;
    const struct residual_kernels *kernels;
    struct residual_field *field;
    struct residual_tile *tile;
    int32_t reach_px;
};

static bool row_is_dark(const float *row, int32_t count)
{
    float any = 0.0f;
    for (int32_t x = 0; x < count; x++) any = row[x] != 0.0f ? 1.0f : any;
    return any == 0.0f;
}

/* Returns whether the component brings nothing to any pixel that the tile reads. */
static bool is_dark(const struct job *j, const struct residual_light *light, struct rect r)
{
    const struct residual_shape *s = &j->field->features.shape;
    const int32_t reach = j->reach_px;
    for (int h = 0; h < (j->pass->kind == RESIDUAL_MEAN ? 1 : 2); h++)
        for (size_t c = 0; c < 3; c++)
            for (int32_t y = r.y0 - reach; y < r.y1 + reach; y++)
                if (!row_is_dark(light->half[h] + c * s->plane + residual_at(s, r.x0 - reach, y),
                                 rect_width(r) + 2 * reach))
                    return false;
    return true;
}

static bool has_probes(const struct job *j)
{
    return j->field->light[0].probe[0] != NULL;
}

/* All taps of the components in `lit` over a tile. */
static void filter_tile(const struct job *j, const bool lit[RESIDUAL_COMPONENTS])
{
    const struct residual_pass *pass = j->pass;
    const int halves = pass->kind == RESIDUAL_CROSS ? 2 : 1;
    memset(j->tile->sums, 0, sizeof j->tile->sums);
    if (has_probes(j)) memset(j->tile->probes, 0, sizeof j->tile->probes);
    for (uint32_t first = 0; first < pass->tap_count; first += RESIDUAL_TAPS_CHUNK) {
        const uint32_t left = pass->tap_count - first;
        const uint32_t count = left < RESIDUAL_TAPS_CHUNK ? left : RESIDUAL_TAPS_CHUNK;
        j->kernels->compare_features(&j->field->features, pass->taps + first, count, j->tile);
        for (int c = 0; c < RESIDUAL_COMPONENTS; c++)
            for (int h = 0; h < halves && lit[c]; h++)
                j->kernels->add_taps(pass, j->field, c, first, count, h, j->tile);
    }
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++)
        for (int h = 0; h < (pass->kind == RESIDUAL_MEAN ? 1 : 2) && lit[c]; h++)
            j->kernels->finish(j->field, c, h, halves == 2 ? h : 0, j->tile);
    for (int c = 0; c < RESIDUAL_COMPONENTS && has_probes(j); c++)
        for (int h = 0; h < halves && lit[c]; h++)
            j->kernels->finish_probes(j->field, c, h, j->tile);
}

static void clear_planes(const struct residual_shape *s, const struct residual_tile *tile,
                         float *planes, size_t count)
{
    for (size_t k = 0; k < count; k++)
        for (size_t y = 0; y < tile->height; y++)
            memset(planes + k * s->plane + tile->base + y * s->stride, 0,
                   tile->width * sizeof(float));
}

static void clear_tile(const struct residual_shape *s, const struct residual_tile *tile,
                       const struct residual_light *light)
{
    for (int h = 0; h < 2; h++) {
        clear_planes(s, tile, light->filtered[h], 3);
        if (light->probe[h]) clear_planes(s, tile, light->probed[h], RESIDUAL_PROBES);
    }
}

/* The part of a tile that shows surfaces, in whole vectors. Nothing lights the rest. */
static struct rect find_shown(const struct residual_features *f, struct rect r)
{
    struct rect shown = {r.x1, r.y1, r.x0, r.y0};
    for (int32_t y = r.y0; y < r.y1; y++)
        for (int32_t x = r.x0; x < r.x1; x += 16) {
            const float *barred = f->barred + residual_at(&f->shape, x, y);
            float least = barred[0];
            for (int i = 1; i < 16; i++) least = barred[i] < least ? barred[i] : least;
            if (least > 0.0f) continue;
            if (x < shown.x0) shown.x0 = x;
            if (x + 16 > shown.x1) shown.x1 = x + 16;
            if (y < shown.y0) shown.y0 = y;
            shown.y1 = y + 1;
        }
    return shown;
}

static void place_tile(const struct job *j, struct rect r)
{
    j->tile->base = residual_at(&j->field->features.shape, r.x0, r.y0);
    j->tile->width = (size_t)rect_width(r), j->tile->height = (size_t)rect_height(r);
}

static void run_tile(const struct job *j, struct rect r, struct residual_statistics *statistics)
{
    const struct rect shown = find_shown(&j->field->features, r);
    bool lit[RESIDUAL_COMPONENTS], any = false;
    place_tile(j, r);
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++) {
        const struct residual_light *light = &j->field->light[c];
        lit[c] = !rect_is_empty(shown) && !is_dark(j, light, shown);
        any |= lit[c];
        statistics->tiles_skipped += !lit[c];
        if (!lit[c] || rect_area(shown) < rect_area(r))
            clear_tile(&j->field->features.shape, j->tile, light);
    }
    if (!any) return;
    place_tile(j, shown);
    filter_tile(j, lit);
}

/* Tiles begin with the area and are as large as it needs: what pixels become does not depend on
 * where they lie in a tile. */
static void run_tiles(const struct job *j, struct rect area, struct residual_statistics *statistics)
{
    for (int32_t y = area.y0; y < area.y1; y += RESIDUAL_TILE_Y)
        for (int32_t x = area.x0; x < area.x1; x += RESIDUAL_TILE_X) {
            const int32_t right = area.x1 - x, below = area.y1 - y;
            const int32_t width =
                right < RESIDUAL_TILE_X ? (right + 15) / 16 * 16 : RESIDUAL_TILE_X;
            const int32_t height = below < RESIDUAL_TILE_Y ? below : RESIDUAL_TILE_Y;
            run_tile(j, (struct rect){x, y, x + width, y + height}, statistics);
        }
}

static void take_filtered(struct residual_field *field, enum residual_kind kind)
{
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++)
        for (int h = 0; h < (kind == RESIDUAL_MEAN ? 1 : 2); h++) {
            struct residual_light *l = &field->light[c];
            float *before = l->half[h];
            l->half[h] = l->filtered[h];
            l->filtered[h] = before;
            residual_pad(&field->features.shape, l->half[h], 3);
        }
}

/* What both halves have in the mean's error is one after the first pass. */
static void take_probes(struct residual_field *field, enum residual_kind kind)
{
    const size_t count = RESIDUAL_PROBES * field->features.shape.plane;
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++) {
        struct residual_light *l = &field->light[c];
        float *before = l->probe[0];
        if (!before) continue;
        l->probe[0] = l->probed[0];
        l->probed[0] = before;
        for (size_t i = 0; i < count && kind == RESIDUAL_CROSS; i++)
            l->probe[0][i] += l->probed[1][i];
    }
}

int residual_pass_run(int number, struct rect area, struct residual_field *field,
                      struct residual_statistics *statistics)
{
    struct job job = {.pass = pass_of(number),
                      .kernels = KERNELS_BEST(residual_kernels),
                      .field = field,
                      .reach_px = residual_reach_px(number)};
    job.tile = scratch_take(field->scratch, sizeof *job.tile);
    if (!job.tile) return ERR_MEMORY;
    if (job.pass->kind == RESIDUAL_MEAN && has_probes(&job)) residual_probes_take_halves(field);
    for (int c = 0; c < RESIDUAL_COMPONENTS; c++)
        KERNELS_BEST(residual_guide_kernels)
            ->find(job.pass, field, c, rect_grow(area, job.reach_px - 1 - job.pass->smooth[c]));
    run_tiles(&job, area, statistics);
    take_filtered(field, job.pass->kind);
    take_probes(field, job.pass->kind);
    scratch_give(field->scratch, job.tile);
    return 0;
}
