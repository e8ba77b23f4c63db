#pragma once
/* How the light of a picture is shown to people: image.view of a job document. The formulas are
 * those of server/image/view_transform.h. */

enum view_curve {
    VIEW_LINEAR, /* as it is, clipped at 1 */
    VIEW_FILMIC, /* a shoulder for each channel */
    VIEW_AGX     /* highlights lose colour as in film */
};
