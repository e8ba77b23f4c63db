/* Names of objects beside their ids: as many as a manifest has need no warning. */
#include <stdlib.h>
#include <string.h>

#include "server/job/prepare/matte_manifest.h"
#include "tests/unit/unit.h"

/* Returns how many warnings a scene of so many objects has, half of them over and over. */
static uint32_t warned(uint32_t names, uint32_t instances)
{
    struct scene_instance *list = calloc(instances, sizeof *list);
    static struct scene_mesh mesh;
    struct scene scene = {.instances = list, .meshes = &mesh, .names = "\0one\0"};
    struct job job = {.layers = LAYER_CRYPTO_OBJECT};
    struct plan_report report = {0};
    struct exr_mattes *mattes = NULL;
    scene.count[SCENE_INSTANCES] = instances;
    scene.count[SCENE_MESHES] = 1;
    scene.count[SCENE_NAMES] = 5;
    for (uint32_t i = names - 1; i < instances; i++) list[i].name = 1;
    assert_int_equal(matte_manifest_make(&job, &scene, &report, &mattes), 0);
    const uint32_t count = report.warning_count;
    exr_mattes_drop(&mattes);
    free(list);
    return count;
}

TEST(as_many_names_as_there_is_room_for_need_no_warning)
{
    assert_int_equal(warned(3, 3), 0);
    assert_int_equal(warned(MATTE_MANIFEST_NAMES, MATTE_MANIFEST_NAMES), 0);
    assert_int_equal(warned(MATTE_MANIFEST_NAMES, MATTE_MANIFEST_NAMES + 9), 0);
    assert_int_equal(warned(MATTE_MANIFEST_NAMES + 1, MATTE_MANIFEST_NAMES + 1), 1);
}
