/* How the units of a scene begin: what their rows of the master's program call. */
#include "scene.h"

/* Initialize a unit anew, with its present inputs and parameters; everything else is as the build has it. */
int32_t scene_begin(double t, void *block, const Unit *unit) {
    double *cells = block;
    uint64_t *whole = (uint64_t *)block - unit->first;
    const uint32_t ranges = unit->left_count + (unit->follows_count && cells[unit->follows[0][0]] != 0.0 ? unit->follows_count : 0);
    uint32_t k = 0;
    int32_t status;
    for (uint32_t i = 0; i <= ranges; i++) { /* ranges are in the order of their cells */
        const uint32_t *range = i < unit->left_count ? unit->left[i] : i < ranges ? unit->follows[i - unit->left_count] : NULL;
        const uint32_t end = range ? range[0] : unit->cells;
        if (end > k) begin_cells(whole, unit->first + k, unit->first + end);
        if (range) k = range[1];
    }
    for (k = unit->u + (unit->u_end - unit->u) / 3; k < unit->u_end; k++) cells[k] = 0.0; /* slopes */
    cells[0] = t;
    status = unit->initialize(t, (int64_t)(intptr_t)block);
    return status ? status : unit->outputs(t, (int64_t)(intptr_t)block);
}
