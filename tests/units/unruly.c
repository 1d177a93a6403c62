/* The FMU of foreign.c with one of many troubles, by TROUBLE, from t = 0.45 s on or where the number says. */
#define _GNU_SOURCE
#define fmi2DoStep calm_step
#define fmi2Terminate calm_terminate
#define fmi2FreeInstance calm_free
#define fmi2EnterInitializationMode calm_initialize
#define fmi2GetReal calm_get
#include "foreign.c"
#undef fmi2DoStep
#undef fmi2Terminate
#undef fmi2FreeInstance
#undef fmi2EnterInitializationMode
#undef fmi2GetReal
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static double now;
static volatile int *nowhere;
static int deep(int k) { volatile char page[4096]; page[0] = (char)k; return deep(k + 1) + page[0]; }
static void hang(void) { for (;;) usleep(1000); }
static void garbage(void) { char text[1000]; memset(text, 0xA5, sizeof text); for (int k = 1; k < 64; k++) write(k, text, sizeof text); }

API int fmi2EnterInitializationMode(void *c) {
    if (TROUBLE == 18) *nowhere = 1;
    if (TROUBLE == 19) hang();
    return calm_initialize(c);
}
API int fmi2Terminate(void *c) {
    if (TROUBLE == 20) hang();
    return calm_terminate(c);
}
API void fmi2FreeInstance(void *c) {
    if (TROUBLE == 21) *nowhere = 1;
    calm_free(c);
}
API int fmi2GetReal(Unit *c, const unsigned *vr, size_t n, double *value) {
    int status = calm_get(c, vr, n, value);
    for (size_t i = 0; i < n && now > 0.45; i++) value[i] = TROUBLE == 9 ? NAN : TROUBLE == 10 ? INFINITY : value[i];
    return status;
}
API int fmi2DoStep(Unit *c, double t, double h, int no_rollback) {
    now = t;
    if (t > 0.45) switch (TROUBLE) {
        case 1: *nowhere = 1; break;
        case 2: abort();
        case 3: exit(0);
        case 4: _exit(7);
        case 5: hang();
        case 6: return ERROR;
        case 7: return 4; /* fmi2Fatal */
        case 8: return 77;
        case 11: for (;;) { char *block = malloc(1 << 24); if (!block) return ERROR; memset(block, 1, 1 << 24); }
        case 12: return deep(0);
        case 13: for (int k = 0; k < 300000; k++) printf("line %d of a library that says everything it thinks, again and again\n", k); break;
        case 14: c->callbacks->logger(NULL, NULL, 99, NULL, NULL); c->callbacks->logger(NULL, "", 0, "", "%s%n%d"); break;
        case 15: for (int k = 1; k < 256; k++) close(k); break;
        case 16: for (int k = 1; k < 32; k++) signal(k, SIG_IGN); chdir("/"); break;
        case 17: raise(SIGFPE); break;
        case 22: garbage(); break;
        case 23: memset((char *)c + sizeof(Unit), 0xff, 4096); break; /* what follows on the heap */
        case 24: if (!fork()) { hang(); } break;
    }
    return calm_step(c, t, h, no_rollback);
}
