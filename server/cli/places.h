#pragma once
/* Where a coordinator finds its programs and pages, and keeps its data. */
#include "proto/error.h"

#define PLACES_PATH_BYTES 4096

struct places {
    char worker[PLACES_PATH_BYTES], import[PLACES_PATH_BYTES]; /* beside this program */
    char web[PLACES_PATH_BYTES], openapi[PLACES_PATH_BYTES];   /* of the source tree or installed */
    char data[PLACES_PATH_BYTES];                              /* made if missing, owner-only */
    char blobs[PLACES_PATH_BYTES];  /* scene blobs by digest, under data */
    char cache[PLACES_PATH_BYTES];  /* of local workers, under data */
    char socket[PLACES_PATH_BYTES]; /* of local workers: under data, or short enough elsewhere */
    char socket_dir[PLACES_PATH_BYTES]; /* made for the socket, to be removed; "" if none */
    int lock_fd;                        /* one coordinator a data folder */
};

/* data, web: from the command line, or NULL for the defaults
 * (${XDG_DATA_HOME:-~/.local/share}/shearwater, beside the program). Locks the data folder. *fault
 * names what is missing. */
int places_find(const char *data, const char *web, struct places *out, struct fault *fault);

/* The worker's program alone. ERR_NOT_FOUND, ERR_IO. */
int places_find_worker(char out[PLACES_PATH_BYTES], struct fault *fault);

/* Unlocks, removes the socket. */
void places_leave(struct places *places);
