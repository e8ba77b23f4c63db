#pragma once
/* What the file of tokens says of tenants: who they are, and how they share the workers. */
#include "proto/error.h"

struct http;

/* Tells the jobs what the file weighs each tenant by; without a file nothing. ERR_MEMORY: they
 * share as they did before. */
int tenants_share(struct http *http, struct fault *fault);
