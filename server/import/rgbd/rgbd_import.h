#pragma once
/* Adds what a sequence's camera sees to a scene: the surfaces of a frame as a catcher, its camera
 * as the scene's own, and the name of its colour image as the backplate. */
#include "server/import/rgbd/rgbd_document.h"
#include "server/import/scene/builder.h"
#include "server/import/scene/scene_choice.h"

/* Adds the frame of the time that is chosen. The builder has the scene already, and is not
 * finished. Faults have pointers that begin with /rgbd. ERR_NOT_FOUND for a time after the last
 * frame. */
int rgbd_import(struct files *files, const struct scene_choice *choice, struct builder *b,
                struct fault *fault);
