#include "server/import/scene/cameras.h"

#include "proto/plan.h"
#include "proto/scene/camera_fit.h"

bool camera_set_frame(struct scene_camera *camera, const struct affine *to_world)
{
    double back[3], up[3], right[3];
    affine_direction(to_world, (double[3]){0, 0, 1}, back);
    affine_direction(to_world, (double[3]){0, 1, 0}, up);
    if (!normalize3(back)) return false;
    cross3(up, back, right);
    if (!normalize3(right)) return false;
    cross3(back, right, up);
    for (int i = 0; i < 3; i++) {
        camera->eye[i] = (float)to_world->m[4 * i + 3];
        camera->right[i] = (float)right[i];
        camera->up[i] = (float)up[i];
        camera->forward[i] = (float)-back[i];
    }
    return true;
}

int camera_append_default(struct builder *b, struct fault *fault)
{
    float lowest[3], highest[3];
    void *at;
    int rc = builder_bounds(b, lowest, highest, fault);
    if (rc == 0) rc = builder_append(b, SCENE_CAMERAS, 1, &at, fault);
    if (rc != 0) return rc;
    struct scene_camera *camera = at;
    camera->type = CAMERA_PERSPECTIVE;
    camera_fit(lowest, highest, 1, camera);
    return 0;
}
