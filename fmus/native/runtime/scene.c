/* A scene as one model: its units are initialized in groups, its master takes the macro steps that a step of the host consists of. */
#include "scene.h"
#include <math.h>
#include <string.h>

#define EXACT ((int64_t)1 << 53) /* whole numbers up to this are doubles */

void (*scene_changed)(int64_t *cells) = NULL;

void model_place(int64_t address) {
    int64_t *cells = (int64_t *)(intptr_t)address;
    if (scene_changed) scene_changed(cells);
    for (uint32_t k = 0; k < scene_place_count; k++) {
        const Place *p = scene_places + k;
        cells[p->cell] = p->function ? (int64_t)(intptr_t)p->function : address + 8 * (int64_t)p->target;
    }
}

void model_forget(uint64_t *cells) {
    for (uint32_t k = 0; k < scene_place_count; k++) cells[scene_places[k].cell] = 0;
}

/* Take rows of the program; returns the status of the model. */
static int32_t take(int64_t *cells, const uint32_t rows[2], int whole, double t, double h) {
    cells[scene_request_first] = rows[0];
    cells[scene_request_last] = rows[1];
    cells[scene_request_steps] = 1;
    cells[scene_request_times] = cells[scene_request_rows] = cells[scene_request_sampled_count] = 0;
    cells[scene_request_whole] = whole;
    return master_run_steps(t, h, (int64_t)(intptr_t)(cells + scene_master)) ? INSIDE : OK;
}
static int32_t failure(const int64_t *cells) {
    const int64_t unit = cells[scene_request_unit];
    const double *values = (const double *)cells;
    if (unit >= 0) return (int32_t)(scene_per_unit * (unit + 1) + cells[scene_request_status] / scene_failed);
    if (unit == scene_no_values) return scene_not_converged;
    if (unit == scene_none) return OK;
    for (uint32_t k = 0; k < scene_signal_count; k++)
        if (!(fabs(values[scene_signals + k] * values[scene_inverse + k]) <= scene_growth)) return scene_grown;
    return OK;
}

/* What happens behind the macro steps that have been taken: faults begin and end, signals jump, outputs follow, figures take their samples. */
static int32_t arrive(double t, int64_t *cells) {
    const int64_t master = (int64_t)(intptr_t)(cells + scene_master);
    int32_t status = OK, changed = 0;
    for (uint32_t k = 0; k < scene_change_count; k++)
        if (scene_changes[k].steps == cells[scene_steps]) {
            cells[scene_changes[k].cell] = scene_changes[k].change;
            changed = 1;
        }
    if (changed) {
        cells[scene_request_updated] = 0;
        if (scene_begin_change(t, 0.0, master)) return INSIDE;
        if ((status = take(cells, scene_jump_rows, 0, t, 0.0)) || (status = failure(cells))) return status;
        if ((status = take(cells, scene_follow_rows, 0, t, 0.0)) || (status = failure(cells))) return status;
        if (scene_end_change(t, 0.0, master)) return INSIDE;
    }
    scene_sample(t, cells);
    return OK;
}

int32_t model_initialize(double t, int64_t address) {
    int64_t *cells = (int64_t *)(intptr_t)address;
    double *values = (double *)cells;
    int32_t status;
    cells[scene_steps] = 0;
    values[scene_start] = t;
    if (master_initialize_groups(t, 0.0, (int64_t)(intptr_t)(cells + scene_master))) return INSIDE;
    if ((status = failure(cells))) return status;
    for (uint32_t k = 0; k < scene_time_count; k++) values[scene_times[k]] = t;
    if ((status = take(cells, scene_push_rows, 0, t, 0.0))) return status;
    return arrive(t, cells);
}

/* Time of so many macro steps, s: correctly rounded as in process, while the whole numbers are exact. */
static double reached(int64_t steps) {
    if (scene_numerator && steps <= EXACT / scene_numerator) return (double)(steps * scene_numerator) / (double)scene_denominator;
    return (double)steps * scene_length;
}

int32_t model_step(double t, double h, int64_t address) {
    int64_t *cells = (int64_t *)(intptr_t)address;
    double *values = (double *)cells;
    const double n = nearbyint(h / scene_length);
    values[scene_asked] = h;
    if (!(n >= 1.0) || fabs(h - n * scene_length) > rounding_at(fmax(fabs(t), fabs(t + h)))) return scene_not_a_multiple;
    for (double k = 0.0; k < n; k += 1.0) {
        int32_t status = take(cells, scene_step_rows, 1, values[scene_start] + reached(cells[scene_steps]), scene_length);
        if (status || (status = failure(cells))) return status;
        cells[scene_steps]++;
        if ((status = arrive(values[scene_start] + reached(cells[scene_steps]), cells))) return status;
    }
    return OK;
}

int32_t model_outputs(double t, int64_t address) { /* they are those of the last step: inputs act from the next one on */
    (void)t; (void)address;
    return OK;
}
