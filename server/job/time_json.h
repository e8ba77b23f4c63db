#pragma once
/* A moment as the contract writes it. */
#include <jansson.h>
#include <stdint.h>

/* RFC 3339, UTC, with milliseconds; null for what no calendar has. New reference. */
json_t *time_json(int64_t time_ms);
