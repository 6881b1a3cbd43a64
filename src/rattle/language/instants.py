"""The instants at which expressions of time switch, and the sides of their switches between them.

A switching function of time is bounded, with its rate, over spans of time.  A span is halved until the function has no
zero in it or is monotone there; then the signs at both ends decide, and false position finds the first instant after
the change of sign.  Nested switches are treated first: between their instants the function is smooth.

`timed` has a row for every such switch, nested ones first.  `switchings` holds an instant and the side from there on,
switch after switch, each from the start of the search on.  `edges` are those of the pieces between all instants.

Source: Moore, Kearfott, Cloud, Introduction to Interval Analysis (2009), section 8.1 (interval Newton, exclusion).
"""

from __future__ import annotations

import math

import numpy as np

from rattle.jit import layout as at
from rattle.jit.functions import compiled
from rattle.language.arithmetic import quotient
from rattle.language.bytecode import SIDE, SIGNAL
from rattle.language.intervals import enclose, switching_span
from rattle.language.span import most

MOST = 600_000  # spans of one switching function that are looked at, at most
WORK = 8e7  # rows of programs times spans that are evaluated for all switching functions of a run, at most
NARROW = 2.0**-44  # share of the whole time below which a span is not halved
NEIGHBOURS = 1e-18  # share of the whole time below which no instant is sought
SAME = 1e-13  # share of the whole time within which two instants count as one
HALVINGS = 128  # of a span, at most: NARROW ends them long before
SEARCHES = 400  # values of a switching function in the search of one instant, at most
ROUNDING = 1e-12  # share of a bound that its computation may be off: some thousand roundings
NEEDED = 4  # column of `signal_spans` after those of a span
INF = math.inf


def search_arrays(signals: int, depth: int, room: int) -> dict[str, np.ndarray]:
    """Arrays of a workspace for the search, with room for so many rows of `switchings`.

    signals: number of states and signals of the model.  depth: of programs.
    """
    return {
        "switchings": np.zeros((room, at.width("switchings"))),
        "edges": np.zeros(room + 2),
        "span_stack": np.zeros((depth, 4)),
        "signal_spans": np.zeros((signals, NEEDED + 1)),
        "halves": np.zeros(HALVINGS),
        "search": np.zeros(at.width("search")),
    }


# ---------------------------------------------------------------- the search
@compiled
def find_instants(m, start, end):
    """Instants and sides of every switch between two times [s]; 0, or how many rows of `switchings` are needed.

    A switch with too many instants, or reached after the work allowed for all of them is used up, is not `RESOLVED`.
    """
    timed, search, code = m.timed, m.search, m.code
    search[at.SPENT], search[at.FILLED] = 0.0, 0.0
    for n in range(timed.shape[0]):
        code[timed[n, at.OWN_CODE], SIDE] = 0
    for n in range(timed.shape[0]):
        first = int(search[at.FILLED])
        timed[n, at.FIRST_FOUND] = first
        take_nested(m, n)
        search[at.CUT], search[at.SIDE_THERE], search[at.LOOKS] = start, 0.0, 0.0
        timed[n, at.RESOLVED] = 1 if locate(m, n, start, end) else 0
        if timed[n, at.RESOLVED] == 0:
            search[at.FILLED] = first
            append(m, start, 0.0)
        timed[n, at.END_FOUND] = int(search[at.FILLED])
        if timed[n, at.END_FOUND] > m.switchings.shape[0]:
            return timed[n, at.END_FOUND]
    return 0


@compiled
def take_nested(m, n):
    """Which signals the switching function of switch n uses, and which switches are nested in it."""
    timed, signal, spans = m.timed, m.signal, m.signal_spans
    for k in range(spans.shape[0]):
        spans[k, NEEDED] = 0.0
    rows = note_signals(m, timed[n, at.FIRST_CODE], timed[n, at.END_CODE])
    for s in range(signal.shape[0] - 1, -1, -1):  # what a signal uses comes before it
        if spans[signal[s, at.TARGET], NEEDED] > 0.0:
            rows += note_signals(m, signal[s, at.FIRST_CODE], signal[s, at.END_CODE])
    m.search[at.ROWS] = rows
    for j in range(n):
        timed[j, at.NESTED] = 1 if is_used(m, n, timed[j, at.OWN_CODE]) else 0
        timed[j, at.NEXT] = timed[j, at.FIRST_FOUND]


@compiled
def note_signals(m, first, last):
    """Note the signals that a program uses; its number of rows."""
    for row in range(first, last):
        if m.code[row, 0] == SIGNAL:
            m.signal_spans[m.code[row, 1], NEEDED] = 1.0
    return last - first


@compiled
def is_used(m, n, row):
    """True if a row of code belongs to the switching function of switch n."""
    signal = m.signal
    if m.timed[n, at.FIRST_CODE] <= row < m.timed[n, at.END_CODE]:
        return True
    for s in range(signal.shape[0]):
        if signal[s, at.FIRST_CODE] <= row < signal[s, at.END_CODE]:
            return m.signal_spans[signal[s, at.TARGET], NEEDED] > 0.0
    return False


@compiled
def locate(m, n, start, end):
    """Write the instants and sides of switch n into `switchings`; False if there are too many."""
    edge = start
    while edge < end:
        following = pass_edge(m, n, edge, end)
        if not find_roots(m, n, edge, following, start, end):
            return False
        cut_at(m, n, following)
        edge = following
    return True


@compiled
def pass_edge(m, n, edge, end):
    """Set the switches nested in switch n to their sides from the time `edge` [s] on; until when they stay there."""
    timed, switchings, following = m.timed, m.switchings, end
    for j in range(n):
        if timed[j, at.NESTED] == 0:
            continue
        k = timed[j, at.NEXT]
        while k + 1 < timed[j, at.END_FOUND] and switchings[k + 1, at.SWITCHES_AT] <= edge:
            k += 1
        timed[j, at.NEXT] = k
        m.code[timed[j, at.OWN_CODE], SIDE] = int(switchings[k, at.SIDE_AFTER])
        if k + 1 < timed[j, at.END_FOUND]:
            following = min(following, float(switchings[k + 1, at.SWITCHES_AT]))
    return following


@compiled
def function_span(m, n, low, high):
    """Span of the switching function of switch n over the times low..high [s]."""
    code, const, signal, timed = m.code, m.const, m.signal, m.timed
    spans, stack = m.signal_spans, m.span_stack
    m.search[at.SPENT] += m.search[at.ROWS]
    for s in range(signal.shape[0]):
        k = signal[s, at.TARGET]
        if spans[k, NEEDED] > 0.0:
            enclose(code, const, signal[s, at.FIRST_CODE], signal[s, at.END_CODE], low, high, spans, stack)
            for column in range(NEEDED):
                spans[k, column] = stack[0, column]
    enclose(code, const, timed[n, at.FIRST_CODE], timed[n, at.END_CODE], low, high, spans, stack)
    row = timed[n, at.OWN_CODE]
    return switching_span(const, code[row, 0], code[row, 1], stack)


@compiled
def value_at(m, n, t):
    """The switching function of switch n at the time t [s]."""
    return function_span(m, n, t, t).low


@compiled
def sign(x):
    """-1, 0 or 1; nan of nan."""
    return 1.0 if x > 0.0 else (-1.0 if x < 0.0 else x)


@compiled
def after(x):
    """The next larger float (Rump, Zimmermann, Boldo and Melquiond, BIT 49 (2009) 419-431)."""
    return x + (abs(x) * (2.0**-53 * (1.0 + 2.0**-52)) + 5e-324)


@compiled
def find_roots(m, n, low, last, start, end):
    """Cut switch n at the first instants after each change of sign in low..last [s]; False if there are too many."""
    search, halves, depth, high = m.search, m.halves, 0, last
    while True:
        search[at.LOOKS] += 1.0
        if search[at.SPENT] > WORK or search[at.LOOKS] > MOST:
            return False
        middle = 0.5 * (low + high)
        way = look(m, n, low, high, NARROW * (end - start))
        if way > 0 and depth < halves.shape[0]:
            halves[depth] = high
            depth += 1
            high = middle
            continue
        if way >= 0:
            root = far_side(m, n, low, high, NEIGHBOURS * (end - start))
            if start + SAME * (end - start) < root < end:
                cut_at(m, n, root)
        if depth == 0:
            return True
        depth -= 1
        low, high = high, float(halves[depth])


@compiled
def has_no_root(s):
    """True of a span without zero, or with nothing else."""
    return s.low != s.low or s.high != s.high or s.low > 0.0 or s.high < 0.0 or (s.low == 0.0 and s.high == 0.0)


@compiled
def look(m, n, low, high, narrow):
    """What is to be done with a span of time: 1 halve it, 0 compare the signs at its ends, -1 nothing."""
    s = function_span(m, n, low, high)
    if has_no_root(s):
        return -1
    here = value_at(m, n, 0.5 * (low + high))
    steepest = most(abs(s.slow), abs(s.fast))
    if steepest < INF:  # by the mean value, with a little for rounding
        reach = 0.5 * (high - low) * steepest * (1.0 + ROUNDING)
        if here - reach > 0.0 or here + reach < 0.0 or reach == 0.0:
            return -1
    monotone = (s.slow > 0.0 or s.fast < 0.0) and s.low > -INF and s.high < INF  # without a pole
    size = abs(high)
    return 0 if monotone or high - low <= max(narrow, 8.0 * (after(size) - size)) else 1


@compiled
def far_side(m, n, low, high, tiny):
    """First instant [s] in low..high with another sign than at `low`; nan if the signs at both ends are the same.

    False position (Illinois) with bisection in every third iteration, until the span is two neighbouring floats or
    shorter than `tiny` [s].
    """
    f_low, f_high = value_at(m, n, low), value_at(m, n, high)
    before = sign(f_low)
    if before == sign(f_high):
        return math.nan
    if before == 0.0:
        return low
    for turn in range(SEARCHES):
        size = abs(high)
        if high - low <= max(tiny, after(size) - size):
            break
        middle = 0.5 * (low + high)
        if turn % 3 < 2:
            chord = low + quotient(f_low, f_low - f_high) * (high - low)
            inside = min(max(chord, after(low)), -after(-high))
            if abs(chord) < INF and low < inside < high:
                middle = inside
        value = value_at(m, n, middle)
        if sign(value) == before:
            low, f_low, f_high = middle, value, 0.5 * f_high
        else:
            high, f_low, f_high = middle, 0.5 * f_low, value
    return high


@compiled
def cut_at(m, n, t):
    """Note the side of switch n between the last cut and t [s], where nothing switches; t is the next cut."""
    search = m.search
    if t <= search[at.CUT]:
        return
    side = sign(value_at(m, n, 0.5 * (search[at.CUT] + t)))
    side = side if side == side else 0.0
    if search[at.FILLED] == m.timed[n, at.FIRST_FOUND] or side != search[at.SIDE_THERE]:
        append(m, search[at.CUT], side)
    search[at.CUT] = t


@compiled
def append(m, t, side):
    """Add a row to `switchings`, or count it where there is no room."""
    search, k = m.search, int(m.search[at.FILLED])
    search[at.SIDE_THERE] = side
    search[at.FILLED] += 1.0
    if k < m.switchings.shape[0]:
        m.switchings[k, at.SWITCHES_AT], m.switchings[k, at.SIDE_AFTER] = t, side


# ---------------------------------------------------------------- the pieces between all instants
@compiled
def merge(m, start, end, beyond):
    """Write the instants of all switches up to the end of a run into `edges` [s]; how many there are.

    Instants equal within rounding of the run are one.  After them comes the next one, or `beyond`, where the search has
    ended; then inf.
    """
    timed, edges, near = m.timed, m.edges, SAME * (end - start)
    for n in range(timed.shape[0]):
        timed[n, at.NEXT] = timed[n, at.FIRST_FOUND] + 1
    count, before = 0, -INF
    edges[0] = start
    while True:
        t = min(following_instant(m, before), beyond)
        if t >= beyond or (t > end + near and t - before > near):
            break
        if t - before > near:
            t_there = end if t >= end - near else t  # no step is left between it and the end
            if t_there > edges[count]:
                count += 1
                edges[count] = t_there
        before = t
    edges[count + 1] = t
    for k in range(count + 2, edges.shape[0]):
        edges[k] = INF
    return count


@compiled
def following_instant(m, t):
    """The next instant after t [s] at which one of all switches changes its side; inf if there is none."""
    timed, switchings, instant = m.timed, m.switchings, INF
    for n in range(timed.shape[0]):
        k = timed[n, at.NEXT]
        while k < timed[n, at.END_FOUND] and switchings[k, at.SWITCHES_AT] <= t:
            k += 1
        timed[n, at.NEXT] = k
        if k < timed[n, at.END_FOUND]:
            instant = min(instant, switchings[k, at.SWITCHES_AT])
    return instant


@compiled
def row_at(m, n, t):
    """The row of `switchings` that holds for switch n at the time t [s]."""
    low, high = m.timed[n, at.FIRST_FOUND], m.timed[n, at.END_FOUND]
    while high - low > 1:
        middle = (low + high) // 2
        if m.switchings[middle, at.SWITCHES_AT] <= t:
            low = middle
        else:
            high = middle
    return low


@compiled
def take_sides_of(m, piece):
    """Write the sides of a piece between two edges into the programs."""
    timed, edges = m.timed, m.edges
    if timed.shape[0] == 0:
        return
    middle = 0.5 * (edges[piece] + edges[piece + 1])
    for n in range(timed.shape[0]):
        m.code[timed[n, at.OWN_CODE], SIDE] = int(m.switchings[row_at(m, n, middle), at.SIDE_AFTER])
