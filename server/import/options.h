#pragma once
/* The command line of shearwater-import. */
#include <stdbool.h>

#include "proto/error.h"

struct options {
    const char *root;   /* folder that holds the scene's files */
    const char *name;   /* main file beneath it */
    const char *out;    /* where the blob goes */
    const char *report; /* where the line goes as well; NULL: nowhere */
    bool help;
};

/* Borrows from argv. ERR_MISSING, ERR_UNKNOWN_MEMBER with the option at fault. */
int options_read(int argc, char **argv, struct options *out, struct fault *fault);

extern const char options_help[];
