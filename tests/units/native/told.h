/* Tells what its importer has told it; does not give a number before `known_from`; discards what is longer than `longest`,
   after which it wants to go back to a state if it is `strict` (FMI 2); with `chatty` warns in every step; with `rounding` leaves
   the floating-point environment changed (1: rounds upward, 2: flushes to zero, 3: as 1 where outputs are read); with `writes`
   writes a file. */
#define TOLD
#include <fenv.h>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif
struct Data { double t, start, stop, tolerance, length, sensor, third, known_from, longest; int32_t chatty, rounding, writes, strict, steps; };
#define AT(name) offsetof(Data, name)
static const Slot slots[] = {{0, FLOAT64, AT(t), 0}, {1, FLOAT64, AT(start), 0}, {2, FLOAT64, AT(stop), 0},
                             {3, FLOAT64, AT(tolerance), 0}, {4, FLOAT64, AT(length), 0}, {5, FLOAT64, AT(sensor), 0},
                             {6, FLOAT64, AT(known_from), 0}, {7, FLOAT64, AT(longest), 0}, {8, INT32, AT(chatty), 0},
                             {9, INT32, AT(rounding), 0}, {10, INT32, AT(writes), 0}, {11, FLOAT64, AT(t), 0},
                             {12, FLOAT64, AT(third), 0}, {13, INT32, AT(strict), 0}};
static void begin(Data *d, const char *r) { (void)r, *d = (Data){.known_from = -1e9, .longest = 1e9}; }
static void told(Data *d, bool has_tolerance, double tolerance, double start, bool has_stop, double stop) {
    d->start = start, d->stop = has_stop ? stop : -1e6, d->tolerance = has_tolerance ? tolerance : -1.0;
}
static void outputs(Data *d) {
    if (d->rounding == 3) fesetround(FE_UPWARD);
    d->sensor = d->t < d->known_from ? NAN : d->t;
}
static volatile double one = 1.0, three = 3.0;
static bool advance(Data *d, double end) {
    d->third = one / three; /* depends on the rounding mode that it finds */
    d->length = end - d->t, d->t = end, d->steps++;
    if (d->rounding == 1) fesetround(FE_UPWARD);
#ifdef __SSE2__
    if (d->rounding == 2) _mm_setcsr(_mm_getcsr() | 0x8040);
#endif
    if (d->writes) {
        FILE *file = fopen("written-by-the-fmu", "a");
        if (file) fputs("a step\n", file), fclose(file);
    }
    return false;
}
#include "nothing.h"
