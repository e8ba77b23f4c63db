#pragma once
/* Makes MHD responses of bodies, with the headers that every answer carries. All functions return
 * NULL on failed allocation; the caller owns the response. */
#include <jansson.h>
#include <microhttpd.h>
#include <stdbool.h>
#include <stdint.h>

/* Copies the bytes. */
struct MHD_Response *response_of_copy(const void *data, size_t size_bytes, const char *type);
/* Borrows the bytes for the daemon's life. */
struct MHD_Response *response_of_borrowed(const void *data, size_t size_bytes, const char *type);
/* Takes malloc'ed bytes over, even on failure. */
struct MHD_Response *response_of_taken(void *data, size_t size_bytes, const char *type);
/* Writes compact JSON. */
struct MHD_Response *response_of_json(const json_t *body, const char *type);
/* Sends a part of an open file; takes the descriptor over, even on failure. */
struct MHD_Response *response_of_file(int fd, uint64_t first_byte, uint64_t size_bytes,
                                      const char *type);
struct MHD_Response *response_empty(void);
/* Returns the answer for when no memory was left: a problem that was made beforehand, else
 * nothing but a status. */
struct MHD_Response *response_without_memory(unsigned *status);
/* Has the length that a body would have, for HEAD alone. */
struct MHD_Response *response_of_length(uint64_t size_bytes);

/* Adds the headers of every answer, as the functions above do; streams call it themselves. False on
 * failed allocation. */
bool response_protect(struct MHD_Response *response, const char *type);
void response_header(struct MHD_Response *response, const char *name, const char *value);
