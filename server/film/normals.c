#include "server/film/normals.h"

#include <string.h>

#include "proto/octahedron.h"

enum { NORMALS_RUN = 16 };

/* The coordinates of packed normals. */
struct codes {
    int32_t x[NORMALS_RUN], y[NORMALS_RUN];
};

static void unpack_run(const struct codes *restrict codes, float steps, size_t count,
                       float *restrict x, float *restrict y, float *restrict z)
{
    float out[3][NORMALS_RUN];
    for (int i = 0; i < NORMALS_RUN; i++) {
        float n[3];
        octahedron_unpack(codes->x[i], codes->y[i], steps, n);
        for (int k = 0; k < 3; k++) out[k][i] = n[k];
    }
    memcpy(x, out[0], count * sizeof *x);
    memcpy(y, out[1], count * sizeof *y);
    memcpy(z, out[2], count * sizeof *z);
}

static void fill_run(const struct codes *codes, float steps, size_t count, float *x, float *y,
                     float *z)
{
    float n[3];
    octahedron_unpack(codes->x[0], codes->y[0], steps, n);
    for (size_t i = 0; i < count; i++) {
        x[i] = n[0];
        y[i] = n[1];
        z[i] = n[2];
    }
}

/* Runs of equal normals are common (walls, and all that is no surface). */
static void unpack_some(struct codes *codes, float steps, size_t count, float *const out[3],
                        size_t to)
{
    int32_t differs = 0;
    for (size_t i = count; i < NORMALS_RUN; i++) codes->x[i] = codes->y[i] = 0;
    for (size_t i = 0; i < count; i++)
        differs |= (codes->x[i] ^ codes->x[0]) | (codes->y[i] ^ codes->y[0]);
    float *x = out[0] + to, *y = out[1] + to, *z = out[2] + to;
    if (differs)
        unpack_run(codes, steps, count, x, y, z);
    else
        fill_run(codes, steps, count, x, y, z);
}

static size_t run_of(size_t left)
{
    return left < NORMALS_RUN ? left : NORMALS_RUN;
}

void normals_unpack16(const uint32_t *packed, size_t count, size_t to, float *const out[3])
{
    struct codes codes;
    for (size_t x = 0; x < count; x += NORMALS_RUN) {
        const size_t run = run_of(count - x);
        for (size_t i = 0; i < run; i++) {
            codes.x[i] = (int16_t)(packed[x + i] & 0xffffu);
            codes.y[i] = (int16_t)(packed[x + i] >> 16);
        }
        unpack_some(&codes, 32767.0f, run, out, to + x);
    }
}

void normals_unpack8(const uint16_t *packed, size_t count, size_t to, float *const out[3])
{
    struct codes codes;
    for (size_t x = 0; x < count; x += NORMALS_RUN) {
        const size_t run = run_of(count - x);
        for (size_t i = 0; i < run; i++) {
            const uint32_t code = packed[x + i];
            codes.x[i] = (int32_t)(code << 24) >> 24; /* with its sign */
            codes.y[i] = (int32_t)(code << 16) >> 24;
        }
        unpack_some(&codes, 127.0f, run, out, to + x);
    }
}
