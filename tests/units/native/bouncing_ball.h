/* A ball that bounces: free flight is exact, and so are the times of the events. */
struct Data { double t, h, v, g, e; int64_t bounces; };
#define AT(name) offsetof(Data, name)
static const Slot slots[] = {{0, FLOAT64, AT(t), 0}, {1, FLOAT64, AT(h), 0}, {3, FLOAT64, AT(v), 0}, {5, FLOAT64, AT(g), 0},
                             {6, FLOAT64, AT(e), 0}};
static void begin(Data *d, const char *r) { (void)r, *d = (Data){.h = 1.0, .g = -9.81, .e = 0.7}; }
static void outputs(Data *d) { (void)d; }
static bool advance(Data *d, double end) {
    double fall = d->g < 0.0 ? (-d->v - sqrt(d->v * d->v - 2.0 * d->g * d->h)) / d->g : INFINITY, dt = end - d->t;
    bool hits = fall <= dt;
    if (hits) dt = fall;
    d->h = hits ? 0.0 : d->h + dt * (d->v + 0.5 * d->g * dt);
    d->v += d->g * dt;
    d->t = hits ? d->t + dt : end;
    return hits;
}
static void event(Data *d, Outcome *o) {
    (void)o;
    if (d->h > 0.0 || d->v >= 0.0) return;
    d->bounces++;
    d->v = -d->e * d->v;
    if (d->v < 0.1) d->v = d->g = 0.0; /* it lies */
}
#define EVENTS
#include "nothing.h"
