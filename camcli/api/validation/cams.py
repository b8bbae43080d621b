"""Published cams and followers."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import pi, sqrt

from camcli.analysis.bench.validation import COUNT, Claim
from camcli.analysis.labels import Label
from camcli.api.machine import machine_of
from camcli.api.validation.problem import Problem, bifurcations, event, register_in
from camcli.kernel.cam_table import lift_at, stretch_at
from camcli.output.tables import Table

LIFT = 1e-15  # m, of the lift, and per radian of its slope: some roundings of 0.25 m
# Half a unit of the last digit of nose_center, 5e-15 m, turns the flank by 3.3 rad/m times that.
# The circles of the source close no better; ours do.
CLOSED = 1.7e-14  # rad
TRACE = 1e-10  # of a trace at a corner: the speed's error of 7e-11 rpm, a slope below 1 per rpm

PROBLEMS: list[Problem] = []
registered = partial(register_in, PROBLEMS)


@registered(
    "cam-follower",
    "Osorio, di Bernardo, Santini, SIAM J. Appl. Dyn. Syst. 7 (2008) 18, and chapter 3 of Osorio's "
    "thesis",
)
def _cam_follower(problem: Problem) -> Iterator[Claim]:
    """Detachment, chatter, border collisions and attractors of the cam-follower example."""
    from camcli.api.detach import detach

    tables = detach(problem.loaded()).tables
    yield from _critical_speeds(tables["detach"])
    yield from _corner_hits(tables["corner_hits"])
    yield from _bifurcations(problem)
    yield from _attractors(problem)


def _critical_speeds(speeds: Table) -> Iterator[Claim]:
    """The speeds at which contact is lost and chatter changes, rows of detach.csv."""
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
        of_row = (speeds["quantity"] == name) & (speeds["region"] == region)
        (value,) = speeds["rpm"][of_row]
        (low,) = speeds["rpm_low"][of_row]
        (high,) = speeds["rpm_high"][of_row]
        yield Claim(
            f"{what}, rpm",
            "chapter 3",
            published=printed,
            ours=value,
            error=max(high - value, value - low),
            independent=independent,
        )


def _corner_hits(hits: Table) -> Iterator[Claim]:
    """The speeds at which impacts after lift-off land on the corner c, rows of corner_hits.csv."""
    for impact, printed, independent in (
        (1, "124.998", "124.99829682080343025"),
        (2, "122.699", "122.69931764156417777"),
        (3, "121.686", "121.68587192213975812"),
        (4, "121.107", "121.10698078783266001"),
        (5, "120.7356", "120.73557717781909648"),
        (6, "120.481", "120.48104105598573014"),
    ):
        (value,) = hits["rpm"][(hits["impact"] == impact) & (hits["corner"] == "c")]
        yield Claim(
            f"impact {impact} after lift-off lands on c, rpm",
            "chapter 3",
            published=printed,
            ours=value,
            error=1e-11 * value,
            independent=independent,
        )


def _bifurcations(problem: Problem) -> Iterator[Claim]:
    """The speeds of three bifurcations, and what the orbits on both sides of two of them do."""
    rows = bifurcations(problem.loaded())
    corner = event(rows, "corner-impact", "P(1;1)", "b")
    second = event(rows, "corner-impact", "P(2;1:1)", "c")
    doubling = event(rows, "period-doubling", "P(1;1)")
    for what, printed, row, independent in (
        ("corner impact of P(1;1) at b", "673.234445", corner, "673.23444500381198097"),
        ("period doubling of P(1;1)", "739.3197803", doubling, "739.31978021600165476"),
        ("corner impact of P(2;1:1) at c", "739.37793", second, "739.37792964927699092"),
    ):
        yield Claim(
            f"{what}, rpm",
            "chapter 3",
            published=printed,
            ours=row["rpm"],
            error=row["rpm_error"],
            independent=independent,
        )

    # the multipliers are the roots of z^2 - trace z + det: real on one side, complex on the other
    trace_a1 = corner["trace_left"]
    det_a1 = corner["det_left"]
    trace_a2 = corner["trace_right"]
    det_a2 = corner["det_right"]
    root_a1 = sqrt(trace_a1**2 - 4.0 * det_a1)
    root_a2 = sqrt(4.0 * det_a2 - trace_a2**2)
    for what, printed, value, independent in (
        ("P(1;1), trace on the side of A1", "1.6419", trace_a1, "1.6418699364295558139"),
        ("P(1;1), trace on the side of A2", "1.37142", trace_a2, "1.3714214414408132759"),
        ("P(2;1:1), trace before", "1.381624791", second["trace_left"], "1.3816245752401572435"),
        ("P(2;1:1), trace behind", "-3.80875", second["trace_right"], "-4.0910731023130986684"),
        ("P(1;1), larger multiplier on the side of A1", "1.0052", (trace_a1 + root_a1) / 2.0,
         "1.0051474054653564611"),
        ("P(1;1), smaller multiplier on the side of A1", "0.6367", (trace_a1 - root_a1) / 2.0,
         "0.6367225309641993528"),
        ("P(1;1), real part of the multipliers on the side of A2", "0.68571", trace_a2 / 2.0,
         "0.6857107207204066379"),
        ("P(1;1), imaginary part of the multipliers on the side of A2", "0.412", root_a2 / 2.0,
         "0.4120689353604570879"),
        ("P(1;1), determinant", "0.8", det_a1, "0.6400000000000000711"),
    ):  # fmt: skip
        yield Claim(
            f"corner impact of {what}",
            "chapter 3",
            published=printed,
            ours=value,
            error=TRACE,
            independent=independent,
        )


def _attractors(problem: Problem) -> Iterator[Claim]:
    """Turns and impacts of the two motions at 358.5 rpm, each from its own start."""
    from camcli.api.simulate import simulate

    place = "chapter 3, coexisting attractors at 358 to 359 rpm"
    for start, words, turns, count in (
        ({}, "from rest", "3", "8"),
        ({"q": 0.546, "v": 32.48}, "from q = 0.546 m, v = 32.48 m/s", "1", "2"),
    ):
        motion = simulate(problem.loaded({"run.rpm": 358.5, "run.start": start}))
        impacts_by_turn = Label.parse(motion.summary["label"]).symbols
        yield Claim(
            f"turns of the motion {words}", place, published=turns, ours=len(impacts_by_turn),
            kind=COUNT,
        )  # fmt: skip
        yield Claim(
            f"impacts of the motion {words}", place, published=count, ours=sum(impacts_by_turn),
            kind=COUNT,
        )  # fmt: skip


@registered(
    "siconos-cam",
    "di Bernardo, Osorio, Santini: Siconos tutorials, examples/mechanics/CamFollower",
    quick=True,
)
def _siconos_cam(problem: Problem) -> Iterator[Claim]:
    """Height and velocity of the cam, at the angles that the source computes."""
    system = machine_of(problem.loaded()).system
    their_pi = 3.14159265  # as the source writes it
    omega = 2.0 * their_pi * 358.0 / 60.0
    for time, height, velocity in (
        (0.01, "1.151296915074145e-01", "3.075369534567873e+00"),
        (0.02, "1.634274783659927e-01", "6.720896440968860e+00"),
        (0.03, "2.468373357741536e-01", "5.540737694914278e+00"),
        (0.05, "2.539332072382101e-01", ""),
    ):
        theta = omega * time + their_pi / 2.0
        if time == 0.03:  # on the nose the source turns its angle by pi/9, with its own pi
            theta += their_pi / 9.0 - pi / 9.0
        c, slope, second_derivative = lift_at(system.cam, stretch_at(system.cam, theta), theta)
        place = "CF.ref, sixth column"
        yield Claim(
            f"height of the cam at {time} s, m",
            place,
            published=height,
            ours=c,
            error=LIFT + CLOSED * abs(slope),
        )
        if velocity:
            place = "CF.ref, seventh column"
            yield Claim(
                f"velocity of the cam at {time} s, m/s",
                place,
                published=velocity,
                ours=omega * slope,
                error=omega * (LIFT + CLOSED * abs(second_derivative)),
            )
