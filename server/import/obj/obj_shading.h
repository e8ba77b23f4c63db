#pragma once
/* How MTL materials scatter, by their illumination model (Wavefront's Object Files, appendix B1 of
 * the Advanced Visualizer manual):
 *
 *   0, 1        Lambert with Kd
 *   2           Kd and a normalised Blinn-Phong lobe of Ks and Ns
 *   3, 5, 8     a mirror of Ks; over a Kd of more than a trace a smooth coat with Schlick's
 *               Fresnel; Kd and a Blinn-Phong lobe where Ns is small
 *   4, 6, 7, 9  glass: a closed solid of index Ni that lets Tf through
 *
 * Pm or Pr (Exocortex' extension) make it glTF's metallic-roughness. d or Tr below 1 blends what is
 * no glass. */
#include "proto/scene/scene.h"
#include "server/import/obj/mtl.h"
#include "server/import/scene/warnings.h"

/* Reads the model into *m, a Lambert surface so far, whose colours and textures have been read.
 * Warns of what is ignored or changed. Numbers out of range are clamped. */
void obj_shading_read(const struct mtl_material *from, const char *place, struct scene_material *m,
                      struct warnings *warnings);
