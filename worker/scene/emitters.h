#pragma once
/* Samples points on meshes that shine and that no light of the plan stands for. A leaf
 * of a tree (emitter_tree.h) is chosen first, then a triangle in proportion to its area times its
 * emitted luminance, with an alias table.
 *
 * The tables are built once per scene and shared read-only. Meshes with MESH_IS_LIGHT (recognised
 * rectangles) and unlit materials are not among them. Emission by texture counts with the
 * texture's mean, so that the density is one number an instance. */
#include <stdbool.h>
#include <stdint.h>

#include "proto/error.h"
#include "worker/scene/emitter_tree.h"

struct render_scene;
struct emitters;

/* Creates the emitters of a scene, which has its meshes and materials and must outlive the result.
 * *out is NULL if nothing shines. ERR_MEMORY; ERR_LIMIT beyond LIMIT_TRIANGLES placed triangles
 * that shine. */
int emitters_create(const struct render_scene *scene, struct emitters **out);
void emitters_destroy(struct emitters **emitters);

struct emitter_point {
    float position[3];
    float normal[3];   /* geometric, unit, world; the side that the winding faces */
    float radiance[3]; /* that leaves the emitting side; of a blended surface times its opacity */
    float offset; /* scene units: a ray that ends this far in front of it misses it (offset.h) */
    bool double_sided; /* shines on both sides */
    uint32_t instance;
    float pdf_area; /* density per area of the surface within the leaf, > 0 */
};

/* Returns the tree; NULL without emitters (NULL). */
const struct emitter_tree *emitters_tree(const struct emitters *e);

/* Chooses a triangle of a leaf by a uniform number in [0, 1), and prefetches it. u, the place on
 * it, refines the choice by its last digits (alias_refine). */
uint32_t emitters_choose(const struct emitters *e, uint32_t leaf, float choice, const float u[2]);

/* Samples a point of a chosen triangle of a leaf by u. */
void emitters_sample(const struct emitters *e, uint32_t leaf, uint32_t chosen, const float u[2],
                     struct emitter_point *out);

/* Finds the smallest leaf of a triangle. Returns false for an instance that is no emitter, and
 * without emitters (NULL). */
bool emitters_find(const struct emitters *e, uint32_t instance, uint32_t triangle, uint32_t *leaf);

/* Returns pdf_area of any point of an emitting instance's triangles in a leaf. */
float emitters_density(const struct emitters *e, uint32_t instance, uint32_t leaf);
