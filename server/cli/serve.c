#include "server/cli/serve.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>
#include <uv.h>

#include "proto/runtime/build.h"
#include "server/cli/cli.h"
#include "server/cli/coordinator.h"
#include "server/cli/option.h"

static struct log server_log = {.fd = STDERR_FILENO};

static void tell(enum log_level level, const char *what, const char *detail)
{
    const struct log_field field = {"detail", detail, 0};
    log_write(&server_log, level, what, NULL, &field, 1);
}

static void on_stopping(int signal)
{
    tell(LOG_INFO, "stopping", strsignal(signal));
}

static void log_fault(const char *what, const struct fault *fault)
{
    char text[LIMIT_POINTER_BYTES + LIMIT_DETAIL_BYTES + 2];
    snprintf(text, sizeof text, "%s%s%s", fault->pointer, fault->pointer[0] ? ": " : "",
             fault->detail[0] ? fault->detail : error_text(fault->code));
    tell(LOG_ERROR, what, text);
}

static int refuse(const struct fault *fault)
{
    log_fault("cannot serve", fault);
    return 1;
}

static void on_reloaded(size_t count, const struct fault *fault)
{
    const struct log_field field = {"tokens", NULL, (double)count};
    if (fault)
        log_fault("tokens kept as they were", fault);
    else
        log_write(&server_log, LOG_INFO, "tokens read again", NULL, &field, 1);
}

/* Prints the line that `render` and other parents wait for. */
static void announce(const struct coordinator *c, const struct coordinator_options *options)
{
    const char *listen = options->listen;
    int host = (int)(strrchr(listen, ':') - listen);
    printf("listening on %s://%.*s:%d\n", options->key ? "https" : "http", host, listen,
           coordinator_http_port(c));
    fflush(stdout);
    const struct log_field fields[] = {{"build", build_id(), 0},
                                       {"pid", NULL, getpid()},
                                       {"workers", NULL, options->workers},
                                       {"worker_port", NULL, coordinator_worker_port(c)},
                                       {"data", options->directories->data, 0}};
    log_write(&server_log, LOG_INFO, "serving", NULL, fields, sizeof fields / sizeof fields[0]);
}

static int serve(const struct coordinator_options *options)
{
    struct coordinator *c;
    struct fault fault = {0};
    int error = coordinator_create(options, &c, &fault);
    if (error) return refuse(&fault);
    announce(c, options);
    coordinator_run(c, on_stopping);
    coordinator_destroy(&c);
    tell(LOG_INFO, "stopped", "");
    return 0;
}

struct serve_choices {
    const char *listen, *data, *worker_listen, *web, *tokens, *cert, *key, *worker_key, *format,
        *webhook_hosts, *webhook_key;
    bool with_parent, ephemeral, unwatched, quiet;
    long tenant_jobs, tenant_assets_mib, threads, workers, feed_mb_per_s, stream_share;
};

static int parse(struct serve_choices *o, int argc, char **argv)
{
    const struct option_line lines[] = {
        {"listen", 0, OPTION_TEXT, "ADDR:PORT",
         "HTTP address (default: " SERVE_LISTEN "); port 0 picks a free port. Other addresses than "
         "loopback need --tokens and TLS",
         0, 0, &o->listen},
        {"tokens", 0, OPTION_TEXT, "FILE",
         "access tokens, made by `shearwater token`; SIGHUP reads them again (default: no tokens, "
         "every user of this machine may do everything)",
         0, 0, &o->tokens},
        {"tenant-jobs", 0, OPTION_NUMBER, "N", "unfinished jobs per tenant (default: unlimited)", 1,
         LIMIT_JOBS_WAITING, &o->tenant_jobs},
        {"tenant-assets", 0, OPTION_NUMBER, "MIB", "MiB of assets per tenant (default: unlimited)",
         1, 1 << 30, &o->tenant_assets_mib},
        {"tls-cert", 0, OPTION_TEXT, "FILE.pem", "the server's certificate with its chain", 0, 0,
         &o->cert},
        {"tls-key", 0, OPTION_TEXT, "FILE.pem", "the certificate's private key", 0, 0, &o->key},
        {"data", 0, OPTION_TEXT, "DIR",
         "directory of jobs, assets and results (default: "
         "${XDG_DATA_HOME:-~/.local/share}/shearwater)",
         0, 0, &o->data},
        {"workers", 0, OPTION_NUMBER, "N",
         "local workers (default: 1; the threads of a worker share a scene)", 0, LIMIT_WORKERS,
         &o->workers},
        {"worker-threads", 0, OPTION_NUMBER, "N",
         "threads per local worker (default: the cores, divided among the workers)", 1,
         LIMIT_THREADS, &o->threads},
        {"worker-listen", 0, OPTION_TEXT, "ADDR:PORT",
         "TCP address for workers on other machines (default: none). Other addresses than loopback "
         "need --worker-key",
         0, 0, &o->worker_listen},
        {"worker-key", 0, OPTION_TEXT, "FILE",
         "key that workers over TCP must have: 64 hexadecimal digits (openssl rand -hex 32)", 0, 0,
         &o->worker_key},
        {"webhook-hosts", 0, OPTION_TEXT, "HOST[:PORT],...",
         "hosts that jobs may have told of their end (default: none). Without a port it is that of "
         "https or http. Needs --webhook-key",
         0, 0, &o->webhook_hosts},
        {"webhook-key", 0, OPTION_TEXT, "FILE",
         "key that signs what they are told: 64 hexadecimal digits (openssl rand -hex 32)", 0, 0,
         &o->webhook_key},
        {"feed-rate", 0, OPTION_NUMBER, "MB",
         "total MB/s for pixel feeds while rendering, once there are more than 8 of them "
         "(default: 24; 0: unlimited)",
         0, 1000000, &o->feed_mb_per_s},
        {"stream-share", 0, OPTION_NUMBER, "PERCENT",
         "CPU time for event streams and pixel feeds while rendering, percent of all cores "
         "(default: 3; 0: unlimited)",
         0, 100, &o->stream_share},
        {"web", 0, OPTION_TEXT, "DIR", "directory of the viewer's files (default: those installed)",
         0, 0, &o->web},
        {"log-format", 0, OPTION_TEXT, "text|json",
         "format of the log on standard error; json: one object per line (default: text)", 0, 0,
         &o->format},
        {"quiet", 'q', OPTION_FLAG, NULL, "log errors only", 0, 0, &o->quiet},
        {"ephemeral", 0, OPTION_FLAG, NULL,
         "temporary data directory: skip fsync, keep no tiles for a restart", 0, 0, &o->ephemeral},
        {"unwatched", 0, OPTION_FLAG, NULL,
         "nobody looks at pictures in work: draw each part once, with all its samples", 0, 0,
         &o->unwatched},
        {"exit-with-parent", 0, OPTION_FLAG, NULL, "stop when the parent process ends", 0, 0,
         &o->with_parent},
    };
    const struct option_table table = {
        .usage = "shearwater serve [options]",
        .summary =
            "Runs the coordinator with local workers. It prints \"listening on URL\" when it "
            "is ready. SIGTERM or Ctrl-C stops it in order.",
        .lines = lines,
        .line_count = sizeof lines / sizeof lines[0],
    };
    int arguments;
    return option_parse(&table, argc, argv, &arguments);
}

/* Checks options against each other. Returns false after a message on standard error. */
static bool go_together(const struct serve_choices *o)
{
    if (!o->cert != !o->key)
        fprintf(stderr, "--tls-cert and --tls-key go together\n");
    else if (!o->webhook_hosts != !o->webhook_key)
        fprintf(stderr, "--webhook-hosts and --webhook-key go together\n");
    else if (!log_format_from_name(o->format, &server_log.format))
        fprintf(stderr, "--log-format is text or json, not \"%.64s\"\n", o->format);
    else if ((o->tenant_jobs || o->tenant_assets_mib) && !o->tokens)
        fprintf(stderr, "--tenant-jobs and --tenant-assets need --tokens\n");
    else
        return true;
    return false;
}

int cli_serve(int argc, char **argv)
{
    static struct directories directories;
    const long cores = (long)uv_available_parallelism();
    struct serve_choices o = {.listen = SERVE_LISTEN,
                              .format = "text",
                              .workers = 1,
                              .feed_mb_per_s = 24,
                              .stream_share = 3};
    struct fault fault = {0};
    int status = parse(&o, argc, argv);
    if (status != OPTION_GO_ON) return status;
    if (!go_together(&o)) return 2;
    if (o.quiet) server_log.least = LOG_ERROR;
    signal(SIGPIPE, SIG_IGN);
    if (o.with_parent) prctl(PR_SET_PDEATHSIG, SIGTERM);
    log_begin(&server_log);
    if (directories_find(o.data, o.web, &directories, &fault) != 0) {
        status = refuse(&fault);
        log_end(&server_log);
        return status;
    }
    if (o.threads == 0 && o.workers > 0) o.threads = (cores + o.workers - 1) / o.workers;
    const struct coordinator_options options = {.log = &server_log,
                                                .directories = &directories,
                                                .listen = o.listen,
                                                .tokens = o.tokens,
                                                .tenant_jobs = (unsigned)o.tenant_jobs,
                                                .tenant_assets_mib = (unsigned)o.tenant_assets_mib,
                                                .feed_mb_per_s = (unsigned)o.feed_mb_per_s,
                                                .stream_share_percent = (unsigned)o.stream_share,
                                                .certificate = o.cert,
                                                .key = o.key,
                                                .reloaded = on_reloaded,
                                                .worker_listen = o.worker_listen,
                                                .worker_key = o.worker_key,
                                                .webhook_hosts = o.webhook_hosts,
                                                .webhook_key = o.webhook_key,
                                                .workers = (unsigned)o.workers,
                                                .worker_threads = (unsigned)o.threads,
                                                .pool_threads = (unsigned)cores,
                                                .ephemeral = o.ephemeral,
                                                .unwatched = o.unwatched};
    status = serve(&options);
    directories_leave(&directories);
    log_end(&server_log);
    return status;
}
