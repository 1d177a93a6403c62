/* What the library of a run with tangents holds beside scene.c. */
#ifndef SLOPE_H
#define SLOPE_H
#include "scene.h"

typedef struct { uint32_t cell; double least; } Compared; /* an output that has to stand, and the size below which it is none */
/* ---- written at build ---- */
extern const uint32_t slope_cells, slope_sweeps, slope_change_count, slope_compared_count;
extern const uint32_t slope_changes[]; /* of links: by how much an input has to move before outputs follow */
extern const Compared slope_compared[];
extern const double slope_stands, slope_about_zero, slope_stalled; /* see orchestrator/derivatives/tangent_block.py */
#endif
