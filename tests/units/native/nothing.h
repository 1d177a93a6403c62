/* For models without events or derivatives. */
#ifndef EVENTS
static void event(Data *d, Outcome *outcome) { (void)d, (void)outcome; }
#endif
#ifndef DERIVATIVES
static bool derivative(const Data *d, unsigned unknown, size_t i, unsigned known, size_t k, double *value) {
    (void)d, (void)unknown, (void)i, (void)known, (void)k, (void)value;
    return false;
}
#endif
