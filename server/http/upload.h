#pragma once
/* A file on its way from a request's body to the disk. The disk is waited for on libuv's pool of
 * threads, never on the loop: the file is made, written and hashed there, piece by piece. While one
 * piece is written the next one gathers; when that is full, too, the connection sleeps until there
 * is room, so that an upload holds UPLOAD_PIECES pieces at most, however slow the disk is.
 *
 * A disk that hangs or crawls keeps the upload, not the request: who has waited for one piece as
 * long as a request waits for an answer (pending.h), or for all of them that long and a second more
 * for each LIMIT_UPLOAD_PACE bytes, or as long as an upload may take to arrive, is told so, and
 * what he sent is thrown away when the disk comes back. Until then the upload is counted, so that
 * asking again and again fills no memory. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "server/store/objects.h"

#define UPLOAD_PIECE_BYTES 131072u /* more than comes from MHD at once */
#define UPLOAD_PIECES      2u
#define UPLOADS_MOST       64u /* that are under way: each holds a descriptor, a hash, pieces */

struct http;
struct request;
struct upload;

/* Begins to make the file. 0: the request is woken when that is over, well or not (upload_error).
 * ERR_FULL: too many are under way; ERR_MEMORY. */
int upload_begin(struct request *r, struct upload **out);

/* Takes bytes, at most UPLOAD_PIECE_BYTES; false: not now, the request is woken when there is room.
 * After a failure they are let pass. */
bool upload_take(struct upload *u, const char *data, size_t size_bytes);

/* Is all of it with the system? False: the request is woken when it is. */
bool upload_is_written(struct upload *u);

/* Of making or writing it; the first one. */
int upload_error(const struct upload *u);

/* The whole file (of one that is written, without error), to be finished; owned by the caller. */
struct object_writer *upload_take_writer(struct upload *u);

/* Nobody wants it any more: nulls the pointer (NULL is fine). The file goes, if it was not taken.
 */
void upload_drop(struct upload **u);

/* From time to time: wakes who has waited too long for the disk, with ERR_TIMEOUT. */
void upload_tick(struct http *http);
