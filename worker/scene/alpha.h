#pragma once
/* Holes of masked surfaces: an Embree filter that drops hits where alpha is below the cutoff. Set
 * only on geometries whose material can be transparent at all. */
#include "worker/scene/render_scene.h"

struct RTCFilterFunctionNArguments;

/* For rtcSetGeometryIntersectFilterFunction and its occluded twin; the geometry's user data is its
 * struct mesh_view. */
void alpha_filter(const struct RTCFilterFunctionNArguments *args);

/* Whether the surface is there at barycentric (u, v) of a triangle. */
bool alpha_covers(const struct mesh_view *mesh, uint32_t triangle, float u, float v);
