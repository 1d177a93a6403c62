/* x' = A x + B u, y = C x + D u with up to 4 of each, by Taylor's series of a constant input: exact to rounding. */
#define MOST 4
struct Data { double t; uint64_t m, n, r; double A[MOST * MOST], B[MOST * MOST], C[MOST * MOST], D[MOST * MOST], x0[MOST], u[MOST],
              y[MOST], x[MOST]; };
#define AT(name) offsetof(Data, name)
static size_t m(const Data *d) { return d->m; }
static size_t n(const Data *d) { return d->n; }
static size_t r(const Data *d) { return d->r; }
static size_t nn(const Data *d) { return d->n * d->n; }
static size_t nm(const Data *d) { return d->n * d->m; }
static size_t rn(const Data *d) { return d->r * d->n; }
static size_t rm(const Data *d) { return d->r * d->m; }
static const Slot slots[] = {
    {0, FLOAT64, AT(t), 0}, {1, UINT64, AT(m), 0, 's'}, {2, UINT64, AT(n), 0, 's'}, {3, UINT64, AT(r), 0, 's'}, {4, FLOAT64, AT(A), nn},
    {5, FLOAT64, AT(B), nm}, {6, FLOAT64, AT(C), rn}, {7, FLOAT64, AT(D), rm}, {8, FLOAT64, AT(x0), n}, {9, FLOAT64, AT(u), m},
    {10, FLOAT64, AT(y), r}, {11, FLOAT64, AT(x), n}};
static void begin(Data *d, const char *resources) {
    (void)resources, *d = (Data){.m = 3, .n = 3, .r = 3};
    for (int i = 0; i < 3; i++) d->A[4 * i] = d->B[4 * i] = d->C[4 * i] = d->D[4 * i] = 1.0, d->u[i] = i + 1.0;
}
static double dot(const double *row, const double *x, size_t k) {
    double sum = 0.0;
    for (size_t j = 0; j < k; j++) sum += row[j] * x[j];
    return sum;
}
static void outputs(Data *d) {
    if (d->t == 0.0) memcpy(d->x, d->x0, sizeof d->x);
    for (size_t i = 0; i < d->r; i++) d->y[i] = dot(d->C + i * d->n, d->x, d->n) + dot(d->D + i * d->m, d->u, d->m);
}
static bool advance(Data *d, double end) {
    double h = end - d->t, term[MOST], next[MOST];
    if (d->t == 0.0) memcpy(d->x, d->x0, sizeof d->x);
    for (size_t i = 0; i < d->n; i++) term[i] = h * (dot(d->A + i * d->n, d->x, d->n) + dot(d->B + i * d->m, d->u, d->m));
    for (int k = 2; k < 40; k++) {
        for (size_t i = 0; i < d->n; i++) d->x[i] += term[i];
        for (size_t i = 0; i < d->n; i++) next[i] = h / k * dot(d->A + i * d->n, term, d->n);
        memcpy(term, next, sizeof term);
    }
    d->t = end;
    return false;
}
static bool derivative(const Data *d, unsigned unknown, size_t i, unsigned known, size_t k, double *value) {
    *value = unknown == 10 && known == 9 ? d->D[i * d->m + k] : 0.0;
    return true;
}
#define DERIVATIVES
#include "nothing.h"
