/* A run of a scene with the derivatives of all that it holds in one direction, for a page. The tangent of the cell at an address lies
   `offset` bytes behind it. The entries that scene.c calls are the derivatives of the scene's. */
#include "slope.h"
#include <stdlib.h>
#include <string.h>

enum { LINE = 64 }; /* bytes of a cache line, as the layout of the arrays asks for */
int32_t initialize(double t, double h, int64_t block, int64_t offset, int64_t stack, int64_t ties) __asm__("call.d.master_initialize_groups");
int32_t run(double t, double h, int64_t block, int64_t offset, int64_t stack, int64_t ties) __asm__("call.d.master_run_steps");

static double *cells, *tangents, *image, *before; /* image: the block that each start, and each start of a unit, begins with */
static int64_t ties;
static double moved; /* size of the number by which the derivatives are */
static size_t size(void) { return (2 * (size_t)slope_cells + STACK + 7) / 8 * 8; }
#define REST (int64_t)(intptr_t)tangents - (int64_t)(intptr_t)cells, (int64_t)(intptr_t)(image + slope_cells), (int64_t)(intptr_t)&ties

/* Where the block of an instance before initialization has to be written, cells() numbers; NULL without memory. */
EXPORT uint32_t slope_size(void) { return slope_cells; }
EXPORT double *slope_block(void) {
    if (!cells) {
        cells = aligned_alloc(LINE, 8 * size());
        tangents = aligned_alloc(LINE, 8 * size());
        before = malloc(8 * (size_t)(slope_compared_count + 1));
        image = cells + slope_cells;
    }
    return cells && tangents && before ? image : NULL;
}
EXPORT void slope_macro_step(double length, double numerator, double denominator) { set_macro_step(length, numerator, denominator); }

/* Numbers of units that feed one another may stand before their tangents do. */
static int stands(void) {
    double largest = 0.0;
    int all = 1;
    for (uint32_t k = 0; k < slope_compared_count; k++) largest = fmax(largest, fabs(tangents[slope_compared[k].cell]));
    for (uint32_t k = 0; k < slope_compared_count; k++) {
        const Compared *c = slope_compared + k;
        const double tangent = tangents[c->cell], size = fmax(fabs(tangent), slope_about_zero * largest);
        const double rounding = slope_stalled * fmax(fabs(cells[c->cell]), c->least) / moved;
        all &= fabs(tangent - before[k]) <= fmax(slope_stands * size, rounding);
    }
    return all;
}
int32_t master_initialize_groups(double t, double h, int64_t block) {
    int32_t status = initialize(t, h, block, REST);
    if (!slope_compared_count) return status;
    for (uint32_t sweep = 0; !status && sweep < slope_sweeps; sweep++) {
        for (uint32_t k = 0; k < slope_compared_count; k++) before[k] = tangents[slope_compared[k].cell];
        status = initialize(t, h, block, REST);
        if (stands()) return status;
    }
    return INSIDE;
}
int32_t master_run_steps(double t, double h, int64_t block) { return run(t, h, block, REST); }

/* Start at t, with derivatives by the number in a cell; 0, or the status of what has failed. */
EXPORT int32_t slope_start(uint32_t cell, double t) {
    const int64_t address = (int64_t)(intptr_t)cells;
    memset(tangents, 0, 8 * size());
    memset(image + slope_cells, 0, 8 * (size() - 2 * (size_t)slope_cells));
    for (uint32_t k = 0; k < slope_change_count; k++) image[slope_changes[k]] = -INFINITY; /* outputs follow, for their tangents may have moved */
    memcpy(cells, image, 8 * (size_t)slope_cells);
    model_place(address);
    for (uint32_t k = 0; k < scene_place_count; k++)
        if (scene_places[k].function) memcpy(tangents + scene_places[k].cell, cells + scene_places[k].cell, 8);
    tangents[cell] = 1.0;
    moved = cells[cell] ? fabs(cells[cell]) : 1.0;
    ties = 0;
    cells[0] = t;
    return model_initialize(t, address);
}

/* Take so many macro steps and write the numbers of n cells, and their derivatives, into rows: before the first step where `first`,
   and after each. Returns how many steps were taken: fewer where one failed. */
EXPORT uint32_t slope_run(uint32_t steps, int first, const uint32_t *wanted, size_t n, double *values, double *derivatives) {
    for (uint32_t k = 0;; k++) {
        if (k || first) {
            for (size_t i = 0; i < n; i++) {
                *values++ = cells[wanted[i]];
                *derivatives++ = tangents[wanted[i]];
            }
        }
        if (k == steps || model_step(cells[0], scene_length, (int64_t)(intptr_t)cells)) return k;
    }
}

/* Whether a decision has stood at its very boundary, and the direction moves it: a derivative is that of one side at most then. */
EXPORT int32_t slope_at_tie(void) { return ties != 0; }
