#pragma once
/* Halves where pixels have one sample each. As on a chessboard, half a is of the samples of white
 * pixels alone and half b of those of black ones: a pixel has its own sample as the half of its
 * colour, and what the four pixels beside it show as the other. Both halves are independent, so
 * that the passes weigh each by the other as ever. */
#include "server/reconstruct/residual/residual_field.h"

/* Sets the halves of a field that has been read, whose pixels have no share yet. A pixel beside
 * which no surface shows has no halves, and keeps its sample. */
void residual_single_lend(const struct patch *patch, struct residual_field *field);
