#pragma once
/* Holding a property to a case in a process of its own, so that one that crashes, or does not end,
 * is found to fail as others are; and finding the simplest case that fails. */
#include "tests/property/property.h"

enum { CHECK_MAX_S = 120, SHRINK_MAX_S = 120 };

enum property_result check(const struct property *property, const struct property_case *c,
                           char says[PROPERTY_SAYS_BYTES]);

/* Makes *c simpler as long as the property fails; says as of the simplest. At most `most` tries,
 * begun within SHRINK_MAX_S; how many there were. */
int check_shrink(const struct property *property, struct property_case *c, int most,
                 char says[PROPERTY_SAYS_BYTES]);
