/* x' = u, z' = x in two internal steps; asks for u where it needs it, and is exact then for inputs of degree 2. */
struct Data { double t, u, x, z; };
#define AT(name) offsetof(Data, name)
static const Slot slots[] = {{0, FLOAT64, AT(t), 0}, {1, FLOAT64, AT(u), 0, 'i'}, {2, FLOAT64, AT(x), 0}, {3, FLOAT64, AT(z), 0}};
static void begin(Data *d, const char *r) { (void)r, *d = (Data){0}; }
static void outputs(Data *d) { (void)d; }
static bool advance(Data *d, double end) {
    double s = 0.5 * (end - d->t);
    for (int k = 0; k < 2; k++) {
        double u[3];
        for (int i = 0; i < 3; i++) request(d, d->t + 0.5 * i * s), u[i] = d->u;
        d->z += s * d->x + s * s * (u[0] / 6.0 + u[1] / 3.0);
        d->x += s / 6.0 * (u[0] + 4.0 * u[1] + u[2]);
        d->t = k ? end : d->t + s;
    }
    return false;
}
#include "nothing.h"
