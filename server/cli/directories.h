#pragma once
/* Where a coordinator finds its programs and pages, and keeps its data. */
#include "proto/error.h"

#define DIRECTORIES_PATH_BYTES 4096

struct directories {
    char worker[DIRECTORIES_PATH_BYTES], import[DIRECTORIES_PATH_BYTES]; /* beside this program */
    char web[DIRECTORIES_PATH_BYTES],
        openapi[DIRECTORIES_PATH_BYTES]; /* of the source tree or installed */
    char data[DIRECTORIES_PATH_BYTES];   /* made if missing, owner-only */
    char blobs[DIRECTORIES_PATH_BYTES];  /* scene blobs by digest, under data */
    char cache[DIRECTORIES_PATH_BYTES];  /* of local workers, under data */
    char socket[DIRECTORIES_PATH_BYTES]; /* of local workers: under data, or short enough elsewhere
                                          */
    char socket_dir[DIRECTORIES_PATH_BYTES]; /* made for the socket, to be removed; "" if none */
    int lock_fd;                             /* one coordinator a data folder */
};

/* data, web: from the command line, or NULL for the defaults
 * (${XDG_DATA_HOME:-~/.local/share}/shearwater, beside the program). Locks the data folder. *fault
 * names what is missing. */
int directories_find(const char *data, const char *web, struct directories *out,
                     struct fault *fault);

/* The worker's program alone. ERR_NOT_FOUND, ERR_IO. */
int directories_find_worker(char out[DIRECTORIES_PATH_BYTES], struct fault *fault);

/* Unlocks, removes the socket. */
void directories_leave(struct directories *directories);
