#pragma once
/* The roster of workers: JSON of GET /v1/workers. */
#include <jansson.h>

#include "server/fleet/session.h"

/* Describes one worker. New reference; NULL on failed allocation. */
json_t *roster_entry(const struct session *s, const struct worker_health *health);

/* Lists the frames of one session's tiles, as fleet_work does. */
unsigned roster_work(const struct session *s, struct fleet_work *out, unsigned most);
