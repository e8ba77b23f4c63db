#include "server/job/job_id.h"

#include <string.h>
#include <sys/random.h>

#include "proto/error.h"

static const char alphabet[] = "0123456789abcdefghjkmnpqrstvwxyz";

/* 128 bits, most significant first, as 26 characters of 5 bits (the first has 3). */
static void write_text(const uint8_t bytes[16], char out[JOB_ID_BYTES])
{
    for (int i = 0; i < 26; i++) {
        unsigned value = 0;
        for (int bit = 0; bit < 5; bit++) {
            int at = i * 5 + bit - 2; /* 130 bits of text hold 128 */
            unsigned one = at < 0 ? 0u : (unsigned)(bytes[at / 8] >> (7 - at % 8)) & 1u;
            value = value << 1 | one;
        }
        out[i] = alphabet[value];
    }
    out[26] = '\0';
}

/* Within one millisecond the random part counts upwards. */
static void increment(struct job_id_source *source)
{
    for (int i = 9; i >= 0; i--)
        if (++source->random[i] != 0) return;
    source->last_ms++;
}

int job_id_next(struct job_id_source *source, uint64_t now_ms, char out[JOB_ID_BYTES])
{
    uint8_t bytes[16];
    if (now_ms > source->last_ms) {
        if (getrandom(source->random, sizeof source->random, 0) != sizeof source->random)
            return ERR_IO;
        source->last_ms = now_ms;
    } else {
        increment(source);
    }
    for (int i = 0; i < 6; i++) bytes[i] = (uint8_t)(source->last_ms >> (40 - 8 * i));
    memcpy(bytes + 6, source->random, sizeof source->random);
    write_text(bytes, out);
    return 0;
}

void job_id_follow(struct job_id_source *source, const char *id)
{
    uint8_t bytes[16] = {0};
    for (int at = 2; at < 130; at++) {
        const unsigned value = (unsigned)(strchr(alphabet, id[at / 5]) - alphabet);
        const unsigned one = value >> (4 - at % 5) & 1u;
        bytes[(at - 2) / 8] |= (uint8_t)(one << (7 - (at - 2) % 8));
    }
    source->last_ms = 0;
    for (int i = 0; i < 6; i++) source->last_ms = source->last_ms << 8 | bytes[i];
    memcpy(source->random, bytes + 6, sizeof source->random);
}

bool job_id_is_valid(const char *text)
{
    return strlen(text) == JOB_ID_BYTES - 1 && strspn(text, alphabet) == JOB_ID_BYTES - 1;
}
