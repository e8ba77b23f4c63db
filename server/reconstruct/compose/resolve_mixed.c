#include "server/reconstruct/compose/resolve_mixed.h"

#include <math.h>

/* Shares that are missing this little are rounding: what is covered has no alpha. */
#define COVERED 0.99999f

static void add_lender(const struct resolver *r, const struct mixed_entry *e, size_t q,
                       struct resolved *sum)
{
    const struct lighting *l = r->lighting;
    for (int c = 0; c < 3; c++) {
        const float shine = l->glossy[c] ? e->reflectance[c] * l->glossy[c][q] : 0.0f;
        const float sent = e->albedo[c] * l->total[c][q] + shine;
        sum->direct[c] += e->albedo[c] * l->direct[c][q];
        sum->indirect[c] += e->albedo[c] * l->indirect[c][q] + shine;
        sum->total[c] += sent;
        sum->albedo[c] += e->albedo[c];
        if (!r->errors) continue;
        if (e->share > 0.0f) sum->spread[c] += sent * sent / e->share;
        if (l->error[0]) sum->error[c] += e->albedo[c] * l->error[c][q];
        if (l->glossy_error[0]) sum->glossy_error[c] += e->reflectance[c] * l->glossy_error[c][q];
    }
    sum->coverage += e->share;
}

/* From the mean of squares to the mean's squared standard error, less the noise of what is lent.
 * Squared, points that are spread over a pixel err as the power -3/2 of their number. */
static void find_spread(const struct resolver *r, struct resolved *out)
{
    const float count = (float)mixed_samples(r->plan); /* at least 16 */
    for (int c = 0; c < 3; c++) {
        const float square = fmaxf(out->spread[c] - out->total[c] * out->total[c], 0.0f);
        const float noise =
            out->error[c] * out->error[c] + out->glossy_error[c] * out->glossy_error[c];
        out->spread[c] = fmaxf(square / ((count - 1.0f) * sqrtf(count)) - noise, 0.0f);
    }
}

void resolve_mixed(const struct resolver *r, size_t i, uint32_t first, struct resolved *out)
{
    const struct mixed_share *mixed = &r->patch->mixed;
    const int64_t width = rect_width(r->patch->rect);
    *out = (struct resolved){.mixed = 1};
    for (uint32_t e = first; e < mixed->count && mixed_share_pixel(mixed, e) == i; e++) {
        const int64_t slot = mixed->entries[e].place % MIXED_SLOTS;
        const int64_t q = (int64_t)i + (slot / 3 - 1) * width + slot % 3 - 1;
        add_lender(r, &mixed->entries[e], (size_t)q, out);
    }
    if (out->coverage > COVERED) out->coverage = 1.0f;
    if (r->errors) find_spread(r, out);
}
