#pragma once
/* A file on its way from a request's body to the disk. libuv's pool of threads creates, writes and
 * hashes it piece by piece, so the loop never waits for the disk. While one piece is written the
 * next one gathers. When that is full, too, the connection sleeps until there is room, so that an
 * upload holds UPLOAD_PIECES pieces at most, however slow the disk is.
 *
 * A disk that hangs or crawls keeps the upload, not the request. The request is answered when one
 * piece takes longer than a request may wait (pending.h). It is also answered when all pieces take
 * longer than that and a second more for each LIMIT_UPLOAD_PACE bytes, or than an upload may take
 * to arrive. What was sent is thrown away when the disk comes back. The upload is counted until
 * then, so that repeated requests fill no memory. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "server/store/objects.h"

#define UPLOAD_PIECE_BYTES 131072u /* more than comes from MHD at once */
#define UPLOAD_PIECES      2u
#define UPLOADS_MAX        64u /* under way: each holds a descriptor, a hash, pieces */

struct http;
struct request;
struct upload;

/* Begins to create the file. 0: the request is woken when that is over, well or not (upload_error).
 * ERR_FULL: too many are under way; ERR_MEMORY. */
int upload_begin(struct request *r, struct upload **out);

/* Takes bytes, at most UPLOAD_PIECE_BYTES. False: there is no room, and the request is woken when
 * there is. After a failure bytes are dropped. */
bool upload_take(struct upload *u, const char *data, size_t size_bytes);

/* Returns whether all of it is written to the system. False: the request is woken when it is. */
bool upload_is_written(struct upload *u);

/* Returns the first error of creating or writing it, or 0. */
int upload_error(const struct upload *u);

/* Returns the whole file, to be finished; owned by the caller. Only when it is written without
 * error. */
struct object_writer *upload_take_writer(struct upload *u);

/* Drops the upload and nulls the pointer (NULL is fine). The file goes, if it was not taken. */
void upload_drop(struct upload **u);

/* Wakes requests that have waited too long for the disk, with ERR_TIMEOUT. Called from time to
 * time. */
void upload_tick(struct http *http);
