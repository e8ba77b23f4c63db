#pragma once
/* A plan with every kind of light, all planes, paths and a perspective camera with a lens under an
 * environment map, for tests to change. */
#include "proto/link/message.h"
#include "proto/plan.h"
#include "proto/samples.h"

#define PLAN_CASE_PLANES                                                                           \
    ((PLANE_BIT(ID_COUNT) - 1) & ~(PLANE_BIT(LENS_SECOND_SET) | PLANE_BIT(LENS_LOBE)))

#define PLAN_CASE_LIGHT_PLANES ((1u << LIGHT_PLANE_COUNT) - 1)

void plan_case(struct plan *plan);
