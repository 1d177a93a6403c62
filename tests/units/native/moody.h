/* Gives the time and does what can go wrong, at times its parameters tell. */
#define MOODY
struct Data { double t, discard_at, end_at, early_at, pause, tolerance, exit_at; Truth restless; int64_t rest; char words[TEXT]; };
#define AT(name) offsetof(Data, name)
static const Slot slots[] = {{0, FLOAT64, AT(t), 0}, {6, FLOAT64, AT(t), 0}, {7, FLOAT64, AT(tolerance), 0},
                             {1, FLOAT64, AT(discard_at), 0}, {2, FLOAT64, AT(end_at), 0},
                             {3, FLOAT64, AT(early_at), 0}, {4, FLOAT64, AT(pause), 0}, {8, FLOAT64, AT(exit_at), 0}, {5, BOOLEAN, AT(restless), 0},
                             {9, STRING, AT(words), 0}};
static void begin(Data *d, const char *r) { (void)r, *d = (Data){.discard_at = 1e9, .end_at = 1e9, .early_at = 1e9, .exit_at = 1e9}; }
static void outputs(Data *d) { snprintf(d->words, TEXT, "at %.1f", d->t); }
static bool advance(Data *d, double end) {
    if (d->t < d->exit_at && d->exit_at <= end) exit(0);
    if (d->t < d->early_at && d->early_at < end) { d->t = d->early_at; return true; }
    d->t = end;
    return false;
}
static void event(Data *d, Outcome *o) { o->again = d->restless; }
#define EVENTS
#include "nothing.h"
