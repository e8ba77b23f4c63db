#include "server/stream/share.h"

#define PARTS_SAVED  4 /* of a second's time */
#define SECONDS_OWED 16

void share_init(struct share *share, int64_t us_per_s, uint64_t now_us)
{
    *share = (struct share){.us_per_s = us_per_s, .at_us = now_us};
    share->all_us = us_per_s / PARTS_SAVED;
    share->events_us = share->feeds_us = us_per_s / 2 / PARTS_SAVED;
}

static int64_t settled(int64_t now_us, int64_t us_per_s, uint64_t passed_us, uint64_t spent_us)
{
    const int64_t most_us = us_per_s / PARTS_SAVED, least_us = -SECONDS_OWED * us_per_s;
    const int64_t next_us = now_us + us_per_s * (int64_t)passed_us / 1000000 - (int64_t)spent_us;
    return next_us > most_us ? most_us : next_us < least_us ? least_us : next_us;
}

void share_settle(struct share *share, uint64_t now_us, uint64_t events_us, uint64_t pixels_us)
{
    uint64_t passed_us = now_us - share->at_us;
    if (passed_us > 1000000) passed_us = 1000000;
    share->at_us = now_us;
    share->all_us = settled(share->all_us, share->us_per_s, passed_us, events_us + pixels_us);
    share->events_us = settled(share->events_us, share->us_per_s / 2, passed_us, events_us);
    share->feeds_us = settled(share->feeds_us, share->us_per_s / 2, passed_us, pixels_us);
}

bool share_has_for_events(const struct share *share)
{
    return share->us_per_s == 0 || share->events_us > 0;
}

int64_t share_for_feeds_us(const struct share *share)
{
    if (share->us_per_s == 0) return INT64_MAX;
    return share->all_us > share->feeds_us ? share->all_us : share->feeds_us;
}
