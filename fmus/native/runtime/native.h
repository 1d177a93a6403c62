/* What a native FMU consists of: the tables of one model, and the runtime that every model shares. */
#ifndef NATIVE_H
#define NATIVE_H
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

enum { REAL, INTEGER, BOOLEAN, STRING };                         /* types of variables */
enum { ABSENT, CONSTANT, PARAMETER, INPUT, DERIVATIVE, OUTPUT, CLOCK_TIME }; /* roles; of an effect that is off: absent */
enum { OK, WARNING, DISCARD, ERROR };                            /* statuses, of both versions of FMI */

/* One variable; its position in the table is its value reference. */
typedef struct {
    const char *name;
    uint8_t type, role;
    uint32_t size;             /* FMI 3: number of elements of the array that begins here; 0 inside of one */
    uint32_t cell;             /* of a parameter, an input, a derivative or an output in the block */
    double factor;             /* of the cell over the variable */
    double value, nominal;     /* value of a constant, size of an input */
    double low, high;          /* limits of a parameter */
    const char *text;          /* of a constant String */
    bool tunable;              /* of a parameter: it may be set during the run */
} Variable;
typedef struct { uint32_t first, count; } Run; /* of cells */
typedef struct { int32_t status; const char *text; uint32_t cells[4]; } Reason; /* a format, and numbers of the block for it */

/* ---- written at build ---- */
extern const Variable model_variables[];
extern const Reason model_reasons[];
extern const Run model_runs[];       /* of the block before initialization, whose other cells are zero, */
extern const uint64_t model_values[]; /* and their numbers */
extern const char model_token[];
extern const int32_t model_untouched; /* status of a step that was refused before anything changed; 0: there is none */
extern const uint32_t model_run_count, model_variable_count, model_reason_count, model_cells, model_saved, model_parameters, model_parameters_size;
extern const uint32_t model_given[][2], model_given_count; /* ranges of cells that the host sets: inputs and parameters */
extern const uint32_t model_row; /* from an input to its derivative; 0: inputs are held */
extern const bool model_whole; /* a state is the whole block, with what follows from parameters */
int32_t model_initialize(double t, int64_t block);
int32_t model_step(double t, double h, int64_t block);
int32_t model_outputs(double t, int64_t block);
/* The derivative of the outputs along one direction: the tangent of a cell lies `offset` bytes behind it, as for cells of the stack. */
int32_t model_slopes(double t, int64_t block, int64_t offset, int64_t stack, int64_t ties);
enum { STACK = 1 << 15 }; /* cells */
void model_place(int64_t block); /* addresses in a block that has come from elsewhere */
void model_forget(uint64_t *cells); /* no addresses in the cells of a state, which is the same in every process */

/* ---- native.c ---- */
typedef struct Instance Instance;
typedef void (*Logger)(const Instance *, int status, const char *category, const char *text);
struct Instance {
    uint32_t phase, stale;       /* stale: the outputs do not belong to the present inputs */
    int initialized;             /* what follows from the parameters stands in the block */
    int logging, fmi3;
    int discarded;               /* the last step was */
    double t, start, stop;
    Logger log;
    void *environment, *callback; /* of the host */
    char name[256];
    double *kept; /* outputs before the step that is under way, by value reference */
    double *block; /* at the beginning of a cache line, as the layout of its arrays asks for */
};
enum { INSTANTIATED = 1, INITIALIZATION = 2, STEPPING = 4, FAILED = 8, TERMINATED = 16, DISCARDED = 32 };

void begin_cells(void *cells, uint32_t first, uint32_t end); /* the cells from `first` on to before `end`, as the build has them */
int report(const Instance *m, int status, const char *format, ...);
Instance *create(const char *name, const char *token, int logging, int fmi3, Logger log, void *environment, void *callback);
void discard_instance(void *m);
int allowed(const Instance *m, uint32_t phases, const char *call);
int get_values(Instance *m, int type, const uint32_t *references, size_t n, void *values, size_t room);
int set_values(Instance *m, int type, const uint32_t *references, size_t n, const void *values, size_t room);
int set_slopes(Instance *m, const uint32_t *references, size_t n, const int32_t *orders, const double *values);
int set_logging(Instance *m, int on, size_t n, const char *const *categories);
int setup(Instance *m, double start, int has_stop, double stop);
int enter_initialization(Instance *m);
int exit_initialization(Instance *m);
int terminate(Instance *m);
int reset(Instance *m);
int do_step(Instance *m, double t, double h);
int directional(Instance *m, const uint32_t *unknowns, size_t n, const uint32_t *knowns, size_t k, const double *seed, size_t seeds,
                double *result, size_t results);
int get_state(Instance *m, void **state);
int set_state(Instance *m, const void *state);
int free_state(Instance *m, void **state);
int state_size(Instance *m, const void *state, size_t *size);
int serialize(Instance *m, const void *state, void *bytes, size_t size);
int deserialize(Instance *m, const void *bytes, size_t size, void **state);
/* By how much a time may be off, four units in the last place: masters form steps as differences of times. */
static inline double rounding_at(double t) { return 4.0 * (nextafter(fabs(t), INFINITY) - fabs(t)); }
int refuse(const Instance *m, const char *call); /* a function that this kind of FMU does not offer */
#endif
