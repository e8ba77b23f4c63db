#pragma once
/* The workers as people see them: JSON of GET /v1/workers. */
#include <jansson.h>

#include "server/fleet/session.h"

/* One worker. New reference; NULL on failed allocation. */
json_t *roster_entry(const struct session *s, const struct worker_health *health);

/* As fleet_work, of one session. */
unsigned roster_work(const struct session *s, struct fleet_work *out, unsigned most);
