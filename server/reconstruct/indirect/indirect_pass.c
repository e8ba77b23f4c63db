#include "server/reconstruct/indirect/indirect_pass.h"

struct rect indirect_pass_tall(const struct indirect_neighbourhood *around, struct rect rect,
                               int32_t reach)
{
    rect.y0 -= reach;
    rect.y1 += reach;
    return rect_intersect(rect, around->rect);
}

static void run_rows(const struct indirect_pass *pass, const struct indirect_neighbourhood *around,
                     struct rect rect, bool along_x, const float *const *in, float *const *out)
{
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const struct indirect_run run =
            indirect_neighbourhood_run(around, rect, y, along_x, pass->reach);
        if (pass->lines)
            pass->kernels->line(&around->field, &run, pass->count, in, out);
        else
            pass->kernels->mean(&around->field, &run, pass->count, in, out);
    }
}

void indirect_pass_run(const struct indirect_pass *pass,
                       const struct indirect_neighbourhood *around, struct rect rect,
                       const float *const *in, float *const *between, float *const *out)
{
    run_rows(pass, around, indirect_pass_tall(around, rect, pass->reach), true, in, between);
    run_rows(pass, around, rect, false, (const float *const *)between, out);
}
