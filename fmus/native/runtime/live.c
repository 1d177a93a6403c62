/* A run of a scene for a page: all macro steps in one call. The page may change the macro step, which an FMU has fixed, and cells of
   the block before initialization that another setting of the master fills with other numbers. */
#include "scene.h"

static struct { uint32_t count; const uint32_t *cells; const int64_t *values; } changed;
static void change(int64_t *cells) {
    for (uint32_t k = 0; k < changed.count; k++) cells[changed.cells[k]] = changed.values[k];
}

/* Cells with other values than at build, for instances made from now on; both arrays stay the caller's and have to stay. */
EXPORT void live_cells(uint32_t count, const uint32_t *cells, const int64_t *values) {
    changed.count = count;
    changed.cells = cells;
    changed.values = values;
    scene_changed = change;
}

/* Before initialization. */
EXPORT void live_macro_step(double length, double numerator, double denominator) { set_macro_step(length, numerator, denominator); }

/* What a run with tangents starts from: the cells of an instance before initialization, and where a variable lies among them. */
EXPORT const double *live_block(const Instance *m) { return m->block; }
EXPORT uint32_t live_cell(uint32_t reference) { return model_variables[reference].cell; }

static struct { size_t n; const uint32_t *references; uint32_t every, step; double *row; } pictures;
/* For the next run: write n further outputs into rows, at its begin and after every so many steps; none for n = 0. */
EXPORT void live_pictures(size_t n, const uint32_t *references, uint32_t every, double *rows) {
    pictures.n = n;
    pictures.references = references;
    pictures.every = every;
    pictures.step = 0;
    pictures.row = rows;
}

static void sample(const Instance *m, const uint32_t *references, size_t n, double *row) {
    for (size_t i = 0; i < n; i++) row[i] = m->block[model_variables[references[i]].cell];
}

static void take_picture(const Instance *m) {
    if (!pictures.n || pictures.step % pictures.every) return;
    sample(m, pictures.references, pictures.n, pictures.row);
    pictures.row += pictures.n;
}

/* Take so many macro steps from time t and write n outputs into rows: once before the steps, and after each. Returns how many
   steps were taken: fewer where one failed, whose message the logger has got. */
EXPORT uint32_t live_run(Instance *m, double t, uint32_t steps, const uint32_t *references, size_t n, double *rows) {
    uint32_t k = 0;
    sample(m, references, n, rows);
    if (!pictures.step) take_picture(m);
    while (k < steps && !do_step(m, t + k * scene_length, scene_length)) {
        sample(m, references, n, rows + ++k * n);
        ++pictures.step;
        take_picture(m);
    }
    return k;
}
