#pragma once
/* The worker's command line. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "proto/error.h"
#include "proto/packing.h"

struct options {
    const char *connect;    /* "unix:PATH" or "HOST:PORT"; required */
    const char *key;        /* file of the key for links over TCP; NULL: not encrypted */
    const char *cache_dir;  /* blobs fetched over the link; default: options_default_cache */
    const char *blob_dir;   /* objects of a coordinator on this machine: mapped, not fetched */
    const char *name;       /* is shown to users; default: worker_name.h */
    uint64_t cache_bytes;   /* bound of the cache; default 16 GiB */
    uint32_t threads;       /* 1..LIMIT_THREADS; default: the CPUs this process may use */
    uint32_t tiles_in_hand; /* 1..LIMIT_TILES_IN_HAND; default 2 for each thread */
    uint32_t nice;          /* 1..19, as in nice(1); 0: unchanged */
    const char *pack;       /* "quick" or "small"; NULL: as the link needs it */
    enum packing packing;   /* the same; by options_read */
    const char *log_format; /* "text" or "json"; default text */
    bool quiet;             /* errors only */
    bool exit_with_parent;  /* end when the parent or the link is gone */
    uint32_t connect_within_s, idle_exit_s, lifetime_s; /* session_deadlines.c; 0: none */
    const char *replay;       /* a plan's file: print one of its samples instead of working */
    const char *arguments[2]; /* then the pixel, "X,Y", and the sample's number */
    uint32_t argument_count;
    bool json;
    bool help, version, dump;
    uint32_t loading_ms; /* not given on the command line; 0: SESSION_LOADING_MS */
};

/* Reads argv, from which the strings are borrowed. *fault names the argument at fault and the
 * values that are allowed. */
int options_read(int argc, char **argv, struct options *out, struct fault *fault);

/* Writes $XDG_CACHE_HOME/shearwater, else ~/.cache/shearwater, else /tmp/shearwater-UID. */
int options_default_cache(char *out, size_t capacity);

/* Prints the answer to --help. */
void options_print_help(FILE *out);

/* Prints the answer to --dump-options (proto/option_text.h). */
void options_dump(FILE *out);
