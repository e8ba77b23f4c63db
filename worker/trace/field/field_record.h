#pragma once
/* What one sample of a light field of pixel centres did: a stratum of a light, a bounce ray, a ray
 * of a glossy lobe. The fields' own code calls these steps where somebody asks (path_record.h): the
 * tile is then a single pixel, and only the sample that the record names is recorded, whose path
 * the path tracer's steps tell of. */
#include "worker/trace/field/glossy.h"
#include "worker/trace/field/indirect.h"
#include "worker/trace/field/shadow.h"
#include "worker/trace/path/path_record.h"

/* What the camera sees through the pixel's centre; the block has one kept lane. */
PATH_RECORD_COLD void field_record_centre(struct path_record *record, const struct block *b,
                                          const struct RTCRayHit16 *camera,
                                          const struct path_vertex *v);

/* All strata of the light are skipped in the block, for the reasons in *packet. */
PATH_RECORD_COLD void field_record_hidden(struct path_record *record,
                                          const struct light_packet *packet);

/* Strata first .. first + count - 1 have come back; `slopes`: by closest hits. */
PATH_RECORD_COLD void field_record_strata(const struct shading_point *p, struct queries *q,
                                          const struct light *light, bool slopes,
                                          const struct shadow_scratch *scratch, uint32_t first,
                                          uint32_t count);

/* A bounce ray is aimed, or lies below the facet. */
PATH_RECORD_COLD void field_record_bounce(const struct path_context *c, const struct block *b,
                                          const struct path_vertex *from, const struct strata *s,
                                          const struct lanes_mask *valid,
                                          const struct lanes3 *direction);

/* A lobe's ray has its random numbers; */
PATH_RECORD_COLD void field_record_draw(struct path_record *record, const float u[2]);

/* and a direction in the shading frame, with its weights over the reflectance. */
PATH_RECORD_COLD void field_record_lobe(struct path_record *record, const struct path_vertex *v,
                                        const float wi[3], const float weight[3], float whole);

/* The ray's path has ended; before what is not finite is taken out. */
PATH_RECORD_COLD void field_record_radiance(struct path_record *record,
                                            const struct path_harvest *h);

/* And after: what the sums hold, which are of this sample alone. `half`: of which half it is, 0 or
 * 1; whether it is of the pixel's. */
PATH_RECORD_COLD void field_record_bounced(struct path_record *record,
                                           const struct indirect_sums *sums, uint32_t half);
PATH_RECORD_COLD void field_record_shone(struct path_record *record,
                                         const struct glossy_scratch *scratch, bool half);
