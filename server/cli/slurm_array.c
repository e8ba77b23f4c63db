#include "server/cli/slurm_array.h"

#include <errno.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define MOST_S    (365u * 24u * 3600u)
#define SIGNAL_S  60u /* before the time limit; Slurm may be up to a minute early */
#define RESERVE_S 30u /* of the time limit, in which a worker must be gone */

extern char **environ;

/* ---- times ---- */

/* Reads up to `most` numbers with ':' between them. Returns how many, 0 for anything else. */
static int read_numbers(const char *text, unsigned long *numbers, int most)
{
    for (int count = 0; count < most;) {
        char *end = NULL;
        if (*text < '0' || *text > '9' || strspn(text, "0123456789") > 9) return 0;
        numbers[count++] = strtoul(text, &end, 10);
        if (*end == '\0') return count;
        if (*end != ':') return 0;
        text = end + 1;
    }
    return 0;
}

/* Returns the seconds; 0: it is no time. */
static uint64_t time_of(const char *text)
{
    unsigned long days = 0, n[3] = {0};
    const char *dash = strchr(text, '-');
    char *end = NULL;
    if (!dash) {
        switch (read_numbers(text, n, 3)) {
        case 1:
            return 60ull * n[0];
        case 2:
            return 60ull * n[0] + n[1];
        case 3:
            return 3600ull * n[0] + 60ull * n[1] + n[2];
        default:
            return 0;
        }
    }
    if (*text < '0' || *text > '9' || dash - text > 4) return 0;
    days = strtoul(text, &end, 10);
    if (end != dash || read_numbers(dash + 1, n, 3) == 0) return 0;
    return 86400ull * days + 3600ull * n[0] + 60ull * n[1] + n[2];
}

int slurm_array_read_time(const char *text, uint32_t *time_s, struct fault *fault)
{
    const uint64_t s = time_of(text);
    if (s == 0)
        return fault_set(fault, ERR_SYNTAX, "--time",
                         "\"%.64s\" is no time: MINUTES, H:M:S or D-H:M:S", text);
    if (s < SLURM_ARRAY_MIN_S || s > MOST_S)
        return fault_set(fault, ERR_RANGE, "--time", "%.64s is not between 2 minutes and 365 days",
                         text);
    *time_s = (uint32_t)s;
    return 0;
}

/* ---- the script ---- */

static int check_text(const char *name, const char *text, struct fault *fault)
{
    if (!text) return 0;
    for (const char *c = text; *c; c++)
        if ((unsigned char)*c < ' ' || *c == 0x7f)
            return fault_set(fault, ERR_SYNTAX, name, "it has a control character");
    return 0;
}

int slurm_array_check(const struct slurm_array *array, struct fault *fault)
{
    const char *colon = strrchr(array->connect, ':');
    if (!colon || colon == array->connect || strncmp(array->connect, "unix:", 5) == 0)
        return fault_set(fault, ERR_SYNTAX, "--connect",
                         "\"%.64s\" is not HOST:PORT, as nodes reach the coordinator",
                         array->connect);
    int error = check_text("--connect", array->connect, fault);
    if (!error) error = check_text("--key", array->key, fault);
    if (!error) error = check_text("--program", array->program, fault);
    return error ? error : check_text("SHEARWATER_ISA", array->isa, fault);
}

/* Writes a word as the shell reads it back: 'it'\''s'. */
static void write_word(FILE *out, const char *text)
{
    putc('\'', out);
    for (; *text; text++)
        if (*text == '\'')
            fputs("'\\''", out);
        else
            putc(*text, out);
    putc('\'', out);
}

static void write_head(const struct slurm_array *a, FILE *out)
{
    const unsigned s = a->time_s;
    fprintf(out,
            "#!/bin/bash\n"
            "# Workers of a Shearwater coordinator, one in each task.\n"
            "#SBATCH --job-name=shearwater-worker\n"
            "#SBATCH --array=1-%ld\n"
            "#SBATCH --ntasks=1\n"
            "#SBATCH --cpus-per-task=%ld\n"
            "#SBATCH --time=%u-%02u:%02u:%02u\n"
            "#SBATCH --requeue\n"
            "#SBATCH --open-mode=append\n"
            "#SBATCH --output=shearwater-worker-%%A_%%a.log\n"
            "#SBATCH --export=PATH,HOME,LD_LIBRARY_PATH\n"
            "#SBATCH --signal=B:USR1@%u\n",
            a->jobs, a->cpus, s / 86400, s / 3600 % 24, s / 60 % 60, s % 60, SIGNAL_S);
}

/* The worker drains when it is told to by SIGTERM, and leaves at once when it is told twice. Slurm
 * sends SIGTERM to all processes of a task that it ends, but SIGUSR1 to the shell alone. */
static void write_run(const struct slurm_array *a, FILE *out)
{
    fprintf(
        out,
        "    --threads %ld --lifetime %u --idle-exit %ld --connect-within %ld \\\n"
        "    --cache \"$cache\" &\n"
        "worker=$!\n"
        "# Before the time limit Slurm sends SIGUSR1 to this shell alone, and the worker drains.\n"
        "# What ends a task (scancel, preemption) sends SIGTERM to the worker, too.\n"
        "trap 'kill -TERM \"$worker\"' USR1\n"
        "trap : TERM\n"
        "while wait \"$worker\"; status=$?; kill -0 \"$worker\" 2>/dev/null; do :; done\n"
        "exit \"$status\"\n",
        a->cpus, a->time_s - RESERVE_S, a->idle_exit_s, a->connect_within_s);
}

int slurm_array_write(const struct slurm_array *a, FILE *out)
{
    write_head(a, out);
    fputs("umask 077\n"
          "cache=$(mktemp -d \"${SLURM_TMPDIR:-${TMPDIR:-/tmp}}/shearwater-worker.XXXXXX\") || "
          "exit 1\n"
          "trap 'rm -rf \"$cache\"' EXIT\n",
          out);
    if (a->isa) {
        fputs("export SHEARWATER_ISA=", out);
        write_word(out, a->isa);
        putc('\n', out);
    }
    write_word(out, a->program);
    fputs(" --connect ", out);
    write_word(out, a->connect);
    fputs(" --key ", out);
    write_word(out, a->key);
    fputs(" \\\n", out);
    write_run(a, out);
    return fflush(out) == 0 && !ferror(out) ? 0 : ERR_IO;
}

/* ---- sbatch ---- */

static int run_sbatch(int script, struct fault *fault)
{
    char name[] = "sbatch", option[] = "--parsable", *argv[] = {name, option, NULL};
    posix_spawn_file_actions_t actions;
    pid_t child = -1;
    int status = 0;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, script, STDIN_FILENO);
    const int failed = posix_spawnp(&child, name, &actions, NULL, argv, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed)
        return fault_set(fault, failed == ENOENT ? ERR_NOT_FOUND : ERR_IO, "sbatch",
                         "%s: is Slurm installed here? --print prints the script",
                         strerror(failed));
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR) return fault_set(fault, ERR_IO, "sbatch", "%s", strerror(errno));
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return 0;
    return fault_set(fault, ERR_STATE, "sbatch", "it has not taken the script");
}

int slurm_array_submit(const struct slurm_array *array, struct fault *fault)
{
    FILE *script = tmpfile();
    if (!script) return fault_set(fault, ERR_IO, "script", "%s", strerror(errno));
    int error = slurm_array_write(array, script);
    if (error)
        fault_set(fault, error, "script", "%s", strerror(errno));
    else if (fseek(script, 0, SEEK_SET) != 0)
        error = fault_set(fault, ERR_IO, "script", "%s", strerror(errno));
    else
        error = run_sbatch(fileno(script), fault);
    fclose(script);
    return error;
}
