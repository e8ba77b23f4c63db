#include "worker/trace/hit/geometry.h"

#include "proto/half.h"
#include "worker/trace/hit/hit_kernels.h"

static void init_sub(struct geometry_sub_planes *p, const struct samples *samples, uint32_t k)
{
    p->depth = samples_u16(samples, PLANE_SUB_DEPTH, k);
    p->normal = samples_u16(samples, PLANE_SUB_NORMAL, k);
    p->id = samples_u16(samples, PLANE_SUB_ID, k);
    for (uint32_t c = 0; c < 3; c++)
        p->albedo[c] = samples_u16(samples, PLANE_SUB_ALBEDO, 3 * k + c);
}

void geometry_planes_init(struct geometry_planes *p, const struct samples *samples)
{
    p->depth = samples_f32(samples, PLANE_DEPTH, 0);
    p->id = samples_u32(samples, PLANE_ID, 0);
    p->normal = samples_u32(samples, PLANE_NORMAL, 0);
    for (uint32_t k = 0; k < 3; k++) p->albedo[k] = samples_u16(samples, PLANE_ALBEDO, k);
    for (uint32_t k = 0; k < samples->layout.sub_samples; k++) init_sub(&p->sub[k], samples, k);
}

void geometry_store(const struct queries *q, const struct block *b, const struct surface *s,
                    const struct geometry_planes *planes)
{
    if (lanes_count(&s->hit) > 0) /* planes begin as zeros */
        q->kernels->store_geometry(b, s, planes);
}

void geometry_store_sub(const struct queries *q, const struct block *b, float length_unit,
                        const struct surface *centre, const struct surface *sub,
                        const struct geometry_sub_planes *planes)
{
    _Alignas(LANES_ALIGN) float relative[LANES];
    _Alignas(LANES_ALIGN) uint16_t halves[LANES];
    q->kernels->relate_depths(centre, sub, length_unit, relative);
    half_from_floats(relative, halves, LANES);
    q->kernels->store_sub(b, sub, halves, planes);
}
