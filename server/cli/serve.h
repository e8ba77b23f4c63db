#pragma once
/* `shearwater serve`: the coordinator until it is told to stop. */
#define SERVE_LISTEN "127.0.0.1:8040"
