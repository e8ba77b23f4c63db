#pragma once
/* Points of surfaces that frames show, and what light falls on them from where. */
#include "server/import/rgbd/light_lamps.h"
#include "server/import/rgbd/light_sky.h"
#include "server/import/rgbd/light_solve.h"

#define LIGHT_ROWS     640 /* points at most, of all views */
#define LIGHT_UNKNOWNS (LIGHT_BINS + LIGHT_LAMPS)

/* Lights are the sky's bins, of what is not seen of them, and then lamps. */
struct light_rows {
    uint32_t count, unknowns;
    float *falls;                   /* owned; count x unknowns */
    float *seen[3];                 /* owned; by colour */
    float *known[3];                /* owned */
    uint8_t *group;                 /* owned */
    double albedo[3][LIGHT_GROUPS]; /* guesses */
};

/* Takes points evenly from all views. ERR_MEMORY; light_rows_destroy frees *out in both cases. */
int light_rows_find(const struct light_views *views, const struct light_sky *sky,
                    const struct light_lamp *lamps, uint32_t lamp_count, struct light_rows *out);
void light_rows_destroy(struct light_rows *rows);
