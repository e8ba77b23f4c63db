#pragma once
/* Shows a job in a running tev while it renders: the pixel feeds of its layers become one image of
 * many channels, named as in the EXR. It runs on a thread of its own. The newest state wins: while
 * tev takes a block, the coordinator only notes which blocks are newer. */
#include "server/cli/client/client_target.h"
#include "server/cli/tev/tev_link.h"

struct tev_push;

/* Connects, so that faults are reported at once, and begins. `layers` are the job's, by name. The
 * id and the link are copied, the target is borrowed. The link is the pusher's when 0 is
 * returned. */
int tev_push_start(const struct client_target *target, const char *job, const char *const *layers,
                   uint32_t count, struct tev_link *link, struct tev_push **out,
                   struct fault *fault);

/* Waits until all of the picture has gone out (or there is none any more). Returns the error of
 * what went wrong meanwhile. Nulls *push. */
int tev_push_finish(struct tev_push **push, struct fault *fault);
