/* The time left in the words of a progress line: a figure where one is told, else a range. */
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "server/cli/progress.h"
#include "tests/unit/unit.h"

/* Writes what the line says after the tiles, where standard error is a file. */
static void said_of(const char *eta, const char *range, char *out, size_t capacity)
{
    char text[256], said[256] = "";
    snprintf(text, sizeof text,
             "{\"fraction\": 0.5, \"tiles_done\": 1, \"tiles_total\": 2, \"eta_s\": %s, "
             "\"eta_range_s\": %s}",
             eta, range);
    json_t *data = json_loads(text, 0, NULL);
    FILE *file = tmpfile();
    const int kept = dup(STDERR_FILENO);
    struct progress progress;
    assert_true(data && file && kept >= 0);
    assert_true(dup2(fileno(file), STDERR_FILENO) >= 0);
    progress_begin(&progress, false);
    progress_show(&progress, "running", data);
    assert_true(dup2(kept, STDERR_FILENO) >= 0);
    rewind(file);
    assert_non_null(fgets(said, sizeof said, file));
    const char *tiles = strstr(said, " of 2 tiles");
    assert_non_null(tiles);
    snprintf(out, capacity, "%.*s", (int)strcspn(tiles + 11, "\n"), tiles + 11);
    close(kept);
    fclose(file);
    json_decref(data);
}

TEST(time_left_in_words)
{
    static const struct {
        const char *eta, *range, *said;
    } cases[] = {
        {"12.2", "[9.8, 15.3]", ", 13 s left"},
        {"null", "[10.4, 40]", ", 11 to 40 s left"},
        {"null", "[20, 400]", ", 20 s to 7 min left"},
        {"null", "[5400, 9000]", ", 1.5 to 2.5 h left"},
        {"null", "[0.1, 0.4]", ", 1 s left"},
        {"null", "null", ""},
        {"null", "[3]", ""},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char said[128];
        said_of(cases[i].eta, cases[i].range, said, sizeof said);
        assert_string_equal(said, cases[i].said);
    }
}
