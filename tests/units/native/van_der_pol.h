/* Van der Pol's oscillator by the classical Runge-Kutta method with internal steps of 1e-3 s. */
struct Data { double t, x0, x1, mu; };
#define AT(name) offsetof(Data, name)
static const Slot slots[] = {{0, FLOAT64, AT(t), 0}, {1, FLOAT64, AT(x0), 0}, {3, FLOAT64, AT(x1), 0}, {5, FLOAT64, AT(mu), 0}};
static void begin(Data *d, const char *r) { (void)r, *d = (Data){.x0 = 2.0, .mu = 1.0}; }
static void outputs(Data *d) { (void)d; }
static bool advance(Data *d, double end) {
    long n = lround((end - d->t) / 1e-3);
    double h = n > 0 ? (end - d->t) / n : 0.0;
    for (; n > 0; n--) {
        double k[4][2], x = d->x0, v = d->x1, part[] = {0.0, 0.5 * h, 0.5 * h, h};
        for (int i = 0; i < 4; i++) {
            double a = x + (i ? part[i] * k[i - 1][0] : 0.0), b = v + (i ? part[i] * k[i - 1][1] : 0.0);
            k[i][0] = b, k[i][1] = d->mu * (1.0 - a * a) * b - a;
        }
        d->x0 += h / 6.0 * (k[0][0] + 2.0 * k[1][0] + 2.0 * k[2][0] + k[3][0]);
        d->x1 += h / 6.0 * (k[0][1] + 2.0 * k[1][1] + 2.0 * k[2][1] + k[3][1]);
    }
    d->t = end;
    return false;
}
#include "nothing.h"
