/* Values of every mathematical function that a native FMU may call, for the same arguments on every Linux machine.

   functions COUNT: writes COUNT doubles for each function, in the order of the tables. */
#define _GNU_SOURCE
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct { double (*f)(double); double low, high; } One;
typedef struct { double (*f)(double, double); double low, high; } Two;
#define PLAIN(name) static double name##_(double x) { return name(x); }
#define PAIR(name) static double name##_(double x, double y) { return name(x, y); }
PLAIN(acos) PLAIN(acosh) PLAIN(asin) PLAIN(asinh) PLAIN(atan) PLAIN(atanh) PLAIN(cbrt) PLAIN(ceil) PLAIN(cos) PLAIN(cosh) PLAIN(erf)
PLAIN(erfc) PLAIN(exp) PLAIN(exp2) PLAIN(expm1) PLAIN(fabs) PLAIN(floor) PLAIN(lgamma) PLAIN(log) PLAIN(log10) PLAIN(log1p)
PLAIN(log2) PLAIN(nearbyint) PLAIN(rint) PLAIN(round) PLAIN(sin) PLAIN(sinh) PLAIN(sqrt) PLAIN(tan) PLAIN(tanh) PLAIN(tgamma)
PLAIN(trunc) PAIR(atan2) PAIR(copysign) PAIR(fmod) PAIR(hypot) PAIR(pow)
static double fma_(double x, double y) { return fma(x, y, 1.0); }
static double frexp_(double x) { int e; return frexp(x, &e) + e; }
static double ldexp_(double x) { return ldexp(x, (int)x); }
static double sincos_(double x) { double s, c; sincos(x, &s, &c); return s + 2.0 * c; }

static const One ONE[] = {
    {acos_, -1, 1}, {acosh_, 1, 50}, {asin_, -1, 1}, {asinh_, -50, 50}, {atan_, -50, 50}, {atanh_, -1, 1}, {cbrt_, -50, 50},
    {ceil_, -50, 50}, {cos_, -50, 50}, {cosh_, -20, 20}, {erf_, -3, 3}, {erfc_, -3, 3}, {exp_, -50, 50}, {exp2_, -50, 50},
    {expm1_, -5, 5}, {fabs_, -50, 50}, {floor_, -50, 50}, {frexp_, -50, 50}, {ldexp_, -50, 50}, {lgamma_, 0.1, 50}, {log_, 1e-3, 50},
    {log10_, 1e-3, 50}, {log1p_, -0.9, 5}, {log2_, 1e-3, 50}, {nearbyint_, -50, 50}, {rint_, -50, 50}, {round_, -50, 50},
    {sin_, -50, 50}, {sincos_, -50, 50}, {sinh_, -20, 20}, {sqrt_, 0, 50}, {tan_, -50, 50}, {tanh_, -5, 5}, {tgamma_, 0.1, 20},
    {trunc_, -50, 50}};
static const Two TWO[] = {{atan2_, -50, 50}, {copysign_, -50, 50}, {fma_, -50, 50}, {fmod_, -50, 50}, {hypot_, -50, 50}, {pow_, 1e-3, 9}};

static uint64_t seed = 88172645463325252u;
static double between(double low, double high) { /* xorshift */
    seed ^= seed << 13; seed ^= seed >> 7; seed ^= seed << 17;
    return low + (high - low) * ((double)(seed >> 11) * 0x1p-53);
}

int main(int argc, char **arguments) {
    if (argc != 2) return 2;
    const long count = atol(arguments[1]);
    for (size_t k = 0; k < sizeof ONE / sizeof *ONE; k++)
        for (long n = 0; n < count; n++) {
            const double value = ONE[k].f(between(ONE[k].low, ONE[k].high));
            fwrite(&value, sizeof value, 1, stdout);
        }
    for (size_t k = 0; k < sizeof TWO / sizeof *TWO; k++)
        for (long n = 0; n < count; n++) {
            const double x = between(TWO[k].low, TWO[k].high), value = TWO[k].f(x, between(TWO[k].low, TWO[k].high));
            fwrite(&value, sizeof value, 1, stdout);
        }
    return 0;
}
