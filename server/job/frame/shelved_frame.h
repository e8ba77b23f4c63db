#pragma once
/* What a frame cost that was dropped to be taken up again from its spool: a paused job's, whose
 * memory others needed. It stays beside the job's own numbers until the frame is done; what is read
 * again then does not count a second time, what has to be traced again does.
 *
 * What is durable does not have it: after a restart nothing is known of it, and what is taken up
 * counts then. */
#include "server/job/frame/frame.h"

struct shelved_frame {
    struct statistics statistics; /* without what is found anew when it is drawn again */
    uint32_t passes[];            /* of each tile, that count there */
};

/* Of a frame that is about to be dropped, which may have been shelved before (taken; NULL: not).
 * NULL on failed allocation, and nothing is taken then. */
struct shelved_frame *shelved_frame_create(const struct frame *work, struct shelved_frame *before);
