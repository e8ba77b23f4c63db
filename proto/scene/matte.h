#pragma once
/* Ids of objects and materials as Cryptomatte has them (Psyop's specification 1.2.0): hashes of
 * names, which are stored as the bits of floats. */
#include "proto/scene/scene.h"

enum matte_kind { MATTE_OBJECT, MATTE_MATERIAL, MATTE_KINDS };

#define MATTE_RANKS 6u /* ids that a pixel has at most, those that cover most of it */

/* Camera samples of a pixel: the first ones, and all where these do not meet one and the same
 * instance. Through a lens and while a shutter is open there are more. Powers of two, so that
 * shares of a pixel are exact as halves. */
#define MATTE_FIRST_DIGITS 4u
#define MATTE_DIGITS       6u
#define MATTE_BLUR_DIGITS  8u

/* The layers' names, which their channels begin with. */
#define MATTE_OBJECT_LAYER   "CryptoObject"
#define MATTE_MATERIAL_LAYER "CryptoMaterial"

/* Computes MurmurHash3_x86_32 of a text, seed 0 (Appleby, public domain). */
uint32_t matte_hash(const char *text);

/* Returns the id of a name: its hash, with bit 23 turned where the float would be denormal,
 * infinite or no number. */
uint32_t matte_id(const char *name);

/* Returns the name of an instance, or that of its material. One without a name has its mesh's, or
 * else its index: that is written to `room`. */
const char *matte_name(const struct scene *scene, enum matte_kind kind, uint32_t instance,
                       char room[32]);
