/* Takes values back where some FMUs do: one in SetupExperiment, one in EnterInitializationMode, one at once; one is limited. */
#define RESETTING
struct Data { double t, early, late, never, limited, sum; int32_t whole; Truth choice; char text[TEXT]; };
#define AT(name) offsetof(Data, name)
static const Slot slots[] = {{0, FLOAT64, AT(t), 0}, {1, FLOAT64, AT(early), 0}, {2, FLOAT64, AT(late), 0},
                             {3, FLOAT64, AT(never), 0}, {4, FLOAT64, AT(limited), 0}, {5, FLOAT64, AT(sum), 0},
                             {6, INT32, AT(whole), 0}, {7, BOOLEAN, AT(choice), 0}, {8, STRING, AT(text), 0}};
static void begin(Data *d, const char *r) {
    (void)r, *d = (Data){.early = 1.0, .late = 1.0, .never = 1.0, .limited = 1.0, .whole = 1, .text = "start"};
}
static void set_up(Data *d) { begin(d, ""); }
static void enter(Data *d) { d->late = 1.0; }
static void outputs(Data *d) {
    d->never = 1.0, d->limited = fmin(d->limited, 10.0);
    d->sum = d->early + d->late + d->limited + d->whole + d->choice;
}
static bool advance(Data *d, double end) {
    d->t = end;
    return false;
}
#include "nothing.h"
