#include "server/reconstruct/residual/residual_fetch.h"

#include <math.h>
#include <string.h>

#include "proto/surface_match.h"

/* What the samples of two pixels meet, in the mean, over what the centres show: so far apart, and
 * by as much as depth changes from pixel to pixel, they are alike; from twice that on they are not.
 * Edges and mirrors show themselves so. */
#define MIXTURE_SHARE 0.06f

/* A lobe that has turned by its width, with the surface or as the eye goes round, shows something
 * else. */
#define ALPHA2_MIN 1e-4f

/* Less of a surface is not worth a guess. */
#define SHARE_MIN 0.1f

/* A pixel of the patch, as other frames see it. */
struct seeker {
    const struct residual_history *from;
    uint32_t of_view;          /* enum plan_view */
    struct motion_point point; /* there */
    float normal[3], view[3];  /* in the patch's frame; from the point to the eye */
    float mixture, tolerance, alpha;
    float pixel; /* size there */
};

static float dot3(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static float apart2(const float a[3], const float b[3])
{
    const float d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return dot3(d, d);
}

/* 1 up to `full`, 0 from `none` on. */
static float fade(float value, float full, float none)
{
    const float part = (none - value) / (none - full);
    return part < 1.0f ? (part > 0.0f ? part : 0.0f) : 1.0f;
}

/* Finds the way from a point to the eye. Returns the distance. */
static float look_back(const struct plan_camera *camera, const double at[3], float view[3])
{
    double v[3], length2 = 0;
    for (int c = 0; c < 3; c++) {
        v[c] = camera->type == CAMERA_PERSPECTIVE ? (double)camera->eye[c] - at[c]
                                                  : -(double)camera->forward[c];
        length2 += v[c] * v[c];
    }
    const double length = sqrt(length2);
    for (int c = 0; c < 3; c++) view[c] = length > 0 ? (float)(v[c] / length) : 0.0f;
    return (float)length;
}

/* How much of pixel q is the surface that is looked for. Textures stay where they are. */
static float match(const struct seeker *s, const struct residual_past *q)
{
    if (q->id == 0 || q->id != s->point.id || !(q->seen > 0.0f)) return 0.0f;
    float off = 0.0f;
    for (int c = 0; c < 3; c++) off += (float)(s->point.at[c] - (double)q->at[c]) * q->normal[c];
    const float plane = SURFACE_PLANE_PX * s->pixel;
    return fade(-dot3(s->normal, q->normal), -SURFACE_COS_FULL, -SURFACE_COS_NONE) *
           fade(fabsf(off), plane, SURFACE_FADE * plane) *
           fade(fabsf(q->mixture - s->mixture), s->tolerance, 2.0f * s->tolerance);
}

/* How much of the rest, which lobes of a width send where they look, stays as it is. */
static float match_lobe(const struct seeker *s, const struct residual_past *q, const float view[3])
{
    const float turn2 = 4.0f * apart2(s->normal, q->normal) + apart2(s->view, view);
    const float part = 1.0f - turn2 / (s->alpha * q->alpha + ALPHA2_MIN);
    return part > 0.0f ? part * part : 0.0f;
}

/* Adds a part of what pixel q has. Its rest is what is left of all light without diffuse light of
 * this albedo, over this tint. */
static void add_light(const struct residual_past *q, float part, const float albedo[3],
                      const float tint[3], size_t i, const struct residual_fetched *out)
{
    float light[2][RESIDUAL_HISTORY_LIGHT];
    for (int h = 0; h < 2; h++) {
        memcpy(light[h], q->half[h], sizeof light[h]);
        for (int c = 0; c < 3; c++)
            light[h][6 + c] =
                (light[h][6 + c] - albedo[c] * (light[h][c] + light[h][3 + c])) / tint[c];
        for (int c = 0; c < RESIDUAL_HISTORY_LIGHT; c++) out->half[h][i][c] += part * light[h][c];
    }
    for (int k = 0; k < RESIDUAL_COMPONENTS; k++) {
        const float *a = light[0] + 3 * k, *b = light[1] + 3 * k;
        const float d = residual_guide(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
        out->noise[k][i] += part * d * d;
    }
}

static void add_tap(const struct seeker *s, const struct residual_past *q, float weight,
                    const float view[3], size_t i, const struct residual_fetched *out)
{
    const float part = weight * match(s, q);
    if (!(part > 0.0f)) return;
    out->share[i] += part;
    out->taps[i] += part * part;
    out->rest[i] += part * match_lobe(s, q, view);
    add_light(q, part, q->albedo, q->tint, i, out);
}

/* Means over the four pixels around, as far as they match. */
static void fetch_around(const struct seeker *s, size_t i, const struct residual_fetched *out)
{
    const int32_t width = s->from->plan.width_px, height = s->from->plan.height_px;
    const double gx = s->point.x - 0.5, gy = s->point.y - 0.5;
    float view[3];
    if (!(gx > -1 && gx < width && gy > -1 && gy < height)) return;
    const int32_t x = (int32_t)floor(gx), y = (int32_t)floor(gy);
    const float fx = (float)(gx - x), fy = (float)(gy - y);
    look_back(&s->from->plan.camera, s->point.at, view);
    for (int k = 0; k < 4; k++) {
        const int32_t tx = x + k % 2, ty = y + k / 2;
        const float weight = (k % 2 ? fx : 1.0f - fx) * (k / 2 ? fy : 1.0f - fy);
        if (tx < 0 || tx >= width || ty < 0 || ty >= height) continue;
        add_tap(s, residual_history_at(s->from, s->of_view, tx, ty), weight, view, i, out);
    }
    const float sum = out->share[i];
    if (sum < SHARE_MIN) {
        out->share[i] = out->rest[i] = 0.0f;
        return;
    }
    out->taps[i] /= sum * sum;
    for (int h = 0; h < 2; h++)
        for (int c = 0; c < RESIDUAL_HISTORY_LIGHT; c++) out->half[h][i][c] /= sum;
    for (int k = 0; k < RESIDUAL_COMPONENTS; k++) out->noise[k][i] /= sum;
}

/* Finds pixel (x, y) of the picture in the other frame. */
static bool seek(const struct residual_way *way, const struct patch *patch,
                 const struct residual_features *f, int32_t x, int32_t y, struct seeker *s)
{
    const struct plan *own = way->plans[0];
    const size_t i = patch_pixel(patch, x, y);
    const size_t at = residual_at(&f->shape, x - patch->rect.x0, y - patch->rect.y0);
    if (!(patch->depth[i] > 0.0f) || !residual_is_filtered(f, at)) return false;
    motion_show(own, patch, x, y, &s->point);
    look_back(&own->camera, s->point.at, s->view);
    for (uint32_t k = 0; k < way->steps; k++)
        if (!motion_follow(way->motions[k], way->plans[k], way->plans[k + 1], way->side, &s->point))
            return false;
    for (int c = 0; c < 3; c++) s->normal[c] = patch->normal[c][i];
    s->alpha = f->alpha[at];
    s->mixture = residual_nearness(f, f->nearness[at]) / patch->depth[i];
    s->tolerance =
        MIXTURE_SHARE + (fabsf(f->slope_x[at]) + fabsf(f->slope_y[at])) / f->nearness[at];
    /* What is seen in a mirror does not move as the mirror does, and edges do not move as one. */
    if (fabsf(s->mixture - 1.0f) > s->tolerance) return false;
    float view[3];
    const float distance = look_back(&s->from->plan.camera, s->point.at, view);
    s->pixel = plan_pixel_size(&s->from->plan, distance);
    return true;
}

static bool is_still(const struct motion_point *a, const struct motion_point *b)
{
    return a->x == b->x && a->y == b->y && a->at[0] == b->at[0] && a->at[1] == b->at[1] &&
           a->at[2] == b->at[2];
}

/* Whether a pixel's centre shows the same point in all frames on the way; or none in both. */
static bool centre_is_still(const struct residual_history *from, const struct residual_way *way,
                            const struct patch *patch, int32_t x, int32_t y)
{
    struct motion_point here, there;
    if (residual_history_at(from, way->view, x, y)->id != patch->id[patch_pixel(patch, x, y)])
        return false;
    motion_show(way->plans[0], patch, x, y, &here);
    there = here;
    for (uint32_t k = 0; k < way->steps; k++)
        if (!motion_follow(way->motions[k], way->plans[k], way->plans[k + 1], way->side, &there))
            return false;
    return is_still(&here, &there);
}

/* The least of a pixel and those beside it, in the rect. */
static uint8_t least_around(const struct rect r, const uint8_t *of, int32_t x, int32_t y)
{
    uint8_t least = 1;
    for (int32_t v = y - 1; v <= y + 1; v++)
        for (int32_t u = x - 1; u <= x + 1; u++)
            if (u >= r.x0 && u < r.x1 && v >= r.y0 && v < r.y1)
                least &= of[(size_t)(v - r.y0) * (size_t)rect_width(r) + (size_t)(u - r.x0)];
    return least;
}

void residual_find_still(const struct residual_history *from, const struct residual_way *way,
                         const struct patch *patch, uint8_t *work, uint8_t *still)
{
    const struct rect r = patch->rect;
    const struct plan_camera *camera = &way->plans[0]->camera;
    const bool stands = motion_is_same_view(camera, &from->plan.camera);
    memset(still, 0, (size_t)rect_area(r));
    size_t i = 0;
    for (int32_t y = r.y0; y < r.y1 && stands; y++)
        for (int32_t x = r.x0; x < r.x1; x++, i++)
            work[i] = centre_is_still(from, way, patch, x, y);
    i = 0;
    for (int32_t y = r.y0; y < r.y1 && stands; y++)
        for (int32_t x = r.x0; x < r.x1; x++, i++) still[i] = least_around(r, work, x, y);
}

/* Takes all of a pixel where nothing has moved, edges and mirrors, too. */
static void take_still(const struct residual_past *q, const struct residual_features *f, size_t at,
                       size_t i, const struct residual_fetched *out)
{
    const size_t plane = f->shape.plane;
    const float albedo[3] = {f->albedo[at], f->albedo[plane + at], f->albedo[2 * plane + at]};
    const float tint[3] = {f->tint[at], f->tint[plane + at], f->tint[2 * plane + at]};
    out->share[i] = out->rest[i] = out->taps[i] = 1.0f;
    add_light(q, 1.0f, albedo, tint, i, out);
}

void residual_fetch(const struct residual_history *from, const struct residual_way *way,
                    const struct patch *patch, const struct residual_features *features,
                    const uint8_t *still, const struct residual_fetched *out)
{
    const struct rect r = patch->rect;
    const size_t area = (size_t)rect_area(r);
    memset(out->share, 0, area * sizeof *out->share);
    memset(out->rest, 0, area * sizeof *out->rest);
    memset(out->taps, 0, area * sizeof *out->taps);
    for (int h = 0; h < 2; h++) memset(out->half[h], 0, area * sizeof *out->half[h]);
    for (int k = 0; k < RESIDUAL_COMPONENTS; k++)
        memset(out->noise[k], 0, area * sizeof *out->noise[k]);
    for (int32_t y = r.y0; y < r.y1; y++)
        for (int32_t x = r.x0; x < r.x1; x++) {
            struct seeker s = {.from = from, .of_view = way->view};
            const size_t at = residual_at(&features->shape, x - r.x0, y - r.y0);
            const size_t i = patch_pixel(patch, x, y);
            const struct residual_past *q = residual_history_at(from, way->view, x, y);
            if (still[i] && q->id > 0 && residual_is_filtered(features, at))
                take_still(q, features, at, i, out);
            else if (!still[i] && seek(way, patch, features, x, y, &s))
                fetch_around(&s, i, out);
        }
}
