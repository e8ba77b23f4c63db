#include "server/import/options.h"

#include <string.h>

const char options_help[] =
    "shearwater-import --root DIR --in NAME --out BLOB [--report FILE]\n"
    "\n"
    "Turns a scene file into a scene blob, or an environment map into an environment blob. It is "
    "run\n"
    "by the coordinator, once per file.\n"
    "\n"
    "  --root DIR     folder with the scene's files; nothing outside it is read\n"
    "  --in NAME      main file beneath DIR: .glb, .gltf, .obj, or without extension; .hdr and "
    ".exr\n"
    "                 are known by their first bytes\n"
    "  --out BLOB     file to write\n"
    "  --report FILE  write the line about the outcome to FILE as well\n"
    "  --help         this text\n"
    "\n"
    "Prints one line of JSON: {\"ok\":true,\"triangles\":..,\"placed_triangles\":..,\n"
    "\"warnings\":[..],\"cpu_s\":..} (of a map \"width_px\" and \"height_px\"), or\n"
    "{\"ok\":false,\"code\":..,\"pointer\":..,\"detail\":..}\n"
    "and exit status 1.\n";

int options_read(int argc, char **argv, struct options *out, struct fault *fault)
{
    *out = (struct options){0};
    const struct {
        const char *name;
        const char **value;
        bool required;
    } rows[] = {{"--root", &out->root, true},
                {"--in", &out->name, true},
                {"--out", &out->out, true},
                {"--report", &out->report, false}};
    const size_t count = sizeof rows / sizeof *rows;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0) {
            out->help = true;
            return 0;
        }
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
    return 0;
}
