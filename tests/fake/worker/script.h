#pragma once
/* The scripts that the fake worker plays, by name: what each does with a tile. */
#include <stdio.h>

#include "tests/fake/worker/fake.h"

/* NULL: there is none of the name. */
const struct script *script_find(const char *name);
bool script_plays(const struct fake *f, const char *script);
void script_print_all(FILE *file);
