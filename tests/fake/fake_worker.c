/* A worker that misbehaves by script, for tests of the coordinator; or one that answers at once,
 * for load tests. Speaks the protocol over a blocking socket and prints what it sees as JSON lines.
 *
 *   fake_worker --connect unix:PATH|HOST:PORT --script NAME
 *               [--threads N] [--seconds S] [--tiles N] [--reconnects N] [--embree VERSION]
 *               [--name NAME]
 *
 * It ends when the link is closed (after N reconnects), after S seconds or N answers. Exit status:
 * 0, 1 when no link could be made, 2 for wrong use, 3 when it was refused. */
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/fake/worker/link.h"
#include "tests/fake/worker/script.h"
#include "tests/fake/worker/talk.h"

static void print_sum(const struct fake *f)
{
    double seconds = (double)(fake_now_ms() - f->started_ms) / 1000.0;
    printf("{\"script\": \"%s\", \"closed\": %s, \"seconds\": %.3f, \"tiles\": %llu, "
           "\"answers\": %llu, \"tiles_per_s\": %.1f, \"accepted\": %llu, \"duplicate\": %llu, "
           "\"stale\": %llu, \"foreign\": %llu, \"corrupt\": %llu}\n",
           f->script->name, f->fd < 0 ? "true" : "false", seconds, (unsigned long long)f->tiles,
           (unsigned long long)f->answers, seconds > 0 ? (double)f->answers / seconds : 0.0,
           (unsigned long long)f->acks[VERDICT_ACCEPTED],
           (unsigned long long)f->acks[VERDICT_DUPLICATE],
           (unsigned long long)f->acks[VERDICT_STALE], (unsigned long long)f->acks[VERDICT_FOREIGN],
           (unsigned long long)f->acks[VERDICT_CORRUPT]);
}

/* Waits for a coordinator that is still starting. */
static bool dial(struct fake *f)
{
    for (int attempt = 0; attempt < 50 && f->fd < 0 && !fake_is_over(f); attempt++) {
        if (attempt > 0) poll(NULL, 0, 100);
        f->fd = link_dial(f->address);
    }
    return f->fd >= 0;
}

static int play(struct fake *f)
{
    bool linked = false;
    f->started_ms = fake_now_ms();
    for (uint64_t links = 0; links <= f->reconnects && !fake_is_over(f) && dial(f); links++) {
        linked = true;
        talk(f);
        if (links < f->reconnects && !fake_is_over(f)) link_lose(f);
    }
    print_sum(f);
    link_lose(f);
    return f->refused ? 3 : linked ? 0 : 1;
}

static int usage(void)
{
    fputs("usage: fake_worker --connect ADDRESS --script NAME [--threads N] [--seconds S]\n"
          "                   [--tiles N] [--reconnects N] [--embree VERSION] [--name NAME]\n",
          stderr);
    script_print_all(stderr);
    return 2;
}

static bool take_option(struct fake *f, const char *name, const char *value)
{
    if (strcmp(name, "--connect") == 0)
        f->address = value;
    else if (strcmp(name, "--embree") == 0)
        f->embree = value;
    else if (strcmp(name, "--name") == 0)
        f->name = value;
    else if (strcmp(name, "--threads") == 0)
        f->threads = (uint32_t)strtoul(value, NULL, 10);
    else if (strcmp(name, "--seconds") == 0)
        f->seconds = strtod(value, NULL);
    else if (strcmp(name, "--tiles") == 0)
        f->tiles_max = strtoull(value, NULL, 10);
    else if (strcmp(name, "--reconnects") == 0)
        f->reconnects = strtoull(value, NULL, 10);
    else if (strcmp(name, "--script") == 0)
        f->script = script_find(value);
    else
        return false;
    return true;
}

int main(int argc, char **argv)
{
    static struct known_frame frames[FAKE_FRAMES];
    struct fake f = {.fd = -1, .threads = 1, .seconds = 60, .embree = "3.13.5", .frames = frames};
    for (int i = 1; i < argc; i += 2)
        if (i + 1 >= argc || !take_option(&f, argv[i], argv[i + 1])) return usage();
    if (!f.address || !f.script || f.threads == 0 || f.threads > LIMIT_THREADS) return usage();
    setvbuf(stdout, NULL, _IOLBF, 0);
    bytes_writer_init(&f.packed);
    int status = play(&f);
    bytes_writer_fini(&f.packed);
    return status;
}
