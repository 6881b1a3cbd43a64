/* The functions of FMI 3.0 for the mechanism in equations.c: model exchange and co-simulation.

   The same in every FMU that rattle writes.  Compile this file alone, with -lm; it needs the C library only.
   All variables are Float64.  Their value references are in this order: time, parameters, parameters that follow from
   others, states, rates of the states, result curves that are not states.

   Model exchange: the states satisfy the constraints of the joints, which integrators do not know.  Where a completed
   step has drifted off by more than a tolerance, event mode is asked for, in which the states are brought back. */
#include "equations.c"
#include "fmi3.h"
#include "instance.h"
#include "mechanism.c"

FMI(fmi3Status, fmi3EnterInitializationMode)(
    fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance, fmi3Float64 startTime,
    fmi3Boolean stopTimeDefined, fmi3Float64 stopTime) {
    Mechanism *m = instance;
    if (initialize(m, toleranceDefined, tolerance, startTime) != fmi3OK) return fmi3Error;
    if (toleranceDefined) m->most_drift = fmax(10.0 * m->tolerance, SMALLEST_DRIFT);
    return fmi3OK;
}

FMI(fmi3Status, fmi3ExitInitializationMode)(fmi3Instance instance) {
    Mechanism *m = instance;
    REQUIRE(INITIALIZING, "fmi3ExitInitializationMode");
    if (!m->begun && begin(m) != fmi3OK) return fmi3Error;
    if (!m->called.exchange && audit(m) != fmi3OK) return fmi3Error;
    m->mode = m->called.exchange ? EVENTS : STEPPING;
    return fmi3OK;
}

FMI(fmi3Status, fmi3EnterStepMode)(fmi3Instance instance) { return lacks(instance, "event mode in co-simulation"); }

FMI(fmi3Status, fmi3EnterEventMode)(fmi3Instance instance) {
    Mechanism *m = instance;
    REQUIRE(CONTINUOUS, "fmi3EnterEventMode");
    m->mode = EVENTS;
    return fmi3OK;
}

/* ---------------------------------------------------------------- variables */
static fmi3Status look_up(Mechanism *m, fmi3ValueReference reference, double *value) {
    fmi3Status status = fmi3OK;
    if (reference >= END_OF_VARIABLES) return say(m, fmi3Error, "there is no variable %u", (unsigned)reference);
    if (reference == TIME) {
        *value = m->t;
    } else if (reference < FIRST_FOLLOWING) {
        *value = m->p[reference - FIRST_PARAMETER];
    } else {
        REQUIRE(~INSTANTIATED, "fmi3GetFloat64 of a variable that is computed");
        if (!m->begun && begin(m) != fmi3OK) return fmi3Error;
        if (reference < FIRST_STATE) {
            *value = m->following[reference - FIRST_FOLLOWING];
        } else if (reference < FIRST_RATE) {
            *value = m->y[reference - FIRST_STATE];
        } else if (reference < FIRST_CURVE) {
            status = need_rates(m);
            *value = m->dy[reference - FIRST_RATE];
        } else {
            status = need_curves(m);
            *value = m->curves[reference - FIRST_CURVE];
        }
    }
    return status;
}

/* parameters that may change during a run: all of them or none */
static fmi3Status set_inputs(
    Mechanism *m, const fmi3ValueReference references[], size_t n, const fmi3Float64 values[]) {
#if NP > 0
    double before[NP], whole[NY + NP + 2] = {0.0};
    size_t i;
    for (i = 0; i < n; i++) {
        const int k = (int)(references[i] - FIRST_PARAMETER);
        if (!varies[k]) {
            return say(m, fmi3Error, "the parameter %s cannot change during a run: more than forces depend on it", names[k]);
        }
    }
    memcpy(before, m->p, sizeof before);
    for (i = 0; i < n; i++) m->p[references[i] - FIRST_PARAMETER] = values[i];
    if (follow_parameters(m, whole) != fmi3OK) {
        memcpy(m->p, before, sizeof before);
        return fmi3Error;
    }
    determine(m);
#endif
    return fmi3OK;
}

/* ---------------------------------------------------------------- model exchange */
FMI(fmi3Status, fmi3EnterContinuousTimeMode)(fmi3Instance instance) {
    Mechanism *m = instance;
    REQUIRE(EVENTS, "fmi3EnterContinuousTimeMode");
    m->mode = CONTINUOUS;
    return fmi3OK;
}

/* how far y is from the constraints, as a share of the largest number of its kind; infinite where nobody knows */
static double drift(Mechanism *m) {
    double closed[NY], size[2][2] = {{SIZE, 1.0}, {SIZE, 1.0}}, largest = 0.0;
    int i;
    if (!on_constraints(m, m->t, m->y, closed)) return INFINITY;
    for (i = NQ; i < motion(); i++) size[1][i % 3 == 2] = fmax(size[1][i % 3 == 2], fabs(closed[i]));
    for (i = 0; i < motion(); i++) largest = fmax(largest, fabs(closed[i] - m->y[i]) / size[i >= NQ][i % 3 == 2]);
    return largest;
}

FMI(fmi3Status, fmi3CompletedIntegratorStep)(
    fmi3Instance instance, fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *enterEventMode,
    fmi3Boolean *terminateSimulation) {
    Mechanism *m = instance;
    double off;
    REQUIRE(CONTINUOUS, "fmi3CompletedIntegratorStep");
    *enterEventMode = *terminateSimulation = false;
    off = drift(m);
    if (!(off < INFINITY)) {
        return say(m, fmi3Error, "t = %g s: the joints cannot be closed after this step: give a smaller tolerance or step",
                   m->t);
    }
    m->drifted = *enterEventMode = off > m->most_drift;
    return fmi3OK;
}

/* states that have drifted off are brought back onto the constraints */
static fmi3Status settle_states(Mechanism *m, bool *changed) {
    double closed[NY];
    if (!m->drifted) return fmi3OK;
    if (!on_constraints(m, m->t, m->y, closed)) return say(m, fmi3Error, "t = %g s: the joints cannot be closed", m->t);
    memcpy(m->y, closed, sizeof m->y);
    moved(m);
    m->drifted = false;
    *changed = true;
    return fmi3OK;
}

FMI(fmi3Status, fmi3SetTime)(fmi3Instance instance, fmi3Float64 time) {
    Mechanism *m = instance;
    REQUIRE(CONTINUOUS, "fmi3SetTime");
    if (time != m->t) moved(m);
    m->t = time;
    return fmi3OK;
}

FMI(fmi3Status, fmi3SetContinuousStates)(
    fmi3Instance instance, const fmi3Float64 continuousStates[], size_t nContinuousStates) {
    Mechanism *m = instance;
    REQUIRE(CONTINUOUS, "fmi3SetContinuousStates");
    if (nContinuousStates != NY) return say(m, fmi3Error, "there are %d continuous states", (int)NY);
    memcpy(m->y, continuousStates, sizeof m->y);
    moved(m);
    return fmi3OK;
}

FMI(fmi3Status, fmi3GetContinuousStates)(
    fmi3Instance instance, fmi3Float64 continuousStates[], size_t nContinuousStates) {
    Mechanism *m = instance;
    REQUIRE(~INSTANTIATED, "fmi3GetContinuousStates");
    if (nContinuousStates != NY) return say(m, fmi3Error, "there are %d continuous states", (int)NY);
    if (!m->begun && begin(m) != fmi3OK) return fmi3Error;
    memcpy(continuousStates, m->y, sizeof m->y);
    return fmi3OK;
}

FMI(fmi3Status, fmi3GetContinuousStateDerivatives)(
    fmi3Instance instance, fmi3Float64 derivatives[], size_t nContinuousStates) {
    Mechanism *m = instance;
    fmi3Status status;
    REQUIRE(~INSTANTIATED, "fmi3GetContinuousStateDerivatives");
    if (nContinuousStates != NY) return say(m, fmi3Error, "there are %d continuous states", (int)NY);
    if (!m->begun && begin(m) != fmi3OK) return fmi3Error;
    status = need_rates(m);
    if (status == fmi3OK) memcpy(derivatives, m->dy, sizeof m->dy);
    return status;
}

FMI(fmi3Status, fmi3GetNominalsOfContinuousStates)(
    fmi3Instance instance, fmi3Float64 nominals[], size_t nContinuousStates) {
    size_t i;
    if (nContinuousStates != NY) return say(instance, fmi3Error, "there are %d continuous states", (int)NY);
    for (i = 0; i < NY; i++) nominals[i] = i < NQ && i % 3 != 2 ? SIZE : 1.0;
    return fmi3OK;
}

FMI(fmi3Status, fmi3GetNumberOfContinuousStates)(fmi3Instance instance, size_t *nContinuousStates) {
    *nContinuousStates = NY;
    return fmi3OK;
}

FMI(fmi3Status, fmi3GetNumberOfEventIndicators)(fmi3Instance instance, size_t *nEventIndicators) {
    *nEventIndicators = 0;
    return fmi3OK;
}

FMI(fmi3Status, fmi3GetEventIndicators)(
    fmi3Instance instance, fmi3Float64 eventIndicators[], size_t nEventIndicators) {
    return nEventIndicators == 0 ? fmi3OK : say(instance, fmi3Error, "there are no event indicators");
}

/* ---------------------------------------------------------------- co-simulation */
FMI(fmi3Status, fmi3DoStep)(
    fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
    fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation,
    fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime) {
    Mechanism *m = instance;
    fmi3Status status;
    REQUIRE(STEPPING, "fmi3DoStep");
    *eventHandlingNeeded = *terminateSimulation = *earlyReturn = false;
    *lastSuccessfulTime = m->t;
    if (check_step(m, currentCommunicationPoint, communicationStepSize) != fmi3OK) return fmi3Error;
    status = advance(m, currentCommunicationPoint + communicationStepSize);
    *lastSuccessfulTime = m->t;
    return status == fmi3OK ? audit(m) : status;
}

#define MORE 0
#define EXCHANGES 1
#include "calls.c"
