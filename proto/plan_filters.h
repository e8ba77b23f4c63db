#pragma once
/* Part of plan_check: filters know what they read, and what they read is there. */
#include "proto/plan.h"
#include "proto/plan_place.h"

int plan_filters_check(const struct plan_place *at, const struct plan *plan);
