/* Every input comes out again; the continuous real one with two parameters added, the text as it is. */
struct Data {
    double t, real_in, real_out, held_in, held_out, fixed, tunable;
    float float_in, float_out, float_held_in, float_held_out;
    int8_t i8, i8_out; uint8_t u8, u8_out; int16_t i16, i16_out; uint16_t u16, u16_out; int32_t i32, i32_out; uint32_t u32, u32_out;
    int64_t i64, i64_out; uint64_t u64, u64_out; Truth truth, truth_out; char text[TEXT], text_out[TEXT]; Octets octets, octets_out;
#if FMI == 2
    int choice, choice_out;
#else
    int64_t choice, choice_out;
#endif
};
#define AT(name) offsetof(Data, name)
#define BOTH(reference, type, name) {reference, type, AT(name), 0}, {reference + 1, type, AT(name##_out), 0}
static const Slot slots[] = {
    {0, FLOAT64, AT(t), 0}, {1, FLOAT32, AT(float_in), 0}, {2, FLOAT32, AT(float_out), 0}, {3, FLOAT32, AT(float_held_in), 0, 'd'},
    {4, FLOAT32, AT(float_held_out), 0}, {5, FLOAT64, AT(fixed), 0, 'd'}, {6, FLOAT64, AT(tunable), 0, 'd'}, {7, FLOAT64, AT(real_in), 0},
    {8, FLOAT64, AT(real_out), 0}, {9, FLOAT64, AT(held_in), 0, 'd'}, {10, FLOAT64, AT(held_out), 0},
    BOTH(11, INT8, i8), BOTH(13, UINT8, u8), BOTH(15, INT16, i16), BOTH(17, UINT16, u16), BOTH(19, INT32, i32),
    BOTH(21, UINT32, u32), BOTH(23, INT64, i64), BOTH(25, UINT64, u64), BOTH(27, BOOLEAN, truth), BOTH(29, STRING, text), BOTH(31, BINARY, octets),
#if FMI == 2
    BOTH(33, INT32, choice),
#else
    BOTH(33, INT64, choice),
#endif
};
static void begin(Data *d, const char *r) { (void)r, *d = (Data){.choice = 1, .text = "Set me!", .octets = {3, "foo"}}; }
static void outputs(Data *d) {
    d->real_out = d->real_in + d->fixed + d->tunable;
#define COPY(name) d->name##_out = d->name;
    COPY(i8) COPY(u8) COPY(i16) COPY(u16) COPY(i32) COPY(u32) COPY(i64) COPY(u64) COPY(truth) COPY(choice) COPY(octets)
    d->float_out = d->float_in, d->float_held_out = d->float_held_in, d->held_out = d->held_in;
    memcpy(d->text_out, d->text, TEXT);
}
static bool advance(Data *d, double end) { d->t = end; return false; }
static bool derivative(const Data *d, unsigned unknown, size_t i, unsigned known, size_t k, double *value) {
    (void)d, (void)i, (void)k;
    *value = (unknown == 8 && (known == 5 || known == 6 || known == 7)) || (unknown == 2 && known == 1);
    return true;
}
#define DERIVATIVES
#include "nothing.h"
