/* A counter that goes up with every second; it asks for the end of the simulation behind the tenth. */
struct Data { double t; int32_t counter; double next; };
static const Slot slots[] = {{0, FLOAT64, offsetof(Data, t), 0}, {1, INT32, offsetof(Data, counter), 0}};
static void begin(Data *d, const char *r) { (void)r, *d = (Data){.counter = 1, .next = 1.0}; }
static void outputs(Data *d) { (void)d; }
static bool advance(Data *d, double end) {
    bool due = d->next <= end;
    d->t = due ? d->next : end;
    return due;
}
static void event(Data *d, Outcome *o) {
    if (d->t >= d->next) d->counter++, d->next += 1.0;
    o->ends = d->counter > 10, o->announced = true, o->next = d->next;
}
#define EVENTS
#include "nothing.h"
