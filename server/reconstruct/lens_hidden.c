#include "server/reconstruct/lens_hidden.h"

#include <math.h>
#include <string.h>

#include "proto/error.h"
#include "server/reconstruct/surface.h"

#define RADIUS_PX  3.5f /* at 9 samples a pixel */
#define ROOM_FIRST 4096

/* The first sample's surface; sums of all samples' light; what they share, once somebody has asked.
 */
struct lens_hidden_cell {
    float point[3], normal[3], off;
    float light[3], shared[3];
    bool known;
};

int lens_hidden_create(struct scratch *scratch, size_t width, size_t height, uint32_t l,
                       struct lens_hidden *out)
{
    const size_t area = width * height;
    const float most = (float)LENS_HIDDEN_REACH_PX + 0.5f;
    const float radius = RADIUS_PX * sqrtf(3.0f / (float)l);
    *out = (struct lens_hidden){.scratch = scratch, .width = width, .height = height};
    out->radius = radius < most ? radius : most;
    out->memory = scratch_take(scratch, area * (sizeof *out->cell + sizeof *out->number));
    if (!out->memory) return ERR_MEMORY;
    out->cell = out->memory;
    out->number = (float *)(void *)(out->cell + area);
    memset(out->number, 0, area * sizeof *out->number);
    return 0;
}

void lens_hidden_fini(struct lens_hidden *h)
{
    scratch_give(h->scratch, h->list);
    scratch_give(h->scratch, h->memory);
}

static int make_room(struct lens_hidden *h)
{
    const size_t room = h->room > 0 ? 2 * h->room : ROOM_FIRST;
    if (h->count < h->room) return 0;
    struct lens_hidden_sample *list = scratch_take(h->scratch, room * sizeof *list);
    if (!list) return ERR_MEMORY;
    if (h->count > 0) memcpy(list, h->list, h->count * sizeof *list);
    scratch_give(h->scratch, h->list);
    h->list = list;
    h->room = room;
    return 0;
}

/* Is `point`, of that normal, on the cell's surface? off: from each other's planes, at most. */
static bool is_same(const struct lens_hidden_cell *cell, const float point[3],
                    const float normal[3], float off)
{
    float cosine = 0.0f, from = 0.0f, own = 0.0f;
    for (int c = 0; c < 3; c++) {
        cosine += normal[c] * cell->normal[c];
        from += (point[c] - cell->point[c]) * cell->normal[c];
        own += (point[c] - cell->point[c]) * normal[c];
    }
    return cosine >= SURFACE_COS_FULL && fabsf(from) <= off && fabsf(own) <= off;
}

int lens_hidden_add(struct lens_hidden *h, const struct lens_light_row *r, uint32_t i,
                    const float light[3], size_t at)
{
    const size_t column = (size_t)r->column[i] + (r->across[i] >= 0.5f ? 1 : 0);
    const size_t row = (size_t)r->row[i] + (r->down[i] >= 0.5f ? 1 : 0);
    const size_t where = row * h->width + column;
    const float point[3] = {r->point[0][i], r->point[1][i], r->point[2][i]};
    const float normal[3] = {r->normal[0][i], r->normal[1][i], r->normal[2][i]};
    struct lens_hidden_cell *cell = h->cell + where;
    const bool first = !(h->number[where] > 0.0f);
    if (!first && !is_same(cell, point, normal, r->off[i])) return 0;
    if (make_room(h)) return ERR_MEMORY;
    if (first) {
        *cell = (struct lens_hidden_cell){.off = r->off[i]};
        memcpy(cell->point, point, sizeof point);
        memcpy(cell->normal, normal, sizeof normal);
    }
    for (int c = 0; c < 3; c++) cell->light[c] += light[c];
    h->number[where] += 1.0f;
    h->list[h->count++] = (struct lens_hidden_sample){at, where};
    return 1;
}

static void share(const struct lens_hidden *h, size_t cell)
{
    struct lens_hidden_cell *own = h->cell + cell;
    const int32_t x = (int32_t)(cell % h->width), y = (int32_t)(cell / h->width);
    float sum[3] = {0}, all = 0.0f;
    for (int32_t v = y - LENS_HIDDEN_REACH_PX; v <= y + LENS_HIDDEN_REACH_PX; v++)
        for (int32_t u = x - LENS_HIDDEN_REACH_PX; u <= x + LENS_HIDDEN_REACH_PX; u++) {
            if (u < 0 || v < 0 || u >= (int32_t)h->width || v >= (int32_t)h->height) continue;
            const size_t q = (size_t)v * h->width + (size_t)u;
            const struct lens_hidden_cell *other = h->cell + q;
            const float square = (float)((u - x) * (u - x) + (v - y) * (v - y));
            const float weight = 1.0f - square / (h->radius * h->radius);
            if (!(h->number[q] > 0.0f) || !(weight > 0.0f)) continue;
            if (q != cell && !is_same(own, other->point, other->normal, own->off)) continue;
            for (int c = 0; c < 3; c++) sum[c] += weight * other->light[c];
            all += weight * h->number[q];
        }
    for (int c = 0; c < 3; c++) own->shared[c] = sum[c] / all; /* the cell itself has some */
    own->known = true;
}

void lens_hidden_share(const struct lens_hidden *h, size_t cell, float light[3])
{
    if (!h->cell[cell].known) share(h, cell);
    memcpy(light, h->cell[cell].shared, sizeof h->cell[cell].shared);
}
