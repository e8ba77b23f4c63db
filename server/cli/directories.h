#pragma once
/* The programs, pages and data directories of a coordinator. */
#include "proto/error.h"

#define DIRECTORIES_PATH_BYTES 4096

struct directories {
    char worker[DIRECTORIES_PATH_BYTES], import[DIRECTORIES_PATH_BYTES]; /* beside this program */
    char web[DIRECTORIES_PATH_BYTES],
        openapi[DIRECTORIES_PATH_BYTES]; /* of the source tree or installed */
    char data[DIRECTORIES_PATH_BYTES];   /* created if missing, owner-only */
    char blobs[DIRECTORIES_PATH_BYTES];  /* scene blobs by digest, under data */
    char cache[DIRECTORIES_PATH_BYTES];  /* of local workers, under data */
    char socket[DIRECTORIES_PATH_BYTES]; /* of local workers: under data, or short enough elsewhere
                                          */
    char socket_dir[DIRECTORIES_PATH_BYTES]; /* created for the socket, to be removed; "": none */
    int lock_fd;                             /* one coordinator a data folder */
};

/* Finds programs and pages, and locks the data folder. data, web: from the command line, or NULL
 * for the defaults (${XDG_DATA_HOME:-~/.local/share}/shearwater, beside the program). *fault names
 * what is missing. */
int directories_find(const char *data, const char *web, struct directories *out,
                     struct fault *fault);

/* Finds only the worker's program. ERR_NOT_FOUND, ERR_IO. */
int directories_find_worker(char out[DIRECTORIES_PATH_BYTES], struct fault *fault);

/* Locks a data folder against other coordinators, on this host and, where hosts share its file
 * system, on others. *fd is to be closed, also after a failure, when it is not -1. ERR_EXISTS: it
 * is locked; ERR_UNSUPPORTED: it cannot be; ERR_IO, ERR_LIMIT. */
int directories_lock(const char *data, int *fd, struct fault *fault);

/* Unlocks the data folder and removes the socket. */
void directories_leave(struct directories *directories);
