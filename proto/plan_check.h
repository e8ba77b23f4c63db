#pragma once
/* The rules of a plan, apart from its bytes. */
#include "proto/plan.h"

/* All that plan_decode demands of a plan whose light_count is within limits. ERR_RANGE, ERR_LIMIT
 * or ERR_NOT_FINITE; *fault names the field. */
int plan_check(const struct plan *plan, struct fault *fault);
