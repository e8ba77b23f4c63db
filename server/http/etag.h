#pragma once
/* Entity tags (RFC 9110, section 8.8.3). */
#include <stdbool.h>
#include <stddef.h>

#include "proto/digest.h"

#define ETAG_BYTES 96

/* Write the strong tag of bytes, with this digest or as they are. */
void etag_of_digest(const struct digest *digest, char out[ETAG_BYTES]);
void etag_of_bytes(const void *data, size_t size_bytes, char out[ETAG_BYTES]);

/* Returns whether a list of tags as in If-None-Match (weak comparison) names `etag`. "*" names
 * all. */
bool etag_listed(const char *list, const char *etag);

/* Does the same for If-Match, by strong comparison, so that a weak tag names nothing. */
bool etag_matches(const char *list, const char *etag);
