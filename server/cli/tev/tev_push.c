#include "server/cli/tev/tev_push.h"

#include <curl/curl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "proto/job/job.h"
#include "server/cli/client/client.h"
#include "server/cli/client/pixel_parser.h"
#include "server/image/image.h"

#define PAUSE_MS       500
#define LOST_PAUSE_MS  250 /* before a tev that hung up is called again */
#define EMPTY_TRIES    20  /* rounds without a block before the coordinator is given up */
#define RECONNECTS     20  /* of tev, a pause apart */
#define LAYERS_MAX     32  /* bits of enum layer */
#define STILL_REVISION 1u  /* of a whole picture that will not change any more */

#define FEED_CHANNELS 4 /* colours and alpha: of ids, which have more, tev gets the colours */

_Static_assert(LAYERS_MAX *FEED_CHANNELS <= TEV_CHANNELS_MAX, "tev has room for all");

/* One layer's feed. */
struct feed {
    struct tev_push *push;
    char layer[32];
    const char *channels[FEED_CHANNELS]; /* names, borrowed from `names` of the push */
    uint32_t channel_count;
    uint64_t revision;           /* what has gone out; 0: nothing */
    int32_t width_px, height_px; /* of the picture whose blocks come; 0: not told yet */
    bool live;                   /* views were told: they have tev's image's size */
    struct pixel_parser parser;
    CURL *curl; /* while it is read */
};

struct tev_push {
    char base_url[512], job[40], name[TEV_NAME_BYTES];
    struct tev_link link;
    struct client *client;
    struct image *names; /* a pixel, for its channels' names */
    struct feed feeds[LAYERS_MAX];
    uint32_t count;
    int32_t width_px, height_px; /* of tev's image; 0: none yet */
    struct tev_packet packet;
    float *numbers; /* owned: a block as tev gets it */
    size_t held;
    uint64_t blocks; /* sent so far */
    pthread_t thread;
    int error;
    struct fault fault;
};

static void pause_ms(long ms)
{
    nanosleep(&(struct timespec){.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000}, NULL);
}

/* Creates an image of all channels in tev, and replaces the one of that name. */
static bool create_image(struct tev_push *p, int32_t width, int32_t height)
{
    const char *channels[TEV_CHANNELS_MAX];
    uint32_t count = 0;
    for (uint32_t k = 0; k < p->count; k++)
        for (uint32_t c = 0; c < p->feeds[k].channel_count; c++)
            channels[count++] = p->feeds[k].channels[c];
    p->error = tev_packet_create(&p->packet, p->name, width, height, channels, count);
    if (p->error || tev_link_send(&p->link, &p->packet) != 0) return false;
    p->width_px = width;
    p->height_px = height;
    for (uint32_t k = 0; k < p->count; k++) p->feeds[k].revision = 0;
    return true;
}

static bool make_room(struct tev_push *p, size_t count)
{
    float *grown = count > p->held ? realloc(p->numbers, count * sizeof *grown) : p->numbers;
    if (!grown) {
        p->error = ERR_MEMORY;
        return false;
    }
    if (count > p->held) p->held = count;
    p->numbers = grown;
    return true;
}

/* Colours as they come, alpha behind them; of a layer of one number one of the three. */
static bool send_block(struct feed *f, const struct pixel_block *b)
{
    struct tev_push *p = f->push;
    const size_t area = (size_t)rect_area(b->rect), held = area * f->channel_count;
    const int64_t behind = 3 * (int64_t)area;
    const int64_t offset[4] = {0, 1, 2, behind}, stride[4] = {3, 3, 3, 1}, one[1] = {1};
    if (!make_room(p, held)) return false;
    if (f->channel_count == 1)
        for (size_t i = 0; i < area; i++) p->numbers[i] = b->numbers[3 * i];
    else
        memcpy(p->numbers, b->numbers, 3 * area * sizeof *p->numbers);
    for (size_t i = 0; i < area && f->channel_count == 4; i++)
        p->numbers[3 * area + i] = b->alpha ? b->alpha[i] : 1.0f;
    p->error = tev_packet_update(&p->packet, p->name, b->rect, f->channels, f->channel_count,
                                 offset, f->channel_count == 1 ? one : stride, p->numbers, held);
    if (p->error || tev_link_send(&p->link, &p->packet) != 0) return false;
    p->blocks++;
    return true;
}

/* A live job's pictures have several sizes, and each feed goes through them at its own time. */
static bool take_size(struct feed *f, const struct pixel_block *b)
{
    struct tev_push *p = f->push;
    if (b->view > 0) {
        f->live = true;
    } else {
        f->width_px = b->width_px;
        f->height_px = b->height_px;
        if (f->live) return true;
    }
    if (b->width_px == p->width_px && b->height_px == p->height_px) return true;
    return create_image(p, b->width_px, b->height_px);
}

/* Coarser pictures than tev's are left out. */
static bool take_block(struct feed *f, const struct pixel_block *b)
{
    const struct tev_push *p = f->push;
    if (b->rect.x1 > f->width_px || b->rect.y1 > f->height_px) return false;
    if (f->width_px != p->width_px || f->height_px != p->height_px) return true;
    return send_block(f, b);
}

static bool take(void *ctx, const struct pixel_block *b)
{
    struct feed *f = ctx;
    if (!(rect_is_empty(b->rect) ? take_size(f, b) : take_block(f, b))) return false;
    f->revision = b->revision;
    return true;
}

static size_t read_feed(char *data, size_t size, size_t count, void *ctx)
{
    struct feed *f = ctx;
    long status = 0;
    curl_easy_getinfo(f->curl, CURLINFO_RESPONSE_CODE, &status);
    if (status != 200) return 0;
    return pixel_parser_feed(&f->parser, data, size * count, take, f) ? size * count : 0;
}

static int open_feed(struct feed *f, CURLM *multi)
{
    char url[768], after[32] = "";
    if (f->revision > STILL_REVISION)
        snprintf(after, sizeof after, "&after=%llu", (unsigned long long)f->revision);
    snprintf(url, sizeof url, "%s/v1/jobs/%s/pixels?layer=%s&format=float&alpha=1%s",
             f->push->base_url, f->push->job, f->layer, after);
    pixel_parser_restart(&f->parser);
    f->width_px = f->height_px = 0;
    f->live = false;
    f->curl = curl_easy_init();
    if (!f->curl) return ERR_MEMORY;
    curl_easy_setopt(f->curl, CURLOPT_URL, url);
    curl_easy_setopt(f->curl, CURLOPT_NOPROXY, "*");
    curl_easy_setopt(f->curl, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(f->curl, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(f->curl, CURLOPT_CONNECTTIMEOUT, 10L);
    curl_easy_setopt(f->curl, CURLOPT_LOW_SPEED_LIMIT, 1L); /* it says something every 15 s */
    curl_easy_setopt(f->curl, CURLOPT_LOW_SPEED_TIME, 60L);
    client_lend(f->push->client, f->curl);
    curl_easy_setopt(f->curl, CURLOPT_WRITEFUNCTION, read_feed);
    curl_easy_setopt(f->curl, CURLOPT_WRITEDATA, f);
    return curl_multi_add_handle(multi, f->curl) == CURLM_OK ? 0 : ERR_MEMORY;
}

static bool is_whole(const struct feed *f)
{
    return f->revision == STILL_REVISION;
}

/* Reads all feeds that are not whole until they end, or tev is gone. */
static void read_feeds(struct tev_push *p)
{
    CURLM *multi = curl_multi_init();
    int running = 1;
    if (!multi) p->error = ERR_MEMORY;
    for (uint32_t k = 0; k < p->count && !p->error; k++)
        if (!is_whole(&p->feeds[k])) p->error = open_feed(&p->feeds[k], multi);
    while (running > 0 && !p->error && p->link.fd >= 0) {
        if (curl_multi_perform(multi, &running) != CURLM_OK) break;
        if (running > 0) curl_multi_poll(multi, NULL, 0, 1000, NULL);
    }
    for (uint32_t k = 0; k < p->count; k++) {
        struct feed *f = &p->feeds[k];
        if (!p->error && f->parser.error) p->error = f->parser.error;
        if (!f->curl) continue;
        curl_multi_remove_handle(multi, f->curl);
        curl_easy_cleanup(f->curl);
        f->curl = NULL;
    }
    if (multi) curl_multi_cleanup(multi);
}

/* tev was closed, or started anew: it has nothing of the picture. One that takes connections only
 * to end them is not called all the time. */
static int reconnect(struct tev_push *p)
{
    pause_ms(LOST_PAUSE_MS);
    p->width_px = p->height_px = 0;
    for (uint32_t k = 0; k < p->count; k++) p->feeds[k].revision = 0;
    for (int tries = 0; tries < RECONNECTS; tries++) {
        if (tev_link_connect(&p->link, &p->fault) == 0) return 0;
        pause_ms(PAUSE_MS);
    }
    return p->fault.code;
}

/* Returns whether more of the picture may come. */
static bool may_go_on(struct tev_push *p)
{
    char path[64];
    json_t *job = NULL;
    struct fault ignored;
    bool whole = true;
    for (uint32_t k = 0; k < p->count; k++) whole = whole && is_whole(&p->feeds[k]);
    if (whole) return false;
    snprintf(path, sizeof path, "/v1/jobs/%s", p->job);
    /* A coordinator that does not answer may be back soon. */
    int error = client_json(p->client, "GET", path, NULL, &job, &ignored);
    if (error == ERR_NOT_FOUND) return false;
    const char *state = error ? NULL : json_string_value(json_object_get(job, "state"));
    const bool ended = state && (!strcmp(state, "failed") || !strcmp(state, "cancelled"));
    json_decref(job);
    return !ended;
}

static void *run(void *ctx)
{
    struct tev_push *p = ctx;
    for (int empty = 0; empty < EMPTY_TRIES && !p->error;) {
        const uint64_t before = p->blocks;
        read_feeds(p);
        if (!p->error && p->link.fd < 0) {
            p->error = reconnect(p);
            continue;
        }
        if (p->error || !may_go_on(p)) break;
        empty = p->blocks > before ? 0 : empty + 1;
        if (empty > 0) pause_ms(PAUSE_MS);
    }
    if (p->error && p->fault.code != p->error)
        fault_set(&p->fault, p->error, "", "--tev: %s", error_text(p->error));
    return NULL;
}

static void destroy(struct tev_push **push)
{
    struct tev_push *p = *push;
    if (!p) return;
    for (uint32_t k = 0; k < p->count; k++) pixel_parser_fini(&p->feeds[k].parser);
    client_destroy(&p->client);
    image_destroy(&p->names);
    tev_packet_fini(&p->packet);
    tev_link_close(&p->link);
    free(p->numbers);
    free(p);
    *push = NULL;
}

/* Feeds of the layers, with the names of their channels. */
static int add_layers(struct tev_push *p, const char *const *layers, uint32_t count)
{
    uint32_t all = 0, first = 0;
    int error = 0;
    for (uint32_t b = 0; b < count; b++) all |= layer_from_name(layers[b]);
    error = image_create(all, 1, 1, &p->names);
    /* Channels stand in the order of the layers' bits. */
    for (uint32_t b = 0; b < LAYERS_MAX && !error; b++) {
        struct feed *f = &p->feeds[p->count];
        struct image *own;
        if (!(all >> b & 1u)) continue;
        error = image_create(1u << b, 1, 1, &own);
        if (error) break;
        const bool more = own->channel_count > FEED_CHANNELS;
        *f = (struct feed){.push = p, .channel_count = more ? 3 : own->channel_count};
        snprintf(f->layer, sizeof f->layer, "%s", layer_name(1u << b));
        for (uint32_t c = 0; c < f->channel_count; c++)
            f->channels[c] = p->names->channels[first + c].name;
        first += own->channel_count;
        p->count++;
        image_destroy(&own);
    }
    return error;
}

int tev_push_start(const struct client_target *target, const char *job, const char *const *layers,
                   uint32_t count, struct tev_link *link, struct tev_push **out,
                   struct fault *fault)
{
    struct tev_push *p = calloc(1, sizeof *p);
    *out = NULL;
    if (!p) return fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
    p->link = *link;
    p->link.fd = -1;
    snprintf(p->base_url, sizeof p->base_url, "%s", client_base_url(target->server));
    snprintf(p->job, sizeof p->job, "%s", job);
    snprintf(p->name, sizeof p->name, "shearwater %s", job);
    int error = tev_link_connect(&p->link, fault);
    if (error) goto fail;
    error = add_layers(p, layers, count);
    if (!error) error = client_target_open(target, &p->client, fault);
    if (!error && pthread_create(&p->thread, NULL, run, p) != 0) error = ERR_MEMORY;
    if (!error) {
        *out = p;
        return 0;
    }
    fault_set(fault, error, "", "--tev: %s", error_text(error));
fail:
    destroy(&p);
    return error;
}

int tev_push_finish(struct tev_push **push, struct fault *fault)
{
    struct tev_push *p = *push;
    pthread_join(p->thread, NULL);
    const int error = p->error;
    if (error) *fault = p->fault;
    destroy(push);
    return error;
}
