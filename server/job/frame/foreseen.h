#pragma once

/* A figure that is foreseen: what it likely is, and may be at the least and at the most. */
enum foreseen { FORESEEN_LIKELY, FORESEEN_LEAST, FORESEEN_MOST, FORESEEN_COUNT };
