#pragma once
/* Command-line options from a table: parsing, checks and --help from the same lines.
 *
 *   static bool quiet;
 *   static const struct option_line lines[] = {
 *       {.name = "quiet", .letter = 'q', .kind = OPTION_FLAG, .out = &quiet, .text = "print
 * nothing"},
 *   };
 *
 * Every table has --help without a line of its own, and --dump-options (proto/option_text.h).
 * Options may stand before, between and after the arguments; "--" ends them. */
#include <stdbool.h>
#include <stddef.h>

enum option_kind {
    OPTION_FLAG,   /* out: bool *, set to true */
    OPTION_TEXT,   /* out: const char **, into argv; not empty */
    OPTION_NUMBER, /* out: long *, whole, in [least, most] */
    OPTION_LIST,   /* out: struct option_list *; the option may be given several times */
};

/* The values of an option, in their order. Each is in argv and not empty. */
#define OPTION_LIST_MOST 64
struct option_list {
    const char *values[OPTION_LIST_MOST];
    size_t count;
};

struct option_line {
    const char *name; /* without dashes */
    char letter;      /* 0: none */
    enum option_kind kind;
    const char *value; /* the value's name in help: "ADDR:PORT", or its words, "text|json"; NULL for
                          flags */
    const char *text;  /* for help, with unit and default; no newline */
    long least, most;  /* OPTION_NUMBER */
    void *out;
};

struct option_table {
    const char *usage;   /* "shearwater render JOB.json [options]" */
    const char *summary; /* sentences without newlines */
    const struct option_line *lines;
    size_t line_count;
    int least_arguments, most_arguments; /* besides options */
};

#define OPTION_GO_ON (-1)

/* Fills the outs and moves the arguments to the front: argv[1] .. argv[*arguments]. argv[0] is the
 * subcommand's name. Returns OPTION_GO_ON, or the exit status after it printed help (0, on stdout)
 * or what is wrong (2, on stderr). */
int option_parse(const struct option_table *table, int argc, char **argv, int *arguments);
