/* /metrics: Prometheus' text format, base units. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/runtime/build.h"
#include "server/http/request.h"
#include "server/http/resource/demand.h"
#include "server/http/resource/metric_text.h"
#include "server/http/resource/metrics_host.h"

static void cpu(FILE *out, const char *stage, uint64_t us)
{
    fprintf(out, "shearwater_cpu_seconds_total{stage=\"%s\"} %.6f\n", stage, (double)us * 1e-6);
}

static void write_build(FILE *out)
{
    const char *isa = build_isa();
    metric_family(out, "shearwater_build_info", "gauge", "What this build is; always 1.");
    fprintf(out, "shearwater_build_info{build=\"%s\",isa=\"%s\"} 1\n", build_id(),
            isa ? isa : "none");
}

static void write_jobs(FILE *out, const struct jobs_totals *t)
{
    const struct metric_sample now[] = {{"queued", t->queued},
                                        {"importing", t->importing},
                                        {"running", t->running},
                                        {"resting", t->resting}};
    const struct metric_sample ended[] = {
        {"finished", t->finished}, {"failed", t->failed}, {"cancelled", t->cancelled}};
    metric_family(out, "shearwater_jobs", "gauge", "Jobs that have not ended, by state.");
    metric_labelled(out, "shearwater_jobs", "state", now, sizeof now / sizeof now[0]);
    metric_family(out, "shearwater_jobs_ended_total", "counter", "Jobs that have ended, by state.");
    metric_labelled(out, "shearwater_jobs_ended_total", "state", ended, 3);
    metric_single(out, "shearwater_jobs_submitted_total", "counter", "Jobs accepted.",
                  t->submitted);
    metric_single(out, "shearwater_tiles_done_total", "counter", "Tiles whose samples landed.",
                  t->tiles_done);
    metric_single(out, "shearwater_tiles_reissued_total", "counter", "Tiles leased again.",
                  t->tiles_reissued);
    metric_single(out, "shearwater_tiles_copied_total", "counter",
                  "Tiles given to a second worker, since the first was late.", t->tiles_copied);
    metric_single(
        out, "shearwater_tiles_resumed_total", "counter",
        "Tiles taken from disk after a restart or a pause, in place of being traced again.",
        t->tiles_resumed);
    metric_single(out, "shearwater_results_dropped_total", "counter",
                  "Results that were late, duplicate or foreign.", t->results_dropped);
    metric_single(out, "shearwater_samples_rejected_total", "counter",
                  "Samples that were not finite.", t->samples_rejected);
}

static void write_group(FILE *out, const struct counters *c, const char *group, const char *name,
                        const char *label)
{
    for (int i = 0; i < COUNTER_COUNT; i++)
        if (strcmp(counter_group((enum counter_id)i), group) == 0)
            fprintf(out, "%s{%s=\"%s\"} %" PRIu64 "\n", name, label,
                    counter_key((enum counter_id)i), c->value[i]);
}

static void write_work(FILE *out, const struct jobs_totals *t)
{
    metric_family(out, "shearwater_rays_total", "counter", "Rays traced since the start, by kind.");
    write_group(out, &t->counters, "rays", "shearwater_rays_total", "kind");
    metric_family(out, "shearwater_skipped_total", "counter",
                  "Work that was not needed, by reason.");
    write_group(out, &t->counters, "skipped", "shearwater_skipped_total", "reason");
    metric_family(out, "shearwater_cpu_seconds_total", "counter", "CPU time of jobs, by stage.");
    cpu(out, "import", t->import_cpu_us);
    cpu(out, "build", t->counters.value[COUNTER_BUILD_CPU_US]);
    cpu(out, "trace", t->counters.value[COUNTER_TRACE_CPU_US]);
    cpu(out, "pack", t->counters.value[COUNTER_PACK_CPU_US]);
    cpu(out, "decode", t->decode_cpu_us);
    cpu(out, "reconstruct", t->reconstruct_cpu_us);
    cpu(out, "shadow", t->shadow_cpu_us);
    cpu(out, "indirect", t->indirect_cpu_us);
    cpu(out, "glossy", t->glossy_cpu_us);
    cpu(out, "lens", t->lens_cpu_us);
    cpu(out, "lens_relight", t->lens_relight_cpu_us);
    cpu(out, "residual", t->residual_cpu_us);
    cpu(out, "oidn", t->oidn_cpu_us);
    cpu(out, "encode", t->encode_cpu_us);
    cpu(out, "coordinate", t->coordinate_cpu_us);
}

static void write_fleet(FILE *out, const struct fleet *fleet)
{
    struct fleet_totals t;
    fleet_totals(fleet, &t);
    const struct metric_sample verdicts[] = {{"accepted", t.results},
                                             {"stale", t.stale},
                                             {"duplicate", t.duplicate},
                                             {"foreign", t.foreign},
                                             {"corrupt", t.corrupt}};
    metric_single(out, "shearwater_workers", "gauge", "Workers that may work.", fleet_count(fleet));
    metric_family(out, "shearwater_results_total", "counter", "Results that came, by verdict.");
    metric_labelled(out, "shearwater_results_total", "verdict", verdicts, 5);
    metric_single(out, "shearwater_leases_returned_total", "counter",
                  "Tiles that came back unfinished.", t.returned);
    metric_single(out, "shearwater_workers_refused_total", "counter", "Workers turned away.",
                  t.refused);
    struct metric_sample strikes[STRIKE_COUNT];
    for (int i = 0; i < STRIKE_COUNT; i++)
        strikes[i] = (struct metric_sample){strike_name((enum strike)i), t.strikes[i]};
    metric_family(out, "shearwater_worker_strikes_total", "counter",
                  "Strikes of workers, by kind.");
    metric_labelled(out, "shearwater_worker_strikes_total", "kind", strikes, STRIKE_COUNT);
    metric_single(out, "shearwater_workers_quarantined_total", "counter",
                  "Workers put into quarantine, each after three strikes.", t.quarantined);
    metric_single(out, "shearwater_workers_respawned_total", "counter",
                  "Local workers started again.", t.respawned);
    metric_single(out, "shearwater_link_received_bytes_total", "counter", "Bytes from workers.",
                  t.bytes_received);
    metric_single(out, "shearwater_link_sent_bytes_total", "counter", "Bytes to workers.",
                  t.bytes_sent);
    metric_single(out, "shearwater_worker_resident_peak_bytes", "gauge",
                  "Most memory that any worker has held.", t.peak_rss_bytes);
}

static void write_demand(FILE *out, const struct http *http)
{
    const struct demand d = demand_now(http);
    metric_single(out, "shearwater_tiles_waiting", "gauge",
                  "Tiles of frames in work that no worker holds.", d.tiles_waiting);
    metric_single(out, "shearwater_tiles_leased", "gauge", "Tiles that workers hold.",
                  d.tiles_leased);
    metric_single(out, "shearwater_threads_wanted", "gauge",
                  "Threads of workers that would have a tile now; a job that waits counts as one.",
                  d.threads_wanted);
    metric_single(out, "shearwater_worker_threads", "gauge", "Threads of workers that may work.",
                  d.threads);
}

/* "none" for requests that met no route. */
static const char *path_of(int route)
{
    return route < ROUTE_COUNT ? route_of((enum route_id)route)->path : "none";
}

static const char *method_of(int route)
{
    return route < ROUTE_COUNT ? method_name(route_of((enum route_id)route)->method) : "none";
}

static void write_route(FILE *out, const struct http *http, int route)
{
    for (unsigned i = 0; i < STATUS_COUNT; i++)
        if (http->count.ended[route][i])
            fprintf(out,
                    "shearwater_http_requests_total{method=\"%s\",route=\"%s\",status=\"%u\"} "
                    "%" PRIu64 "\n",
                    method_of(route), path_of(route), STATUS_FIRST + i,
                    http->count.ended[route][i]);
}

static void write_http(FILE *out, const struct http *http)
{
    metric_family(out, "shearwater_http_requests_total", "counter",
                  "Requests, by route and status.");
    for (int route = 0; route <= ROUTE_COUNT; route++) write_route(out, http, route);
    metric_family(out, "shearwater_http_request_duration_seconds", "histogram",
                  "Time from request line to end of answer, without streams, by route.");
    for (int route = 0; route <= ROUTE_COUNT; route++) {
        char labels[128];
        snprintf(labels, sizeof labels, "method=\"%s\",route=\"%s\"", method_of(route),
                 path_of(route));
        metric_histogram(out, "shearwater_http_request_duration_seconds", labels,
                         &http->count.durations[route]);
    }
    metric_single(out, "shearwater_http_connections", "gauge", "Open connections.",
                  http->connections);
    metric_single(out, "shearwater_http_connections_cut_total", "counter",
                  "Connections ended for want of room before their request was whole.",
                  http->connections_cut);
    metric_single(
        out, "shearwater_http_waiting", "gauge",
        "Requests that wait for the store, the pool or the importer, including those already "
        "answered 503 overdue.",
        http->pending.count);
    metric_single(out, "shearwater_http_overdue_total", "counter", "Requests answered 503 overdue.",
                  http->pending.overdue);
    metric_single(out, "shearwater_http_log_lines_total", "counter",
                  "Complaints of the HTTP library about connections.", http->log_lines);
}

static void write_stream_cpu(FILE *out, const struct streams_totals *t)
{
    metric_family(out, "shearwater_stream_cpu_seconds_total", "counter",
                  "CPU time that streams have taken, sockets' work included (--stream-share).");
    fprintf(out, "shearwater_stream_cpu_seconds_total{kind=\"events\"} %.6f\n",
            1e-6 * (double)t->events_cpu_us);
    fprintf(out, "shearwater_stream_cpu_seconds_total{kind=\"pixels\"} %.6f\n",
            1e-6 * (double)t->pixels_cpu_us);
}

static void write_streams(FILE *out, struct streams *streams)
{
    struct streams_totals t;
    streams_totals(streams, &t);
    const struct metric_sample cut[] = {{"events", t.cut_events}, {"pixels", t.cut_pixels}};
    metric_single(out, "shearwater_stream_readers", "gauge", "Readers of events and pixels.",
                  t.readers);
    metric_family(out, "shearwater_stream_readers_cut_total", "counter",
                  "Readers disconnected because they took nothing or fell too far behind.");
    metric_labelled(out, "shearwater_stream_readers_cut_total", "kind", cut, 2);
    metric_single(out, "shearwater_feed_bytes_total", "counter", "Bytes of pixel feeds.",
                  t.pixel_bytes);
    metric_single(out, "shearwater_feed_blocks_made_total", "counter",
                  "Blocks converted for feeds of pictures in work.", t.blocks_made);
    metric_single(out, "shearwater_feed_blocks_sent_total", "counter",
                  "Blocks that such feeds began to send; one may go to many.", t.blocks_sent);
    metric_single(out, "shearwater_feed_kept_bytes", "gauge",
                  "Memory of blocks that are kept for all feeds of a layer.", t.kept_bytes);
    metric_single(out, "shearwater_feed_waits_total", "counter",
                  "Turns of feeds that waited for --feed-rate or --stream-share.", t.waits);
    metric_single(out, "shearwater_events_late_total", "counter",
                  "Times that progress waited for --stream-share.", t.tells_late);
    write_stream_cpu(out, &t);
}

static void write_webhooks(FILE *out, const struct webhooks *webhooks)
{
    struct webhooks_totals t;
    webhooks_totals(webhooks, &t);
    const struct metric_sample outcomes[] = {
        {"delivered", t.delivered}, {"failed", t.failed}, {"given_up", t.given_up}};
    metric_family(out, "shearwater_webhooks_total", "counter",
                  "Calls that told of a job's end; those that failed are repeated.");
    metric_labelled(out, "shearwater_webhooks_total", "outcome", outcomes, 3);
    metric_single(out, "shearwater_webhooks_in_flight", "gauge", "Such calls on their way.",
                  t.in_flight);
}

void route_metrics(struct request *r)
{
    char *text = NULL;
    size_t size_bytes = 0;
    struct jobs_totals totals;
    FILE *out = open_memstream(&text, &size_bytes);
    if (!out) {
        request_trouble(r, ERR_MEMORY, NULL);
        return;
    }
    jobs_totals(r->http->options.jobs, &totals);
    write_build(out);
    write_jobs(out, &totals);
    write_work(out, &totals);
    write_fleet(out, r->http->options.fleet);
    write_demand(out, r->http);
    write_http(out, r->http);
    write_streams(out, r->http->options.streams);
    write_webhooks(out, r->http->options.webhooks);
    metrics_store(out, r->http);
    metrics_log(out, r->http->options.log);
    metrics_host(out, r->http);
    if (fclose(out) != 0) {
        free(text);
        request_trouble(r, ERR_MEMORY, NULL);
        return;
    }
    struct MHD_Response *response =
        response_of_taken(text, size_bytes, "text/plain; version=0.0.4; charset=utf-8");
    if (response) response_header(response, "Cache-Control", "no-store");
    request_answer(r, 200, response);
}
