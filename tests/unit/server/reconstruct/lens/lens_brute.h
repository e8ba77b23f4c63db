#pragma once
/* The sheared filter of lens samples without cells: of each layer every pixel looks at each sample
 * by itself, where its slope takes it, sum over picture and lens in four dimensions. A sample
 * (x', u') of slope s is seen from pixel x through the point u' + (x' - x) / s of the lens, if that
 * is one. Layers, what is in focus and what is left of the plain average's difference are the
 * filter's own. */
#include "server/reconstruct/lens/lens_field.h"
#include "server/reconstruct/lens/lens_residual.h"
#include "tests/unit/server/reconstruct/lens/lens_scene.h"

/* Writes the picture into p->out. 0, or what lens_filter returns. */
int lens_brute(struct lens_picture *p);
