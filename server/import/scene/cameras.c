#include "server/import/scene/cameras.h"

#include <math.h>
#include <string.h>

#include "proto/plan.h"

#define DEFAULT_YFOV_RAD      0.78539816339744831 /* 45 degrees */
#define DEFAULT_ELEVATION_RAD 0.13962634015955    /* 8 degrees */

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
    int rc = builder_view_bounds(b, lowest, highest, fault);
    if (rc == 0) rc = builder_append(b, SCENE_CAMERAS, 1, &at, fault);
    if (rc != 0) return rc;
    double centre[3], half[3];
    for (int i = 0; i < 3; i++) {
        centre[i] = ((double)lowest[i] + (double)highest[i]) / 2;
        half[i] = ((double)highest[i] - (double)lowest[i]) / 2;
    }
    double radius = sqrt(dot3(half, half));
    if (!(radius > 0)) radius = 1;
    double distance = radius / sin(DEFAULT_YFOV_RAD / 2);
    double s = sin(DEFAULT_ELEVATION_RAD), c = cos(DEFAULT_ELEVATION_RAD);
    const struct affine to_world = {{1, 0, 0, centre[0], 0, c, s, centre[1] + s * distance, 0, -s,
                                     c, centre[2] + c * distance}};
    struct scene_camera *camera = at;
    camera->type = CAMERA_PERSPECTIVE;
    camera->yfov_rad = (float)DEFAULT_YFOV_RAD;
    camera->is_default = 1;
    camera_set_frame(camera, &to_world);
    return 0;
}
