#include "server/webhook/webhooks.h"

#include <curl/curl.h>
#include <gnutls/gnutls.h>
#include <stdlib.h>
#include <string.h>

#include "proto/link/link_key.h"
#include "proto/runtime/clock.h"
#include "server/webhook/webhook_call.h"
#include "server/webhook/webhook_hosts.h"

#define CALLS_MAX    8
#define DRIVE_MS     20    /* between looks at calls on their way */
#define ANSWER_MS    10000 /* that a call may take */
#define RETRY_MS     5000  /* pause after the first failure; each is four times as long */
#define RETRY_MAX_MS 3600000
#define LOOK_MAX_MS  60000

struct webhooks {
    uv_timer_t look, drive;
    struct log *log;
    struct job_store *store;
    struct webhook_hosts hosts;
    struct link_key key;
    CURLM *multi;
    struct webhook_call *calls[CALLS_MAX]; /* owned; NULL: free */
    long answer_ms;
    int64_t retry_ms;
    bool looking, again; /* the store is asked; and once more after that */
    bool stopping;
    struct webhooks_totals totals;
};

static int64_t now_ms(void)
{
    return (int64_t)(clock_us(CLOCK_REALTIME) / 1000);
}

/* Tests do not wait for hours. */
static long from_environment(const char *name, long otherwise)
{
    const char *text = getenv(name);
    const long ms = text ? strtol(text, NULL, 10) : 0;
    return ms >= 1 && ms <= 86400000 ? ms : otherwise;
}

static void tell(const struct webhooks *w, enum log_level level, const char *what,
                 const struct webhook_row *row, const char *detail)
{
    const struct log_field fields[] = {
        {"job", row->id, 0}, {"tries", NULL, row->tries + 1.0}, {"detail", detail, 0}};
    if (w->log) log_write(w->log, level, what, NULL, fields, 3);
}

static void on_noted(void *ctx, int error)
{
    struct webhooks *w = ctx;
    if (!error) webhooks_soon(w);
}

/* Ends a try: it is over, or comes again. */
static void settle(struct webhooks *w, const struct webhook_row *row, const char *failure)
{
    const uint32_t tries = row->tries + 1;
    int64_t due_ms = -1, pause_ms = w->retry_ms;
    if (!failure) {
        w->totals.delivered++;
        tell(w, LOG_INFO, "webhook delivered", row, "");
    } else if (tries >= WEBHOOK_TRIES) {
        w->totals.given_up++;
        tell(w, LOG_ERROR, "webhook given up", row, failure);
    } else {
        for (uint32_t i = 1; i < tries && pause_ms < RETRY_MAX_MS; i++) pause_ms *= 4;
        due_ms = now_ms() + (pause_ms < RETRY_MAX_MS ? pause_ms : RETRY_MAX_MS);
        w->totals.failed++;
        tell(w, LOG_WARNING, "webhook failed", row, failure);
    }
    job_store_note_webhook(w->store, row->id, tries, due_ms, on_noted, w);
}

static struct webhook_call **call_of(struct webhooks *w, const CURL *curl)
{
    for (int i = 0; i < CALLS_MAX; i++)
        if (w->calls[i] && w->calls[i]->curl == curl) return &w->calls[i];
    return NULL;
}

static void end_call(struct webhooks *w, struct webhook_call **call)
{
    curl_multi_remove_handle(w->multi, (*call)->curl);
    webhook_call_destroy(call);
    w->totals.in_flight--;
}

static void on_drive(uv_timer_t *timer)
{
    struct webhooks *w = timer->data;
    int running, left;
    const CURLMsg *message;
    curl_multi_perform(w->multi, &running);
    while ((message = curl_multi_info_read(w->multi, &left))) {
        char failure[256];
        struct webhook_call **call = call_of(w, message->easy_handle);
        if (message->msg != CURLMSG_DONE || !call) continue;
        const bool done = webhook_call_succeeded(*call, message->data.result, failure);
        settle(w, &(*call)->row, done ? NULL : failure);
        end_call(w, call);
    }
    if (w->totals.in_flight == 0) uv_timer_stop(&w->drive);
}

static bool is_on_its_way(const struct webhooks *w, const char *id)
{
    for (int i = 0; i < CALLS_MAX; i++)
        if (w->calls[i] && strcmp(w->calls[i]->row.id, id) == 0) return true;
    return false;
}

/* False: all calls are taken. */
static bool begin_call(struct webhooks *w, const struct webhook_row *row)
{
    struct webhook_call **place = w->calls;
    while (place < w->calls + CALLS_MAX && *place) place++;
    if (place == w->calls + CALLS_MAX) return false;
    *place = webhook_call_create(row, &w->key, w->answer_ms);
    if (!*place || curl_multi_add_handle(w->multi, (*place)->curl) != CURLM_OK) {
        webhook_call_destroy(place);
        settle(w, row, "no memory for it");
        return true;
    }
    w->totals.in_flight++;
    if (!uv_is_active((uv_handle_t *)&w->drive)) uv_timer_start(&w->drive, on_drive, 0, DRIVE_MS);
    return true;
}

static void on_look(uv_timer_t *timer)
{
    webhooks_soon(timer->data);
}

/* A due time beyond the longest pause was written under another clock, before it was set back or on
 * another host. */
static bool is_early(const struct webhook_row *row, int64_t now)
{
    return row->due_ms > now && row->due_ms - now <= RETRY_MAX_MS;
}

static void on_listed(void *ctx, int error, const struct webhook_row *rows, size_t count)
{
    struct webhooks *w = ctx;
    const int64_t now = now_ms();
    int64_t next_ms = error ? w->retry_ms : count > 0 ? LOOK_MAX_MS : -1;
    w->looking = false;
    if (w->stopping) return;
    for (size_t i = 0; !error && i < count; i++) {
        struct fault fault;
        if (is_on_its_way(w, rows[i].id)) continue;
        if (is_early(&rows[i], now)) {
            if (rows[i].due_ms - now < next_ms) next_ms = rows[i].due_ms - now;
        } else if (webhook_hosts_check(&w->hosts, rows[i].url, &fault) != 0) {
            settle(w, &rows[i], fault.detail); /* the operator has changed the list since */
        } else if (!begin_call(w, &rows[i])) {
            break; /* the end of a call looks again */
        }
    }
    if (w->again) next_ms = 0;
    w->again = false;
    if (next_ms >= 0) uv_timer_start(&w->look, on_look, (uint64_t)next_ms, 0);
}

void webhooks_soon(struct webhooks *w)
{
    if (!w || w->stopping) return;
    if (w->looking) {
        w->again = true;
        return;
    }
    w->looking = true;
    job_store_list_webhooks(w->store, on_listed, w);
}

int webhooks_check(const struct webhooks *w, const char *url, struct fault *fault)
{
    return webhook_hosts_check(w ? &w->hosts : NULL, url, fault);
}

int webhooks_create(const struct webhooks_options *options, struct webhooks **out,
                    struct fault *fault)
{
    struct webhooks *w = calloc(1, sizeof *w);
    if (!w) return fault_set(fault, ERR_MEMORY, "", "no memory for webhooks");
    w->log = options->log;
    w->store = options->store;
    w->answer_ms = from_environment("SHEARWATER_WEBHOOK_MS", ANSWER_MS);
    w->retry_ms = from_environment("SHEARWATER_WEBHOOK_RETRY_MS", RETRY_MS);
    int error = webhook_hosts_read(options->hosts, &w->hosts, fault);
    if (!error) error = link_key_read(options->key_path, &w->key, fault);
    if (!error && !(w->multi = curl_multi_init()))
        error = fault_set(fault, ERR_MEMORY, "", "no memory for webhooks");
    if (error) {
        free(w);
        return error;
    }
    uv_timer_init(options->loop, &w->look);
    uv_timer_init(options->loop, &w->drive);
    w->look.data = w->drive.data = w;
    *out = w;
    uv_timer_start(&w->look, on_look, 0, 0);
    return 0;
}

void webhooks_stop(struct webhooks *w)
{
    if (!w) return;
    w->stopping = true;
    for (int i = 0; i < CALLS_MAX; i++)
        if (w->calls[i]) end_call(w, &w->calls[i]);
    uv_close((uv_handle_t *)&w->look, NULL);
    uv_close((uv_handle_t *)&w->drive, NULL);
}

void webhooks_destroy(struct webhooks **out)
{
    struct webhooks *w = *out;
    *out = NULL;
    if (!w) return;
    curl_multi_cleanup(w->multi);
    gnutls_memset(&w->key, 0, sizeof w->key);
    free(w);
}

void webhooks_totals(const struct webhooks *w, struct webhooks_totals *out)
{
    *out = w ? w->totals : (struct webhooks_totals){0};
}
