#pragma once
/* Colours as FLIP has them: from what a screen shows to the linearised CIELAB that contrast
 * sensitivity is measured in, and on to CIELAB with Hunt's effect. D65; the matrix of sRGB. */

/* Converts sRGB in [0, 1] to Y, Cx, Cz. */
void flip_color_opponent(const double encoded[3], double out[3]);

/* Converts Y, Cx, Cz, cut to what a screen can show, to L*, a*, b* whose a and b grow with L. */
void flip_color_hunt(const double opponent[3], double out[3]);

/* Returns HyAB (Abasi, Amani Tehran and Fairchild 2020): |dL| + |(da, db)|. */
double flip_color_distance(const double a[3], const double b[3]);

/* Returns the distance of the screen's green and blue, which is the largest there is. */
double flip_color_largest(void);
