#include "server/cli/option.h"

#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/option_text.h"

#define MOST_LINES  48
#define FIRST_VALUE 256 /* getopt's values of long options: above any letter */
#define HELP_VALUE  (FIRST_VALUE + MOST_LINES)

static struct option_text text_of(const struct option_line *line)
{
    return (struct option_text){line->letter, line->name, line->value, line->text};
}

static const struct option_text help_option = {0, "help", NULL, "print this text"};

static void print_help(const struct option_table *table)
{
    printf("usage: %s\n\n", table->usage);
    option_text_wrap(stdout, table->summary, 0);
    putchar('\n');
    for (size_t i = 0; i < table->line_count; i++) {
        const struct option_text text = text_of(&table->lines[i]);
        option_text_help(stdout, &text);
    }
    option_text_help(stdout, &help_option);
}

static void dump(const struct option_table *table)
{
    printf("usage\t%s\nsummary\t%s\n", table->usage, table->summary);
    for (size_t i = 0; i < table->line_count; i++) {
        const struct option_text text = text_of(&table->lines[i]);
        option_text_dump(stdout, &text);
    }
    option_text_dump(stdout, &help_option);
}

static int refuse(const struct option_table *table, const char *program)
{
    fprintf(stderr, "usage: %s\n`shearwater %s --help` lists the options\n", table->usage, program);
    return 2;
}

static int take_number(const struct option_line *line, const char *text)
{
    char *end;
    errno = 0;
    long value = strtol(text, &end, 10);
    if (errno || end == text || *end) {
        fprintf(stderr, "--%s: \"%s\" is not a whole number\n", line->name, text);
        return -1;
    }
    if (value < line->least || value > line->most) {
        fprintf(stderr, "--%s: %ld is not in %ld..%ld\n", line->name, value, line->least,
                line->most);
        return -1;
    }
    *(long *)line->out = value;
    return 0;
}

static int add(const struct option_line *line, const char *text)
{
    struct option_list *list = line->out;
    if (list->count == OPTION_LIST_MOST) {
        fprintf(stderr, "--%s: it is given more than %d times\n", line->name, OPTION_LIST_MOST);
        return -1;
    }
    list->values[list->count++] = text;
    return 0;
}

static int take(const struct option_line *line, const char *text)
{
    if (line->kind == OPTION_NUMBER) return take_number(line, text);
    if (line->kind == OPTION_FLAG) {
        *(bool *)line->out = true;
        return 0;
    }
    if (!*text) {
        fprintf(stderr, "--%s: the value is empty\n", line->name);
        return -1;
    }
    if (line->kind == OPTION_LIST) return add(line, text);
    *(const char **)line->out = text;
    return 0;
}

/* What getopt_long wants to know. */
struct getopt_table {
    struct option longs[MOST_LINES + 2];
    char letters[2 * MOST_LINES + 2];
};

static void prepare(const struct option_table *table, struct getopt_table *g)
{
    *g = (struct getopt_table){0};
    char *letters = g->letters;
    for (size_t i = 0; i < table->line_count; i++) {
        const struct option_line *line = &table->lines[i];
        int has_value = line->kind == OPTION_FLAG ? no_argument : required_argument;
        g->longs[i] = (struct option){line->name, has_value, NULL, FIRST_VALUE + (int)i};
        if (!line->letter) continue;
        *letters++ = line->letter;
        if (has_value) *letters++ = ':';
    }
    g->longs[table->line_count] = (struct option){"help", no_argument, NULL, HELP_VALUE};
}

static const struct option_line *find(const struct option_table *table, int value)
{
    if (value >= FIRST_VALUE && value < FIRST_VALUE + (int)table->line_count)
        return &table->lines[value - FIRST_VALUE];
    for (size_t i = 0; i < table->line_count; i++)
        if (table->lines[i].letter && table->lines[i].letter == value) return &table->lines[i];
    return NULL;
}

int option_parse(const struct option_table *table, int argc, char **argv, int *arguments)
{
    struct getopt_table g;
    if (table->line_count > MOST_LINES) return refuse(table, argv[0]);
    if (argc == 2 && strcmp(argv[1], OPTION_TEXT_DUMP) == 0) {
        dump(table);
        return 0;
    }
    prepare(table, &g);
    optind = 0; /* starts glibc's getopt afresh */
    for (int value; (value = getopt_long(argc, argv, g.letters, g.longs, NULL)) != -1;) {
        if (value == HELP_VALUE) {
            print_help(table);
            return 0;
        }
        const struct option_line *line = find(table, value);
        if (!line || take(line, optarg) != 0) return refuse(table, argv[0]);
    }
    *arguments = argc - optind;
    if (*arguments < table->least_arguments || *arguments > table->most_arguments) {
        fprintf(stderr, *arguments < table->least_arguments ? "an argument is missing\n"
                                                            : "there are too many arguments\n");
        return refuse(table, argv[0]);
    }
    memmove(argv + 1, argv + optind, (size_t)*arguments * sizeof *argv);
    argv[*arguments + 1] = NULL;
    return OPTION_GO_ON;
}
