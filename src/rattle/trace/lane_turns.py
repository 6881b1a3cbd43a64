"""What a trip of a lane leaves of its contacts: which are shut, the step to try next, and whether it gets on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from rattle.jit import layout as at
from rattle.language.recorded import Flag, Operand
from rattle.solvers.contacts.contact_events import AFTER_CONTACT, FIRST_STEP
from rattle.solvers.nonsmooth.impacts import NOTICED
from rattle.trace.graph import apply, select, select_flag
from rattle.trace.lane_contacts import COUNTED, LANE, Ends, Meets, Met, Struck, Touch, one
from rattle.trace.lane_gaps import IN_TIME, SHARP
from rattle.trace.lane_methods import largest, least
from rattle.trace.lane_polynomials import FAR, LITTLE
from rattle.trace.recorded_contacts import PRESSED
from rattle.trace.recorded_friction import Joint, ended, settled, sign
from rattle.trace.recorded_rigid import DECIDES, HITS, OPEN, SHUT
from rattle.trace.reductions import Touches

LEAVES = 2.0  # speed of a rigid contact whose force has just ended
RELEASED = 2.0  # of a compliant contact: without force inside its wall
AGAIN = 1.25  # of one that was: it has just pushed again
SOON = 0.5  # share of that step within which a contact is landed on that was not reached
NEARER = 0.7  # share of the way to a contact that a step takes where all of it is too much: a force ends with a kink
MOST_LANDINGS, MOST_TURNS = 200, 60  # tries that do not land; turns at one instant
MOST_UNSOUND = 60  # tries of a run with stages that are not sound, as some are that go far beyond a contact
MOST_CHANGES = 12.0  # of modes of joints beside rigid contacts, one after the other, before all are tried
MOST_TRIED = 200  # trips at one instant that try them
STUCK = 1e-11  # share of the speed of an impact below which a slip after it is rounding
TURN = 0.2  # of a body within which forces on a body at rest are known by three values [rad]
AT_WALL = 1e-3  # share of the height of bounces that are not followed which may be rounding
CRAWLS, MOST_CRAWLS = 1e-11, 500  # share of the time that a step makes no way by, and such tries in a row
AT_ONCE = 1e-13  # share of the time within which turns are at one instant
JUST = 1e-11  # share of the time likewise, beside clutches that let go where joints have just begun to slip
MISSED = 4.0  # of the time by which an instant may be missed: what is farther beyond zero has jumped there
SHORTEST_LANDING = 2e-15  # share of the time that a step to a contact takes at least


class Turned(NamedTuple):
    """What a lane goes on with."""

    touch: list[Operand]
    ahead: Operand  # the step to try next [s]
    still: Operand  # 1: no time passes in the next trip
    landing: Operand  # number of tries that were to end at a contact
    lost: Flag  # a flag: the lane does not get on
    crowded: Operand  # 1, 2: more contacts take part at one instant than it follows, than any lane does
    decided: Flag  # the joints that rub have modes that can last
    switched: Flag  # an expression jumps at the end of its step
    jolted: Flag  # what drives it jumps
    rests: Flag  # an expression that jumps rests where it does
    unkept: Flag  # its stages have failed too often


class Lane(NamedTuple):
    """What else is known of a lane after a trip."""

    running: Flag
    good: Flag  # its step counts
    fits: Flag  # its error is small enough
    still: Flag  # it took no time
    landing: Operand
    ahead: Operand  # the step that its error allows next [s]
    planned: Operand  # that which was to follow
    kept: Flag  # its stages are sound


class Instant(NamedTuple):
    """The end of a trip."""

    t: Operand  # [s]
    still: Flag  # it took no time
    planned: Operand  # the step that was to follow [s]


class Meeting:
    """The contacts of a lane in one trip."""

    def __init__(
        self, meets: Meets, touch: Sequence[Operand], ends: Sequence[Operand], met: Sequence[Operand],
        struck: Sequence[Operand], instant: Instant,
    ) -> None:  # fmt: skip
        self.meets, self.touch, self.ends = meets, Touch(meets, touch), Ends(meets, ends)
        self.met, self.struck = Met(meets, met), Struck(meets, struck)
        self.near, self.instant = [x > 0.0 for x in self.met.near], instant
        # time by which an instant may be missed [s]
        self.late = SHARP * self.touch.lane["hit length"] + IN_TIME * instant.t
        self.shut = [(x > 0.5) & (x < 1.5) for x in self.touch.shut[: meets.n]]
        hits = [self.touch.shut[n] for n in meets.rigid]
        self.hits, self.decides = _any((x > 1.5) & (x < 2.5) for x in hits), _any(x > 2.5 for x in hits)
        self.agreed: Flag = self.struck.agreed > 0.0  # joints that rub agree with the impulses
        self.some: Flag = self.struck.agreed >= 0.0  # there are any, or forces that last, in their modes

    def touches(self, at_start: Flag) -> Touches:
        """What the trip tells the reductions of contacts; at_start: it is the one that takes no time at the start."""
        begins = [near & (code < 0.5) for near, code in zip(self.near, self.touch.shut, strict=False)]
        at_first = at_start & (self.touch.lane["tried"] < 0.5)
        for k, n in enumerate(self.meets.held):  # one that pushes again, and a clutch that takes
            if n < self.meets.n:
                again = (self.met.spent[k] > 0.0) & apply("not", self.shut[n])
                begins[n] = begins[n] | (again if n in self.meets.rigid else again & self._is_inside(n))
        for n in range(self.meets.n):
            if n not in self.meets.rigid:  # it is shut from the start on
                begins[n] = begins[n] | (at_first & self.shut[n])
                if self.meets.table[n, at.LEVEL]:
                    begins[n] = begins[n] | (self.instant.still & self._takes(n))
        hardest: Operand = 0.0
        for impulse in self.struck.impulse:
            hardest = largest(impulse, hardest)
        speeds = [largest(-x, 0.0) for x in self.ends.rate]
        falls = self._falls()
        for n, impulse in zip(self.meets.rigid, self.struck.impulse, strict=True):
            speeds[n] = largest(-self.touch.rate[n], 0.0)
            struck = self.hits & (impulse > NOTICED * hardest) & falls
            level, toothed = self.meets.table[n, at.LEVEL], self.meets.table[n, at.TOOTHED]
            begins[n] = begins[n] | (struck & (speeds[n] > 0.0)) if level else struck
            if level or toothed:  # a clutch is locked from the start on
                decided = self.struck.shut[self.meets.rigid.index(n)] > 0.5
                begins[n] = begins[n] | (at_first & self.decides & decided)
        return Touches(begins, speeds, self.shut, dict(zip(self.meets.peaks, self.met.peaks, strict=True)))

    def _falls(self) -> Flag:
        """Whether a contact hits from farther than rounding, or as from a height that is followed.

        One that has just let go opens with the third power of time, and may touch again at once by rounding.
        """
        some: Flag = False
        for n in self.meets.rigid:
            k, speed = self.meets.held.index(n), largest(-self.touch.rate[n], 0.0)
            fallen = speed * speed > 2.0 * abs(self.ends.held["bend"][k]) * self.met.low[k]
            fallen = fallen | (speed * self.touch.lane["flown"] > AT_WALL * self.met.low[k])
            if n not in self.meets.limited:
                some = some | (fallen if not self.meets.table[n, at.LEVEL] else speed > 0.0)
        return some

    def rests(self, touch: Sequence[Operand]) -> Flag:
        """Whether a rigid contact is shut, or a joint sticks: steps grow while a body rests, however what presses on it
        changes."""
        shut = _any((touch[n] > 0.5) & (touch[n] < 1.5) for n in self.meets.rigid)
        speeds = touch[self.meets.n + self.meets.rubs :]
        return shut | _any(apply("equal", speeds[n], 0.0) for n in self.meets.rubbing)

    def ahead(self, turned: Turned, short: Operand) -> Operand:
        """The step to try next [s], of limited length then; short: one that is short beside the run, for loads that
        change with time."""
        turn = TURN / largest(self.met.turning, LITTLE)
        longest = least(turn, short) if self.meets.pulsates else turn
        return select(self.rests(turned.touch), least(turned.ahead, longest), turned.ahead)

    def turn(self, planned: Sequence[Operand], flags: Lane) -> Turned:
        """What a trip to t leaves of the contacts; its step has the length h [s]."""
        h, t, still, touch, met = planned[0], planned[1], flags.still, self.touch, self.met
        lane, landing = touch.lane, flags.landing
        rigid = self.meets.rigid
        closes = _any(near & (touch.shut[n] < 0.5) for n, near in enumerate(self.near) if n not in rigid)
        strikes = _any(self.near[n] & apply("not", self.shut[n] | self._is_gentle(n)) for n in rigid)
        turns = flags.good & (_any(self.near) | _any(x > 0.0 for x in met.spent))
        reach = select(landing > 0.0, lane["hit length"], h)
        hit = (met.hit > 0.0) & flags.kept  # also where an error is too large: beyond its contact a curve has a kink
        cut = hit | (flags.fits & (met.cut > 0.0))
        lands = landing > 0.0
        comes = lands & flags.good & apply("not", turns | still) & (met.due <= SOON * lane["hit length"])
        missed = lands & apply("not", hit | flags.fits)
        ahead = select(comes, met.due, self._ahead(h, flags, hit, cut, missed))
        landings = select(turns | still, 0.0, select(hit | comes | missed, landing + 1.0, 0.0))
        first = select(lane["closing"] > 0.0, least(flags.planned, FIRST_STEP * self._lasting()), flags.planned)
        after = select(closes | strikes, reach, largest(reach, AFTER_CONTACT * lane["free length"]))
        ahead = select(landings > 0.0, largest(ahead, SHORTEST_LANDING * t), ahead)
        ahead = select(turns, after, select(still, first, ahead))
        again = (t - lane["turned at"]) <= AT_ONCE * t
        count = select(turns, select(again, lane["turns"] + 1.0, 1.0), lane["turns"])
        values = {
            "closing": select(turns, one(closes), select(still, 0.0, lane["closing"])),
            "hit length": select(hit & (landing <= 0.0), h, lane["hit length"]),
            "free length": select(turns & closes, largest(reach, 0.5 * lane["free length"]), lane["free length"]),
            "unsound": lane["unsound"] + one(flags.running & apply("not", flags.kept)),
            **{
                name: lane[name] + one(flags.running & event)
                for name, event in zip(COUNTED, (cut & apply("not", hit), hit | comes | missed, turns), strict=True)
            },
            "turns": count, "tried": select(flags.good & still, lane["tried"] + 1.0, 0.0),
            "flown": select(turns, t - lane["turned at"], lane["flown"]),
            "turned at": select(turns, t, lane["turned at"]),
            "crawls": select(flags.good & (still | (h > CRAWLS * t)), 0.0, lane["crawls"] + one(flags.running)),
        }  # fmt: skip
        shut, speed = self._states(flags.good & still, strikes)
        others = (*self.meets.rubbing, *self.meets.switching)
        jumps = _any(self._jumps(n) for n in range(self.meets.n) if self._is_soft_clutch(n))
        jumps = jumps | (self.hits & self.agreed & bool(self.meets.limited))  # whose torques jump after impacts
        waits = _any(shut[n] > 2.5 for n in (*rigid, *others)) | (still & (self.decides | jumps))
        waits = waits | (still & self.hits & apply("not", self.agreed))
        state = [
            *self._moved(flags.good, shut, touch.shut), *self._moved(flags.good, speed, touch.speed),
            *(
                x
                for new, old in (
                    (self.ends.gap, touch.gap), (self.ends.rate, touch.rate), (self.ends.force, touch.force),
                    (self.ends.change, touch.change), *self._held(still),
                )
                for x in self._moved(flags.good, new, old)
            ),
            *(values[name] for name in LANE),
        ]  # fmt: skip
        struck = flags.running & still & (self.hits | self.decides)
        unsound, crowded = struck & apply("equal", self.struck.sound, 0.0), select(struck, -self.struck.sound, 0.0)
        missed_one = flags.good & (met.deep > 0.0)  # see `solvers.contacts.penetration`
        lost = missed_one | (landings > float(MOST_LANDINGS)) | (count > float(MOST_TURNS)) | unsound
        unkept = values["unsound"] > float(MOST_UNSOUND)
        decided = apply("not", _any(shut[n] > 2.5 for n in others) | jumps)
        lost = lost | (values["crawls"] > float(MOST_CRAWLS))
        lost = lost | (values["tried"] > float(MOST_TRIED if rigid and self.meets.rubs else MOST_TURNS))
        switched = flags.good & apply("not", still) & self._jumps_now(still)
        jolted, rests = flags.good & self._jolts(still), flags.good & self._rests_on_jumps()
        return Turned(
            state, ahead, one(turns | (flags.good & waits)), landings, lost, crowded, decided, switched, jolted, rests,
            unkept,
        )  # fmt: skip

    def _held(self, still: Flag) -> list[tuple[list[Operand], list[Operand]]]:
        """HELD_STARTS of the next step, and those of this one."""
        pairs, sizes = [], []
        for name in ("pressed", "reserve"):
            ends, most = self.ends.held[name], self.touch.held[f"most {name}"]
            pairs.append((ends, self.touch.held[name]))
            sizes.append(([select(still, abs(x), largest(abs(x), y)) for x, y in zip(ends, most, strict=True)], most))
        return [*pairs, (self.ends.held["slip"], self.touch.held["slip"]), *sizes]

    def _ahead(self, h: Operand, flags: Lane, hit: Flag, cut: Flag, missed: Flag) -> Operand:
        """The step to try next [s] if no contact turns."""
        whole = flags.fits | (flags.ahead >= self.met.ahead)
        ahead = select(cut, select(hit & apply("not", whole), NEARER * self.met.ahead, self.met.ahead), flags.ahead)
        return select(missed, largest(flags.ahead, NEARER * h), ahead)

    def _lasting(self) -> Operand:
        """The shortest time that a contact will last about [s]."""
        lasting: Operand = FAR
        for shut, x in zip(self.shut, self.ends.lasting, strict=True):
            lasting = select(shut & (x > 0.0), least(lasting, x), lasting)
        return lasting

    def _states(self, still: Flag, strikes: Flag) -> tuple[list[Operand], list[Operand]]:
        """What contacts are after a good trip, and their speeds; still: it took no time."""
        shut, speed = list(self.touch.shut), list(self.touch.speed)
        for n in range(self.meets.n):
            if n not in self.meets.rigid:
                shut[n], speed[n] = self._compliant(n)
                if self._is_soft_clutch(n):
                    shut[n] = select(still, self._jumped(n), shut[n])
        ended = _any(
            (self.near[n] & (self.shut[n] | self._is_gentle(n))) | (self.met.spent[self.meets.held.index(n)] > 0.0)
            for n in self.meets.rigid
        )
        switched: Flag = False
        for n in self.meets.switching:
            turns, shut[n], speed[n] = self._switching(n, still)
            switched = switched | turns
        rubbing = self.meets.rubbing
        modes = [self.touch.speed[n] for n in rubbing]
        settle = settled(modes, [self._joint(n) for n in rubbing])
        unsettled = _any(apply("not", apply("equal", x, y)) for x, y in zip(settle, modes, strict=True))
        for n, mode in zip(rubbing, settle, strict=True):
            shut[n], speed[n] = self._rubbing(n, still, mode, strikes, ended | self._others_give_way(n), unsettled)
            spent = self.met.spent[self.meets.held.index(n)] > 0.0  # forces of contacts jump with it
            jumps = (self._quiet() & unsettled) | (self.decides & self._comes_to_rest(n))
            switched = switched | select_flag(still, jumps, spent)
        again = self._again()
        for n in self.meets.rigid:
            if n in self.meets.limited:
                shut[n], speed[n] = self._limited(n, still, ended | switched, again)
            else:
                shut[n], speed[n] = self._rigid(n, still, strikes, ended | switched, again)
            decided_now = self.decides & self._comes_to_rest(n)
            again_now = still & (switched | decided_now) & self._is_open_question(n, shut[n], speed[n])
            slip = self.ends.held["slip"][self.meets.held.index(n)]  # one at rest may slip either way now
            shut[n], speed[n] = select(again_now, DECIDES, shut[n]), select(again_now, sign(slip), speed[n])
        if self.meets.rigid:  # joints are looked at once forces of contacts are known
            turned = _any((shut[n] > 1.5) for n in self.meets.rigid) | (still & apply("not", self._quiet()))
            for n in rubbing:
                shut[n] = select(turned, DECIDES, shut[n])
        return shut, speed

    def _is_gentle(self, n: int) -> Flag:
        """Whether a rigid contact that is met is hit by rounding alone, as what rests at its wall does."""
        return apply("not", self.ends.held["calm"][self.meets.held.index(n)] < 0.0)

    def _is_open_question(self, n: int, shut: Operand, speed: Operand) -> Flag:
        """Whether a rigid contact may be another one once joints or loads are: it is shut, or a clutch whose shafts
        are equally fast, unless its torque has just ended."""
        closed = (shut > 0.5) & (shut < 1.5)
        if not self.meets.table[n, at.LEVEL]:
            return closed
        even = apply("equal", self.ends.held["calm"][self.meets.held.index(n)], 0.0)
        holds = closed & (speed > -0.5) if n in self.meets.limited else closed
        return holds | (even & (shut < 1.5) & (speed < LEAVES))

    def _quiet(self) -> Flag:
        """Whether rigid contacts neither hit nor decide."""
        return apply("not", self.hits | self.decides)

    def _again(self) -> dict[int, Flag]:
        """Rigid contacts that decide once more though nothing has hit: those that others hold down to a bounce that is
        not followed, which shows only once these are shut, and with them all that are shut."""
        quiet, low = self._quiet(), {}
        for n in self.meets.rigid:
            k = self.meets.held.index(n)
            at_wall = (self.touch.shut[n] < 0.5) & (self.ends.gap[n] <= self.met.low[k])
            at_wall = at_wall & (self.touch.speed[n] < LEAVES)
            level = bool(self.meets.table[n, at.LEVEL])
            low[n] = False if level else quiet & at_wall & self._low(n, k)
        some = _any(low.values())
        return {n: flag | (some & self.shut[n]) for n, flag in low.items()}

    def _low(self, n: int, k: int) -> Flag:
        """Whether a contact at its wall leaves it by less than is followed."""
        rises, bend = self.ends.held["calm"][k], self.ends.held["bend"][k]
        return (bend < 0.0) & (rises >= 0.0) & (rises * rises <= -2.0 * bend * self.met.low[k])

    def _compliant(self, n: int) -> tuple[Operand, Operand]:
        """What a compliant contact is after a trip, and its approach speed."""
        code, near = self.touch.shut[n], self.near[n]
        begins = near & (code < 0.5)
        after = select(code > 0.5, 0.0, 1.0)
        if n in self.meets.held:
            again = (self.met.spent[self.meets.held.index(n)] > 0.0) & self._is_inside(n)
            after = select(self.shut[n] & (self.ends.gap[n] < 0.0), RELEASED, after)
            pressed = select(code > PRESSED, AGAIN, SHUT)
            after, near, begins = select(again, pressed, after), near | again, begins | again
            code = select((code > SHUT) & (code < PRESSED), SHUT, code)
        speed = select(begins, largest(-self.ends.rate[n], 0.0), self.touch.speed[n])
        return select(near, after, code), speed

    def _is_inside(self, n: int) -> Flag:
        """Whether a contact is in its wall, and not only by rounding on its way out."""
        return (self.ends.gap[n] < -MISSED * self.late * abs(self.ends.rate[n])) | bool(self.meets.table[n, at.LEVEL])

    def _is_soft_clutch(self, n: int) -> bool:
        return bool(self.meets.table[n, at.LEVEL]) and n not in self.meets.rigid

    def _jumps(self, n: int) -> Flag:
        """Whether such a clutch takes or lets go in a trip that took no time."""
        return apply("not", apply("equal", self._jumped(n), self.touch.shut[n]))

    def _jumped(self, n: int) -> Operand:
        """What a clutch without impacts is after a trip that took no time: rates may have jumped."""
        k, code, rate = self.meets.held.index(n), self.touch.shut[n], self.ends.rate[n]
        torque, change = self.ends.held["pressed"][k], self.ends.held["bend"][k]
        pulls = (code > 0.5) & (torque < 0.0) & (rate > MISSED * self.late * abs(change)) & self.hits & self.agreed
        return select(self._takes(n), SHUT, select(pulls, OPEN, code))

    def _takes(self, n: int) -> Flag:
        """Whether such a clutch takes that did not: its rate is below zero, or will be at once."""
        rate, change = self.ends.rate[n], self.ends.held["bend"][self.meets.held.index(n)]
        close = MISSED * self.late * abs(change)
        falls = (rate < -close) | ((abs(rate) <= close) & (change * self.instant.planned < -close))
        return (self.touch.shut[n] < 0.5) & falls & ((self.hits & self.agreed) | (self.instant.t <= 0.0))

    def _rigid(
        self, n: int, still: Flag, strikes: Flag, ended: Flag, again: dict[int, Flag]
    ) -> tuple[Operand, Operand]:
        """What a rigid contact is after a trip, and the sense of its slip."""
        touch, near, k, r = self.touch, self.near[n], self.meets.held.index(n), self.meets.rigid.index(n)
        end = {name: rows[k] for name, rows in self.ends.held.items()}
        level, spent = bool(self.meets.table[n, at.LEVEL]), self.met.spent[k] > 0.0
        # at the end of a step
        goes, way = touch.shut[n], touch.speed[n]
        part = (touch.shut[n] < 0.5) | self.shut[n] if level else self.shut[n]
        goes = select(part & strikes, HITS, select(self.shut[n] & ended, DECIDES, goes))
        goes = select(near, select(self.shut[n], OPEN, select(self._is_gentle(n), DECIDES, HITS)), goes)
        way = select(near, select(self.shut[n], LEAVES, 0.0), select(touch.shut[n] < 0.5, 0.0, way))
        broken = select(end["tangent"] > 0.0, 1.0, -1.0)  # the force on B along t is -T: it begins to slip so
        way = select(spent, select(apply("equal", way, 0.0), broken, 0.0), way)
        goes = select(spent, DECIDES, goes) if level else goes
        # after an impact, and after a decision
        rises, took_part = end["calm"], touch.shut[n] > 0.5
        low = rises <= 0.0
        if not level:
            low = low | self._low(n, k)
        after = select(took_part & low, DECIDES, OPEN)
        sense = select(abs(end["slip"]) <= STUCK * self._fastest(), 0.0, sign(end["slip"]))
        decided = self.decides & self.some
        shut = select(decided, self.struck.shut[r], select(again[n], DECIDES, touch.shut[n]))
        slide = select(again[n] & (touch.shut[n] < 0.5), sense, touch.speed[n])
        slide = select(decided & (touch.shut[n] > 0.5), self.struck.slide[r], slide)
        after, sense = select(self.agreed, after, touch.shut[n]), select(self.agreed, sense, touch.speed[n])
        shut, slide = select(self.hits, after, shut), select(self.hits, sense, slide)
        return select(still, shut, goes), select(still, slide, way)

    def _limited(self, n: int, still: Flag, ended: Flag, again: dict[int, Flag]) -> tuple[Operand, Operand]:
        """What a clutch with a largest torque is after a trip: open, holds (1), or slips (-1); it bears no impulse."""
        code, way = self.touch.shut[n], self.touch.speed[n]
        k, r = self.meets.held.index(n), self.meets.rigid.index(n)
        spent, rate = self.met.spent[k] > 0.0, self.ends.held["calm"][k]
        holds = self.shut[n] & (way > -0.5)
        # at the end of a step
        goes = select(holds & ended, DECIDES, code)
        goes = select(spent, select(holds, SHUT, DECIDES), goes)
        goes = select(self.near[n] & holds, OPEN, goes)
        after = select(spent, select(holds, -1.0, 0.0), way)
        # after an impact, and after a decision
        decided = self.decides & self.some & (code > 2.5)
        shut = select(decided, self.struck.shut[r], select(again[n] & holds, DECIDES, code))
        slide = select(decided, self.struck.slide[r], way)
        jumped = self.hits & self.agreed
        shut = select(jumped, select(rate > 0.0, OPEN, select(rate < 0.0, SHUT, DECIDES)), shut)
        slide = select(jumped, select(rate < 0.0, -1.0, 0.0), slide)
        return select(still, shut, goes), select(still, slide, after)

    def _fastest(self) -> Operand:
        """The largest speed with which a rigid contact closes before a trip."""
        fastest: Operand = 0.0
        for n in self.meets.rigid:
            fastest = largest(fastest, -self.touch.rate[n])
        return fastest

    def _rubbing(
        self, n: int, still: Flag, settles: Operand, strikes: Flag, lets_go: Flag, unsettled: Flag
    ) -> tuple[Operand, Operand]:  # fmt: skip
        """What a joint that rubs is after a trip, and the sense of its slip.

        settles: that to which its forces lead; strikes, lets_go: a contact does; unsettled: some joint is to change.
        """
        k, mode, code = self.meets.held.index(n), self.touch.speed[n], self.touch.shut[n]
        spent = self.met.spent[k] > 0.0
        way = select(spent, ended(mode, self._joint(n)), mode)
        if self.meets.rigid:
            way, spent = self._beside(n, way, strikes, lets_go), spent | lets_go
            settles = self._tried_beside(n, settles, unsettled)
        changes = apply("not", apply("equal", settles, mode))
        return select(still, select(changes, DECIDES, SHUT), select(spent, DECIDES, code)), select(still, settles, way)

    def _beside(self, n: int, way: Operand, strikes: Flag, lets_go: Flag) -> Operand:
        """The mode at the end of a step beside rigid contacts: in an impact it goes on as it slips, or sticks.  One
        that a contact has held at rest sticks first once that lets go."""
        moved = sign(self.ends.held["slip"][self.meets.held.index(n)])
        rests = lets_go & apply("equal", moved, 0.0)
        if self.meets.clutches_hold:  # one that has just begun to slip goes on
            just = (self.instant.t - self.touch.lane["turned at"]) <= JUST * self.instant.t
            rests = rests & apply("not", just & apply("equal", self.met.spent[self.meets.held.index(n)], 0.0))
        return select(strikes | rests, moved, way)

    def _others_give_way(self, n: int) -> Flag:
        """Whether the mode of another joint than n ends, where clutches may hold what rests as long as others do."""
        if not self.meets.clutches_hold:
            return False
        ends = {k: self.met.spent[self.meets.held.index(k)] > 0.0 for k in self.meets.rubbing}
        return _any(flag for k, flag in ends.items() if k != n) & apply("not", ends[n])

    def _tried_beside(self, n: int, settles: Operand, unsettled: Flag) -> Operand:
        """The mode in a trip that takes no time beside rigid contacts.

        In an impact it changes until it agrees with the impulses; after it, it slips as it moves.  Where modes do not
        fit after some changes, or there is no solution, all combinations are tried.
        """
        joint, mode = n - self.meets.n, self.touch.speed[n]
        moved = sign(self.ends.held["slip"][self.meets.held.index(n)])
        long, some = self.touch.lane["tried"] >= MOST_CHANGES, self._some_mode(joint)
        other = select(apply("equal", moved, 0.0), some, moved)
        kept = select(self._comes_to_rest(n), 0.0, mode)
        settles = select(unsettled & long, other, settles)
        settles = select(self.decides, select(self.some, kept, other), settles)
        tried = select(long | apply("not", self.some), some, self.struck.rubs[joint])
        return select(self.hits, select(self.agreed, moved, tried), settles)

    def _comes_to_rest(self, n: int) -> Flag:
        """Whether a contact or joint slips until a trip that takes no time, as others come to rest that hold it, or a
        bounce is not followed."""
        k = self.meets.held.index(n)
        before, after = self.touch.held["slip"][k], self.ends.held["slip"][k]
        return apply("not", apply("equal", self.touch.speed[n] * before, 0.0)) & apply("equal", after, 0.0)

    def _some_mode(self, joint: int) -> Operand:
        """The mode of a joint that rubs in the next one of all combinations; that which it has if it is held."""
        digit = apply("floor", self.touch.lane["tried"] / 3.0**joint)
        digit = digit - 3.0 * apply("floor", digit / 3.0)
        free, own = self.struck.free[joint] > 0.0, self.touch.speed[self.meets.n + joint]
        return select(free, select(digit > 1.5, -1.0, digit), own)

    def _joint(self, n: int) -> Joint:
        """A joint that rubs at the end of a trip."""
        k = self.meets.held.index(n)
        end = {name: rows[k] for name, rows in self.ends.held.items()}
        return Joint(end["reserve"], end["faint"], end["slip"], end["tangent"], end["bend"], end["calm"])

    def _switching(self, n: int, still: Flag) -> tuple[Flag, Operand, Operand]:
        """Whether an expression switches, as its switching function comes to zero or has jumped beyond it, what it is
        after a trip, and its side.  Forces that hold contacts shut may jump with it."""
        k, side, code = self.meets.held.index(n), self.touch.speed[n], self.touch.shut[n]
        reserve, rate, slight = (self.ends.held[name][k] for name in ("reserve", "pressed", "faint"))
        jumped = reserve < -(slight + MISSED * self.late * abs(rate))
        jumped = jumped | (
            (reserve <= slight) & (rate * self.instant.planned < -slight - abs(reserve))
        )  # it leaves at once
        turns = select_flag(still, jumped, self.met.spent[k] > 0.0)
        return turns, select(still, select(jumped, DECIDES, SHUT), code), select(turns, -side, side)

    def _jolts(self, still: Flag) -> Flag:
        """Whether a driver or gravity jumps with an expression that switches now, which only single runs follow."""
        calm = dict(zip(self.meets.held, self.ends.held["calm"], strict=True))
        return _any(self._switching(n, still)[0] & (calm[n] > 0.5) for n in self.meets.switching)

    def _jumps_now(self, still: Flag) -> Flag:
        """Whether an expression switches now whose sides differ."""
        differs = dict(zip(self.meets.held, self.ends.held["bend"], strict=True))
        return _any(self._switching(n, still)[0] & (differs[n] > 0.5) for n in self.meets.switching)

    def _rests_on_jumps(self) -> Flag:
        """Whether an expression stays at its switch, where it has a value of its own, if that of both sides differ."""
        some: Flag = False
        for n in self.meets.switching:
            end = {name: rows[self.meets.held.index(n)] for name, rows in self.ends.held.items()}
            rests = (abs(end["reserve"]) <= end["faint"]) & apply("equal", end["pressed"], 0.0)
            some = some | (rests & (end["bend"] > 0.5))
        return some

    @staticmethod
    def _moved(good: Flag, new: Sequence[Operand], old: Sequence[Operand]) -> list[Operand]:
        return [select(good, a, b) for a, b in zip(new, old, strict=True)]


def _any(flags: Iterable[Flag]) -> Flag:
    result: Flag = False
    for flag in flags:
        result = result | flag
    return result
