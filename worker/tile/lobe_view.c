#include "worker/tile/lobe_view.h"

#include <math.h>

/* Boxes are larger by this share of their numbers, and rectangles by so many pixels on each side:
 * more than rounding takes. */
#define SHARE     1e-5f
#define MARGIN_PX 2

/* Nearer points are seen anywhere. */
#define NEAREST 1e-6f

/* Corners of a box as the camera sees them. */
struct seen_box {
    float low[2], high[2]; /* pixels */
    float near, far;       /* along forward */
};

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Adds a corner by the inverse of plan_camera_ray. */
static void add_corner(const struct plan *plan, const float corner[3], struct seen_box *out)
{
    const struct plan_camera *c = &plan->camera;
    const float size[2] = {(float)plan->width_px, (float)plan->height_px};
    const float half[2] = {c->half_width, c->half_height};
    float off[3], across[2];
    for (int k = 0; k < 3; k++) off[k] = corner[k] - c->eye[k];
    const float ahead = dot(off, c->forward);
    const float scale =
        c->type == CAMERA_ORTHOGRAPHIC ? 1.0f : 1.0f / (ahead > NEAREST ? ahead : NEAREST);
    across[0] = dot(off, c->right) * scale / half[0] + c->centre_x;
    across[1] = -dot(off, c->up) * scale / half[1] - c->centre_y;
    for (int k = 0; k < 2; k++) {
        const float px = 0.5f * (across[k] + 1.0f) * size[k];
        out->low[k] = fminf(out->low[k], px);
        out->high[k] = fmaxf(out->high[k], px);
    }
    out->near = fminf(out->near, ahead);
    out->far = fmaxf(out->far, ahead);
}

static void see(const struct plan *plan, const struct lobe_box *box, struct seen_box *out)
{
    *out = (struct seen_box){{INFINITY, INFINITY}, {-INFINITY, -INFINITY}, INFINITY, -INFINITY};
    for (int corner = 0; corner < 8; corner++) {
        float p[3];
        for (int k = 0; k < 3; k++) {
            const float low = box->low[k], high = box->high[k];
            const float grown = SHARE * (fabsf(low) + fabsf(high));
            p[k] = corner >> k & 1 ? high + grown : low - grown;
        }
        add_corner(plan, p, out);
    }
}

/* Pixels from a to b, where these are in the tile: no float is too large for it. */
static void clamp_range(float a, float b, int32_t *from, int32_t *to)
{
    const float first = floorf(a) - (float)MARGIN_PX, end = ceilf(b) + (float)MARGIN_PX;
    if (first > (float)*from) *from = first < (float)*to ? (int32_t)first : *to;
    if (end < (float)*to) *to = end > (float)*from ? (int32_t)end : *from;
}

/* Returns the pixels of the tile that may show the box. */
static struct rect cover(const struct plan *plan, const struct lobe_box *box, struct rect tile)
{
    const bool flat = plan->camera.type == CAMERA_ORTHOGRAPHIC;
    struct seen_box seen;
    see(plan, box, &seen);
    if (seen.far < 0.0f) return (struct rect){0, 0, 0, 0};
    if (flat || seen.near > NEAREST) {
        clamp_range(seen.low[0], seen.high[0], &tile.x0, &tile.x1);
        clamp_range(seen.low[1], seen.high[1], &tile.y0, &tile.y1);
    }
    return tile;
}

void lobe_view_init(const struct lobe_boxes *boxes, const struct plan *plan, struct rect tile,
                    struct lobe_view *out)
{
    out->count = 0;
    for (uint32_t k = 0; k < boxes->count; k++) {
        const struct rect r = cover(plan, &boxes->box[k], tile);
        if (!rect_is_empty(r)) out->rect[out->count++] = r;
    }
}

bool lobe_view_meets(const struct lobe_view *view, struct rect pixels)
{
    for (uint32_t k = 0; k < view->count; k++)
        if (!rect_is_empty(rect_intersect(view->rect[k], pixels))) return true;
    return false;
}
