#include "server/import/options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/option_text.h"

static const char usage[] = "shearwater-import --root DIR --in NAME --out BLOB [--variant NAME] "
                            "[--animation NAME] [--time S | --times S,S,.. [--shutter S]] "
                            "[--moves JSON] "
                            "[--catchers JSON [--holdouts JSON] [--ground Y] "
                            "[--rgbd NAME [--surfaces screen|fused] [--light auto|estimate]]] "
                            "[--report FILE]";
static const char summary[] =
    "Turns a scene file into a scene blob, or an environment map into an environment blob. The "
    "coordinator runs it, once per file. It prints one line of JSON: {\"ok\":true, "
    "\"triangles\":.., "
    "\"placed_triangles\":.., \"warnings\":[..], \"cpu_s\":..}, of a map \"width_px\" and "
    "\"height_px\", or {\"ok\":false, \"code\":.., \"pointer\":.., \"detail\":..} and exit status "
    "1.";

static const struct option_text texts[] = {
    {0, "root", "DIR", "directory of the scene's files; nothing outside it is read"},
    {0, "in", "NAME",
     "main file in DIR: .glb, .gltf or .obj; .hdr and .exr are known by their first bytes"},
    {0, "variant", "NAME", "variant of the materials (KHR_materials_variants)"},
    {0, "animation", "NAME", "the animation that plays; without it all play"},
    {0, "time", "S", "seconds into the animations at which the scene stands; by default 0"},
    {0, "times", "S,S,..",
     "several such times: a scene that moves becomes a base in BLOB and frames in BLOB.0, BLOB.1, "
     ".., as many as \"frames\" of the answer says"},
    {0, "shutter", "S",
     "seconds around each of --times for which the shutter is open; by default a moment"},
    {0, "moves", "JSON",
     "where nodes are moved to, [{\"node\": \"box\", \"translation\": [1, 0, 0], "
     "\"rotation_deg\": 30}]"},
    {0, "catchers", "JSON",
     "names of nodes and materials that catch shadows in a photograph, [\"floor\"]; all else but "
     "holdouts is not in the photograph"},
    {0, "holdouts", "JSON", "names of those that hide what is behind them, beside --catchers"},
    {0, "ground", "Y", "height of a floor of our making that catches shadows, too"},
    {0, "rgbd", "NAME",
     "document in DIR of colour and depth images (server/import/rgbd): the frame at the time "
     "catches "
     "shadows, and its camera is the scene's"},
    {0, "surfaces", "KIND",
     "of --rgbd: \"screen\", what each frame saw; or \"fused\", one model of all frames"},
    {0, "light", "KIND",
     "of --rgbd: \"estimate\" it from the frames; or \"auto\", do so unless the scene has lights; "
     "by default there is none"},
    {0, "out", "BLOB", "file to write"},
    {0, "report", "FILE", "also write the line of JSON to this file"},
    {0, "help", NULL, "print this text"},
};
#define TEXT_COUNT (sizeof texts / sizeof texts[0])

void options_print_help(FILE *out)
{
    fprintf(out, "usage: %s\n\n", usage);
    option_text_wrap(out, summary, 0);
    fputc('\n', out);
    for (size_t i = 0; i < TEXT_COUNT; i++) option_text_help(out, &texts[i]);
}

void options_dump(FILE *out)
{
    fprintf(out, "usage\t%s\nsummary\t%s\n", usage, summary);
    for (size_t i = 0; i < TEXT_COUNT; i++) option_text_dump(out, &texts[i]);
}

static int read_number(const char *option, const char *text, const char *what, double *out,
                       struct fault *fault)
{
    char *end;
    *out = strtod(text, &end);
    if (end != text && *end == '\0' && isfinite(*out)) return 0;
    return fault_set(fault, ERR_RANGE, option, "%.40s is no %s", text, what);
}

static int read_time(const char *text, double *out, struct fault *fault)
{
    return read_number("--time", text, "time in seconds", out, fault);
}

static int read_times(const char *text, struct options *out, struct fault *fault)
{
    char *end = (char *)(uintptr_t)text;
    do {
        const char *at = end + (end > text);
        const uint32_t n = out->choice.time_count;
        if (n == OPTIONS_TIMES)
            return fault_set(fault, ERR_LIMIT, "--times", "there are more than %d times",
                             OPTIONS_TIMES);
        out->times[n] = strtod(at, &end);
        if (end == at || (*end != ',' && *end != '\0') || !isfinite(out->times[n]))
            return fault_set(fault, ERR_RANGE, "--times", "%.40s is no time in seconds", at);
        out->choice.time_count++;
    } while (*end == ',');
    out->choice.times = out->times;
    return 0;
}

static int read_light(const char *text, enum rgbd_estimate *out, struct fault *fault)
{
    *out = strcmp(text, "estimate") == 0 ? RGBD_ESTIMATE_ALWAYS : RGBD_ESTIMATE_UNLESS_LIT;
    if (*out == RGBD_ESTIMATE_ALWAYS || strcmp(text, "auto") == 0) return 0;
    return fault_set(fault, ERR_RANGE, "--light", "%.40s is neither auto nor estimate", text);
}

int options_read(int argc, char **argv, struct options *out, struct fault *fault)
{
    const char *time = NULL, *times = NULL, *ground = NULL, *shutter = NULL, *moves = NULL;
    const char *surfaces = "screen", *light = NULL;
    *out = (struct options){0};
    const struct {
        const char *name;
        const char **value;
        bool required;
    } rows[] = {{"--root", &out->root, true},
                {"--in", &out->name, true},
                {"--variant", &out->choice.variant, false},
                {"--animation", &out->choice.animation, false},
                {"--time", &time, false},
                {"--times", &times, false},
                {"--shutter", &shutter, false},
                {"--moves", &moves, false},
                {"--catchers", &out->choice.catchers, false},
                {"--holdouts", &out->choice.holdouts, false},
                {"--ground", &ground, false},
                {"--rgbd", &out->choice.rgbd, false},
                {"--surfaces", &surfaces, false},
                {"--light", &light, false},
                {"--out", &out->out, true},
                {"--report", &out->report, false}};
    const size_t count = sizeof rows / sizeof *rows;
    for (int i = 1; i < argc; i++) {
        out->help = strcmp(argv[i], "--help") == 0;
        out->dump = strcmp(argv[i], OPTION_TEXT_DUMP) == 0;
        if (out->help || out->dump) return 0;
        size_t row = 0;
        while (row < count && strcmp(argv[i], rows[row].name) != 0) row++;
        if (row == count)
            return fault_set(fault, ERR_UNKNOWN_MEMBER, argv[i], "this option does not exist");
        if (++i == argc)
            return fault_set(fault, ERR_MISSING, rows[row].name, "its value is missing");
        *rows[row].value = argv[i];
    }
    for (size_t row = 0; row < count; row++)
        if (rows[row].required && *rows[row].value == NULL)
            return fault_set(fault, ERR_MISSING, rows[row].name, "this option is required");
    out->choice.has_ground = ground != NULL;
    out->choice.is_fused = strcmp(surfaces, "fused") == 0;
    if (!out->choice.is_fused && strcmp(surfaces, "screen") != 0)
        return fault_set(fault, ERR_RANGE, "--surfaces", "%.40s is neither screen nor fused",
                         surfaces);
    int rc = light != NULL ? read_light(light, &out->choice.estimate, fault) : 0;
    if (rc == 0 && ground != NULL)
        rc = read_number("--ground", ground, "height", &out->choice.ground_height, fault);
    if (rc != 0) return rc;
    if (shutter != NULL)
        rc = read_number("--shutter", shutter, "time in seconds", &out->choice.shutter_s, fault);
    if (rc != 0) return rc;
    if (moves != NULL) rc = job_moves_parse(moves, &out->moves, fault);
    if (rc != 0) return rc;
    if (out->moves.count > 0) out->choice.moves = &out->moves;
    rc = time != NULL ? read_time(time, &out->choice.time_s, fault) : 0;
    return rc == 0 && times != NULL ? read_times(times, out, fault) : rc;
}
