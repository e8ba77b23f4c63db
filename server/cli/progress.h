#pragma once
/* A job's progress for people: a bar that redraws itself on a terminal, a line every tenth
 * elsewhere. It is written to standard error, so that standard output stays for results. */
#include <jansson.h>
#include <stdbool.h>

struct progress {
    bool quiet, terminal;
    int width; /* columns of the bar */
    int tenth; /* last tenth said where there is no terminal */
    double fraction;
    char state[32];
};

void progress_begin(struct progress *p, bool quiet);

/* Draws the progress. `state`: queued, importing, running ...; `data`: a progress event or NULL. It
 * never shows 100 % before the job is finished. */
void progress_show(struct progress *p, const char *state, const json_t *data);

/* Clears the bar and, unless quiet, leaves one line. */
void progress_end(struct progress *p, const char *line);
