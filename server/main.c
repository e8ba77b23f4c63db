/* shearwater: one program, a subcommand for each thing that it does. */
#include <stdio.h>
#include <string.h>

#include "proto/option_text.h"
#include "proto/runtime/build.h"
#include "server/cli/cli.h"

static const struct command {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *text;
} commands[] = {
    {"serve", cli_serve, "run the coordinator with local workers"},
    {"render", cli_render, "render a job file here and now"},
    {"submit", cli_submit, "submit a job file to a coordinator"},
    {"jobs", cli_jobs, "list a coordinator's jobs, by name, label or state"},
    {"watch", cli_watch, "follow a job until it ends"},
    {"steer", cli_steer, "pause or resume a job, or change what is rendered first"},
    {"mark", cli_mark, "change a job's name, comment or labels"},
    {"cancel", cli_cancel, "cancel a job"},
    {"workers", cli_workers, "list a coordinator's workers, or launch some by Slurm"},
    {"health", cli_health, "tell whether a coordinator is well"},
    {"token", cli_token, "create an access token"},
    {"replay", cli_replay, "print every step of one sample of a job"},
    {"compare", cli_compare, "measure how far a picture is from a reference"},
};
#define COMMAND_COUNT (sizeof commands / sizeof commands[0])

static void print_help(FILE *out)
{
    fprintf(out, "usage: shearwater COMMAND [options]\n\n");
    for (size_t i = 0; i < COMMAND_COUNT; i++)
        fprintf(out, "  %-10s %s\n", commands[i].name, commands[i].text);
    fprintf(
        out,
        "\n`shearwater COMMAND --help` lists a command's options; --version prints the build.\n");
}

/* What the scripts that make man pages and completion read (proto/option_text.h). */
static int dump_options(void)
{
    int status = 0;
    for (size_t i = 0; i < COMMAND_COUNT && status == 0; i++) {
        char name[32], dump[] = OPTION_TEXT_DUMP, *argv[] = {name, dump, NULL};
        snprintf(name, sizeof name, "%s", commands[i].name);
        printf("command\t%s\t%s\n", commands[i].name, commands[i].text);
        status = commands[i].run(2, argv);
    }
    return status;
}

/* Letters to insert, drop or replace to turn a into b (Levenshtein 1966), for short words. */
static size_t distance(const char *a, const char *b)
{
    enum { MOST = 32 };
    size_t row[MOST + 1], width = strnlen(b, MOST);
    for (size_t j = 0; j <= width; j++) row[j] = j;
    for (size_t i = 0; i < MOST && a[i]; i++) {
        size_t diagonal = row[0];
        row[0] = i + 1;
        for (size_t j = 1; j <= width; j++) {
            size_t best = diagonal + (a[i] != b[j - 1]);
            diagonal = row[j];
            if (row[j] + 1 < best) best = row[j] + 1;
            if (row[j - 1] + 1 < best) best = row[j - 1] + 1;
            row[j] = best;
        }
    }
    return row[width];
}

static int refuse(const char *name)
{
    const char *nearest = commands[0].name;
    for (size_t i = 1; i < COMMAND_COUNT; i++)
        if (distance(name, commands[i].name) < distance(name, nearest)) nearest = commands[i].name;
    fprintf(stderr, "shearwater: there is no command \"%.64s\"; did you mean \"%s\"?\n", name,
            nearest);
    return 2;
}

int main(int argc, char **argv)
{
    if (argc < 2) {
        print_help(stderr);
        return 2;
    }
    if (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h") || !strcmp(argv[1], "help")) {
        print_help(stdout);
        return 0;
    }
    if (!strcmp(argv[1], "--version")) {
        printf("shearwater %s\n", build_id());
        return 0;
    }
    if (!strcmp(argv[1], OPTION_TEXT_DUMP)) return dump_options();
    for (size_t i = 0; i < COMMAND_COUNT; i++)
        if (!strcmp(argv[1], commands[i].name)) return commands[i].run(argc - 1, argv + 1);
    return refuse(argv[1]);
}
