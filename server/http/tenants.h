#pragma once
/* The tenants of the file of tokens, and their shares of the workers. */
#include "proto/error.h"

struct http;

/* Tells the jobs the weight of each tenant in the file. Without a file it does nothing. ERR_MEMORY:
 * shares stay as before. */
int tenants_share(struct http *http, struct fault *fault);
