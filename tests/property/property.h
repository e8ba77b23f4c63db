#pragma once
/* What must hold of every case. */
#include "tests/property/picture.h"

enum property_result { PROPERTY_HOLDS, PROPERTY_FAILS, PROPERTY_DOES_NOT_APPLY };

enum { PROPERTY_SAYS_BYTES = 512 };

struct property {
    const char *name;
    /* `says`: how far off, where it fails; why it does not apply. */
    enum property_result (*holds)(const struct property_case *c, char says[PROPERTY_SAYS_BYTES]);
};

extern const struct property properties[];
extern const int property_count;

/* Of properties.c. */
enum property_result property_finite(const struct property_case *c, char says[PROPERTY_SAYS_BYTES]);
enum property_result property_cut(const struct property_case *c, char says[PROPERTY_SAYS_BYTES]);
enum property_result property_scaled(const struct property_case *c, char says[PROPERTY_SAYS_BYTES]);
enum property_result property_moved(const struct property_case *c, char says[PROPERTY_SAYS_BYTES]);
enum property_result property_brighter(const struct property_case *c,
                                       char says[PROPERTY_SAYS_BYTES]);
/* Of properties_looked.c. */
enum property_result property_looked(const struct property_case *c, char says[PROPERTY_SAYS_BYTES]);
/* Of properties_mean.c: that hold of means over many seeds. */
enum property_result property_mirrored(const struct property_case *c,
                                       char says[PROPERTY_SAYS_BYTES]);
enum property_result property_turned(const struct property_case *c, char says[PROPERTY_SAYS_BYTES]);
enum property_result property_filtered(const struct property_case *c,
                                       char says[PROPERTY_SAYS_BYTES]);
enum property_result property_lights_add(const struct property_case *c,
                                         char says[PROPERTY_SAYS_BYTES]);
enum property_result property_dealt(const struct property_case *c, char says[PROPERTY_SAYS_BYTES]);
/* Of properties_constant.c: scenes of the case's cut, samples and filters, whose picture is known.
 */
enum property_result property_open(const struct property_case *c, char says[PROPERTY_SAYS_BYTES]);
enum property_result property_unoccluded(const struct property_case *c,
                                         char says[PROPERTY_SAYS_BYTES]);
enum property_result property_glow(const struct property_case *c, char says[PROPERTY_SAYS_BYTES]);
enum property_result property_furnace(const struct property_case *c,
                                      char says[PROPERTY_SAYS_BYTES]);

/* Shared: nothing that is not lit; the picture, or NULL with the reason in says, where a job is
 * refused. */
void property_light_up(struct property_case *c);
struct image *property_picture(const struct property_case *c, const struct change *change,
                               char says[PROPERTY_SAYS_BYTES]);
/* RMS of both pictures' difference over RMS of the first, of beauty's R, G, B, where at most the
 * share `spared` of the pixels, those that differ most, is left out. */
double property_apart(const struct image *a, const struct image *b, double gain, double spared);
