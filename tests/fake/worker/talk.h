#pragma once
/* What the fake worker says on a link, and what it prints of what comes in. */
#include "tests/fake/worker/fake.h"

/* From HELLO until the link ends or the fake is over. */
void talk(struct fake *f);
