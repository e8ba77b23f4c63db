#pragma once
/* A picture by way of a film: tiles are filled pixel by pixel and land, and blocks that are ready
 * are reconstructed. */
#include "server/film/film.h"
#include "server/image/image.h"
#include "server/reconstruct/block.h"

/* Fills what place `i` of a tile holds, image pixel (x, y). */
typedef void put_pixel_fn(struct samples *s, const struct plan *plan, int32_t x, int32_t y,
                          size_t i, const void *ctx);

/* Makes the first pass of a tile. Owned by the caller; NULL on failed allocation. */
struct samples *picture_tile(const struct plan *plan, uint32_t tile, put_pixel_fn *put,
                             const void *ctx);

/* Makes a film with the plan's halos, `more_px` wider than they must be. */
struct film *picture_film(const struct plan *plan, int32_t block_px, int32_t more_px);

typedef struct samples *tile_fn(const struct plan *plan, uint32_t tile, const void *ctx);

/* Lands the first pass of all tiles, by tiles or by pixels. */
void picture_land(const struct plan *plan, struct film *film, tile_fn *make, const void *ctx);
void picture_land_pixels(const struct plan *plan, struct film *film, put_pixel_fn *put,
                         const void *ctx);

/* Reconstructs all blocks that are ready. `sum`, if not NULL, grows by the statistics of those that
 * are complete. */
void picture_draw(const struct plan *plan, struct film *film, struct image *image,
                  struct block_statistics *sum);

const float *picture_channel(const struct image *image, const char *channel);
float picture_at(const struct image *image, const char *channel, int32_t x, int32_t y);
