/* The functions of FMI 3.0 that are alike for every model: how an instance begins and ends, variables of all types,
   saved states, and what no model has.

   Before them stand `clear`, which makes an instance as it is when it is new, `take_place`, which makes what was copied
   from another one its own, `look_up`, which finds a variable, `set_inputs`, which changes parameters during a run, and
   `settle_states`, which may change states in event mode; MORE, the bytes that an instance has behind its struct, and
   EXCHANGES, whether there is model exchange. */
FMI(const char *, fmi3GetVersion)(void) { return "3.0"; }

FMI(fmi3Status, fmi3SetDebugLogging)(
    fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories, const fmi3String categories[]) {
    ((Mechanism *)instance)->called.debug = loggingOn;
    return fmi3OK;
}

static fmi3Instance instantiate(
    bool exchange, bool events, bool early, fmi3String name, fmi3String token, bool debug,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    Mechanism *m = calloc(1, sizeof *m + MORE);
    if (m == NULL) return NULL;
    m->called = (Called){exchange, events, early, debug, environment, log};
    if (exchange && !EXCHANGES) {
        say(m, fmi3Error, "this model is for co-simulation only, as its description says");
        free(m);
        return NULL;
    }
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
    return instantiate(
        true, false, false, instanceName, instantiationToken, loggingOn, instanceEnvironment, logMessage);
}

FMI(fmi3Instance, fmi3InstantiateCoSimulation)(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
    fmi3Boolean loggingOn, fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
    const fmi3ValueReference requiredIntermediateVariables[], size_t nRequiredIntermediateVariables,
    fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
    fmi3IntermediateUpdateCallback intermediateUpdate) {
    return instantiate(
        false, eventModeUsed, earlyReturnAllowed, instanceName, instantiationToken, loggingOn, instanceEnvironment,
        logMessage);
}

FMI(fmi3Instance, fmi3InstantiateScheduledExecution)(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
    fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
    fmi3ClockUpdateCallback clockUpdate, fmi3LockPreemptionCallback lockPreemption,
    fmi3UnlockPreemptionCallback unlockPreemption) {
    return NULL;
}

FMI(void, fmi3FreeInstance)(fmi3Instance instance) { free(instance); }

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

FMI(fmi3Status, fmi3UpdateDiscreteStates)(
    fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate, fmi3Boolean *terminateSimulation,
    fmi3Boolean *nominalsOfContinuousStatesChanged, fmi3Boolean *valuesOfContinuousStatesChanged,
    fmi3Boolean *nextEventTimeDefined, fmi3Float64 *nextEventTime) {
    Mechanism *m = instance;
    REQUIRE(EVENTS, "fmi3UpdateDiscreteStates");
    *discreteStatesNeedUpdate = *terminateSimulation = *nominalsOfContinuousStatesChanged = false;
    *valuesOfContinuousStatesChanged = *nextEventTimeDefined = false;
    *nextEventTime = 0.0;
    return settle_states(m, valuesOfContinuousStatesChanged);
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

/* ---------------------------------------------------------------- saved states */
FMI(fmi3Status, fmi3GetFMUState)(fmi3Instance instance, fmi3FMUState *FMUState) {
    if (*FMUState == NULL) *FMUState = malloc(sizeof(Mechanism) + MORE);
    if (*FMUState == NULL) return say(instance, fmi3Error, "there is no memory to save a state");
    memcpy(*FMUState, instance, sizeof(Mechanism) + MORE);
    return fmi3OK;
}

FMI(fmi3Status, fmi3SetFMUState)(fmi3Instance instance, fmi3FMUState FMUState) {
    Mechanism *m = instance;
    const Called called = m->called;
    if (FMUState == NULL) return say(m, fmi3Error, "no state was saved");
    memcpy(m, FMUState, sizeof(Mechanism) + MORE);
    m->called = called;
    take_place(m);
    return fmi3OK;
}

FMI(fmi3Status, fmi3FreeFMUState)(fmi3Instance instance, fmi3FMUState *FMUState) {
    free(*FMUState);
    *FMUState = NULL;
    return fmi3OK;
}

/* ---------------------------------------------------------------- what this model does not have */
#define LACKS(name, arguments, what)                                                                                  \
    FMI(fmi3Status, name) arguments { return lacks(instance, what); }
#define ON(...) (fmi3Instance instance, __VA_ARGS__)
#define REFERENCES const fmi3ValueReference valueReferences[], size_t nValueReferences

LACKS(fmi3SerializedFMUStateSize, ON(fmi3FMUState FMUState, size_t *size), "state to write down")
LACKS(fmi3SerializeFMUState, ON(fmi3FMUState FMUState, fmi3Byte serializedState[], size_t size), "state to write down")
LACKS(fmi3DeserializeFMUState, ON(const fmi3Byte serializedState[], size_t size, fmi3FMUState *FMUState),
      "state to write down")
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
LACKS(fmi3GetOutputDerivatives, ON(REFERENCES, const fmi3Int32 orders[], fmi3Float64 values[], size_t nValues),
      "derivatives of outputs")
LACKS(fmi3ActivateModelPartition, ON(fmi3ValueReference clockReference, fmi3Float64 activationTime), "clocks")
