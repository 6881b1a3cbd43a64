"""What stands after the recorded functions in a C program; `c` puts in what stands in @...@ here."""

MAIN = """
enum { NY = @ny@, NO = @no@, NP = @np@, NIN = NY + NP + 2 };
static const char *const names[NO] = {@names@};
static const double own_start[NY] = {@start@}; /* of the parameters below */

struct parameter {
    const char *name, *unit;
    double value, low, high; /* in SI units; infinite limits: none are given */
};
static const struct parameter parameters[NP + !NP] = {
@parameters@
};

/* what a motion depends on: parameters in the order above [SI], energy at its start [J], from which the last result
   column counts */
struct setting {
    double p[NP + !NP], energy;
};

static void stop(double t, const char *why) {
    fprintf(stderr, "t = %g s: %s\\n", t, why);
    exit(1);
}

/* stops where a load or driver has no finite value, or the motion diverges */
static void require_finite(double t, const double *y) {
    int i;
    for (i = 0; i < NY; i++) {
        if (!(fabs(y[i]) < INFINITY)) stop(t, "no finite value (a load outside its domain, or a diverging motion)");
    }
}

static void require_sound(double t, double flag) {
    if (flag == 0.0) stop(t, "near a singular position or coincident points, which this code cannot pass");
}

/* what the recorded functions take */
static void put(double *in, double t, const double *y, const struct setting *s) {
    in[0] = t;
    memcpy(in + 1, y, sizeof(double) * NY);
    memcpy(in + 1 + NY, s->p, sizeof(double) * NP);
    in[NIN - 1] = s->energy;
}

/* dy/dt; stops where an assumption of the code does not hold */
static void rate(double t, const double *y, double *dy, const struct setting *s) {
    double in[NIN], out[NY + 1];
    put(in, t, y, s);
    derivative(in, out);
    require_sound(t, out[NY]);
    require_finite(t, out);
    memcpy(dy, out, sizeof(double) * NY);
}

/* one step of the classical Runge-Kutta method of order 4, brought onto the constraints */
static void advance(double t, double h, double *y, const struct setting *s) {
    double k[4][NY], stage[NY], in[NIN], out[NY + 1];
    int i;
    rate(t, y, k[0], s);
    for (i = 0; i < NY; i++) stage[i] = y[i] + 0.5 * h * k[0][i];
    rate(t + 0.5 * h, stage, k[1], s);
    for (i = 0; i < NY; i++) stage[i] = y[i] + 0.5 * h * k[1][i];
    rate(t + 0.5 * h, stage, k[2], s);
    for (i = 0; i < NY; i++) stage[i] = y[i] + h * k[2][i];
    rate(t + h, stage, k[3], s);
    for (i = 0; i < NY; i++) stage[i] = y[i] + h / 6.0 * (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]);
    put(in, t + h, stage, s);
    project(in, out);
    if (out[NY] == 0.0) stop(t + h, "the joints cannot be closed after this step; choose a shorter one");
    memcpy(y, out, sizeof(double) * NY);
    require_finite(t + h, y);
}

@begin@
/* y at t = 0, and the energy there */
static void start(double *y, struct setting *s) {
    double in[NIN], out[NO + 1];
    int i, changed = 0;
    for (i = 0; i < NP; i++) changed = changed || s->p[i] != parameters[i].value;
    s->energy = 0.0;
    memcpy(y, own_start, sizeof own_start);
    if (changed) begin(y, s);
    put(in, 0.0, y, s);
    outputs(in, out);
    s->energy = out[NO - 1];
}

/* one line of CSV; stops where the energy error is above 0.1 % of the largest energy: the last columns are kinetic and
   potential energy, work done, energy dissipated, balance */
static void print(double t, const double *y, const struct setting *s) {
    static double kinetic = 0.0, work = 0.0, lowest = INFINITY, highest = -INFINITY;
    double in[NIN], out[NO + 1], largest, rounding;
    int i;
    put(in, t, y, s);
    outputs(in, out);
    require_sound(t, out[NO]);
    kinetic = fmax(kinetic, out[NO - 5]);
    lowest = fmin(lowest, out[NO - 4]);
    highest = fmax(highest, out[NO - 4]);
    work = fmax(work, fabs(out[NO - 3]));
    largest = fmax(fmax(kinetic, work), highest - lowest);
    rounding = 1e-12 * (kinetic + work + fmax(fabs(lowest), fabs(highest)));
    if (!(fabs(out[NO - 1]) <= 1e-3 * largest + rounding)) {
        fprintf(stderr, "t = %g s: energy error %g J, above 0.1 %% of the largest energy: choose a shorter step\\n",
                t, fabs(out[NO - 1]));
        exit(1);
    }
    printf("%.17g", t);
    for (i = 0; i < NO; i++) printf(",%.17g", out[i]);
    printf("\\n");
}

/* a whole text as a finite number; 0 for anything else */
static int number(const char *text, double *value) {
    char *end;
    *value = strtod(text, &end);
    return end != text && *end == 0 && fabs(*value) < INFINITY;
}

/* takes an argument name=value; 0 if there is no such parameter or no such number */
static int set(const char *text, struct setting *s) {
    const char *equals = strchr(text, '=');
    const size_t n = equals ? (size_t)(equals - text) : 0;
    int i;
    for (i = 0; i < NP; i++) {
        if (n > 0 && strlen(parameters[i].name) == n && strncmp(parameters[i].name, text, n) == 0) {
            return number(equals + 1, &s->p[i]);
        }
    }
    return 0;
}

static int usage(const char *program, const char *wrong) {
    int i;
    if (wrong) fprintf(stderr, "%s: expected a parameter and its value in SI units, name=value\\n", wrong);
    fprintf(stderr, "usage: %s [t_end [step]]@set@, both in s and positive, at most 1e9 steps\\n", program);
    for (i = 0; i < NP; i++) {
        fprintf(stderr, "  %s=%.10g %s\\n", parameters[i].name, parameters[i].value, parameters[i].unit);
    }
    return 2;
}

/* CSV in SI units, about @rows@ lines */
int main(int argc, char **argv) {
    double y[NY], times[2] = {@t_end@, @step@}, h;
    struct setting s;
    long n, k, every;
    int i, given = 0, right = 1;
    for (i = 0; i < NP; i++) s.p[i] = parameters[i].value;
    for (i = 1; i < argc; i++) {
        if (strchr(argv[i], '=')) {
            if (!set(argv[i], &s)) return usage(argv[0], argv[i]);
        } else {
            right = right && given < 2 && number(argv[i], &times[given]);
            given++;
        }
    }
    if (!right || !(times[0] > 0.0) || !(times[1] > 0.0) || !(times[0] / times[1] <= 1e9)) return usage(argv[0], NULL);
    n = (long)ceil(times[0] / times[1] - 1e-9);
    n = n > 0 ? n : 1;
    h = times[0] / (double)n;
    every = (n + @rows@ - 1) / @rows@;
    start(y, &s);
    printf("t");
    for (i = 0; i < NO; i++) printf(",%s", names[i]);
    printf("\\n");
    print(0.0, y, &s);
    for (k = 0; k < n; k++) {
        advance((double)k * h, h, y, &s);
        if ((k + 1) % every == 0 || k + 1 == n) print((double)(k + 1) * h, y, &s);
    }
    if (fflush(stdout) != 0 || ferror(stdout)) {
        fprintf(stderr, "the motion could not be written completely\\n");
        return 1;
    }
    return 0;
}
"""
BEGIN = """enum { NQ = @nq@, NG = @ng@ };
static const double sizes[NQ] = {@sizes@};
static const char *const gap_names[NG] = {@gaps@};
static const char *const gap_units[NG] = {@units@};

static double larger(double a, double b) { return b > a || b != b ? b : a; } /* nan stays */

/* positions q that close, by Newton's method; returns 0, or 1: a gap stays, 2: singular, 3: too far from the first */
static int close_positions(double *q, const struct setting *s) {
    double in[NIN], found[NQ + 2], state[NY], left = INFINITY, sound = 0.0, step, far = 0.0;
    int i, round;
    memset(state, 0, sizeof state);
    put(in, 0.0, state, s);
    memcpy(in + 1, q, sizeof(double) * NQ);
    for (round = 0; round < @rounds@; round++) {
        correct(in, found);
        for (i = 0, step = 0.0; i < NQ; i++) step = larger(step, fabs((found[i] - in[1 + i]) / sizes[i]));
        memcpy(in + 1, found, sizeof(double) * NQ);
        left = found[NQ];
        sound = found[NQ + 1];
        if (!(step > @small@)) break;
    }
    for (i = 0; i < NQ; i++) far = larger(far, fabs((in[1 + i] - q[i]) / sizes[i]));
    memcpy(q, in + 1, sizeof(double) * NQ);
    return !(left <= @closed@) ? 1 : sound == 0.0 ? 2 : !(far <= @far@) ? 3 : 0;
}

/* why the parameters have no start */
static void refuse(int why, const double *q, const struct setting *s) {
    double in[NIN], open[NG], state[NY];
    int i, worst = 0;
    fprintf(stderr, "the mechanism cannot be put together with these parameters: ");
    if (why == 1) {
        memset(state, 0, sizeof state);
        memcpy(state, q, sizeof(double) * NQ);
        put(in, 0.0, state, s);
        gaps(in, open);
        for (i = 1; i < NG; i++) worst = open[i] > open[worst] || open[i] != open[i] ? i : worst;
        fprintf(stderr, "%s %g %s\\n", gap_names[worst], open[worst], gap_units[worst]);
    } else {
        fprintf(stderr, "%s\\n", why == 2 ? "its position is singular" : why == 3 ? "they are too far from the model's"
                                        : "given rates contradict the joints");
    }
    exit(1);
}

/* y at t = 0 for other parameters than the model's, from y for the model's: at once, or in up to @pieces@ pieces */
static void begin(double *y, const struct setting *s) {
    double in[NIN], found[NQ + 2], q[NQ], first[NQ], fastest = 0.0;
    struct setting part = *s;
    int i, k, n, why = 1, once = 0;
    put(in, 0.0, y, &part);
    readable(in, found);
    for (i = 0; i < NP; i++) {
        if (found[0] == 0.0 && (s->p[i] < parameters[i].low || s->p[i] > parameters[i].high)) {
            fprintf(stderr, "%s = %g is outside of its limits, %g to %g %s\\n", parameters[i].name, s->p[i],
                    parameters[i].low, parameters[i].high, parameters[i].unit);
            exit(1);
        }
    }
    if (found[0] == 0.0) {
        fprintf(stderr, "with these parameters the model is refused or has another form; write its code anew\\n");
        exit(1);
    }
    for (n = 1; why && n <= @pieces@; n *= 2) {
        memcpy(q, y, sizeof q);
        for (k = 1, why = 0; !why && k <= n; k++) {
            for (i = 0; k < n && i < NP; i++) {
                part.p[i] = parameters[i].value + (double)k / (double)n * (s->p[i] - parameters[i].value);
            }
            if (k == n) part = *s;
            why = close_positions(q, &part);
        }
        if (n == 1) {
            once = why;
            memcpy(first, q, sizeof q);
        }
    }
    if (why) refuse(once, first, s);
    memcpy(y, q, sizeof q);
    put(in, 0.0, y, s);
    closeRates(in, found);
    for (i = 0; i < NQ; i++) fastest = larger(fastest, fabs(found[i]));
    if (found[NQ + 1] == 0.0) refuse(2, q, s);
    if (!(found[NQ] <= @missed@ * larger(1.0, fastest))) refuse(4, q, s);
    memcpy(y + NQ, found, sizeof q);
    require_finite(0.0, y);
}
"""
NO_BEGIN = """static void begin(double *y, const struct setting *s) {
    (void)y;
    (void)s;
    fprintf(stderr, "only the parameters of the model have a start here\\n");
    exit(1);
}
"""
