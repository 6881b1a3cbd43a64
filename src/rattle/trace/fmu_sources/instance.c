/* What an instance of every model says and checks.  Before it stands `Mechanism`, with EVERY_INSTANCE. */
#include <stdarg.h>

static fmi3Status say(Mechanism *m, fmi3Status status, const char *format, ...) {
    char text[600];
    va_list given;
    if (m->called.log == NULL || (status == fmi3Discard && !m->called.debug)) return status;
    va_start(given, format);
    vsnprintf(text, sizeof text, format, given);
    va_end(given);
    m->called.log(
        m->called.environment, status,
        status == fmi3Warning ? "logStatusWarning" : status == fmi3Discard ? "logStatusDiscard" : "logStatusError", text);
    return status;
}

static bool finite_numbers(const double *x, int n) {
    int i;
    for (i = 0; i < n; i++) {
        if (!(fabs(x[i]) < INFINITY)) return false;
    }
    return true;
}

#if NP > 0
static fmi3Status check_limits(Mechanism *m) {
    int i;
    for (i = 0; i < NP; i++) {
        if (!(fabs(m->p[i]) < INFINITY)) {
            return say(m, fmi3Error, "the parameter %s is not a finite number", names[i]);
        }
        if (m->p[i] < least[i] || m->p[i] > most[i]) {
            return say(m, fmi3Error, "the parameter %s = %g is not between its limits %g and %g", names[i], m->p[i],
                       least[i], most[i]);
        }
    }
    return fmi3OK;
}
#endif

static fmi3Status lacks(fmi3Instance instance, const char *what) {
    return say(instance, fmi3Error, "this model has no %s, as its description says", what);
}

static fmi3Status initialize(Mechanism *m, bool told, double tolerance, double start_time) {
    REQUIRE(INSTANTIATED, "fmi3EnterInitializationMode");
    if (start_time != 0.0) return say(m, fmi3Error, "the start time is %g s; this model starts at 0", start_time);
    if (told && !(tolerance > 0.0)) return say(m, fmi3Error, "the relative tolerance must be positive");
    if (told) m->tolerance = fmin(fmax(tolerance, SMALLEST_TOLERANCE), 0.1);
    m->mode = INITIALIZING;
    return fmi3OK;
}

static fmi3Status check_step(Mechanism *m, double point, double size) {
    if (!(size > 0.0 && size < INFINITY)) return say(m, fmi3Error, "the communication step size must be positive");
    if (!(fabs(point - m->t) <= 1e-6 * size + 1e-12 * fabs(m->t))) {
        return say(m, fmi3Error, "the communication point is %.17g s, but the model is at %.17g s", point, m->t);
    }
    return fmi3OK;
}
