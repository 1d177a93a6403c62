/* Gives the time and does what can go wrong, at times its parameters tell. */
#define MOODY
#include <unistd.h>
struct Data { double t, discard_at, end_at, early_at, pause, tolerance, exit_at; Truth restless; int64_t rest; char words[TEXT]; int32_t mischief; };
#define AT(name) offsetof(Data, name)
static const Slot slots[] = {{0, FLOAT64, AT(t), 0}, {6, FLOAT64, AT(t), 0}, {7, FLOAT64, AT(tolerance), 0},
                             {1, FLOAT64, AT(discard_at), 0}, {2, FLOAT64, AT(end_at), 0},
                             {3, FLOAT64, AT(early_at), 0}, {4, FLOAT64, AT(pause), 0}, {8, FLOAT64, AT(exit_at), 0}, {5, BOOLEAN, AT(restless), 0},
                             {9, STRING, AT(words), 0}, {10, INT32, AT(mischief), 0}};
static void begin(Data *d, const char *r) { (void)r, *d = (Data){.discard_at = 1e9, .end_at = 1e9, .early_at = 1e9, .exit_at = 1e9}; }
static void outputs(Data *d) { snprintf(d->words, TEXT, "at %.1f", d->t); }
static int deeper(volatile char *above) { char here[4096]; here[0] = *above; return deeper(here) + here[0]; }
static void misbehave(int how) {
    if (how == 0) exit(0);
    if (how == 1) for (int i = 0; i < 100000; i++) printf("a line of nothing that anybody wants to read, again and again\n");
    if (how == 2) for (int fd = 0; fd < 1024; fd++) close(fd);
    if (how == 3 && chdir("/")) exit(1);
    if (how == 5) { char c = 0; deeper(&c); }
    if (how == 6) for (int fd = 3; fd < 1024; fd++) if (write(fd, "\xff\xff\xff\x7f\x05 garbage", 14) < 0) continue;
    if (how == 7) abort();
}
static bool advance(Data *d, double end) {
    if (d->t < d->exit_at && d->exit_at <= end) misbehave(d->mischief);
    if (d->t < d->early_at && d->early_at < end) { d->t = d->early_at; return true; }
    d->t = end;
    return false;
}
static void event(Data *d, Outcome *o) { o->again = d->restless; }
#define EVENTS
#include "nothing.h"
