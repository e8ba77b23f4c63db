/* Runs a fuzz target without a fuzzer: every file of the corpus as it is, cut at every byte and
 * with every byte changed. Any compiler builds it, so that every test run asks the decoders the
 * questions that fuzzing has found worth keeping.
 *
 *   replay FILE ...      speaks TAP, one line a file */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHANGED_BYTES 2048u /* larger inputs are cut and changed at this many places only */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);

/* Exactly as large as the input, so that a sanitizer sees a read beyond. */
static void try_input(const uint8_t *data, size_t size_bytes)
{
    uint8_t *exact = malloc(size_bytes + (size_bytes == 0));
    if (exact == NULL) abort();
    if (size_bytes > 0) memcpy(exact, data, size_bytes);
    LLVMFuzzerTestOneInput(exact, size_bytes);
    free(exact);
}

static void try_neighbours(uint8_t *data, size_t size_bytes)
{
    size_t step = size_bytes / CHANGED_BYTES + 1;
    for (size_t at = 0; at < size_bytes; at += step) {
        uint8_t was = data[at];
        try_input(data, at);
        data[at] = (uint8_t)(was ^ 0xff);
        try_input(data, size_bytes);
        data[at] = (uint8_t)(was + 1);
        try_input(data, size_bytes);
        data[at] = was;
    }
}

static bool replay(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL) return false;
    uint8_t *data = malloc(1u << 20);
    size_t size_bytes = data != NULL ? fread(data, 1, 1u << 20, file) : 0;
    bool good = data != NULL && !ferror(file);
    fclose(file);
    if (good) {
        try_input(data, size_bytes);
        try_neighbours(data, size_bytes);
    }
    free(data);
    return good;
}

int main(int argc, char **argv)
{
    int status = 0;
    printf("1..%d\n", argc - 1);
    for (int i = 1; i < argc; i++) {
        fflush(stdout);
        bool good = replay(argv[i]);
        printf("%s %d - %s\n", good ? "ok" : "not ok", i, argv[i]);
        if (!good) status = 1;
    }
    return status;
}
