/* FMI 2.0 for co-simulation around first[], kind[], sense(), advance(), sound() of the model that includes this. */

enum phase { INSTANTIATED = 1, INITIALIZING = 2, STEPPING = 4, TERMINATED = 8, FAILED = 16 };

typedef struct {
    double v[TOTAL];
    double before[TOTAL];
    double work[WORK];
    long tick;    /* samples since the start */
    double begun; /* time of sample 0 */
    enum phase phase;
    fmi2CallbackFunctions calls;
    char name[128];
} instance;

typedef struct {
    double v[TOTAL];
    long tick;
    double begun;
    enum phase phase;
} kept;

static fmi2Status told(instance *c, fmi2Status status, const char *what)
{
    if (c && c->calls.logger)
        c->calls.logger(c->calls.componentEnvironment, c->name, status, status == fmi2OK ? "logAll" : "logStatusError",
                        "%s", what);
    return status;
}

/* The instance, if a function may be called now; else NULL, and the master is told. */
static instance *called(fmi2Component component, int phases, const char *function)
{
    instance *c = component;
    if (c && !(c->phase & (unsigned)phases)) {
        told(c, fmi2Error, function);
        return NULL;
    }
    return c;
}

static void begin(instance *c)
{
    memcpy(c->v, first, sizeof first);
    c->tick = 0;
    c->begun = 0.0;
    c->phase = INSTANTIATED;
    (void)sense(c->v, c->work);
}

EXPORTED const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORTED const char *fmi2GetVersion(void) { return "2.0"; }

EXPORTED fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                       const fmi2CallbackFunctions *calls, fmi2Boolean visible, fmi2Boolean logging)
{
    instance *c;
    (void)resources, (void)visible, (void)logging;
    if (!calls || !calls->allocateMemory || !calls->freeMemory || !name || !guid)
        return NULL;
    if (type != fmi2CoSimulation || strcmp(guid, GUID) != 0) {
        if (calls->logger)
            calls->logger(calls->componentEnvironment, name, fmi2Error, "logStatusError", "%s",
                          type != fmi2CoSimulation ? "this FMU is for co-simulation" : "the GUID is another FMU's");
        return NULL;
    }
    c = calls->allocateMemory(1, sizeof *c);
    if (!c)
        return NULL;
    memset(c, 0, sizeof *c);
    c->calls = *calls;
    strncpy(c->name, name, sizeof c->name - 1);
    begin(c);
    return c;
}

EXPORTED void fmi2FreeInstance(fmi2Component component)
{
    instance *c = component;
    if (c)
        c->calls.freeMemory(c);
}

EXPORTED fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t n, const fmi2String names[])
{
    (void)on, (void)n, (void)names;
    return component ? fmi2OK : fmi2Error;
}

EXPORTED fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean toleranced, fmi2Real tolerance,
                                        fmi2Real start, fmi2Boolean stopped, fmi2Real stop)
{
    instance *c = called(component, INSTANTIATED, "fmi2SetupExperiment comes before initialization");
    (void)toleranced, (void)tolerance, (void)stopped, (void)stop;
    if (!c || !isfinite(start))
        return fmi2Error;
    c->begun = start;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2EnterInitializationMode(fmi2Component component)
{
    instance *c = called(component, INSTANTIATED, "fmi2EnterInitializationMode comes once, after instantiation");
    if (!c)
        return fmi2Error;
    c->phase = INITIALIZING;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2ExitInitializationMode(fmi2Component component)
{
    instance *c = called(component, INITIALIZING, "fmi2ExitInitializationMode comes after entering it");
    if (!c)
        return fmi2Error;
    c->phase = STEPPING;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2Terminate(fmi2Component component)
{
    instance *c = called(component, STEPPING | FAILED, "fmi2Terminate comes after initialization");
    if (!c)
        return fmi2Error;
    c->phase = TERMINATED;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2Reset(fmi2Component component)
{
    instance *c = component;
    if (!c)
        return fmi2Error;
    begin(c);
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference r[], size_t n, fmi2Real value[])
{
    instance *c = called(component, ~0, "");
    size_t i;
    if (!c)
        return fmi2Error;
    for (i = 0; i < n; i++) {
        if (r[i] >= TOTAL || !kind[r[i]])
            return told(c, fmi2Error, "no variable has this value reference");
        value[i] = c->v[r[i]];
    }
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference r[], size_t n, const fmi2Real value[])
{
    instance *c = called(component, INSTANTIATED | INITIALIZING | STEPPING, "fmi2SetReal comes before the end");
    size_t i;
    if (!c)
        return fmi2Error;
    for (i = 0; i < n; i++) {
        if (r[i] >= TOTAL || kind[r[i]] != 1)
            return told(c, fmi2Error, "no input has this value reference");
        if (!isfinite(value[i]))
            return told(c, fmi2Error, "an input is no number");
    }
    for (i = 0; i < n; i++)
        c->v[r[i]] = value[i];
    return fmi2OK;
}

EXPORTED fmi2Status fmi2DoStep(fmi2Component component, fmi2Real now, fmi2Real size, fmi2Boolean no_return)
{
    instance *c = called(component, STEPPING, "fmi2DoStep comes after initialization, and not after an error");
    double samples = floor(size / PERIOD + 0.5), here;
    long left;
    (void)no_return;
    if (!c)
        return fmi2Error;
    here = c->begun + (double)c->tick * PERIOD;
    if (!(fabs(now - here) <= 1e-2 * PERIOD + 1e-9 * fabs(now)))
        return told(c, fmi2Error, "the communication point is not where the last step ended");
    if (!(samples >= 1.0 && samples < 1e9 && fabs(size - samples * PERIOD) <= 1e-6 * PERIOD * samples))
        return told(c, fmi2Error, "the step must be a multiple of the default step size");
    for (left = (long)samples; left > 0; left--) {
        int limit;
        memcpy(c->before, c->v, sizeof c->v);
        advance(c->v, c->work);
        limit = sense(c->v, c->work);
        if (limit || !sound(c->v)) {
            memcpy(c->v, c->before, sizeof c->v);
            c->phase = FAILED;
            return told(c, fmi2Error, limit ? limit_names[limit - 1] : "a number is no longer finite");
        }
        c->tick++;
    }
    return fmi2OK;
}

EXPORTED fmi2Status fmi2CancelStep(fmi2Component component)
{
    (void)component;
    return fmi2Error; /* no step is ever pending */
}

EXPORTED fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    instance *c = called(component, ~0, "");
    kept *k;
    if (!c || !state)
        return fmi2Error;
    k = *state ? *state : c->calls.allocateMemory(1, sizeof *k);
    if (!k)
        return told(c, fmi2Error, "no memory for a state");
    memcpy(k->v, c->v, sizeof k->v);
    k->tick = c->tick;
    k->begun = c->begun;
    k->phase = c->phase;
    *state = k;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state)
{
    instance *c = called(component, ~0, "");
    const kept *k = state;
    if (!c || !k)
        return fmi2Error;
    memcpy(c->v, k->v, sizeof k->v);
    c->tick = k->tick;
    c->begun = k->begun;
    c->phase = k->phase;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    instance *c = component;
    if (!c || !state)
        return fmi2Error;
    if (*state)
        c->calls.freeMemory(*state);
    *state = NULL;
    return fmi2OK;
}

/* What this FMU has none of. */
#define NONE(function, kind_of)                                                                                      \
    EXPORTED fmi2Status function(fmi2Component component, const fmi2ValueReference r[], size_t n, kind_of value[])   \
    {                                                                                                                \
        (void)r, (void)value;                                                                                        \
        return component && n == 0 ? fmi2OK : fmi2Error;                                                             \
    }
NONE(fmi2GetInteger, fmi2Integer)
NONE(fmi2GetBoolean, fmi2Boolean)
NONE(fmi2GetString, fmi2String)
NONE(fmi2SetInteger, const fmi2Integer)
NONE(fmi2SetBoolean, const fmi2Boolean)
NONE(fmi2SetString, const fmi2String)

EXPORTED fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate s, size_t *size)
{
    (void)c, (void)s, (void)size;
    return fmi2Error;
}

EXPORTED fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate s, fmi2Byte bytes[], size_t size)
{
    (void)c, (void)s, (void)bytes, (void)size;
    return fmi2Error;
}

EXPORTED fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *s)
{
    (void)c, (void)bytes, (void)size, (void)s;
    return fmi2Error;
}

EXPORTED fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference u[], size_t nu,
                                                 const fmi2ValueReference k[], size_t nk, const fmi2Real du[],
                                                 fmi2Real dk[])
{
    (void)c, (void)u, (void)nu, (void)k, (void)nk, (void)du, (void)dk;
    return fmi2Error;
}

EXPORTED fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                                const fmi2Integer order[], const fmi2Real value[])
{
    (void)c, (void)r, (void)n, (void)order, (void)value;
    return fmi2Error;
}

EXPORTED fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                                 const fmi2Integer order[], fmi2Real value[])
{
    (void)c, (void)r, (void)n, (void)order, (void)value;
    return fmi2Error;
}

EXPORTED fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value)
{
    (void)c, (void)s, (void)value;
    return fmi2Discard;
}

EXPORTED fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind s, fmi2Real *value)
{
    instance *c = component;
    if (!c || s != fmi2LastSuccessfulTime)
        return fmi2Discard;
    *value = c->begun + (double)c->tick * PERIOD;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value)
{
    (void)c, (void)s, (void)value;
    return fmi2Discard;
}

EXPORTED fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind s, fmi2Boolean *value)
{
    instance *c = component;
    if (!c || s != fmi2Terminated)
        return fmi2Discard;
    *value = c->phase == TERMINATED;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String *value)
{
    (void)c, (void)s, (void)value;
    return fmi2Discard;
}
