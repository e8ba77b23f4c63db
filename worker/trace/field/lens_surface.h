#pragma once
/* What lens samples tell of the surfaces they meet, for light fields of pixel centres to light
 * them; and what is left of the samples without that light. */
#include "proto/samples.h"
#include "worker/trace/path/path.h"

/* Takes the light that fields bring out of what the harvest's slot holds. */
void lens_surface_take_out(const struct path_context *c, size_t slot, struct path_harvest *h);

/* Stores depth, normal, albedo and own light of lens sample `sample`, which lies in the harvest
 * from slot `first` on, and takes that light out of what the harvest holds. Nothing happens under a
 * plan whose light fields light no lens samples. */
void lens_surface_store(const struct path_context *c, const struct block *b, size_t first,
                        uint32_t sample, struct path_harvest *h, struct samples *samples);
