#pragma once
/* The cost of a frame that was dropped and will be taken up again from its spool, because other
 * jobs need the memory of a paused one. It stays beside the job's own numbers until the frame is
 * done. Passes that are read again then do not count twice; passes that are traced again do.
 *
 * It is not durable. After a restart it is gone, and passes that are taken up count. */
#include "server/job/frame/frame.h"

struct shelved_frame {
    struct statistics statistics; /* without what is found anew when it is drawn again */
    uint32_t passes[];            /* of each tile, that count there */
};

/* Makes it for a frame that is about to be dropped. If the frame was shelved before, `before` is
 * taken; else it is NULL. Returns NULL on failed allocation, and takes nothing then. */
struct shelved_frame *shelved_frame_create(const struct frame *work, struct shelved_frame *before);
