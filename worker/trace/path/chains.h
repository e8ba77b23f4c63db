#pragma once
/* Chains of mirrors and clear glass before the surface that a camera path sees in them. To filters
 * this is the path's surface: features and albedo are those of this surface, seen in the colours of
 * the chain, and light is divided into diffuse and other there.
 *
 * A surface is part of a chain if all its lobes are Dirac ones. Which of them a path takes is
 * chance, as a sample's place in its pixel is. */
#include "worker/trace/path/path.h"

/* Returns whether lane i's surface ends a chain, or continues it. */
static inline bool chains_has(const struct path_context *c, const struct path_packet *p,
                              const struct path_vertex *v, const struct path_radiance *h,
                              uint32_t i)
{
    return c->chains && p->part[i] == PATH_PART_NONE && v->depth > 0 &&
           h->chain[p->slot[i]] == v->depth;
}

/* Returns whether lane i's surface, which has scattered, belongs to a chain that goes on. Filters
 * may ask for features or not: it does not depend on that, since paths live by it. */
static inline bool chains_go_on(const struct path_packet *p, const struct path_vertex *v,
                                const struct path_radiance *h, uint32_t i)
{
    return p->part[i] == PATH_PART_NONE && h->chain[p->slot[i]] == v->depth + 1;
}

/* Notes features of surfaces after chains in place of those before. */
void chains_note(const struct path_context *c, const struct path_packet *p,
                 const struct path_vertex *v, struct path_radiance *h);

/* Adds the diffuse part of light samples, albedo taken out, of the lanes in *lit. */
void chains_gather(const struct path_context *c, const struct path_packet *p,
                   const struct path_vertex *v, const struct lanes_mask *lit,
                   const struct lanes3 *diffuse, struct path_radiance *h);

/* Keeps the diffuse shares of what comes after a chain's last surface, and continues chains that
 * have not ended. */
void chains_scatter(const struct path_context *c, const struct path_packet *p,
                    const struct path_vertex *v, const struct path_scattering *s,
                    struct path_radiance *h);
