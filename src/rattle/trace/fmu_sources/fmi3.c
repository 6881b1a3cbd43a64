/* The functions of FMI 3.0 for the mechanism in equations.c: model exchange and co-simulation.

   The same in every FMU that rattle writes.  Compile this file alone, with -lm; it needs the C library only.
   All variables are Float64.  Their value references are in this order: time, parameters, parameters that follow from
   others, states, rates of the states, result curves that are not states.

   Model exchange: the states satisfy the constraints of the joints, which integrators do not know.  Where a completed
   step has drifted off by more than a tolerance, event mode is asked for, in which the states are brought back. */
#include "equations.c"
#include "fmi3.h"
#include "mechanism.c"

#define REQUIRE(modes, name)                                                                                          \
    if (!(m->mode & (modes))) return say(m, fmi3Error, name " was called in a mode in which it is not allowed")

FMI(const char *, fmi3GetVersion)(void) { return "3.0"; }

FMI(fmi3Status, fmi3SetDebugLogging)(
    fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories, const fmi3String categories[]) {
    ((Mechanism *)instance)->debug = loggingOn;
    return fmi3OK;
}

static fmi3Instance instantiate(
    bool exchange, fmi3String name, fmi3String token, bool debug, fmi3InstanceEnvironment environment,
    fmi3LogMessageCallback log) {
    Mechanism *m = calloc(1, sizeof *m);
    if (m == NULL) return NULL;
    m->exchange = exchange;
    m->debug = debug;
    m->environment = environment;
    m->log = log;
    if (name == NULL || token == NULL || strcmp(token, TOKEN) != 0) {
        say(m, fmi3Error, "the instantiation token is not that of this model: description and binary do not match");
        free(m);
        return NULL;
    }
    clear(m);
    return m;
}

FMI(fmi3Instance, fmi3InstantiateModelExchange)(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
    fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage) {
    return instantiate(true, instanceName, instantiationToken, loggingOn, instanceEnvironment, logMessage);
}

FMI(fmi3Instance, fmi3InstantiateCoSimulation)(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
    fmi3Boolean loggingOn, fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
    const fmi3ValueReference requiredIntermediateVariables[], size_t nRequiredIntermediateVariables,
    fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
    fmi3IntermediateUpdateCallback intermediateUpdate) {
    return instantiate(false, instanceName, instantiationToken, loggingOn, instanceEnvironment, logMessage);
}

FMI(fmi3Instance, fmi3InstantiateScheduledExecution)(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
    fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
    fmi3ClockUpdateCallback clockUpdate, fmi3LockPreemptionCallback lockPreemption,
    fmi3UnlockPreemptionCallback unlockPreemption) {
    return NULL;
}

FMI(void, fmi3FreeInstance)(fmi3Instance instance) { free(instance); }

FMI(fmi3Status, fmi3EnterInitializationMode)(
    fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance, fmi3Float64 startTime,
    fmi3Boolean stopTimeDefined, fmi3Float64 stopTime) {
    Mechanism *m = instance;
    REQUIRE(INSTANTIATED, "fmi3EnterInitializationMode");
    if (startTime != 0.0) return say(m, fmi3Error, "the start time is %g s; this model starts at 0", startTime);
    if (toleranceDefined) {
        if (!(tolerance > 0.0)) return say(m, fmi3Error, "the relative tolerance must be positive");
        m->tolerance = fmin(fmax(tolerance, SMALLEST_TOLERANCE), 0.1);
        m->most_drift = fmax(10.0 * m->tolerance, SMALLEST_DRIFT);
    }
    m->mode = INITIALIZING;
    return fmi3OK;
}

FMI(fmi3Status, fmi3ExitInitializationMode)(fmi3Instance instance) {
    Mechanism *m = instance;
    REQUIRE(INITIALIZING, "fmi3ExitInitializationMode");
    if (!m->begun && begin(m) != fmi3OK) return fmi3Error;
    if (!m->exchange && audit(m) != fmi3OK) return fmi3Error;
    m->mode = m->exchange ? EVENTS : STEPPING;
    return fmi3OK;
}

FMI(fmi3Status, fmi3EnterEventMode)(fmi3Instance instance) {
    Mechanism *m = instance;
    REQUIRE(CONTINUOUS, "fmi3EnterEventMode");
    m->mode = EVENTS;
    return fmi3OK;
}

FMI(fmi3Status, fmi3Terminate)(fmi3Instance instance) {
    Mechanism *m = instance;
    REQUIRE(EVENTS | CONTINUOUS | STEPPING, "fmi3Terminate");
    m->mode = TERMINATED;
    return fmi3OK;
}

FMI(fmi3Status, fmi3Reset)(fmi3Instance instance) {
    clear(instance);
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

FMI(fmi3Status, fmi3GetFloat64)(
    fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3Float64 values[],
    size_t nValues) {
    size_t i;
    if (nValues != nValueReferences) return say(instance, fmi3Error, "fmi3GetFloat64: as many values as variables");
    for (i = 0; i < nValues; i++) {
        const fmi3Status status = look_up(instance, valueReferences[i], values + i);
        if (status != fmi3OK) return status;
    }
    return fmi3OK;
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

FMI(fmi3Status, fmi3SetFloat64)(
    fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
    const fmi3Float64 values[], size_t nValues) {
    Mechanism *m = instance;
    size_t i;
    if (nValues != nValueReferences) return say(m, fmi3Error, "fmi3SetFloat64: as many values as variables");
    if (nValues == 0) return fmi3OK;
    REQUIRE(~TERMINATED, "fmi3SetFloat64");
    for (i = 0; i < nValues; i++) {
        if (valueReferences[i] < FIRST_PARAMETER || valueReferences[i] >= FIRST_FOLLOWING) {
            return say(m, fmi3Error, "the variable %u cannot be set: only parameters can", (unsigned)valueReferences[i]);
        }
    }
    if (!(m->mode & (INSTANTIATED | INITIALIZING))) return set_inputs(m, valueReferences, nValues, values);
    for (i = 0; i < nValues; i++) m->p[valueReferences[i] - FIRST_PARAMETER] = values[i];
    m->begun = false;
    return fmi3OK;
}

static fmi3Status none(Mechanism *m, size_t count, const char *type) {
    return count == 0 ? fmi3OK : say(m, fmi3Error, "no variable has the type %s: all are Float64", type);
}

#define NO_VARIABLES(Type)                                                                                            \
    FMI(fmi3Status, fmi3Get##Type)(                                                                                   \
        fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,                   \
        fmi3##Type values[], size_t nValues) {                                                                        \
        return none(instance, nValueReferences, #Type);                                                               \
    }                                                                                                                 \
    FMI(fmi3Status, fmi3Set##Type)(                                                                                   \
        fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,                   \
        const fmi3##Type values[], size_t nValues) {                                                                  \
        return none(instance, nValueReferences, #Type);                                                               \
    }
NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(Int32)
NO_VARIABLES(UInt32)
NO_VARIABLES(Int64)
NO_VARIABLES(UInt64)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)

FMI(fmi3Status, fmi3GetBinary)(
    fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, size_t valueSizes[],
    fmi3Binary values[], size_t nValues) {
    return none(instance, nValueReferences, "Binary");
}

FMI(fmi3Status, fmi3SetBinary)(
    fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
    const size_t valueSizes[], const fmi3Binary values[], size_t nValues) {
    return none(instance, nValueReferences, "Binary");
}

FMI(fmi3Status, fmi3GetClock)(
    fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3Clock values[]) {
    return none(instance, nValueReferences, "Clock");
}

FMI(fmi3Status, fmi3SetClock)(
    fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
    const fmi3Clock values[]) {
    return none(instance, nValueReferences, "Clock");
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

FMI(fmi3Status, fmi3UpdateDiscreteStates)(
    fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate, fmi3Boolean *terminateSimulation,
    fmi3Boolean *nominalsOfContinuousStatesChanged, fmi3Boolean *valuesOfContinuousStatesChanged,
    fmi3Boolean *nextEventTimeDefined, fmi3Float64 *nextEventTime) {
    Mechanism *m = instance;
    double closed[NY];
    REQUIRE(EVENTS, "fmi3UpdateDiscreteStates");
    *discreteStatesNeedUpdate = *terminateSimulation = *nominalsOfContinuousStatesChanged = false;
    *valuesOfContinuousStatesChanged = *nextEventTimeDefined = false;
    *nextEventTime = 0.0;
    if (!m->drifted) return fmi3OK;
    if (!on_constraints(m, m->t, m->y, closed)) return say(m, fmi3Error, "t = %g s: the joints cannot be closed", m->t);
    memcpy(m->y, closed, sizeof m->y);
    moved(m);
    m->drifted = false;
    *valuesOfContinuousStatesChanged = true;
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
    if (!(communicationStepSize > 0.0 && communicationStepSize < INFINITY)) {
        return say(m, fmi3Error, "the communication step size must be positive");
    }
    if (!(fabs(currentCommunicationPoint - m->t) <= 1e-6 * communicationStepSize + 1e-12 * fabs(m->t))) {
        return say(m, fmi3Error, "the communication point is %.17g s, but the model is at %.17g s",
                   currentCommunicationPoint, m->t);
    }
    status = advance(m, currentCommunicationPoint + communicationStepSize);
    *lastSuccessfulTime = m->t;
    return status == fmi3OK ? audit(m) : status;
}

/* ---------------------------------------------------------------- what this model does not have */
static fmi3Status lacks(fmi3Instance instance, const char *what) {
    return say(instance, fmi3Error, "this model has no %s, as its description says", what);
}

#define LACKS(name, arguments, what)                                                                                  \
    FMI(fmi3Status, name) arguments { return lacks(instance, what); }
#define ON(...) (fmi3Instance instance, __VA_ARGS__)
#define REFERENCES const fmi3ValueReference valueReferences[], size_t nValueReferences

LACKS(fmi3GetFMUState, ON(fmi3FMUState *FMUState), "state to save")
LACKS(fmi3SetFMUState, ON(fmi3FMUState FMUState), "state to save")
LACKS(fmi3FreeFMUState, ON(fmi3FMUState *FMUState), "state to save")
LACKS(fmi3SerializedFMUStateSize, ON(fmi3FMUState FMUState, size_t *size), "state to save")
LACKS(fmi3SerializeFMUState, ON(fmi3FMUState FMUState, fmi3Byte serializedState[], size_t size), "state to save")
LACKS(fmi3DeserializeFMUState, ON(const fmi3Byte serializedState[], size_t size, fmi3FMUState *FMUState),
      "state to save")
LACKS(fmi3GetDirectionalDerivative,
      ON(const fmi3ValueReference unknowns[], size_t nUnknowns, const fmi3ValueReference knowns[], size_t nKnowns,
         const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity),
      "directional derivatives")
LACKS(fmi3GetAdjointDerivative,
      ON(const fmi3ValueReference unknowns[], size_t nUnknowns, const fmi3ValueReference knowns[], size_t nKnowns,
         const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity),
      "adjoint derivatives")
LACKS(fmi3GetNumberOfVariableDependencies, ON(fmi3ValueReference valueReference, size_t *nDependencies),
      "dependencies of elements")
LACKS(fmi3GetVariableDependencies,
      ON(fmi3ValueReference dependent, size_t elementIndicesOfDependent[], fmi3ValueReference independents[],
         size_t elementIndicesOfIndependents[], fmi3DependencyKind dependencyKinds[], size_t nDependencies),
      "dependencies of elements")
LACKS(fmi3EnterConfigurationMode, (fmi3Instance instance), "structural parameters")
LACKS(fmi3ExitConfigurationMode, (fmi3Instance instance), "structural parameters")
LACKS(fmi3GetIntervalDecimal, ON(REFERENCES, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[]), "clocks")
LACKS(fmi3GetIntervalFraction,
      ON(REFERENCES, fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[]), "clocks")
LACKS(fmi3GetShiftDecimal, ON(REFERENCES, fmi3Float64 shifts[]), "clocks")
LACKS(fmi3GetShiftFraction, ON(REFERENCES, fmi3UInt64 counters[], fmi3UInt64 resolutions[]), "clocks")
LACKS(fmi3SetIntervalDecimal, ON(REFERENCES, const fmi3Float64 intervals[]), "clocks")
LACKS(fmi3SetIntervalFraction, ON(REFERENCES, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]), "clocks")
LACKS(fmi3SetShiftDecimal, ON(REFERENCES, const fmi3Float64 shifts[]), "clocks")
LACKS(fmi3SetShiftFraction, ON(REFERENCES, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]), "clocks")
LACKS(fmi3EvaluateDiscreteStates, (fmi3Instance instance), "discrete states to evaluate")
LACKS(fmi3EnterStepMode, (fmi3Instance instance), "event mode in co-simulation")
LACKS(fmi3GetOutputDerivatives, ON(REFERENCES, const fmi3Int32 orders[], fmi3Float64 values[], size_t nValues),
      "derivatives of outputs")
LACKS(fmi3ActivateModelPartition, ON(fmi3ValueReference clockReference, fmi3Float64 activationTime), "clocks")
