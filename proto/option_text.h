#pragma once
/* Command-line options as text: for people (--help) and for the scripts that write man pages and
 * completion (--dump-options). */
#include <stdio.h>

/* The hidden option that every command has. Each line of its answer is a record whose parts have
 * tabs between them:
 *
 *   command  NAME TEXT             one of the program's commands; what follows is about it
 *   usage    TEXT                  once or more
 *   summary  TEXT
 *   option   -LETTER --NAME VALUE TEXT    LETTER and VALUE may be missing: the part is empty
 *   note     TEXT                  none or more */
#define OPTION_TEXT_DUMP "--dump-options"

struct option_text {
    char letter;       /* 0: none */
    const char *name;  /* without dashes */
    const char *value; /* "FILE", "N"; words with | between them: one of these; NULL: a flag */
    const char *text;
};

/* Prints a text from `column` on, in lines of at most 80 columns. The first line begins where the
 * output is. Ends the last line. */
void option_text_wrap(FILE *out, const char *text, int column);

/* Prints an option's lines of --help. */
void option_text_help(FILE *out, const struct option_text *option);

/* Prints an option's record. */
void option_text_dump(FILE *out, const struct option_text *option);
