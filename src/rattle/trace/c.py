"""Straight-line code in C99, without dependencies but the C library's sqrt, fabs and floor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rattle.trace.graph import ROUND, Graph
from rattle.trace.text import statements

FORMS = {
    "add": "{0} + {1}", "sub": "{0} - {1}", "mul": "{0} * {1}", "div": "{0} / {1}", "neg": "-{0}", "abs": "fabs({0})",
    "sqrt": "sqrt({0})", "floor": "floor({0})", "less": "{0} < {1}", "at_most": "{0} <= {1}", "equal": "{0} == {1}",
    "both": "{0} && {1}", "either": "{0} || {1}", "not": "!{0}", "select": "{0} ? {1} : {2}",
    "power_of_two": "power_of_two({0})", "exponent": "exponent_of({0})", "mantissa": "mantissa_of({0})",
}  # fmt: skip
INCLUDES = "#include <math.h>\n#include <stdint.h>\n#include <stdio.h>\n#include <stdlib.h>\n#include <string.h>\n"
BITS = {  # what works on the bits of a number, by the name under which code calls it
    "power_of_two": f"""/* 2^n for a whole n */
static double power_of_two(double n) {{
    uint64_t u;
    n += {ROUND + 1023.0!r};
    memcpy(&u, &n, 8);
    u <<= 52;
    memcpy(&n, &u, 8);
    return n;
}}
""",
    "exponent_of": """/* x = m 2^n with m from 1 to 2: n, for a positive normal number */
static double exponent_of(double x) {
    uint64_t u;
    memcpy(&u, &x, 8);
    return (double)((u >> 52) & 0x7FF) - 1023.0;
}
""",
    "mantissa_of": """/* x = m 2^n with m from 1 to 2: m, for a positive normal number */
static double mantissa_of(double x) {
    uint64_t u;
    memcpy(&u, &x, 8);
    u = (u & UINT64_C(0xFFFFFFFFFFFFF)) | UINT64_C(0x3FF0000000000000);
    memcpy(&x, &u, 8);
    return x;
}
""",
}


def helpers(functions: Sequence[str]) -> list[str]:
    """The functions of BITS that these call."""
    return [text for name, text in BITS.items() if any(f"{name}(" in one for one in functions)]


def number(value: float) -> str:
    """A number as C reads it, to the bit."""
    if value != value:
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0.0 else "(-INFINITY)"
    text = repr(value)
    return f"({text})" if text.startswith("-") else text


def function(graph: Graph, outputs: Sequence[Any], name: str) -> str:
    """`static void name(const double *in, double *out)`; the file needs INCLUDES and `helpers` before it."""
    body = statements(graph, outputs, FORMS, number, lambda x, flag: f"const {'int' if flag else 'double'} {x}")
    return "\n    ".join([f"static void {name}(const double *in, double *out) {{", *body]) + "\n}\n"


MAIN = """
enum {{ NY = {ny}, NO = {no} }};
static const char *const names[NO] = {{{names}}};
static const double start[NY] = {{{start}}};

/* stops where a load or driver has no finite value, or the motion diverges */
static void require_finite(double t, const double *y) {{
    int i;
    for (i = 0; i < NY; i++) {{
        if (!(fabs(y[i]) < INFINITY)) {{
            fprintf(stderr, "t = %g s: no finite value (a load outside its domain, or a diverging motion)\\n", t);
            exit(1);
        }}
    }}
}}

/* dy/dt; stops where an assumption of the code does not hold */
static void rate(double t, const double *y, double *dy) {{
    double in[NY + 1], out[NY + 1];
    in[0] = t;
    memcpy(in + 1, y, sizeof(double) * NY);
    derivative(in, out);
    if (out[NY] == 0.0) {{
        fprintf(stderr, "t = %g s: near a singular position or coincident points, which this code cannot pass\\n", t);
        exit(1);
    }}
    require_finite(t, out);
    memcpy(dy, out, sizeof(double) * NY);
}}

/* one step of the classical Runge-Kutta method of order 4, brought onto the constraints */
static void advance(double t, double h, double *y) {{
    double k[4][NY], stage[NY], in[NY + 1], out[NY + 1];
    int i;
    rate(t, y, k[0]);
    for (i = 0; i < NY; i++) stage[i] = y[i] + 0.5 * h * k[0][i];
    rate(t + 0.5 * h, stage, k[1]);
    for (i = 0; i < NY; i++) stage[i] = y[i] + 0.5 * h * k[1][i];
    rate(t + 0.5 * h, stage, k[2]);
    for (i = 0; i < NY; i++) stage[i] = y[i] + h * k[2][i];
    rate(t + h, stage, k[3]);
    for (i = 0; i < NY; i++) in[i + 1] = y[i] + h / 6.0 * (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]);
    in[0] = t + h;
    project(in, out);
    if (out[NY] == 0.0) {{
        fprintf(stderr, "t = %g s: the joints cannot be closed after this step; choose a shorter one\\n", t + h);
        exit(1);
    }}
    memcpy(y, out, sizeof(double) * NY);
    require_finite(t + h, y);
}}

/* one line of CSV; stops where the energy error is above 0.1 % of the largest energy: the last columns are kinetic and
   potential energy, work done, energy dissipated, balance */
static void print(double t, const double *y) {{
    static double kinetic = 0.0, work = 0.0, lowest = INFINITY, highest = -INFINITY;
    double in[NY + 1], out[NO + 1], largest, rounding;
    int i;
    in[0] = t;
    memcpy(in + 1, y, sizeof(double) * NY);
    outputs(in, out);
    kinetic = fmax(kinetic, out[NO - 5]);
    lowest = fmin(lowest, out[NO - 4]);
    highest = fmax(highest, out[NO - 4]);
    work = fmax(work, fabs(out[NO - 3]));
    largest = fmax(fmax(kinetic, work), highest - lowest);
    rounding = 1e-12 * (kinetic + work + fmax(fabs(lowest), fabs(highest)));
    if (out[NO] == 0.0 || !(fabs(out[NO - 1]) <= 1e-3 * largest + rounding)) {{
        fprintf(stderr, "t = %g s: energy error %g J, above 0.1 %% of the largest energy: choose a shorter step\\n",
                t, fabs(out[NO - 1]));
        exit(1);
    }}
    printf("%.17g", t);
    for (i = 0; i < NO; i++) printf(",%.17g", out[i]);
    printf("\\n");
}}

/* a time given as a number of seconds, -1 for anything else */
static double seconds(const char *text) {{
    char *end;
    const double value = strtod(text, &end);
    return end != text && *end == 0 ? value : -1.0;
}}

/* usage: model [t_end [step]], both in s; CSV in SI units, about {rows} lines */
int main(int argc, char **argv) {{
    const double t_end = argc > 1 ? seconds(argv[1]) : {t_end};
    const double longest = argc > 2 ? seconds(argv[2]) : {step};
    double y[NY], h;
    long n, k, every;
    int i;
    if (argc > 3 || !(t_end > 0.0) || !(longest > 0.0) || !(t_end / longest <= 1e9)) {{
        fprintf(stderr, "usage: %s [t_end [step]], both in s and positive, at most 1e9 steps\\n", argv[0]);
        return 2;
    }}
    n = (long)ceil(t_end / longest - 1e-9);
    n = n > 0 ? n : 1;
    h = t_end / (double)n;
    every = (n + {rows} - 1) / {rows};
    memcpy(y, start, sizeof start);
    printf("t");
    for (i = 0; i < NO; i++) printf(",%s", names[i]);
    printf("\\n");
    print(0.0, y);
    for (k = 0; k < n; k++) {{
        advance((double)k * h, h, y);
        if ((k + 1) % every == 0 || k + 1 == n) print((double)(k + 1) * h, y);
    }}
    return 0;
}}
"""
ROWS = 1000


def program(
    header: Sequence[str], functions: Sequence[str], names: Sequence[str], units: Sequence[str],
    start: Sequence[float], t_end: float, step: float,
) -> str:  # fmt: skip
    """A whole file: functions `derivative`, `project`, `outputs`, and a main that prints the motion as CSV.

    header: lines of the comment on top; start: y at t = 0 [SI]; t_end, step: what the program does when not told [s].
    """
    columns = "\n".join(f"     {name} [{unit or '-'}]" for name, unit in zip(names, units, strict=True))
    comment = "\n   ".join(header).replace("*/", "* /").replace("/*", "/ *")
    top = f"""/* {comment}

   cc -std=c99 -O2 model.c -lm && ./a.out [t_end [step]]

   The functions take t [s], then the state y [SI]: positions x, y, angle of every body in turn, their rates, work done
   and energy dissipated.  The last number that each returns is 0 where it holds for no reason:
   next to a singular position, or where points coincide.
   Result columns:
{columns}
*/
"""
    quoted = ", ".join(f'"{name}"' for name in names)
    values = ", ".join(number(x) for x in start)
    main = MAIN.format(
        ny=len(start), no=len(names), names=quoted, start=values, t_end=number(t_end), step=number(step), rows=ROWS
    )
    return "\n".join([top, INCLUDES, *helpers(functions), *functions, main])
