#pragma once
/* What bodies wear: textures drawn from a seed, and normals that are not those of facets. Mirrors
 * swap the sides of a quad, and with them u and v: textures are the same either way. */
#include "tests/property/case.h"
#include "tests/unit/worker/scene_fixture.h"

/* Sets what the dress changes of the body's material, whose other fields are as they stay; `gain`
 * is of what glows, 0: nothing does. */
void dress_material(struct scene_fixture *f, uint32_t material, const struct case_body *b,
                    double gain);

/* Normals and tangents of the newest quad, whose half sides are u and v; the mesh has both, where
 * dress_has_normals. */
void dress_quad(struct scene_fixture *f, const struct case_body *b, const float u[3],
                const float v[3]);
bool dress_has_normals(const struct case_body *b);
