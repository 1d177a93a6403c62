/* What the library of a scene holds beside that of a component: one block with the blocks of its units and of its master. */
#ifndef SCENE_H
#define SCENE_H
#include "native.h"

enum { INSIDE = 99 }; /* an error inside a kernel; it has no message of its own */
typedef int32_t (*Entry)(double t, double h, void *block);
/* A cell that holds an address: of a function, or of another cell of the block. */
typedef struct { uint32_t cell, target; Entry function; } Place;
/* A unit: its cells in the block, ranges among them that an initialization leaves, those of its inputs, and the entries that
   initialize it. What follows from parameters alone is left, too, once it has been computed, as the first cell of it says. */
typedef struct {
    uint32_t first, cells, u, u_end, left_count, follows_count;
    const uint32_t (*left)[2], (*follows)[2];
    int32_t (*initialize)(double, int64_t), (*outputs)(double, int64_t);
} Unit;
/* What becomes of a fault behind so many macro steps: the cell that says so. */
typedef struct { int64_t steps; uint32_t cell; int64_t change; } Change;
extern void (*scene_changed)(int64_t *cells); /* what a host changes in the block of the build, each time that it is filled */
/* ---- written at build ---- */
extern const Change scene_changes[];
extern const uint32_t scene_change_count, scene_follow_rows[2], scene_jump_rows[2];
extern int32_t (*const scene_begin_change)(double, double, int64_t), (*const scene_end_change)(double, double, int64_t);
extern const Place scene_places[];
extern const uint32_t scene_place_count, scene_times[], scene_time_count, scene_master;
extern const uint32_t scene_steps, scene_start, scene_asked; /* of the first cells of the block */
extern const uint32_t scene_request_first, scene_request_last, scene_request_steps, scene_request_times,
    scene_request_whole, scene_request_updated, scene_request_rows, scene_request_sampled_count, scene_request_unit, scene_request_status; /* of the master's */
extern const uint32_t scene_signals, scene_inverse, scene_signal_count, scene_step_rows[2], scene_push_rows[2];
/* statuses, each with a message; of unit k: scene_per_unit * (k + 1) + its own */
extern const int32_t scene_not_a_multiple, scene_grown, scene_not_converged, scene_per_unit;
extern double scene_length;                       /* of the macro step, s */
extern int64_t scene_numerator, scene_denominator; /* of it as it is written; 0 for one of too many digits */
extern const int64_t scene_failed, scene_none, scene_no_values; /* of the request: a unit's status times this; no unit; no convergence */
extern const double scene_growth; /* of an output over its nominal value: no answer of a model any more */
int32_t master_run_steps(double t, double h, int64_t block);
int32_t master_initialize_groups(double t, double h, int64_t block);
void scene_sample(double t, int64_t *cells); /* at the start and behind each macro step */

int32_t scene_begin(double t, void *block, const Unit *unit);
/* Seconds of a macro step, which an FMU has fixed; numerator / denominator is the same number, 0 where no whole numbers are. */
static inline void set_macro_step(double length, double numerator, double denominator) {
    scene_length = length;
    scene_numerator = (int64_t)numerator;
    scene_denominator = (int64_t)denominator;
}
#endif
