/* The functions of FMI 3.0 for a model with contacts and events, which compiled kernels move: co-simulation.

   Value references are in this order: time, parameters, result curves.  Steps are those of a run that knows of no
   communication points.  Where event mode is used a step ends early after an impact, or where a contact begins, ends,
   sticks or slips. */
#include "model.c"
#include "fmi3.h"
#include "instance.h"
#include "run.c"

FMI(fmi3Status, fmi3EnterInitializationMode)(
    fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance, fmi3Float64 startTime,
    fmi3Boolean stopTimeDefined, fmi3Float64 stopTime) {
    Mechanism *m = instance;
    if (initialize(m, toleranceDefined, tolerance, startTime) != fmi3OK) return fmi3Error;
    m->asked_end = stopTimeDefined ? stopTime : 0.0;
    return fmi3OK;
}

FMI(fmi3Status, fmi3ExitInitializationMode)(fmi3Instance instance) {
    Mechanism *m = instance;
    REQUIRE(INITIALIZING, "fmi3ExitInitializationMode");
    if (!m->begun && begin(m) != fmi3OK) return fmi3Error;
    m->mode = m->called.events ? EVENTS : STEPPING;
    return fmi3OK;
}

FMI(fmi3Status, fmi3EnterEventMode)(fmi3Instance instance) {
    Mechanism *m = instance;
    REQUIRE(m->called.events ? STEPPING : 0, "fmi3EnterEventMode");
    m->mode = EVENTS;
    return fmi3OK;
}

FMI(fmi3Status, fmi3EnterStepMode)(fmi3Instance instance) {
    Mechanism *m = instance;
    REQUIRE(EVENTS, "fmi3EnterStepMode");
    m->mode = STEPPING;
    return fmi3OK;
}

/* events have been taken when a step ends with them */
static fmi3Status settle_states(Mechanism *m, bool *changed) { return fmi3OK; }

/* ---------------------------------------------------------------- variables */
enum { TIME, FIRST_PARAMETER, FIRST_FOLLOWING = FIRST_PARAMETER + NP, END_OF_VARIABLES = FIRST_FOLLOWING + NO };

static fmi3Status look_up(Mechanism *m, fmi3ValueReference reference, double *value) {
    if (reference >= END_OF_VARIABLES) return say(m, fmi3Error, "there is no variable %u", (unsigned)reference);
    if (reference == TIME) {
        *value = m->t;
    } else if (reference < FIRST_FOLLOWING) {
        *value = m->p[reference - FIRST_PARAMETER];
    } else {
        REQUIRE(~INSTANTIATED, "fmi3GetFloat64 of a variable that is computed");
        if (!m->begun && begin(m) != fmi3OK) return fmi3Error;
        if (need_curves(m) != fmi3OK) return fmi3Error;
        *value = m->curves[reference - FIRST_FOLLOWING];
    }
    return fmi3OK;
}

static fmi3Status set_inputs(
    Mechanism *m, const fmi3ValueReference references[], size_t n, const fmi3Float64 values[]) {
    return say(m, fmi3Error, "parameters of a model with contacts cannot change during a run");
}

/* ---------------------------------------------------------------- steps */
FMI(fmi3Status, fmi3DoStep)(
    fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
    fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation,
    fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime) {
    Mechanism *m = instance;
    const double until = currentCommunicationPoint + communicationStepSize;
    fmi3Status status;
    REQUIRE(STEPPING, "fmi3DoStep");
    *eventHandlingNeeded = *terminateSimulation = *earlyReturn = false;
    *lastSuccessfulTime = m->t;
    if (check_step(m, currentCommunicationPoint, communicationStepSize) != fmi3OK) return fmi3Error;
    status = advance(m, until, m->called.events && m->called.early, eventHandlingNeeded);
    *lastSuccessfulTime = m->t;
    if (status != fmi3OK) return status;
    *earlyReturn = m->t < until;
    return audit(m);
}

#define MORE (sizeof(int64_t) * (CELLS + RUN_CELLS))
#define EXCHANGES 0
#include "calls.c"

#define NO_EXCHANGE(name, arguments) LACKS(name, arguments, "model exchange")
NO_EXCHANGE(fmi3EnterContinuousTimeMode, (fmi3Instance instance))
NO_EXCHANGE(fmi3CompletedIntegratorStep,
            ON(fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation))
NO_EXCHANGE(fmi3SetTime, ON(fmi3Float64 time))
NO_EXCHANGE(fmi3SetContinuousStates, ON(const fmi3Float64 continuousStates[], size_t nContinuousStates))
NO_EXCHANGE(fmi3GetContinuousStates, ON(fmi3Float64 continuousStates[], size_t nContinuousStates))
NO_EXCHANGE(fmi3GetContinuousStateDerivatives, ON(fmi3Float64 derivatives[], size_t nContinuousStates))
NO_EXCHANGE(fmi3GetNominalsOfContinuousStates, ON(fmi3Float64 nominals[], size_t nContinuousStates))
NO_EXCHANGE(fmi3GetNumberOfContinuousStates, ON(size_t *nContinuousStates))
NO_EXCHANGE(fmi3GetNumberOfEventIndicators, ON(size_t *nEventIndicators))
NO_EXCHANGE(fmi3GetEventIndicators, ON(fmi3Float64 eventIndicators[], size_t nEventIndicators))
