#include "server/fleet/roster.h"

static const struct {
    enum capability bit;
    const char *name;
} capability_names[] = {
    {CAPABILITY_DIRECT, "direct"},
    {CAPABILITY_INDIRECT, "indirect"},
    {CAPABILITY_VISIBILITY, "visibility"},
    {CAPABILITY_STRATA, "strata"},
    {CAPABILITY_PATHS, "paths"},
    {CAPABILITY_ENVIRONMENT, "environment"},
    {CAPABILITY_LENS, "lens"},
};

unsigned roster_work(const struct session *s, struct fleet_work *out, unsigned most)
{
    unsigned count = 0;
    for (uint32_t i = 0; i < s->leases.count; i++) {
        uint64_t frame = s->leases.at[i].tile.frame_id;
        unsigned at = 0;
        while (at < count && out[at].frame_id != frame) at++;
        if (at == most) continue;
        if (at == count) out[count++] = (struct fleet_work){.frame_id = frame};
        out[at].tiles++;
    }
    return count;
}

static json_t *capabilities(uint32_t bits)
{
    json_t *names = json_array();
    for (size_t i = 0; names && i < sizeof capability_names / sizeof capability_names[0]; i++)
        if (bits & (uint32_t)capability_names[i].bit)
            json_array_append_new(names, json_string(capability_names[i].name));
    return names;
}

static const char *state_of(const struct session *s)
{
    if (s->state == SESSION_DRAINING && s->quarantined_until_ms) return "quarantined";
    if (s->state == SESSION_WORKING && s->stalled) return "stalled";
    if (s->state == SESSION_WORKING && s->leases.count == 0) return "idle";
    return session_state_name(s->state);
}

static const char *phase_of(const struct session *s)
{
    static const char *const names[] = {"idle", "loading", "tracing"};
    return s->beat.phase < sizeof names / sizeof names[0] ? names[s->beat.phase] : "unknown";
}

/* Returns null, or why and for how much longer it gets no tiles. */
static json_t *quarantine_of(const struct session *s, const struct worker_health *health)
{
    const uint64_t now_ms = uv_now(s->handle.any.loop);
    const struct worker_health_record *r =
        s->quarantined_until_ms ? worker_health_quarantine(health, s->hello.name, s->local, now_ms)
                                : NULL;
    if (!r) return json_null();
    return json_pack("{ss sf}", "reason", strike_text(r->last), "seconds_left",
                     (double)(r->until_ms - now_ms) / 1000.0);
}

json_t *roster_entry(const struct session *s, const struct worker_health *health)
{
    const struct message_hello *h = &s->hello;
    const struct message_beat *b = &s->beat;
    return json_pack("{sI ss ss ss so sb si sI ss ss ss so si sI sI sf sf sI sI sI sI sI}", /**/
                     "id", (json_int_t)s->id, "name", h->name, "state", state_of(s), "phase",
                     phase_of(s), "quarantine", quarantine_of(s, health), "local", (int)s->local,
                     "threads", (int)h->threads, "pid", (json_int_t)h->pid, "isa", h->isa, "build",
                     h->build_id, "embree", h->embree_version, "capabilities",
                     capabilities(h->capabilities), "tiles_in_hand", (int)s->leases.count,
                     "tiles_done", (json_int_t)s->answered, "rays", (json_int_t)s->rays,
                     "tiles_per_s", s->tiles_per_s, "rays_per_s", s->rays_per_s, "bytes_received",
                     (json_int_t)s->received_bytes, "bytes_sent", (json_int_t)s->sent_bytes,
                     "rss_bytes", (json_int_t)b->rss_bytes, "peak_rss_bytes",
                     (json_int_t)b->peak_rss_bytes, "cpu_us", (json_int_t)b->cpu_us);
}
