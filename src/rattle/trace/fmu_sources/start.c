/* The start of the model in model.c for other parameters: numbers are entered into the workspaces of the systems that it
   is put together from, and a kernel finds a start, as `Mechanism.set` does.  See `pages/viewer/core_start.js`. */

enum { OTHER_FORM = -1 }; /* what became of a start, beside the words of the kernel */

static int64_t *workspace(Mechanism *m, int system) { return m->tables[1 + system]; }

/* the numbers of an array as it was written */
static void copy_written(int system, int array, double *into) {
    const Image *image = images + 1 + system;
    const Array *one = image->arrays + array;
    if (one->content >= 0) memcpy(into, image->content + one->content, sizeof(double) * one->size);
    else memset(into, 0, sizeof(double) * one->size);
}

/* numbers that follow from inputs; false where the model has another form */
static bool enter(Mechanism *m, int system, const double *in) {
    const System *one = systems + system;
    int64_t *const table = workspace(m, system);
    double own[MOST_NUMBERS], found[MOST_NUMBERS];
    int k;
    one->numbers(one->inputs, own);
    one->numbers(in, found);
    if (found[0] == 0.0 || !finite_numbers(found, 1 + one->count)) return false;
    m->same[system] = true;
    for (k = 0; k < one->count; k++) {
        if (one->counts[k] && memcmp(own + 1 + k, found + 1 + k, sizeof(double)) != 0) m->same[system] = false;
    }
    for (k = 0; k < one->placed; k++) {
        numbers(table, one->places[k].array)[one->places[k].cell] = found[1 + k];
    }
    return true;
}

/* why there is no start, in m->why */
static void explain(Mechanism *m, const Start *one, int64_t became) {
    int64_t *const table = workspace(m, one->system);
    double most = -1.0;
    int k, worst = -1;
    if (became == NOT_FINITE) {
        snprintf(m->why, sizeof m->why, "with these parameters numbers of the mechanism are too large or have no value");
    } else {
        for (k = 0; k < one->count; k++) {
            const double gap = fabs(numbers(table, ROWS)[k * columns(table, ROWS) + ROWS_RES]);
            if (gap > most) most = gap, worst = k;
        }
        snprintf(m->why, sizeof m->why,
                 "the mechanism cannot be put together with these parameters: %s stays open by %.3g %s", worst < 0 ? "a joint" : one->rows[worst].name, most, worst < 0 ? "m" : one->rows[worst].unit);
    }
}

/* a start; returns what became of it.  same: it is that of the model as it was written */
static int64_t find(Mechanism *m, int number, const double *p, bool *same) {
    const Start *one = starts + number;
    int64_t *const table = workspace(m, one->system);
    const int others[3] = {one->system, one->shut, one->every};
    double in[NP + MOST_CONSTANTS + 1] = {0.0}, *const constants = in + NP;
    bool inner = true, without = true;
    int64_t became, none;
    int k;
    memcpy(in, p, sizeof(double) * NP);
    if (one->loose >= 0) {
        became = find(m, one->loose, p, &inner);
        if (became != MOVED) return became;
        if (!inner) {
            int64_t *const counting = workspace(m, one->counting);
            if (!enter(m, one->counting, in)) return OTHER_FORM;
            if (rattle_start_constants(&none, counting, workspace(m, starts[one->loose].system), 0.0)) return NOT_FINITE;
            memcpy(constants, numbers(counting, START_CONSTANTS), sizeof(double) * rows(counting, START_CONSTANTS));
        } else {
            copy_written(one->counting, START_CONSTANTS, constants);
        }
    }
    if (number == 0) memcpy(m->constants, constants, sizeof m->constants);
    *same = inner;
    for (k = 0; k < 3; k++) {
        if (others[k] < 0) continue;
        if (!enter(m, others[k], in)) return OTHER_FORM;
        *same = *same && m->same[others[k]];
    }
    if (one->ideal >= 0) {
        became = find(m, one->ideal, p, &without);
        if (became != MOVED) return became;
    }
    *same = *same && without;
    if (*same) {
        copy_written(one->system, START_Q, numbers(table, START_Q));
        copy_written(one->system, START_V, numbers(table, START_V));
        return MOVED;
    }
    if (rattle_start_find(&became, table, one->ideal < 0 ? table : workspace(m, starts[one->ideal].system),
                          one->shut < 0 ? table : workspace(m, one->shut),
                          one->every < 0 ? table : workspace(m, one->every), 0.0)) became = NOT_FINITE;
    if (became != MOVED) explain(m, one, became);
    return became;
}

/* positions and rates into the state, and the constants that the start sets, for the parameters in m->p */
static fmi3Status find_start(Mechanism *m, double *state) {
    int64_t *const table = workspace(m, starts[0].system), became = OTHER_FORM, who;
    bool same;
    int k;
    for (k = 0; k < SYSTEMS; k++) lay_out(images + 1 + k, workspace(m, k));
    became = find(m, 0, m->p, &same);
    if (became == OTHER_FORM) return other_form(m);
    if (became != MOVED) return say(m, fmi3Error, "%s", m->why);
    if (rattle_start_outside(&who, table, 0.0)) return say(m, fmi3Error, "%s", told);
    if (who >= 0) {
        return say(m, fmi3Error, "with these parameters joint '%s' starts %.3g outside its play", contacts[who],
                   fabs(numbers(table, CONTACT_KINEMATICS)[who * columns(table, CONTACT_KINEMATICS) + CONTACT_KINEMATICS_GAP]
                        - fmax(numbers(table, START_LEAST)[who], -1.0)));
    }
    memcpy(state, numbers(table, START_Q), sizeof(double) * rows(table, START_Q));
    memcpy(state + rows(table, START_Q), numbers(table, START_V), sizeof(double) * rows(table, START_V));
    return fmi3OK;
}
