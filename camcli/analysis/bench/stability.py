"""The table of extreme cases: `cam bench stability`, and the tests of the same rows.

A row is a case, what is expected, and a check that returns what was observed, or raises
MismatchError with what was seen instead.
"""

import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from itertools import pairwise
from math import nextafter, pi, radians, sqrt
from tempfile import TemporaryDirectory
from time import perf_counter

from camcli.analysis.bench.machine import Machines, events, orbit, phases, reference, run
from camcli.analysis.bench.precision import FAILED, OK, case, compare, run_core
from camcli.analysis.integrate import Record
from camcli.analysis.labels import label
from camcli.errors import Status, plural
from camcli.system import System

COMMAND_TIME = 60.0  # s, beyond which a command is stopped
Check = Callable[[Machines], str]  # returns what was observed
# rpm of the example (Osorio, di Bernardo and Santini, 2008)
CHATTERING = 190.0  # a complete chatter in every turn
DETACHING = 114.979326744  # the first loss of contact, at the corner b
COMPLETING = 198.5605  # from here on chatter is incomplete


class MismatchError(Exception):
    """What was seen is not what is expected."""


@dataclass(frozen=True)
class Row:
    """One extreme case."""

    case: str
    expected: str
    check: Check


@dataclass(frozen=True)
class RowOutcome:
    """A row of stability.csv."""

    case: str
    expected: str
    observed: str
    status: str
    seconds: float


ROWS: dict[int, Row] = {}


def row(number: int, what: str, expected: str) -> Callable[[Check], Check]:
    """A decorator that enters a check into the table ROWS, by number.

    what: its case, in words; expected: what it should observe, in words.
    """

    def enter(check: Check) -> Check:
        ROWS[number] = Row(f"{number}: {what}", expected, check)
        return check

    return enter


def measure(row: Row, machines: Machines) -> RowOutcome:
    """Run a row; whatever it raises is an outcome too."""
    began = perf_counter()
    try:
        observed = row.check(machines)
        status = OK
    except MismatchError as mismatch:
        observed = str(mismatch)
        status = FAILED
    except Exception as error:
        observed = f"{type(error).__name__}: {error}"
        status = FAILED
    return RowOutcome(
        case=row.case,
        expected=row.expected,
        observed=observed,
        status=status,
        seconds=perf_counter() - began,
    )


def need(holds: bool, seen: str) -> None:
    """Raise MismatchError with what was seen unless it is as expected.

    holds: whether it is; seen: what `observed` shall say.
    """
    if not holds:
        raise MismatchError(seen)


def fine(record: Record, where: str = "the run") -> Record:
    """The record, which must have ended well."""
    need(record.status == Status.OK, f"{where}: {record.status.text}")
    return record


def kinds(record: Record) -> list[str]:
    """Kinds of the logged events, in order."""
    return [event.kind for event in events(record)]


def said(words: str, *texts: str, code: int = 0) -> str:
    """What `cam WORDS` printed; it must end with the code and its messages have these texts."""
    with TemporaryDirectory(prefix="cam-bench-") as folder:
        command = [sys.executable, "-m", "camcli", *words.split()]
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, timeout=COMMAND_TIME
        )
    messages = done.stderr.strip() or "nothing"
    need(done.returncode == code, f"exit {done.returncode}: {messages}")
    need(all(text in messages for text in texts), f"said: {messages}")
    return done.stdout


# --- restitution, no spring, no force


@row(1, "r = 0", "one impact then sticking if a < 0; no chatter test")
def _plastic(machines: Machines) -> str:
    """With r = 0 every landing ends in rest, so no chatter has to be recognised."""
    machine = machines.example(restitution=0.0)
    record = run(machine, CHATTERING, record=4)
    need(kinds(record)[:3] == ["detachment", "impact", "detachment"], f"events {kinds(record)[:3]}")
    impacts = [int(count) for count in record.impacts]
    need(impacts == [2] * 4, f"impacts per turn {impacts}")
    need(not any(record.chatter), "a chatter was recorded")
    rows = events(fine(run(machine, 700.0, record=20)))
    order = [(event.turn, event.theta) for event in rows]
    need(order == sorted(order), "events out of order at 700 rpm")
    return f"{label(record)}; {plural(len(order), 'event')} in order at 700 rpm; no chatter"


@row(2, "r = 1", "runs; warning")
def _elastic(machines: Machines) -> str:
    """Bounces on the dwell keep their speed; the command says that nothing ever comes to rest."""
    bouncing = machines.example(restitution=1.0, stiffness=0.0, gravity=9.81)
    rows = events(run(bouncing, 0.05, record=1, q=0.11, v=0.0))
    dwell = 1.5  # rad: up to here the cam does not move
    speeds = [event.u for event in rows if event.kind == "impact" and event.theta < dwell]
    drift = max(abs(u / speeds[0] - 1.0) for u in speeds)
    need(
        len(speeds) > 1000 and drift < 1e-11, f"{plural(len(speeds), 'bounce')}; drift {drift:.1e}"
    )
    record = fine(run(machines.example(restitution=1.0), 130.0, record=1))
    need("chatter" not in kinds(record), "a chatter at 130 rpm")
    said(
        "simulate --no-plot --rpm 190 --set follower.restitution=1 --set run.transient=0"
        " --set run.record=1",
        "warning: restitution 1",
    )
    return f"{plural(len(speeds), 'bounce')}; speeds equal to {drift:.1e}; warning said"


@row(3, "r = 0.999999", "impact budget with status or chatter map in tolerance")
def _nearly_elastic(machines: Machines) -> str:
    """A chatter of more than a million impacts ends with its map, or with the budget of impacts."""
    system = machines.example(restitution=0.999999, gravity=9.81)
    record = run(system, 2.0, record=2, budget=5000, q=0.1001, v=0.0)
    seen = f"{record.status.text} after {plural(record.cost.impacts, 'impact')}"
    ended = record.status == Status.IMPACT_BUDGET and record.cost.impacts == 5000
    need(ended or (record.status == Status.OK and any(record.chatter)), seen)
    return seen


@row(5, "b critical +- 1 ulp and +- 1e-12", "continuous; same digits on both sides")
def _critical(machines: Machines) -> str:
    """Three formulas of the flight meet at critical damping: none of them jumps there."""
    critical = 2.0 * sqrt(1430.8 * 1.221)  # N s/m, 83.594...
    dampings = [
        critical,
        nextafter(critical, 99.0),
        nextafter(critical, 0.0),
        critical * (1.0 + 1e-12),
        critical * (1.0 - 1e-12),
    ]
    worst = 0.0
    for rpm in (190.0, 300.0, 700.0):
        runs = [events(run(machines.example(damping=damping), rpm)) for damping in dampings]
        at_critical, *others = runs
        for other in others:
            same = [(e.kind, e.turn) for e in other] == [(e.kind, e.turn) for e in at_critical]
            need(same, f"other events at {rpm} rpm")
            for event, exact in zip(other[:10], at_critical[:10], strict=True):
                worst = max(worst, abs(event.theta - exact.theta))
    need(worst < 1e-9, f"phases {worst:.1e} rad apart")  # a relative 1e-12 of b, 10 impacts long
    return f"phases within {worst:.1e} rad on both sides"


# --- heavy damping

# How exact heights can be where a damper hardly lets the follower move; derived, not fitted:
# Heights are below 0.5 m, so one rounding is at most h = HALF_ULP, and c comes within 1.5 ulp of
# the cam: 4 h with the rounding of q itself. A step of a flight rounds the height at most twice,
# q = c + gap and q + (w B - F P). Roundings of a flight add up, since the equation is linear and
# its response to a disturbance of the height is at most 1 and with such dampers nearly 1; nothing
# is carried through a contact. Independent roundings of N steps, uniform within h, have a standard
# deviation of h sqrt(2 N/3), and SIGMAS of these is the limit. Evaluations of the gap stand for N:
# a step takes at least one. So the limit depends on the steps, not on the error that is seen.
HALF_ULP = 2.0**-55  # m, of heights from 0.25 to 0.5 m
SIGMAS = 6.0
SAME_DEPARTURE = 2e-15  # rad, 4 roundings of an angle below 4 rad


@row(6, "b > 6.6e3 at 115 rpm; > 4e4 at 700 rpm", "the oracle's stored value")
def _heavy(machines: Machines) -> str:
    """A follower that its damper hardly lets move."""
    return heights(machines, "6.7e3 at 115", "4.1e4 at 700")


@row(7, "b = 1e9 and 1e12", "against the oracle within the rounding of its steps")
def _heaviest(machines: Machines) -> str:
    """A follower that its damper does not let move in a turn."""
    return heights(machines, "1e9 at 115", "1e12 at 115")


def heights(machines: Machines, *names: str) -> str:
    """The last height, departures and landings of runs against those stored of the oracle.

    A landing is compared in height: its difference of phase times the rate of the gap there. Words
    on how near the heights come to the limit above are returned.
    """
    seen = []
    share = 0.0
    for name in names:
        stored = reference("stability")["heavy"][name]
        system = machines.example(damping=stored["damping"])
        ours = orbit(system, stored["rpm"], stored["turns"], tolerance=1e-13)
        record = fine(ours.run(), f"b = {stored['damping']:g}")
        q, _ = ours.position()
        height = abs(float(Decimal(q) - Decimal(stored["q"])))
        height = max(height, _height_of_landings(name, record, stored["events"]))
        steps = record.cost.evaluations
        share = max(share, height / (HALF_ULP * (4.0 + SIGMAS * sqrt(2.0 * steps / 3.0))))
        seen.append(f"{height:.1e} m in {steps} steps")
    words = f"{share:.2f} of the limit at most: {'; '.join(seen)}"
    need(share <= 1.0, words)
    return words


def _height_of_landings(name: str, record: Record, wanted: list) -> float:
    """How far the landings after departures are off those stored, m, as heights; the largest.

    wanted: (kind, turn, phase in rad as text) of every departure and of the landing that follows
    it. Raises MismatchError where there are others, or where a departure is off.
    """
    rows = events(record)
    compared = []  # departures, and the landing that follows each
    kind_before = ""
    for event in rows:
        if "detachment" in (event.kind, kind_before):
            compared.append(event)
        kind_before = event.kind
    same = [[event.kind, event.turn] for event in compared] == [event[:2] for event in wanted]
    need(same, plural(len(compared), "event"))
    height = 0.0
    for event, (_, _, exact) in zip(compared, wanted, strict=True):
        off = abs(float(Decimal(event.theta) - Decimal(exact)))
        if event.kind == "impact":
            height = max(height, off * abs(event.u))
        else:
            need(off < SAME_DEPARTURE, f"{name} rpm: departures {off:.1e} rad off")
    return height


# --- no spring, no force


@row(8, "k = 0; ball dropped from 1 m", "rests at 4.06371277 s")
def _dropped_ball(machines: Machines) -> str:
    """A ball on the dwell rests where the geometric series of its hops ends, at any tolerance.

    That is after sqrt(2 h/g) (1 + r)/(1 - r) seconds.
    """
    g, h, r = 9.81, 1.0, 0.8
    omega = pi / 30.0  # rad/s, at 1 rpm
    system = machines.example(stiffness=0.0, gravity=g, restitution=r)
    c, _ = orbit(system, 1.0).position()
    exact = sqrt(2.0 * h / g) * (1.0 + r) / (1.0 - r)
    worst = 0.0
    rest = 0.0
    for tolerance in (1e-3, 1e-9, 1e-15, 1e-18):
        record = run(system, 1.0, record=1, tolerance=tolerance, q=c + h, v=0.0)
        theta, *_ = phases(record, "chatter")
        rest = theta / omega
        worst = max(worst, abs(rest / exact - 1.0))
        need(kinds(record).count("impact") == 1, "a hop was followed that the map gives exactly")
    need(abs(rest - 4.06371277) < 5e-9 and worst < 1e-13, f"rests at {rest!r} s")
    return f"rests at {rest:.10f} s; relative error {worst:.1e}"


@row(9, "k = b = g = preload = 0", "separating follower: no-return")
def _flown_off(machines: Machines) -> str:
    """Where nothing pulls back the follower does not return, and the status says so."""
    free, damped = (machines.example(stiffness=0.0, damping=b) for b in (0.0, 5.0))
    for system in (free, damped):
        record = run(system, 500.0, record=50, q=0.5, v=30.0)
        seen = f"{record.status.text}; {plural(len(kinds(record)), 'event')}"
        need(record.status == Status.NO_RETURN and not kinds(record), seen)
    thrown = run(free, 500.0, record=50)
    need(thrown.status == Status.NO_RETURN, f"from rest: {thrown.status.text}")
    return "no-return; no event invented"


@row(24, "cam below zero; no spring needed", "said in words")
def _no_spring_needed(machines: Machines) -> str:
    """What `cam detach` says of springs where a spring pulls away, and where none is needed.

    Where k c <= 0 a spring pulls away, so only a preload helps. A weight that presses harder than
    the cam falls away needs no spring.
    """
    command = "detach --no-plot --json --points 2 --set cam.offset=0.7"
    pulling = json.loads(said(f"{command} --rpm 110:120 --hold-to 120"))["result"]
    sentences = "; ".join(pulling["words"])
    need("not held even at standstill" in sentences, f"said: {sentences}")
    stiffness, preload, _both = pulling["hold"]  # in the order of `CriticalQuantity`
    answer = stiffness["words"]
    need("a spring does not press" in answer, f"of stiffness: {answer}")
    need(preload["status"] == "ok" and preload["preload"] > 0.0, f"preload {preload['status']}")
    weight = "--set follower.gravity=1000 --set follower.stiffness=0"
    springs = json.loads(said(f"{command} --rpm 20:30 --hold-to 30 {weight}"))["result"]["hold"]
    needless = all(spring["status"] == "not-needed" for spring in springs)
    last = springs[-1]["words"]
    need(needless and last == "no spring is needed", f"with a weight: {last}")
    return f"'not held even at standstill'; 'a spring does not press'; '{last}'"


@row(25, "chatter at 1e-300 m/s", "signs compared; not products")
def _tiny_restitution(machines: Machines) -> str:
    """Velocities whose products are no doubles any more: the motion is that of r = 0."""
    zero = phases(run(machines.example(restitution=0.0), CHATTERING))
    for r in (1e-200, 1e-300, 5e-324):
        record = fine(run(machines.example(restitution=r), CHATTERING), f"r = {r}")
        need(phases(record) == zero, f"r = {r}: {plural(len(phases(record)), 'impact')}")
    # With a tolerance of 0 no chatter is closed by its series: every impact is followed, down to
    # velocities whose square is below the smallest double.
    rows = events(run(machines.example(), 130.0, record=1, tolerance=0.0))
    slow = [e.u for e in rows if e.kind == "impact" and abs(e.u) < 1e-50]
    need(bool(slow) and max(slow) < 0.0, f"{plural(len(slow), 'impact')} below 1e-50 m/rad")
    return f"as r = 0; {plural(len(slow), 'impact')} down to {-max(slow):.0e} m/rad; all with u < 0"


# --- powers of two, a thousandth and a million turns per minute, a stiff spring


@row(10, "k 4^n; rpm and v 2^n; n = +-20", "bit-identical phases")
def _faster(machines: Machines) -> str:
    """Time measured in other units, by powers of two: every phase keeps its bits."""
    compared = 0
    for b in (0.0, 20.0):
        machine = machines.example(damping=b, gravity=1.0)
        plain = run(machine, 358.5, record=40, q=0.3, v=2.0)
        for n in (-20, 20):
            f = 2.0**n
            machine = machines.example(stiffness=1430.8 * f * f, damping=b * f, gravity=f * f)
            scaled = run(machine, 358.5 * f, record=40, q=0.3, v=2.0 * f)
            need(list(plain.theta) == list(scaled.theta), f"other phases with n = {n}")
            need(list(plain.strobe_w) == list(scaled.strobe_w), f"other states with n = {n}")
            compared += len(scaled.theta)
    return f"{compared} phases identical"


@row(11, "m; k; b times 2^n", "bit-identical phases")
def _heavier(machines: Machines) -> str:
    """Mass and forces measured in other units, by powers of two: every phase keeps its bits."""
    base = {"mass": 1.221, "stiffness": 1430.8, "damping": 3.0, "preload": 5.0}
    plain = list(run(machines.example(**base), 700.0, record=60).theta)
    for n in (-40, -1, 7, 40):
        scaled = machines.example(**{key: value * 2.0**n for key, value in base.items()})
        need(plain == list(run(scaled, 700.0, record=60).theta), f"other phases with n = {n}")
    return f"{4 * len(plain)} phases identical"


@row(12, "1e-3 rpm; many turns", "sticks throughout; phases exact after many turns")
def _slow(machines: Machines) -> str:
    """Far below any loss of contact the follower sticks, and phases do not drift with the turns."""
    machine = machines.example()
    record = fine(run(machine, 1e-3, record=2000))
    need(label(record) == "contact", label(record))
    early, late = (run(machine, 150.0, record=1, transient=n) for n in (10, 2000))
    need(phases(early) == phases(late), "phases drift with the turns")
    return f"contact for {record.periods} turns; phases of turn 2000 those of turn 10"


@row(13, "1e6 rpm", "bounded cost; warning")
def _fast(machines: Machines) -> str:
    """A follower thrown far above the cam costs little, and the command warns."""
    cost = fine(run(machines.example(), 1e6, record=20_000)).cost
    seen = (
        f"{plural(cost.impacts, 'impact')}; {plural(cost.evaluations, 'evaluation')}; "
        f"{plural(cost.crossings, 'crossing')}"
    )
    few = 5 < cost.impacts < 100 and cost.evaluations < 20 * cost.impacts
    need(few and cost.crossings < 40_000, seen)
    short = "--no-plot --set simulate.samples=1 --set run.transient=0 --set run.record=20"
    said(f"simulate --rpm 1e6 {short}", "throws the follower")
    return f"{seen} in 20000 turns; warning said"


@row(14, "k = 1e8 N/m at 50000 rpm", "as exact as the example's machine")
def _stiff(machines: Machines) -> str:
    """A valve spring at the speed of a racing engine, against the stored reference."""
    stored = case("stiff")
    tolerance = 1e-13
    trace = run_core(machines.system(stored.follower, stored.cam), stored, tolerance)
    comparison = compare(stored, trace, tolerance)
    seen = (
        f"{plural(len(trace.hits), 'impact')}; {comparison.missed} missed; "
        f"error {comparison.error:.1e} turns"
    )
    need(comparison.missed == comparison.extra == 0 and comparison.excess <= 1.0, seen)
    return f"{seen}; {comparison.excess:.2f} of the bound at most"


# --- critical speeds, corners and the strobe


ON_A_CORNER = 1e-12  # rad: an event so near to a corner is on it
HOPS_UNTIL = 3.2  # rad, on the top dwell behind c: hops are counted up to here


def corner(machine: System, number: int) -> float:
    """Phase (rad) of a corner; number: 0 for a, 1 for b, and so on."""
    return machine.corners[number]


def neighbours(x: float, count: int) -> list[float]:
    """A number, and so many doubles on either side."""
    doubles = [x]
    for _ in range(count):
        doubles = [nextafter(doubles[0], 0.0), *doubles, nextafter(doubles[-1], 1e9)]
    return doubles


@row(15, "114.979326744 rpm +- 1e-5", "no impact below; detachment at b above")
def _first_detachment(machines: Machines) -> str:
    """On either side of the first loss of contact: at rest, and thrown off at the corner b."""
    machine = machines.example()
    below, above = (events(run(machine, DETACHING + d, record=3)) for d in (-1e-5, 1e-5))
    need(not below, f"{plural(len(below), 'event')} below")
    first = above[0]
    off = abs(first.theta - corner(machine, 1))
    at_b = first.kind == "detachment" and first.turn == 0 and off < 1e-15
    need(at_b, f"{first} above")
    return "no event below; detachment at b above"


@row(16, "114.98 rpm", "impacts of about 1e-7 m/s resolved")
def _weak_impacts(machines: Machines) -> str:
    """Just above the first loss of contact: impacts as in the reference, each weaker.

    The reference holds (phase, velocity in m/s) of each, as text.
    """
    stored = reference("stability")["weak"]
    omega = stored["rpm"] * pi / 30.0
    wanted = [float(velocity) for _, velocity in stored["impacts"]]
    rows = events(run(machines.example(), stored["rpm"], record=1))
    velocities = [e.u * omega for e in rows if e.kind == "impact" and e.theta < pi]
    need(len(velocities) >= len(wanted), plural(len(velocities), "impact"))
    weaker = all(after > before for before, after in pairwise(velocities))  # all are below zero
    need(weaker, "a hop gains speed")
    pairs = zip(velocities, wanted, strict=False)
    off = max(abs(velocity / exact - 1.0) for velocity, exact in pairs)
    need(off < 1e-9, f"speeds off by {off:.1e}")  # relative, of speeds of 1e-9 m/s
    count = plural(len(velocities), "impact")
    return f"{count} from {-velocities[0]:.2e} m/s down; speeds right to {off:.1e}"


@row(21, "impact exactly on a corner", "once")
def _on_a_corner(machines: Machines) -> str:
    """At the speed, to the last bit, at which the first impact meets a corner: one impact there."""
    machine = machines.example()
    low = 124.99  # rpm; between it and `high` the first impact is on corner c
    high = 125.01
    c = corner(machine, 2)
    while nextafter(low, high) < high:
        middle = 0.5 * (low + high)
        first, *_ = phases(run(machine, middle, record=1))
        if first < c:
            low = middle
        else:
            high = middle
    speeds = neighbours(low, 6)
    for rpm in speeds:
        rows = events(run(machine, rpm, record=1, tolerance=1e-16))
        at_corner = [e.kind for e in rows if abs(e.theta - c) < ON_A_CORNER]
        hops = [e for e in rows if e.kind == "impact" and c + ON_A_CORNER < e.theta < HOPS_UNTIL]
        once = at_corner == ["impact"] and len(hops) > 2
        need(once, f"{at_corner} and {plural(len(hops), 'hop')} at {rpm!r} rpm")
    return f"one impact on c at {len(speeds)} speeds around {low:.9f} rpm; its hops follow"


@row(22, "event exactly at the strobe", "counted in exactly one period")
def _on_the_strobe(machines: Machines) -> str:
    """An impact at the strobe, or a few doubles beside it, belongs to one turn and not to two."""
    example = machines.example()
    impact, *_ = phases(run(example, 700.0, record=1, transient=2000))
    strobes = neighbours(impact, 8)
    for strobe in strobes:
        record = fine(run(machines.example(strobe), 700.0, record=50, transient=2000))
        total = int(sum(record.impacts))
        logged = len(phases(record))
        need(total == logged and 49 <= total <= 51, f"{total} counted; {logged} logged")
    first, *_ = events(run(example, CHATTERING, record=1, v=-3.0))
    at_start = first[:3] == ("impact", 0, 0.0)  # kind, turn, theta
    need(at_start, f"first event {first[:3]}")
    return f"counted once for {len(strobes)} strobes within 8 ulp; a start on it too"


@row(23, "198.5605 +- 0.01 rpm", "complete to incomplete chatter once")
def _completion(machines: Machines) -> str:
    """Where complete chatter becomes incomplete, 0.01 rpm to either side in steps of 0.001."""
    machine = machines.example()
    speeds = [COMPLETING - 0.01 + 0.001 * k for k in range(21)]
    complete = [bool(run(machine, rpm, record=2).chatter[1]) for rpm in speeds]
    once = complete == sorted(complete, reverse=True) and complete[0] and not complete[-1]
    need(once, f"complete: {complete}")
    last = speeds[sum(complete) - 1]
    return f"complete up to {last:.4f} rpm; incomplete from {last + 0.001:.4f} rpm"


# --- grazes and hostile starts


@row(17, "exact graze +- 1 ulp", "at most one contact of near-zero speed")
def _graze(machines: Machines) -> str:
    """Flights that touch the cam to the last bit: one contact there at most, and a slow one."""
    machine = machines.example()
    flights = reference("stability")["grazes"]
    rates: list[float] = []
    for flight in flights:
        start = {"q": flight["q"], "v": flight["v"], "theta": radians(flight["theta_deg"])}
        record = run(machine, flight["rpm"], record=1, tolerance=1e-16, budget=4, **start)
        hits = [e for e in events(record) if e.kind == "impact"]
        near = [abs(e.u) for e in hits if abs(e.theta - flight["at"]) < 1e-4]  # rad
        ended = record.status in (Status.OK, Status.IMPACT_BUDGET)
        need(len(near) <= 1 and ended, f"{plural(len(near), 'contact')}; {record.status.text}")
        rates += near
    fastest = max(rates, default=0.0)
    need(fastest < 1e-6, f"a contact with {fastest:.1e} m/rad")
    ending = f"; fastest {fastest:.1e} m/rad" if rates else ""
    return f"{plural(len(flights), 'graze')}; {plural(len(rates), 'contact')}{ending}"


@row(18, "start with q = c; u = 0", "leaves or sticks; no impact recorded")
def _at_rest(machines: Machines) -> str:
    """Starts at rest on the cam: pressed on they stick, pulled off they leave; no impact."""
    machine = machines.example()
    for degrees in (0.0, 100.0, 150.17, 170.0, 250.0):
        record = run(machine, 100.0, record=1, theta=radians(degrees))  # below DETACHING
        need(not events(record) and record.resting, f"does not stick at {degrees} deg")
    for degrees in (151.0, 155.0, 159.0):  # past the corner b, where the follower is pulled off
        first, *_ = events(run(machine, CHATTERING, record=1, theta=radians(degrees)), 1)
        is_impact = first.kind == "impact" and first.turn == 0
        later = first.theta > radians(degrees) + 0.01
        need(
            is_impact and later and first.u < 0.0,
            f"{first.kind} at {first.theta} rad from {degrees} deg",
        )
    damped = machines.example(damping=40.0)  # at rest where a sticking ends: a = 0, a' > 0
    stuck = run(damped, 160.0, record=1)
    leave, *_ = phases(stuck, "detachment")
    started = run(damped, 160.0, record=1, theta=leave)
    off = abs(phases(stuck)[0] - phases(started)[0])
    need(off < 1e-7, f"from zero force the first impact is {off:.1e} rad off")
    return f"5 starts stick; 3 leave; no impact recorded; zero force: as if stuck to {off:.0e} rad"


@row(19, "start with q = c; u < 0", "one impact at t = 0")
def _into_the_cam(machines: Machines) -> str:
    """Starts on the cam with a velocity into it: an impact at once, and the next event later."""
    for degrees in (0.0, 100.0, 155.0, 300.0):
        record = run(machines.example(), CHATTERING, record=1, theta=radians(degrees), v=-20.0)
        is_off_strobe = degrees != 0.0
        rows = events(record, 1 if is_off_strobe else 0)
        first, second, *_ = rows
        is_impact = first.kind == "impact" and first.turn == 0
        at_once = is_impact and first.theta == radians(degrees)
        later = (second.turn, second.theta) > (first.turn, first.theta)
        need(at_once and later, f"{rows[:2]} from {degrees} deg")
    return "one impact at t = 0 from each of 4 phases"


@row(20, "start below the cam", "exit 2 with the depth")
def _below_the_cam(machines: Machines) -> str:
    """One double below the cam is on it; half a decimetre below it the command refuses."""
    machine = machines.example()
    c = orbit(machine, CHATTERING).position()[0]
    for q in (nextafter(c, 0.0), nextafter(c, 1.0)):
        fine(run(machine, CHATTERING, record=1, q=q, v=0.0), f"{q - c:.1g} m off the cam")
    said("simulate --no-plot --rpm 190 --set run.start.q=0.05", "0.05 m below", code=2)
    return "exit 2; 'found q = 0.05 m; 0.05 m below the cam'; one ulp below is on it"


ROWS = dict(sorted(ROWS.items()))
