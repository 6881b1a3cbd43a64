/* One instance of the mechanism in equations.c: its start, its rates and curves, its steps.  The same in every FMU.

   Steps are those of a run: Dormand-Prince 8(5, 3), each brought onto the constraints.
   Source of the method and of the choice of steps: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I
   (1993), sections II.4 and II.10. */

enum { TIME, FIRST_PARAMETER };
enum {
    FIRST_FOLLOWING = FIRST_PARAMETER + NP,
    FIRST_STATE = FIRST_FOLLOWING + ND,
    FIRST_RATE = FIRST_STATE + NY,
    FIRST_CURVE = FIRST_RATE + NY,
    END_OF_VARIABLES = FIRST_CURVE + NO
};
typedef struct {
    EVERY_INSTANCE
    bool drifted, rates_known;           /* states are off the constraints; rates are those at t and y */
    double most_drift;                   /* off the constraints in model exchange, as a share of the state's size */
    double h;                            /* next step [s]; 0: not chosen yet */
    double y[NY], dy[NY];                /* [SI] */
    double following[ND + 1];            /* parameters that follow from others [SI] */
    double energy;                       /* at the start [J] */
    double kinetic, work, lowest, highest; /* largest energies so far, range of the potential one [J] */
    double in[1 + NY + NC];              /* arguments of the recorded functions: t, y, what parameters determine */
} Mechanism;

#include "instance.c"

/* ---------------------------------------------------------------- the recorded functions */
typedef void (*Function)(const double *in, double *out);

/* a function at an instant: n numbers and a flag; false where they are not finite or the flag is not set */
static bool evaluate(Mechanism *m, Function function, double t, const double *y, double *out, int n) {
    m->in[0] = t;
    memcpy(m->in + 1, y, sizeof m->y);
    function(m->in, out);
    return out[n] != 0.0 && finite_numbers(out, n);
}

static bool rate(Mechanism *m, double t, const double *y, double *dy) {
    double out[NY + 1];
    if (!evaluate(m, derivative, t, y, out, NY)) return false;
    memcpy(dy, out, sizeof m->y);
    return true;
}

static bool on_constraints(Mechanism *m, double t, const double *y, double *closed) {
    double out[NY + 1];
    if (!evaluate(m, project, t, y, out, NY)) return false;
    memcpy(closed, out, sizeof m->y);
    return true;
}

static void moved(Mechanism *m) { m->rates_known = m->curves_known = false; }

static fmi3Status cannot(Mechanism *m) {
    return say(m, m->called.exchange ? fmi3Discard : fmi3Error,
               "t = %g s: near a singular position or coincident points, or a load has no finite value", m->t);
}

static fmi3Status need_rates(Mechanism *m) {
    if (!m->rates_known) {
        if (!rate(m, m->t, m->y, m->dy)) return cannot(m);
        m->rates_known = true;
    }
    return fmi3OK;
}

static fmi3Status need_curves(Mechanism *m) {
    double out[NO + 1];
    if (!m->curves_known) {
        if (!evaluate(m, outputs, m->t, m->y, out, NO)) return cannot(m);
        memcpy(m->curves, out, sizeof m->curves);
        m->curves_known = true;
    }
    return fmi3OK;
}

/* a warning, once, where the energy error is above 0.1 % of the largest energy */
static fmi3Status audit(Mechanism *m) {
    double largest, rounding;
    if (need_curves(m) != fmi3OK) return fmi3Error;
    const double kinetic = m->curves[KINETIC], potential = m->curves[POTENTIAL], balance = m->curves[BALANCE];
    m->kinetic = fmax(m->kinetic, kinetic);
    m->lowest = fmin(m->lowest, potential);
    m->highest = fmax(m->highest, potential);
    m->work = fmax(m->work, fabs(m->y[WORK]));
    largest = fmax(fmax(m->kinetic, m->work), m->highest - m->lowest);
    rounding = 1e-12 * (m->kinetic + m->work + fmax(fabs(m->lowest), fabs(m->highest)));
    if (m->warned || fabs(balance) <= 1e-3 * largest + rounding) return fmi3OK;
    m->warned = true;
    return say(m, fmi3Warning,
               "t = %g s: energy error %g J, above 0.1 %% of the largest energy: give a smaller relative tolerance",
               m->t, fabs(balance));
}

/* ---------------------------------------------------------------- the start */
#if NP > 0
/* largest change of positions, as a share of the mechanism's size or in rad */
static double change(const double *q, const double *before) {
    double largest = 0.0;
    int i;
    for (i = 0; i < NQ; i++) {
        const double one = fabs(q[i] - before[i]) / (i % 3 == 2 ? 1.0 : SIZE);
        if (!(one <= largest)) largest = one;
    }
    return largest;
}

/* positions that follow from the parameters, by Newton's method from positions nearby; whole: t = 0, y, parameters, 0 */
static bool close_positions(double *whole) {
    double found[NQ + 2], began[NQ], step = INFINITY;
    double *const q = whole + 1;
    int k;
    memcpy(began, q, sizeof began);
    for (k = 0; k < ROUNDS && step > LAST_STEP; k++) {
        correct(whole, found);
        if (found[NQ + 1] == 0.0 || !finite_numbers(found, NQ)) return false;
        step = change(found, q);
        memcpy(q, found, sizeof began);
    }
    return found[NQ] <= STILL_OPEN * SIZE && change(q, began) <= FAR;
}

/* the start at given parameters, on a straight way from the one that was written, in more and more steps */
static bool close_start(double *whole, const double *p) {
    double found[NQ + 2], largest = 1.0;
    double *const q = whole + 1, *const v = q + NQ, *const now = whole + 1 + NY;
    bool closed = false;
    int parts, k, i;
    for (parts = 1; parts <= MOST_PARTS && !closed; parts *= 2) {
        memcpy(whole + 1, start, sizeof start);
        closed = true;
        for (k = 1; k <= parts && closed; k++) {
            for (i = 0; i < NP; i++) now[i] = k == parts ? p[i] : nominal[i] + (p[i] - nominal[i]) * k / parts;
            closed = close_positions(whole);
        }
    }
    if (!closed) return false;
    close_rates(whole, found);
    if (found[NQ + 1] == 0.0 || !finite_numbers(found, NQ)) return false;
    memcpy(v, found, sizeof(double) * NQ);
    for (i = 0; i < NQ; i++) largest = fmax(largest, fabs(v[i]));
    return found[NQ] <= MISSED * largest;
}

#endif

/* parameters that follow from others; an error where they give another kind of model */
static fmi3Status follow_parameters(Mechanism *m, double *whole) {
#if NP > 0
    double known[ND + 1];
    int i;
    if (check_limits(m) != fmi3OK) return fmi3Error;
    memcpy(whole + 1 + NY, m->p, sizeof(double) * NP);
    follow(whole, known);
    if (known[ND] == 0.0) {
        return say(m, fmi3Error,
                   "the parameters give another kind of model than the one that was written, or one without sense "
                   "(a length or mass below zero): write it with them, rattle code FILE --set NAME=VALUE");
    }
    for (i = 0; i < ND; i++) m->following[i] = known[i];
#endif
    return fmi3OK;
}

/* everything that the parameters determine, during a run */
static void determine(Mechanism *m) {
    double whole[NY + NP + 2] = {0.0};
    memcpy(whole + 1 + NY, m->p, sizeof(double) * NP);
    whole[1 + NY + NP] = m->energy;
    prepare(whole, m->in + 1 + NY);
    moved(m);
}

/* state at t = 0 and everything that the parameters determine */
static fmi3Status begin(Mechanism *m) {
    double whole[NY + NP + 2] = {0.0};
    memcpy(whole + 1, start, sizeof start);
    if (follow_parameters(m, whole) != fmi3OK) return fmi3Error;
#if NP > 0
    if (!close_start(whole, m->p)) {
        return say(m, fmi3Error,
                   "the mechanism cannot be put together with these parameters, or not on the way from the start "
                   "that was written: rattle code FILE --set NAME=VALUE says why, or writes it");
    }
#endif
    initial_energy(whole, &m->energy);
    m->t = 0.0;
    memcpy(m->y, whole + 1, sizeof m->y);
    determine(m);
    if (!rate(m, m->t, m->y, m->dy)) {
        return say(m, fmi3Error, "the start is near a singular position, or a load has no finite value there");
    }
    m->begun = true;
    return fmi3OK;
}

static void clear(Mechanism *m) {
    m->mode = INSTANTIATED;
    m->begun = m->drifted = m->warned = false;
    m->t = m->h = m->kinetic = m->work = 0.0;
    m->lowest = INFINITY;
    m->highest = -INFINITY;
    m->tolerance = TOLERANCE;
    m->most_drift = DRIFT;
    memcpy(m->p, nominal, sizeof m->p);
    moved(m);
}

static void take_place(Mechanism *m) { (void)m; } /* it holds no addresses */

/* ---------------------------------------------------------------- steps of co-simulation */
/* how many of y have an error that counts: positions and rates; energies are integrated along */
static int motion(void) { return 2 * NQ; }

static double scale(const Mechanism *m, double size) { return m->tolerance * (ABSOLUTE + size); }

/* x^(1/ORDER), x >= 0: square roots as far as they go */
static double root(double x) {
    int power = ORDER;
    for (; power % 2 == 0; power /= 2) x = sqrt(x);
    return power == 1 ? x : pow(x, 1.0 / power);
}

/* a first step [s] whose error should be small */
static double first_step(Mechanism *m) {
    double size = 0.0, slope = 0.0, bend = 0.0, h, largest, later[NY], dy[NY];
    int i;
    for (i = 0; i < motion(); i++) {
        const double s = scale(m, fabs(m->y[i]));
        size += m->y[i] / s * (m->y[i] / s);
        slope += m->dy[i] / s * (m->dy[i] / s);
    }
    h = size > 1e-10 && slope > 1e-10 ? 0.01 * sqrt(size / slope) : 1e-6;
    for (i = 0; i < NY; i++) later[i] = m->y[i] + h * m->dy[i];
    if (!rate(m, m->t + h, later, dy)) return 1e-3 * h;
    for (i = 0; i < motion(); i++) {
        const double s = (dy[i] - m->dy[i]) / scale(m, fabs(m->y[i]));
        bend += s * s;
    }
    largest = fmax(sqrt(slope), sqrt(bend) / h) / sqrt(motion());
    return fmin(100.0 * h, largest > 1e-15 ? root(0.01 / largest) : fmax(1e-6, 1e-3 * h));
}

/* y at t + h and its error as a share of the tolerance; infinite where the equations do not hold on the way */
static double step(Mechanism *m, double h, double *end) {
    double k[STAGES][NY], stage[NY], first = 0.0, second = 0.0;
    int s, j, i;
    memcpy(k[0], m->dy, sizeof stage);
    for (s = 1; s < STAGES; s++) {
        for (i = 0; i < NY; i++) {
            double sum = 0.0;
            for (j = 0; j < s; j++) sum += A[s][j] * k[j][i];
            stage[i] = m->y[i] + h * sum;
        }
        if (!rate(m, m->t + C[s] * h, stage, k[s])) return INFINITY;
    }
    for (i = 0; i < NY; i++) {
        double sum = 0.0, error = 0.0, other = 0.0;
        for (s = 0; s < STAGES; s++) {
            sum += B[s] * k[s][i];
            error += ERROR[s] * k[s][i];
            other += DAMPING[s] * k[s][i];
        }
        end[i] = m->y[i] + h * sum;
        if (i < motion()) {
            const double size = scale(m, fmax(fabs(m->y[i]), fabs(end[i])));
            first += error / size * (error / size);
            second += other / size * (other / size);
        }
    }
    if (!finite_numbers(end, NY)) return INFINITY;
    return h * first / sqrt((first + 0.01 * second) * motion() + 1e-300);
}

/* from m->t to an instant */
static fmi3Status advance(Mechanism *m, double until) {
    double end[NY], closed[NY];
    if (need_rates(m) != fmi3OK) return fmi3Error;
    if (m->h == 0.0) m->h = first_step(m);
    while (m->t < until) {
        const bool last = m->t + 1.000001 * m->h >= until;
        const double h = last ? until - m->t : m->h;
        const double error = step(m, h, end);
        if (error <= 1.0 && on_constraints(m, m->t + h, end, closed)) {
            const double next = h * (error < 1e-7 ? 6.0 : fmin(6.0, 0.9 / root(error)));
            m->h = last ? fmax(next, m->h) : next;
            m->t = last ? until : m->t + h;
            memcpy(m->y, closed, sizeof m->y);
            moved(m);
            if (need_rates(m) != fmi3OK) return fmi3Error;
            continue;
        }
        m->h = h * (error <= 1.0 ? 0.25 : error < INFINITY ? fmax(0.2, 0.9 / root(error)) : 0.1);
        if (m->h <= 1e-15 * fabs(m->t) || m->h < 1e-16 * until || m->t + m->h == m->t) {
            return say(m, fmi3Error,
                       "t = %g s: no step is short enough: near a singular position or coincident points, or a load "
                       "has no finite value", m->t);
        }
    }
    return fmi3OK;
}
