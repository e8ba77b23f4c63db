#include "server/import/rgbd/rgbd_light.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/plan.h"
#include "server/import/rgbd/light_rows.h"
#include "server/import/rgbd/light_solve.h"

#define ABOVE_M 0.1 /* of the scene's origin: the place whose surroundings count */

/* How far what is guessed is trusted, in shares of all points: the sky's bins together, a lamp as
 * its file shows it, and one that may be brighter than its file can tell. */
#define TRUST_SKY  0.005
#define TRUST_LAMP 1.0
#define TRUST_CUT  1e-4

#define DARKEST 1e-9

static double luminance(const double c[3])
{
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

/* What is not seen is as bright as what is, and has the colour of white: most of what is seen may
 * be one coloured floor. */
static void set_guesses(const struct rgbd_light *light, uint32_t rows, int c,
                        float guess[LIGHT_UNKNOWNS], float trust[LIGHT_UNKNOWNS])
{
    const double by = luminance(light->sky.mean) / fmax(luminance(light->white), DARKEST);
    for (uint32_t j = 0; j < LIGHT_BINS; j++) {
        guess[j] = (float)(by * light->white[c]);
        trust[j] = (float)(TRUST_SKY * rows / LIGHT_BINS);
    }
    for (uint32_t k = 0; k < light->lamp_count; k++) {
        guess[LIGHT_BINS + k] = (float)light->lamps[k].radiance[c];
        trust[LIGHT_BINS + k] = (float)(rows * (light->lamps[k].is_cut ? TRUST_CUT : TRUST_LAMP));
    }
}

static int solve(const struct light_rows *rows, struct rgbd_light *light)
{
    double bins[3 * LIGHT_BINS], radiance[LIGHT_UNKNOWNS];
    float guess[LIGHT_UNKNOWNS], trust[LIGHT_UNKNOWNS];
    for (int c = 0; c < 3; c++) {
        const struct light_system s = {rows->count,    rows->unknowns, rows->falls, rows->seen[c],
                                       rows->known[c], rows->group,    guess,       trust};
        double albedo[LIGHT_GROUPS];
        memcpy(albedo, rows->albedo[c], sizeof albedo);
        set_guesses(light, rows->count, c, guess, trust);
        const int rc = light_solve(&s, albedo, radiance);
        if (rc != 0) return rc;
        for (uint32_t j = 0; j < LIGHT_BINS; j++) bins[3 * j + (uint32_t)c] = radiance[j];
        for (uint32_t k = 0; k < light->lamp_count; k++)
            light->lamps[k].radiance[c] = radiance[LIGHT_BINS + k];
    }
    light_sky_fill(&light->sky, bins);
    return 0;
}

/* Cuts what samples cannot hold. Returns whether there is any light. */
static bool finish(struct rgbd_light *light)
{
    float most = 0;
    for (uint32_t i = 0; i < 3 * SCENE_SKY_TEXELS; i++) {
        light->sky.texels[i] = fminf(fmaxf(light->sky.texels[i], 0), LIMIT_RADIANCE);
        most = fmaxf(most, light->sky.texels[i]);
    }
    for (uint32_t k = 0; k < light->lamp_count; k++)
        for (int c = 0; c < 3; c++) {
            double *radiance = &light->lamps[k].radiance[c];
            *radiance = fmin(fmax(*radiance, 0), (double)LIMIT_RADIANCE);
            most = fmaxf(most, (float)*radiance);
        }
    return most > 0;
}

static int find(const struct light_views *views, const double place[3], struct rgbd_light *out)
{
    struct light_rows rows;
    for (uint32_t i = 0; i < views->count; i++)
        for (int c = 0; c < 3; c++) out->white[c] += (double)views->list[i].white[c] / views->count;
    light_sky_look(views, place, &out->sky);
    const int lamps = light_lamps_find(views, out->lamps);
    if (lamps < 0) return ERR_MEMORY;
    out->lamp_count = (uint32_t)lamps;
    int rc = light_rows_find(views, &out->sky, out->lamps, out->lamp_count, &rows);
    if (rc == 0) rc = solve(&rows, out);
    light_rows_destroy(&rows);
    out->found = rc == 0 && finish(out);
    return rc;
}

int rgbd_light_find(const struct rgbd_document *d, struct files *files, const struct affine *place,
                    const struct scene_choice *choice, struct rgbd_light *out,
                    struct warnings *warnings, struct fault *fault)
{
    struct light_views views;
    memset(out, 0, sizeof *out);
    if (choice->estimate == RGBD_ESTIMATE_NONE) return 0;
    int rc = light_views_read(d, files, place, &views, warnings, fault);
    if (rc == 0) {
        const double at[3] = {0, ABOVE_M * views.list[0].units_per_m, 0};
        rc = find(&views, at, out);
        if (rc != 0) fault_set(fault, rc, "/rgbd", "no memory to estimate the light");
    }
    light_views_destroy(&views);
    return rc;
}

static int add_lamp(const struct light_lamp *lamp, struct builder *b, struct fault *fault)
{
    struct scene_light out = {.type = LIGHT_RECTANGLE,
                              .profile = PROFILE_UNIFORM,
                              .cos_inner = 1,
                              .instance = SCENE_NONE};
    const int rc = builder_name(b, "rgbd", &out.name, fault);
    for (int c = 0; c < 3; c++) {
        out.position[c] = (float)(lamp->center[c] - b->origin[c]);
        out.direction[c] = (float)lamp->normal[c];
        out.half_u[c] = (float)lamp->half_u[c];
        out.half_v[c] = (float)lamp->half_v[c];
        out.color[c] = (float)lamp->radiance[c];
    }
    return rc == 0 ? builder_append_record(b, SCENE_LIGHTS, &out, fault) : rc;
}

static void tell(const struct rgbd_light *light, struct warnings *warnings)
{
    if (!light->found)
        warnings_add(warnings, "/rgbd/frames", "they are too dark: no light is estimated of them");
    else
        warnings_add(warnings, "/rgbd/frames",
                     "the light is estimated: they show %.0f %% of what is around (lamps: %u)",
                     100 * light->sky.share, light->lamp_count);
}

bool rgbd_light_is_wanted(const struct scene_choice *choice, const struct builder *b)
{
    return choice->estimate == RGBD_ESTIMATE_ALWAYS ||
           (choice->estimate == RGBD_ESTIMATE_UNLESS_LIT && builder_count(b, SCENE_LIGHTS) == 0);
}

int rgbd_light_add(const struct rgbd_light *light, const struct scene_choice *choice,
                   struct builder *b, struct fault *fault)
{
    void *texels;
    if (!rgbd_light_is_wanted(choice, b)) return 0;
    tell(light, &b->warnings);
    if (!light->found) return 0;
    int rc = builder_append(b, SCENE_SKY, SCENE_SKY_TEXELS, &texels, fault);
    if (rc == 0) memcpy(texels, light->sky.texels, sizeof light->sky.texels);
    for (uint32_t k = 0; k < light->lamp_count && rc == 0; k++)
        rc = add_lamp(&light->lamps[k], b, fault);
    return rc;
}
