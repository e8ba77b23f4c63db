#pragma once
/* The planes that describe surfaces: depth, normal, albedo, id, of pixel centres and of
 * anti-aliasing rays. */
#include "proto/samples.h"
#include "worker/trace/block.h"
#include "worker/trace/hit.h"

void geometry_store(const struct queries *q, const struct block *b, const struct surface *s,
                    struct samples *samples);

/* Anti-aliasing ray k; `centre` is the pixel's own surface, which its depth is relative to. */
void geometry_store_sub(const struct queries *q, const struct plan *plan, const struct block *b,
                        const struct surface *centre, const struct surface *sub, uint32_t k,
                        struct samples *samples);
