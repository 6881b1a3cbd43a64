/* What an instance of every model has, and in which order functions may be called. */
typedef enum { INSTANTIATED = 1, INITIALIZING = 2, EVENTS = 4, CONTINUOUS = 8, STEPPING = 16, TERMINATED = 32 } Mode;

/* how an instance was asked for: of itself, whatever state it is set to */
typedef struct {
    bool exchange;      /* model exchange, else co-simulation */
    bool events, early; /* event mode is used, steps may end early: in co-simulation */
    bool debug;         /* say more than warnings and errors */
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} Called;

#define EVERY_INSTANCE                                                                                                \
    Called called;                                                                                                    \
    Mode mode;                                                                                                        \
    bool begun, warned, curves_known;      /* the start is known; energy error was said; curves are those at t */     \
    double tolerance;                      /* relative one of a step of co-simulation */                              \
    double t, curves[NO];                  /* [SI] */                                                                 \
    double p[NP + 1];                      /* parameters [SI] */

#define REQUIRE(modes, name)                                                                                          \
    if (!(m->mode & (modes))) return say(m, fmi3Error, name " was called in a mode in which it is not allowed")
