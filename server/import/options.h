#pragma once
/* The command line of shearwater-import. */
#include <stdbool.h>
#include <stdio.h>

#include "proto/error.h"
#include "server/import/scene/scene_choice.h"

#define OPTIONS_TIMES 64

struct options {
    const char *root;           /* folder that holds the scene's files */
    const char *name;           /* main file beneath it */
    struct scene_choice choice; /* its times are those below */
    double times[OPTIONS_TIMES];
    struct job_moves moves; /* the same */
    const char *out;        /* where the blob goes */
    const char *report;     /* where the line goes as well; NULL: nowhere */
    bool help, dump;
};

/* Reads the options, which borrow from argv. ERR_MISSING, ERR_UNKNOWN_MEMBER with the option at
 * fault. */
int options_read(int argc, char **argv, struct options *out, struct fault *fault);

/* Prints the answer to --help. */
void options_print_help(FILE *out);

/* Prints the answer to --dump-options (proto/option_text.h). */
void options_dump(FILE *out);
