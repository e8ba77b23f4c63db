#pragma once
/* Environment maps in memory. */
#include "tests/unit/unit.h"
#include "worker/scene/environment.h"

struct environment_fixture {
    struct environment_blob blob;
    struct environment *map;
};

/* A map of 3 * width * height texels, which are copied. */
void environment_fixture_open(struct environment_fixture *f, uint32_t width, uint32_t height,
                              const float *texels);

void environment_fixture_close(struct environment_fixture *f);

/* -- the steps of worker/scene/environment.h, one direction at a time -- */

void environment_lookup(const struct environment *e, const float direction[3], float radiance[3]);
float environment_pdf(const struct environment *e, const float direction[3]);

/* 0: a black map, no sample. */
void environment_sample(const struct environment *e, float choice, const float u[2],
                        float direction[3], float *pdf);
