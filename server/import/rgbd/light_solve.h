#pragma once
/* Finds lights by what they do: what surfaces send on is their albedo times the light that falls on
 * them, which is known in part. Lights and the albedo of surfaces of like colour are found in
 * turns, as inverse lighting does (Marschner and Greenberg 1997, "Inverse lighting for
 * photography"). */
#include <stdint.h>

#define LIGHT_GROUPS 64 /* of surfaces of like colour */

/* One colour channel's. Arrays are borrowed. */
struct light_system {
    uint32_t rows, unknowns;
    const float *falls;   /* rows x unknowns: irradiance by each light of radiance 1 */
    const float *seen;    /* rows: radiance that frames show */
    const float *known;   /* rows: irradiance that comes from what is known */
    const uint8_t *group; /* rows */
    const float *guess;   /* unknowns: radiance if nothing tells of it */
    const float *trust;   /* unknowns: of the guess, in rows */
};

/* Solves for the radiance of each light, which is not negative, by weighted least squares. albedo:
 * LIGHT_GROUPS guesses, replaced by what is found. ERR_MEMORY. */
int light_solve(const struct light_system *s, double albedo[LIGHT_GROUPS], double *radiance);
