/* One instance of the model in model.c: its workspaces, its start, its steps by the compiled kernels.

   A workspace is a table of addresses and shapes, three cells for every array, and the arrays behind it. */
#include <stddef.h>

typedef struct {
    EVERY_INSTANCE
    double asked_end, end;             /* of the run [s]; 0: not asked for */
    double rtol, atol, longest;        /* of the run, its longest step [s] */
    double target, row[WIDTH], first[ENERGIES]; /* an output asked for [s], its row, energies of the first one [J] */
    double constants[MOST_CONSTANTS + 1]; /* that the start sets [m or rad] */
    bool same[SYSTEMS];                /* nothing on which its start depends has changed in a system */
    char why[300];                     /* there is no start */
    bool event_ahead;                  /* what the last step has ended with, beyond the communication point */
    int64_t *tables[WORKSPACES];       /* of the workspaces; the first is that of the run */
    int64_t *before;                   /* the workspace of the run before its last step */
} Mechanism;

#include "instance.c"

static const char *told = "";
RATTLE_HIDDEN void rattle_fault(const char *text) { told = text; }

/* ---------------------------------------------------------------- workspaces */
static double *numbers(int64_t *table, int array) { return (double *)(intptr_t)table[3 * array]; }
static int64_t *wholes(int64_t *table, int array) { return (int64_t *)(intptr_t)table[3 * array]; }
static int64_t rows(const int64_t *table, int array) { return table[3 * array + 1]; }
static int64_t columns(const int64_t *table, int array) { return table[3 * array + 2]; }

/* a workspace as it was written, in cells of which nothing is known; the cells behind it */
static int64_t *lay_out(const Image *image, int64_t *cells) {
    int64_t *place = cells + 3 * ARRAYS;
    int k;
    for (k = 0; k < ARRAYS; k++) {
        const Array *one = image->arrays + k;
        int64_t n;
        cells[3 * k] = (int64_t)(intptr_t)place;
        cells[3 * k + 1] = one->rows;
        cells[3 * k + 2] = one->columns;
        for (n = 0; n < one->size; n++) {
            place[n] = one->kernels != NULL ? (int64_t)(intptr_t)kernel(one->kernels[n])
                       : one->content >= 0  ? (int64_t)image->content[one->content + n]
                                            : 0;
        }
        place += one->size > 0 ? one->size : 1;
    }
    return place;
}

static void clear(Mechanism *m) {
    int64_t *cells = (int64_t *)(m + 1);
    int k;
    m->mode = INSTANTIATED;
    m->begun = m->warned = m->curves_known = m->event_ahead = false;
    m->t = 0.0;
    m->tolerance = TOLERANCE;
    m->asked_end = 0.0;
    memcpy(m->p, nominal, sizeof m->p);
    for (k = 0; k < WORKSPACES; k++) {
        m->tables[k] = cells;
        cells = lay_out(images + k, cells);
    }
    m->before = cells;
}

/* the addresses of workspaces that were copied from another instance */
static void take_place(Mechanism *m) {
    const intptr_t moved = (intptr_t)(m + 1) - (intptr_t)m->tables[0];
    int k, n;
    m->before = (int64_t *)((char *)m->before + moved);
    for (k = 0; k < WORKSPACES; k++) m->tables[k] = (int64_t *)((char *)m->tables[k] + moved);
    for (n = 0; n < ARRAYS; n++) {
        m->before[3 * n] += moved;
        for (k = 0; k < WORKSPACES; k++) m->tables[k][3 * n] += moved;
    }
}

/* ---------------------------------------------------------------- what the run has become */
/* the run as it is now, to go back to */
static void keep(Mechanism *m) { memcpy(m->before, m->tables[0], sizeof(int64_t) * RUN_CELLS); }
static void go_back(Mechanism *m) { memcpy(m->tables[0], m->before, sizeof(int64_t) * RUN_CELLS); }

/* where the same number stands in what was kept */
static const double *kept(const Mechanism *m, const double *number) {
    return (const double *)m->before + (number - (const double *)m->tables[0]);
}

static double now(Mechanism *m) { return numbers(m->tables[0], CLOCK)[CLOCK_T]; }

static void forget_events(Mechanism *m) {
    int64_t *const tally = wholes(m->tables[0], TALLY);
    tally[TALLY_FOUND] = tally[TALLY_EVENT_COUNT] = 0;
    if (rows(m->tables[0], BREAK_TIMES) > 0) numbers(m->tables[0], BREAK_TIMES)[0] = 0.0;
}

/* whether the last step has ended where a contact has changed, or at an instant known in advance */
static bool met_event(Mechanism *m) {
    const double *const memory = numbers(m->tables[0], CONTACT_MEMORY), *const was = kept(m, memory);
    const double *const course = numbers(m->tables[0], COURSE);
    const int64_t wide = columns(m->tables[0], CONTACT_MEMORY);
    int64_t n;
    if (wholes(m->tables[0], TALLY)[TALLY_EVENT_COUNT] > 0) return true;
    if (course[COURSE_PIECE] != kept(m, course)[COURSE_PIECE]) return true;
    for (n = 0; n < rows(m->tables[0], CONTACT_MEMORY); n++) {
        if (memory[n * wide + CONTACT_MEMORY_CLOSED] != was[n * wide + CONTACT_MEMORY_CLOSED]) return true;
    }
    return false;
}

static fmi3Status ended(Mechanism *m, int64_t status) {
    size_t k;
    for (k = 0; k < sizeof ends / sizeof *ends; k++) {
        if (ends[k].status == status) return say(m, fmi3Error, "t = %.9g s: %s", now(m), ends[k].words);
    }
    return say(m, fmi3Error, "t = %.9g s: the motion cannot go on", now(m));
}

/* the row of curves at the state that the run has reached, which is left as it is */
static fmi3Status record_here(Mechanism *m) {
    int64_t none;
    keep(m);
    if (rattle_record(&none, m->tables[0], now(m), numbers(m->tables[0], STATE), rows(m->tables[0], STATE), m->row, WIDTH)) {
        return say(m, fmi3Error, "%s", told);
    }
    go_back(m);
    return fmi3OK;
}

/* one step, which is kept from before, with the output at m->target if that lies in it */
static fmi3Status step(Mechanism *m) {
    int64_t status;
    keep(m);
    wholes(m->tables[0], TALLY)[TALLY_OUTPUTS] = 0;
    if (rattle_run_advance(&status, m->tables[0], m->end, m->end, m->rtol, m->atol, m->longest, &m->target, 1, m->row,
                           1, WIDTH, 1)) return say(m, fmi3Error, "%s", told);
    return status == PAUSED || status == DONE ? fmi3OK : ended(m, status);
}

/* ---------------------------------------------------------------- the start */
static fmi3Status other_form(Mechanism *m) {
    return say(m, fmi3Error,
               "the parameters give another form of the model than the one that was written, or one without sense "
               "(a length or mass below zero): write it with them, rattle code FILE --set NAME=VALUE");
}

#include "start.c"

/* events are found to a share of the run's end: a tool's stop time may be that of never */
enum { FARTHEST_END = 1000000 };

static void settle(Mechanism *m, const double *facts) {
    (void)facts;
    m->end = T_END;
    if (m->asked_end > 0.0) m->end = fmin(m->asked_end, FARTHEST_END * m->end);
    m->rtol = m->tolerance > 0.0 ? m->tolerance : RTOL;
    m->atol = ATOL;
    m->longest = LONGEST;
}

/* numbers of the run, which follow from parameters and from constants that the start sets [SI] */
static fmi3Status enter_numbers(Mechanism *m) {
    double in[NP + NCONST + 1], out[1 + NENTRIES + NFACTS];
    int k;
    memcpy(in, m->p, sizeof(double) * NP);
    memcpy(in + NP, m->constants, sizeof(double) * NCONST);
    arrays(in, out);
    if (out[0] == 0.0 || !finite_numbers(out, 1 + NENTRIES + NFACTS)) return other_form(m);
    for (k = 0; k < NENTRIES; k++) numbers(m->tables[0], entries[k].array)[entries[k].cell] = out[1 + k];
    settle(m, out + 1 + NENTRIES);
    return fmi3OK;
}

/* when expressions of time switch, and drivers jump */
static fmi3Status find_instants(Mechanism *m) {
    int64_t *const table = m->tables[0], needed;
    const double *leap = numbers(table, DRIVER_LEAP);
    int k;
    if (rattle_run_timetable(&needed, table, 0.0, m->end)) return say(m, fmi3Error, "%s", told);
    if (needed > 0) {
        return say(m, fmi3Error, "expressions of time switch more often up to %g s than the model has room for: write it "
                   "with that end and these parameters, rattle code FILE --t-end TIME --set NAME=VALUE", m->end);
    }
    for (k = 0; k < rows(table, TIMED); k++) {
        if (wholes(table, TIMED)[k * columns(table, TIMED) + TIMED_RESOLVED] != 0) continue;
        say(m, fmi3Warning, "an expression of time switches too often up to %g s to follow: steps do not end at its "
            "switching instants; tell an earlier stop time", m->end);
        break;
    }
    for (k = 0; k < rows(table, DRIVER_LEAP); k++, leap += columns(table, DRIVER_LEAP)) {
        if (leap[DRIVER_LEAP_LEAP_COUNT] > 0.0) {
            return say(m, fmi3Error, "driver '%s' jumps by %.6g at t = %.9g s: no body can follow", drivers[k],
                       leap[DRIVER_LEAP_LEAP_SIZE], leap[DRIVER_LEAP_LEAP_AT]);
        }
    }
    return fmi3OK;
}

static fmi3Status begin(Mechanism *m) {
    double *const state = numbers(m->tables[0], STATE);
    int64_t status;
#if NP > 0
    if (check_limits(m) != fmi3OK) return fmi3Error;
#endif
    lay_out(images, m->tables[0]);
    if (starts[0].counting >= 0) copy_written(starts[0].counting, START_CONSTANTS, m->constants);
    if (memcmp(m->p, nominal, sizeof(double) * NP) != 0 && find_start(m, state) != fmi3OK) return fmi3Error;
    if (enter_numbers(m) != fmi3OK) return fmi3Error;
    if (find_instants(m) != fmi3OK) return fmi3Error;
    m->t = m->target = 0.0;
    if (rattle_run_begin(&status, m->tables[0], 0.0, m->end, m->rtol, m->atol, m->longest, &m->target, 1, m->row, 1, WIDTH)) {
        return say(m, fmi3Error, "%s", told);
    }
    if (status != PAUSED) return ended(m, status);
    forget_events(m);
    if (wholes(m->tables[0], TALLY)[TALLY_OUTPUTS] == 0) { /* with equal steps the first one writes it */
        if (step(m) != fmi3OK) return fmi3Error;
        go_back(m);
    }
    keep(m);
    memcpy(m->first, m->row + FIRST_ENERGY, sizeof m->first);
    m->curves_known = m->event_ahead = false;
    m->begun = true;
    return fmi3OK;
}

/* ---------------------------------------------------------------- steps */
/* whether an instant is reached, but for what a sum of communication steps is rounded by: no step is so short */
static bool reached(Mechanism *m, double until) { return now(m) >= until - 1e-14 * until; }

/* to an instant, or, where that is allowed, to an event before it or there */
static fmi3Status advance(Mechanism *m, double until, bool may_stop, bool *event) {
    int64_t *const tally = wholes(m->tables[0], TALLY);
    if (until > (1.0 + 1e-9) * m->end && rows(m->tables[0], TIMED) > 0) { /* a sum of communication steps is rounded */
        return say(m, fmi3Error, "instants at which expressions of time switch were looked for up to %g s only: tell a "
                   "later stop time", m->end);
    }
    m->target = until;
    m->curves_known = false;
    if (now(m) > until || (now(m) == until && !(m->event_ahead && may_stop))) { /* the last step is taken again */
        go_back(m);
        m->event_ahead = false;
    }
    tally[TALLY_OUTPUTS] = 0;
    for (;;) {
        *event = m->event_ahead && may_stop && now(m) <= until;
        if (*event || tally[TALLY_OUTPUTS] > 0 || reached(m, until)) break;
        if (reached(m, m->end)) m->end = until; /* not before: equal steps are counted up to the end */
        if (step(m) != fmi3OK) {
            m->mode = TERMINATED; /* the run is beyond m->t, and nothing leads on */
            return fmi3Error;
        }
        m->event_ahead = met_event(m);
        forget_events(m);
    }
    m->t = *event && !reached(m, until) ? now(m) : until;
    if (!*event && tally[TALLY_OUTPUTS] > 0) return fmi3OK;
    if (*event) m->event_ahead = false;
    return record_here(m);
}

/* a warning, once, where the energy error is above 0.1 % of the largest energy, see `solvers/step_audit.py` */
static fmi3Status audit(Mechanism *m) {
    const double *const seen = numbers(m->tables[0], AUDIT), error = seen[AUDIT_MOST_UNREST];
    const double moved = fmax(seen[AUDIT_MOST_KINETIC], seen[AUDIT_MOST_WORK]);
    const double largest = fmax(moved, seen[AUDIT_MOST_POTENTIAL] - seen[AUDIT_LEAST_POTENTIAL]) + seen[AUDIT_FLOOR];
    if (m->warned || error <= 1e-3 * largest) return fmi3OK;
    m->warned = true;
    return say(m, fmi3Warning,
               "t = %g s: energy error %g J, above 0.1 %% of the largest so far: a smaller tolerance or step reduces it",
               m->t, error);
}

/* ---------------------------------------------------------------- curves */
static fmi3Status need_curves(Mechanism *m) {
    double in[NP + WIDTH + ENERGIES + NCALLS + 1];
    if (m->curves_known) return fmi3OK;
    memcpy(in, m->p, sizeof(double) * NP);
    memcpy(in + NP, m->row, sizeof m->row);
    memcpy(in + NP + WIDTH, m->first, sizeof m->first);
    if (!call_kernels(in, in + NP + WIDTH + ENERGIES)) return say(m, fmi3Error, "%s", told);
    read_curves(in, m->curves);
    m->curves_known = true;
    return fmi3OK;
}
