#include "server/reconstruct/lens/lens_shape.h"

#include <math.h>

#define LINES    256   /* that quarters' areas are summed over */
#define EDGE_MIN 0.05f /* edges are 0.19 long at least; parts of one may be shorter */

/* Adds an edge from a to b. The inside lies to its right in the image, whose rows go downwards. */
static void add_edge(struct lens_shape *s, float ax, float ay, float bx, float by)
{
    const float dx = bx - ax, dy = by - ay, length = sqrtf(dx * dx + dy * dy);
    if (length < EDGE_MIN || s->edges == 2 * LIMIT_LENS_BLADES) return;
    float *n = s->normal[s->edges++];
    n[0] = dy / length;
    n[1] = -dx / length;
    const float distance = n[0] * ax + n[1] * ay;
    s->inradius = s->edges == 1 ? distance : fmaxf(s->inradius, distance);
}

static void add_edges(struct lens_shape *s, const struct lens_aperture *a)
{
    const uint32_t last = a->bands;
    add_edge(s, a->left[0], a->height[0], a->right[0], a->height[0]);
    for (uint32_t i = 0; i < last; i++) {
        add_edge(s, a->right[i], a->height[i], a->right[i + 1], a->height[i + 1]);
        add_edge(s, a->left[i + 1], a->height[i + 1], a->left[i], a->height[i]);
    }
    add_edge(s, a->right[last], a->height[last], a->left[last], a->height[last]);
}

static void find_shares(struct lens_shape *s, const struct lens_aperture *a)
{
    double area[LENS_GROUPS] = {0}, all = 0.0;
    for (int k = 0; k < LINES; k++) {
        const float height = 2.0f * ((float)k + 0.5f) / LINES - 1.0f;
        float left, right;
        lens_aperture_chord(a, height, &left, &right);
        area[lens_shape_group(-1.0f, height)] += (double)(fminf(right, 0.0f) - fminf(left, 0.0f));
        area[lens_shape_group(1.0f, height)] += (double)(fmaxf(right, 0.0f) - fmaxf(left, 0.0f));
    }
    for (int g = 0; g < LENS_GROUPS; g++) all += area[g];
    float sum = 0.0f; /* in their order they add up to 1, without rounding */
    for (int g = 0; g + 1 < LENS_GROUPS; g++) sum += s->share[g] = (float)(area[g] / all);
    s->share[LENS_GROUPS - 1] = 1.0f - sum;
}

void lens_shape_init(struct lens_shape *out, const struct lens_aperture *aperture)
{
    *out = (struct lens_shape){.inradius = 1.0f};
    if (aperture->bands > 0) add_edges(out, aperture);
    find_shares(out, aperture);
}

float lens_shape_distance(const struct lens_shape *shape, float x, float y)
{
    if (shape->edges == 0) return sqrtf(x * x + y * y);
    float most = 0.0f;
    for (uint32_t e = 0; e < shape->edges; e++) {
        const float out = shape->normal[e][0] * x + shape->normal[e][1] * y;
        most = out > most ? out : most;
    }
    return most;
}
