/* x' = -k x by explicit Euler with internal steps of 0.1 s. */
struct Data { double t, x, k, dx; };
#define AT(name) offsetof(Data, name)
static const Slot slots[] = {{0, FLOAT64, AT(t), 0}, {1, FLOAT64, AT(x), 0}, {2, FLOAT64, AT(dx), 0}, {3, FLOAT64, AT(k), 0}};
static void begin(Data *d, const char *r) { (void)r, *d = (Data){.x = 1.0, .k = 1.0}; }
static void outputs(Data *d) { d->dx = -d->k * d->x; }
static bool advance(Data *d, double end) {
    for (long n = lround((end - d->t) / 0.1); n > 0; n--) d->x -= 0.1 * d->k * d->x;
    d->t = end;
    return false;
}
#include "nothing.h"
