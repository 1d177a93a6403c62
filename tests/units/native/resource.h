/* The first character of resources/y.txt. */
struct Data { double t; int32_t y; };
static const Slot slots[] = {{0, FLOAT64, offsetof(Data, t), 0}, {1, INT32, offsetof(Data, y), 0}};
static void begin(Data *d, const char *resources) {
    char path[4096];
    *d = (Data){0};
    snprintf(path, sizeof path, "%s/y.txt", strncmp(resources, "file://", 7) ? resources : resources + 7);
    FILE *file = fopen(path, "r");
    if (file) d->y = fgetc(file), fclose(file);
}
static void outputs(Data *d) { (void)d; }
static bool advance(Data *d, double end) { d->t = end; return false; }
#include "nothing.h"
