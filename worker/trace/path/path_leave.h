#pragma once
/* Removes from the paths of a packet the light that light fields bring, at the surfaces *vertex
 * that the paths have met. */
#include "worker/trace/path/path.h"

/* Leaves out indirect light of the first surface's diffuse lobe: where paths have gone one segment
 * on, they end or lose what fields bring. */
void path_leave_diffuse(const struct path_context *context, struct path_packet *packet,
                        struct path_vertex *vertex, struct path_radiance *radiance);

/* Leaves out all that diffuse lobes of first surfaces send on. */
void path_leave_surface(const struct path_context *context, const struct path_packet *packet,
                        struct path_vertex *vertex, struct path_radiance *radiance);

/* Leaves out what diffuse lobes of first surfaces send on of the plan's lights directly. Marks
 * these surfaces, whose layers are set, and the paths. */
void path_leave_listed(const struct path_packet *packet, struct path_vertex *vertex,
                       struct path_radiance *radiance);

/* Returns whether fields bring the diffuse light of lane i's surface, which is there. Under a
 * normal map a pixel has many normals, of which a field of pixel centres knows only one. */
bool path_leaves_to_fields(const struct surface *surface, int i);

/* Blackens the surfaces whose light paths do not leave to fields. */
void path_hide_from_fields(struct surface *surface);

/* Plays roulette with paths that have little weight left then. The layers of the vertex are set. */
void path_thin_lobes(const struct path_context *context, struct path_packet *packet,
                     struct path_vertex *vertex);

/* Ends the paths in the lanes of *ended. */
void path_end_lanes(const struct lanes_mask *ended, struct path_vertex *vertex);
