"""The published problems of `cam bench validation`: what each source prints, and our number.

A problem is a scene of configs/validation and a function that asks the analyses about it, through
the same functions as any user, and yields a `Claim` for every number that the source prints. Its
printed digits stand beside the question, so that both are read together. Numbers with a tail of 20
digits or more are independent values: tests/published/test_validation.py computes each of them
anew with mpmath and code of its own.

Signs: `u_minus_m_per_s` of an impact is q' - c', the velocity at which the gap closes. An
oscillator's is x' = -u.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from math import cos, pi, radians, sin
from pathlib import Path
from time import perf_counter
from typing import Any

from camcli.analysis.bench.validation import FORMULA, Claim, ValidationRow, row_of
from camcli.scene import Scene, load_scene
from camcli.scene.load import default_scene_path

RPM = 30.0 / pi  # of 1 rad/s
# Our own relative error of a solved orbit or of an impact after a few flights: some 50 roundings.
# The tests hold every number here to its independent value by this.
SOLVED = 1e-14
TRACE = 1e-10  # of a trace at a corner: the speed's error of 7e-11 rpm, a slope below 1 per rpm

Overrides = dict[str, Any]


@dataclass(frozen=True)
class Problem:
    """A published problem.

    scene: name of its file in configs/validation; source: author, journal, year; claims: yields its
    numbers, given the problem; quick: part of the subset of --quick.
    """

    scene: str
    source: str
    claims: Callable[[Problem], Iterator[Claim]]
    quick: bool

    def loaded(self, overrides: Overrides | None = None) -> Scene:
        """Its scene, with some keys changed."""
        return load_scene(folder() / f"{self.scene}.yaml", overrides or {})


PROBLEMS: dict[str, Problem] = {}


def problem(scene: str, source: str, quick: bool = True) -> Callable:
    """Enter the function of a problem."""

    def enter(claims: Callable[[Problem], Iterator[Claim]]) -> Callable:
        PROBLEMS[scene] = Problem(scene, source, claims, quick)
        return claims

    return enter


def folder() -> Path:
    """Where the scenes are: configs/validation of the package (wheel) or beside it (checkout)."""
    return default_scene_path().parent / "validation"


def chosen(quick: bool) -> list[Problem]:
    """The problems of a run: all, or those of the quick subset."""
    return [problem for problem in PROBLEMS.values() if problem.quick or not quick]


def measure(problem: Problem) -> list[ValidationRow]:
    """The rows of a problem; the seconds of a row are those that its number took."""
    rows = []
    began = perf_counter()
    for claim in problem.claims(problem):
        now = perf_counter()
        rows.append(row_of(claim, problem.source, problem.scene, now - began))
        began = now
    return rows


# --- questions


def rows_of(table: Any) -> list[dict[str, Any]]:
    """The rows of a table, by column."""
    return [dict(zip(table, row, strict=True)) for row in zip(*table.values(), strict=True)]


def found_orbits(scene: Scene, label: str | None = None) -> list[dict[str, Any]]:
    """The orbits that `cam orbits` finds at one speed, of this label: rows of branch.csv."""
    from camcli.api.orbits import orbits

    return [row for row in rows_of(orbits(scene).tables["branch"]) if label in (None, row["label"])]


def bifurcations(scene: Scene) -> list[dict[str, Any]]:
    """The events of the branches that `cam orbits` follows, a row each."""
    from camcli.api.orbits import orbits

    return rows_of(orbits(scene).tables["bifurcations"])


def event(rows: list[dict[str, Any]], kind: str, label: str, corner: str = "") -> dict[str, Any]:
    """The event of this kind, orbit and corner; branches that meet there each tell it."""
    return next(
        row for row in rows if (row["kind"], row["label"], row["corner"]) == (kind, label, corner)
    )


def steady(cam: Any, theta: float) -> tuple[float, float]:
    """(p, p') of the oscillator's motion without its stop, at this phase of the force."""
    spring = cam.stiffness - cam.mass * cam.frequency**2
    damper = cam.follower_damping * cam.frequency
    share = cam.amplitude / (spring**2 + damper**2)
    along, across = spring * share, damper * share
    return (
        along * cos(theta) + across * sin(theta),
        cam.frequency * (across * cos(theta) - along * sin(theta)),
    )


def threshold(holds: Callable[[float], bool], low: float, high: float) -> tuple[float, float]:
    """(middle, half width) of the narrowest bracket about the value from which on `holds` is true.

    holds: false at low, true at high.
    """
    assert not holds(low)
    assert holds(high)
    while low < (middle := 0.5 * (low + high)) < high and high - low > 1e-14 * abs(middle):
        low, high = (low, middle) if holds(middle) else (middle, high)
    return 0.5 * (low + high), 0.5 * (high - low)


# --- problems


@problem(
    "impact-oscillator",
    "COCO, example impact of its po toolbox; Dankowicz and Schilder: Recipes for Continuation, "
    "SIAM 2013, example 15.2",
)
def _coco(problem: Problem) -> Iterator[Claim]:
    """The orbit that COCO starts from, and where its family grazes."""
    scene = problem.loaded({"run.strobe_deg": 180})
    (orbit,) = found_orbits(scene, "P(1;1)")
    speed = -orbit["u_minus_m_per_s_1"]
    yield Claim(
        "velocity before the impact",
        "example impact, as quoted in our guide since 0.3",
        "1.69573293759488",
        speed,
        SOLVED * speed,
        "1.695732937594882009658779747363702559575",
    )
    after = -scene.follower.restitution * speed
    demo = "po/examples/impact/demo.m, start of the second segment"
    yield Claim("velocity after the impact", demo, "-1.36", after, SOLVED)
    phase = radians(orbit["theta_deg_1"])
    yield Claim("phase of the impact, rad", demo, "0.076", phase, SOLVED)
    p, p_dot = steady(scene.cam, pi)
    start = "po/examples/impact/demo.m, start of the first segment"
    yield Claim("x at phase -pi", start, "-0.98", p - orbit["q_m"], 1e-13)
    yield Claim("x' at phase -pi", start, "-0.29", p_dot - orbit["v_m_per_s"], 1e-13)
    grazes, error = threshold(partial(_impacts, problem), 0.09, 0.11)
    yield Claim(
        "amplitude of the force at which the orbit grazes",
        "Recipes for Continuation, figures 15.4 and 15.6: d c w at w^2 = k",
        "0.1000000000000000",
        grazes,
        error + SOLVED,
        kind=FORMULA,
    )


def _impacts(problem: Problem, amplitude: float) -> bool:
    """Whether the motion without impacts is not possible at this amplitude of the force."""
    scene = problem.loaded({"cam.amplitude": amplitude, "orbits.label": "P(1;0)"})
    return not found_orbits(scene, "P(1;0)")


@problem(
    "bouncing-ball",
    "Holmes, J. Sound Vib. 84 (1982) 173; Everson, Physica D 19 (1986) 355; Luck and Mehta, "
    "Phys. Rev. E 48 (1993) 3988",
)
def _ball(problem: Problem) -> Iterator[Claim]:
    """Fold, period doubling and sticking of the ball on a table, in Gamma = a omega^2/g."""
    from camcli.api.detach import detach

    rests = detach(problem.loaded()).tables["detach"]
    omega = rests["rpm"][0] / RPM
    width = (rests["rpm_high"][0] - rests["rpm_low"][0]) / RPM
    yield Claim(
        "Gamma up to which a resting ball stays on the table",
        "a omega^2 = g",
        "1.0000000000000000",
        omega * omega,
        2.0 * width + SOLVED,
        kind=FORMULA,
    )
    formula = {
        1: ("1.0471975511965977462", "1.5268237005190608643"),
        2: ("2.0943951023931954923", "2.3708772102669449996"),
    }
    for turns, (fold, doubling) in formula.items():
        label = f"P({turns};{':'.join(['1', *'0' * (turns - 1)])})"
        low, high = (0.98 * float(fold)) ** 0.5 * RPM, (1.02 * float(doubling)) ** 0.5 * RPM
        keys = {"start": low, "stop": high, "num": 40}
        at = (0.5 * (float(fold) + float(doubling))) ** 0.5 * RPM
        overrides = {"orbits.rpm": keys, "orbits.at": at, "orbits.label": label}
        rows = bifurcations(problem.loaded({**overrides, "orbits.branches": 0}))
        for kind, printed, place in (
            ("fold", fold, "pi n (1 - r)/(1 + r)"),
            ("period-doubling", doubling, "sqrt((pi n (1-r)/(1+r))^2 + (2 (1+r^2)/(1+r)^2)^2)"),
        ):
            row = event(rows, kind, label)
            omega, error = row["rpm"] / RPM, row["rpm_error"] / RPM
            yield Claim(
                f"Gamma of the {kind.replace('-', ' ')} of one impact in {turns} "
                f"{'turn' if turns == 1 else 'turns'}, r = 0.5",
                place,
                printed,
                omega * omega,
                2.0 * omega * error + SOLVED,
                kind=FORMULA,
            )


@problem(
    "cam-follower",
    "Osorio, di Bernardo, Santini, SIAM J. Appl. Dyn. Syst. 7 (2008) 18, and chapter 3 of Osorio's "
    "thesis",
)
def _cam_follower(problem: Problem) -> Iterator[Claim]:
    """Detachment, chatter and border collisions of the cam-follower example."""
    from camcli.api.detach import detach

    tables = detach(problem.loaded()).tables
    speeds = tables["detach"]
    for name, what, region, printed, independent in (
        ("first_detachment", "first loss of contact", "A2", "114.979", "114.97932674399878183"),
        ("fills", "contact is lost all over A2", "A2", "134.873", "134.87296805791602062"),
        ("accumulation_at_corner", "chatter accumulates at c", "c", "119.72",
         "119.71248103959564120"),
        ("accumulation_at_corner", "chatter accumulates at d", "d", "136.38",
         "136.31237239287048200"),
        ("completion_loss", "chatter is complete no longer", "A2", "198.56",
         "198.56051143179207228"),
    ):  # fmt: skip
        (k,) = ((speeds["quantity"] == name) & (speeds["region"] == region)).nonzero()[0]
        low, high = speeds["rpm_low"][k], speeds["rpm_high"][k]
        value = speeds["rpm"][k]
        yield Claim(
            f"{what}, rpm", "chapter 3", printed, value, max(high - value, value - low),
            independent,
        )  # fmt: skip
    hits = tables["corner_hits"]
    for impact, printed, independent in (
        (1, "124.998", "124.99829682080343025"),
        (2, "122.699", "122.69931764156417777"),
        (3, "121.686", "121.68587192213975812"),
        (4, "121.107", "121.10698078783266001"),
        (5, "120.7356", "120.73557717781909648"),
        (6, "120.481", "120.48104105598573014"),
    ):
        (k,) = ((hits["impact"] == impact) & (hits["corner"] == "c")).nonzero()[0]
        value = hits["rpm"][k]
        yield Claim(
            f"impact {impact} after lift-off lands on c, rpm", "chapter 3", printed, value,
            1e-11 * value, independent,
        )  # fmt: skip
    rows = bifurcations(problem.loaded())
    corner = event(rows, "corner-impact", "P(1;1)", "b")
    second = event(rows, "corner-impact", "P(2;1:1)", "c")
    doubling = event(rows, "period-doubling", "P(1;1)")
    rpm = (
        ("corner impact of P(1;1) at b", "673.234445", corner, "673.23444500381198097"),
        ("period doubling of P(1;1)", "739.3197803", doubling, "739.31978021600165476"),
        ("corner impact of P(2;1:1) at c", "739.37793", second, "739.37792964927699092"),
    )
    for what, printed, row, independent in rpm:
        yield Claim(f"{what}, rpm", "chapter 3", printed, row["rpm"], row["rpm_error"], independent)
    traces = (
        ("P(1;1), trace on the side of A1", "1.6419", corner["trace_left"],
         "1.6418699364295558139"),
        ("P(1;1), trace on the side of A2", "1.37142", corner["trace_right"],
         "1.3714214414408132759"),
        ("P(2;1:1), trace before", "1.381624791", second["trace_left"], "1.3816245752401572435"),
        ("P(2;1:1), trace behind", "-3.80875", second["trace_right"], "-4.0910731023130986684"),
    )  # fmt: skip
    for what, printed, value, independent in traces:
        yield Claim(f"corner impact of {what}", "chapter 3", printed, value, TRACE, independent)
