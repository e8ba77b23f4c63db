#include "server/job/frame/fingerprint.h"

#include <stdlib.h>
#include <string.h>

#include "proto/json.h"

int fingerprint_of(const struct job *job, char out[FINGERPRINT_BYTES])
{
    char hex[DIGEST_HEX_BYTES];
    struct digest digest;
    static const char *const files[] = {"exr_compression", "view", "exposure", "png_bits",
                                        "png_alpha"};
    json_t *document = job_write(job);
    static const char *const idle[] = {"priority", "live", "name", "comment", "labels", "webhook"};
    for (size_t i = 0; i < sizeof idle / sizeof *idle; i++) json_object_del(document, idle[i]);
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++)
        json_object_del(json_object_get(document, "image"), files[i]);
    json_object_del(json_object_get(document, "sampling"), "tile_px");
    char *text = json_text(document, JSON_COMPACT | JSON_SORT_KEYS);
    json_decref(document);
    if (!text) return ERR_MEMORY;
    digest_of(text, strlen(text), &digest);
    free(text);
    digest_to_hex(&digest, hex);
    memcpy(out, hex, FINGERPRINT_BYTES - 1);
    out[FINGERPRINT_BYTES - 1] = '\0';
    return 0;
}
