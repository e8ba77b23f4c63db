/* What a preparation makes. */
#include <stdlib.h>

#include "server/image/exr_mattes.h"
#include "server/job/prepare/made_map.h"
#include "server/job/prepare/preparation.h"
#include "server/job/prepare/studio_light.h"
#include "server/reconstruct/motion/motion.h"

struct plan_source prepared_source(const struct prepared *prepared)
{
    const bool has_environment = prepared->job.environment.kind == ENVIRONMENT_MAP;
    return (struct plan_source){.studio = prepared->studio.version ? &prepared->studio : NULL,
                                .studio_blob = prepared->studio_blob,
                                .scene = &prepared->scene,
                                .scene_blob = prepared->plan.scene,
                                .map = has_environment ? prepared->map.header : NULL,
                                .map_warnings = prepared->map.warnings,
                                .map_blob = prepared->plan.environment.map,
                                .photograph = prepared->plan.photograph};
}

void prepared_destroy(struct prepared **prepared)
{
    if (*prepared) {
        scene_unmap(&(*prepared)->scene);
        environment_unmap(&(*prepared)->map);
        motion_drop(&(*prepared)->motion);
        plate_drop(&(*prepared)->plate);
        exr_mattes_drop(&(*prepared)->mattes);
        shared_base_unref(&(*prepared)->base);
        job_fini(&(*prepared)->job);
        free((*prepared)->parts);
    }
    free(*prepared);
    *prepared = NULL;
}

int prepared_find_light(struct prepared *prepared, const struct objects *objects,
                        const struct scene *scene, struct environment_header *estimate,
                        struct plan_source *source, struct fault *fault)
{
    int error = 0;
    if (scene->count[SCENE_SKY] > 0) {
        error = made_map_place(objects, SCENE_SKY_WIDTH_PX, SCENE_SKY_HEIGHT_PX, scene->sky,
                               estimate, &source->estimate_blob, fault);
        source->estimate = estimate;
    } else if (plan_may_want_studio(&prepared->job, scene)) {
        error = studio_light_place(objects, &prepared->studio, &prepared->studio_blob, fault);
        source->studio = &prepared->studio;
        source->studio_blob = prepared->studio_blob;
    }
    return error;
}
