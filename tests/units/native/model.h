/* What a model of these test FMUs consists of; fmi2.c and fmi3.c make an FMU of it. The models do what the Reference FMUs
   of the Modelica Association (github.com/modelica/Reference-FMUs) of the same names do. No model holds a pointer, so that
   a copy of its data is its state. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum Type { FLOAT64, FLOAT32, INT8, UINT8, INT16, UINT16, INT32, UINT32, INT64, UINT64, BOOLEAN, STRING, BINARY };
#if FMI == 2
typedef int Truth;
#else
typedef bool Truth;
#endif
#define TEXT 64
typedef struct { size_t length; uint8_t octets[TEXT]; } Octets;

typedef struct { bool again, ends, announced; double next; } Outcome; /* of the update of discrete states */
typedef struct Data Data;
typedef struct {
    unsigned reference;
    enum Type type;
    size_t offset;
    size_t (*count)(const Data *); /* elements of an array; none: a scalar */
    char when; /* 'd': changes at instants only, as all but reals do; 's': size of an array;
                  'i': input that may be given inside a step */
} Slot;

static void begin(Data *d, const char *resources);       /* start values */
static void outputs(Data *d);                            /* what follows from the inputs at once */
static bool advance(Data *d, double end);                /* to the end or to an event before it, which is told */
static void event(Data *d, Outcome *outcome);            /* update of discrete states */
static void request(Data *d, double t);                  /* the inputs at a time inside a step, if the importer gives them */
static bool derivative(const Data *d, unsigned unknown, size_t i, unsigned known, size_t k, double *value);

#include MODEL

#define SLOTS (sizeof slots / sizeof *slots)
static double *clock_of(Data *d) { return (double *)d; } /* the time is the first field of every model */

static const Slot *slot(unsigned reference, enum Type type) {
    for (size_t i = 0; i < SLOTS; i++)
        if (slots[i].reference == reference && slots[i].type == type) return slots + i;
    return NULL;
}

static const Slot *real(unsigned reference) {
    const Slot *s = slot(reference, FLOAT64);
    return s ? s : slot(reference, FLOAT32);
}

static size_t count(const Data *d, const Slot *s) { return s->count ? s->count(d) : 1; }

/* The derivatives of all elements of some variables along a direction. */
static bool along(const Data *d, const unsigned *unknowns, size_t nu, const unsigned *knowns, size_t nk, const double *seed,
                  double *result) {
    for (size_t u = 0; u < nu; u++) {
        const Slot *y = real(unknowns[u]);
        if (!y) return false;
        for (size_t i = 0; i < count(d, y); i++) {
            const double *direction = seed;
            double sum = 0.0, value;
            for (size_t k = 0; k < nk; k++) {
                const Slot *x = real(knowns[k]);
                if (!x) return false;
                for (size_t j = 0; j < count(d, x); j++) {
                    if (!derivative(d, unknowns[u], i, knowns[k], j, &value)) return false;
                    sum += value * *direction++;
                }
            }
            *result++ = sum;
        }
    }
    return true;
}
