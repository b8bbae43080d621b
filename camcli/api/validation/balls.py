"""Published balls: on a table that vibrates, and on a floor."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

from camcli.analysis.bench.validation import COUNT, FORMULA, ROUNDING, Claim
from camcli.api.validation.problem import (
    RPM,
    SOLVED,
    Problem,
    bifurcations,
    event,
    one_impact_in,
    register_in,
    rows_of,
)
from camcli.scene import Scene

PROBLEMS: list[Problem] = []
registered = partial(register_in, PROBLEMS)


@registered(
    "bouncing-ball",
    "Holmes, J. Sound Vib. 84 (1982) 173; Everson, Physica D 19 (1986) 355; Luck and Mehta, "
    "Phys. Rev. E 48 (1993) 3988",
    quick=True,
)
def _ball(problem: Problem) -> Iterator[Claim]:
    """Fold, period doubling and sticking of the ball on a table, in Gamma = a omega^2/g."""
    from camcli.api.detach import detach

    rests = detach(problem.loaded()).tables["detach"]
    omega = rests["rpm"][0] / RPM  # a = g = 1 in this scene: Gamma is omega squared
    bracket = (rests["rpm_high"][0] - rests["rpm_low"][0]) / RPM
    yield Claim(
        "Gamma up to which a resting ball stays on the table",
        "a omega^2 = g",
        published="1.0000000000000000",
        ours=omega * omega,
        error=2.0 * bracket + SOLVED,
        kind=FORMULA,
    )
    published = {  # Gamma of the fold and of the period doubling, by turns of the period
        1: ("1.0471975511965977462", "1.5268237005190608643"),
        2: ("2.0943951023931954923", "2.3708772102669449996"),
    }
    for turns, (fold, doubling) in published.items():
        label = one_impact_in(turns)
        low = _rpm_of_gamma(0.98 * float(fold))
        high = _rpm_of_gamma(1.02 * float(doubling))
        between = _rpm_of_gamma(0.5 * (float(fold) + float(doubling)))
        overrides = {
            "orbits.rpm": {"start": low, "stop": high, "num": 40},
            "orbits.at": between,
            "orbits.label": label,
            "orbits.branches": 0,
        }
        rows = bifurcations(problem.loaded(overrides))
        for kind, printed, place in (
            ("fold", fold, "pi n (1 - r)/(1 + r)"),
            ("period-doubling", doubling, "sqrt((pi n (1-r)/(1+r))^2 + (2 (1+r^2)/(1+r)^2)^2)"),
        ):
            row = event(rows, kind, label)
            omega = row["rpm"] / RPM
            error = row["rpm_error"] / RPM
            yield Claim(
                f"Gamma of the {kind.replace('-', ' ')} of one impact in {turns} "
                f"{'turn' if turns == 1 else 'turns'}, r = 0.5",
                place,
                published=printed,
                ours=omega * omega,
                error=2.0 * omega * error + SOLVED,
                kind=FORMULA,
            )


def _rpm_of_gamma(gamma: float) -> float:
    """The speed of the table at which a omega^2/g is gamma; a = g = 1 in the scene."""
    return gamma**0.5 * RPM


SICONOS = "Siconos tutorials, examples/mechanics/BouncingBallEventDriven; Acary et al., INRIA"
# Relative error of the time and the speed of an impact, for each flight so far: four roundings.
FLIGHT = 4.0 * ROUNDING


class Impact(NamedTuple):
    """An impact of a motion: its time, s, and the velocity after it, m/s."""

    time: float
    velocity_after: float


def impacts(problem: Problem) -> list[Impact]:
    """The impacts of the scene's motion."""
    from camcli.api.simulate import simulate

    events = rows_of(simulate(problem.loaded()).tables["events"])
    return [
        Impact(float(row["t_s"]), float(row["u_plus_m_per_s"]))
        for row in events
        if row["event"] == "impact"
    ]


def times(found: list[Impact], place: str, printed: dict[int, tuple[str, str]]) -> Iterator[Claim]:
    """The times of some impacts.

    place: in the source. printed: by the number of the impact, from 1, its time as printed and from
    an independent computation.
    """
    for number, (published, independent) in printed.items():
        time = found[number - 1].time
        error = FLIGHT * number * time
        yield Claim(
            f"time of impact {number}, s",
            place,
            published=published,
            ours=time,
            error=error,
            independent=independent,
        )


def speeds(found: list[Impact], place: str, printed: dict[int, tuple[str, str]]) -> Iterator[Claim]:
    """The velocities after some impacts; printed: as of `times`."""
    for number, (published, independent) in printed.items():
        speed = found[number - 1].velocity_after
        error = FLIGHT * number * abs(speed)
        yield Claim(
            f"velocity after impact {number}, m/s",
            place,
            published=published,
            ours=speed,
            error=error,
            independent=independent,
        )


@registered("siconos-ball", SICONOS, quick=True)
def _siconos_ball(problem: Problem) -> Iterator[Claim]:
    """A ball falls on a floor."""
    found = impacts(problem)
    yield from times(found, "BouncingBallED.ref, first column", {
        1: ("4.515236409857308e-01", "0.4515236409857308930043896060683300235152"),
        2: ("1.264266194760045e+00", "1.264266194760046520463968592388982073829"),
        3: ("1.995734493156927e+00", "1.995734493156930603224099605935461571537"),
        6: ("3.779785672946910e+00", "3.779785672946930966020981368988429211515"),
        12: ("6.028476926052508e+00", "6.028476926052619049916457474827601035731"),
    })  # fmt: skip
    yield from speeds(found, "BouncingBallED.ref, third column", {
        1: ("3.986502226263017e+00", "3.986502226263018354810146097511196013952"),
        3: ("3.229066803273031e+00", "3.229066803273045026728854474383413043433"),
        12: ("1.251006639937613e+00", "1.251006639937710182553585994435176304585"),
    })  # fmt: skip


@registered("siconos-ball-thrown", SICONOS, quick=True)
def _siconos_thrown(problem: Problem) -> Iterator[Claim]:
    """A ball that is thrown at the floor, from the floor."""
    found = impacts(problem)
    place = "BouncingBallED-initialImpact.ref"
    yield from times(found, f"{place}, first column", {
        2: ("1.834862385321100e-01", "0.1834862385321100869670286701683174564283"),
        3: ("3.486238532110067e-01", "0.3486238532110091693115674077240472462041"),
        4: ("4.972477064220083e-01", "0.4972477064220183470884439124880238185594"),
        10: ("1.123999102752105e+00", "1.123999102752293640458878931967861691153"),
    })  # fmt: skip
    yield from speeds(found, f"{place}, third column", {
        1: ("8.999999999999999e-01", "0.9000000000000000222044604925031308084726"),
        2: ("8.099999999999997e-01", "0.8100000000000000399680288865056359482888"),
        4: ("6.560999999999521e-01", "0.6561000000000000647482067961391318336712"),
    })  # fmt: skip


@registered("siconos-ball-plastic", SICONOS, quick=True)
def _siconos_plastic(problem: Problem) -> Iterator[Claim]:
    """A ball that stays where it lands, and the force under it."""
    from camcli.api.simulate import simulate

    result = simulate(problem.loaded())
    (landing,) = (row for row in rows_of(result.tables["events"]) if row["event"] == "impact")
    place = "BouncingBallED-withRestingContact.ref"
    time = float(landing["t_s"])
    speed = float(landing["u_minus_m_per_s"])
    yield Claim(
        "time of the landing, s",
        f"{place}, first column",
        published="4.515236409857311e-01",
        ours=time,
        error=FLIGHT * time,
        independent="0.4515236409857308930043896060683300235152",
    )
    yield Claim(
        "velocity before it, m/s",
        f"{place}, third column",
        published="-4.429446918070021e+00",
        ours=speed,
        error=FLIGHT * abs(speed),
        independent="-4.429446918070020284951852223984087220138",
    )
    yield Claim(
        "impacts in 8.5 s", f"{place}, fourth column", published="1",
        ours=sum(row["event"] == "impact" for row in rows_of(result.tables["events"])), kind=COUNT,
    )  # fmt: skip


@registered("siconos-oscillator", SICONOS, quick=True)
def _siconos_oscillator(problem: Problem) -> Iterator[Claim]:
    """A stiff spring beats a light mass on a floor."""
    found = impacts(problem)
    yield from times(found, "LinearOscillatorED.ref, first column", {
        1: ("4.966983943888618e-03", "0.004966983943888632500594538627711437979975"),
        2: ("1.490088290077536e-02", "0.01490088290077543426454757692899406231949"),
        3: ("2.483470526778414e-02", "0.02483470526778413631993770180071874391024"),
        10: ("9.436846907529510e-02", "0.09436846907529383339268110876194968846343"),
    })  # fmt: skip
    yield from speeds(found, "LinearOscillatorED.ref, third column", {
        1: ("2.846329077952886e+02", "284.6329077952863873883724207351820312251"),
        2: ("2.561696170157613e+02", "256.1696170157577549696553346683868257101"),
        3: ("2.305526553141809e+02", "230.5526553141819851607979416075989813207"),
        10: ("1.102726203235375e+02", "110.2726203235417885824870899441494886298"),
    })  # fmt: skip


@registered(
    "modelica-ball", "Nouidui (2017), Modelica models for QSS solvers, lbl-srg/soep", quick=True
)
def _modelica_ball(problem: Problem) -> Iterator[Claim]:
    """The state events of a falling ball, the first of each pair."""
    found = impacts(problem)
    place = "QSS/Specific/Events/BouncingBall.mo, info"
    yield from times(found, place, {
        1: ("0.4515236395553223", "0.4515236409857308930043896060683300235152"),
        2: ("1.173961461717483", "1.173961466562900361914768366572974077113"),
        3: ("1.751911718232403", "1.751911727024635969125755687612943913718"),
        4: ("2.214271923191991", "2.214271935394024480560692994553924882740"),
        5: ("2.584160083998069", "2.584160102089535310241560800193914877554"),
        6: ("2.880070609653692", "2.880070635445943990412589412775671960927"),
    })  # fmt: skip
    events = 2 * sum(impact.time < 3.0 for impact in found)
    yield Claim(
        "state events in 3 s, two for an impact", place, published="12", ours=events, kind=COUNT
    )


@registered(
    "qss-ball", "NREL/SOEP-QSS-Test: tests of the QSS solver of Spawn of EnergyPlus", quick=True
)
def _qss_ball(problem: Problem) -> Iterator[Claim]:
    """The first impact of a falling ball, and how many there are."""
    found = impacts(problem)
    time = found[0].time
    place = "mdl/BouncingBall/ana/BouncingBall.py, notes"
    yield Claim(
        "time of impact 1, s",
        place,
        published="0.451600756",
        ours=time,
        error=FLIGHT,
        independent="0.4516007557517875329366454593678710180753",
    )
    events = 2 * sum(impact.time < 3.0 for impact in found)
    place = "mdl/BouncingBall/BouncingBall.mo, info"
    yield Claim(
        "state events in 3 s, two for an impact", place, published="12", ours=events, kind=COUNT
    )


@registered(
    "numerous-ball", "numerous.engine (a Python package), test of a bouncing ball", quick=True
)
def _numerous_ball(problem: Problem) -> Iterator[Claim]:
    """Ten impacts of a falling ball."""
    found = impacts(problem)
    for number, exact in (
        (1, "0.4515236409857308930043896060683300235152"),
        (2, "1.3094185588586195496"),
        (5, "3.6342065494294134843"),
        (10, "6.7956666865408966758"),
    ):
        time = found[number - 1].time
        yield Claim(
            f"time of impact {number}, s", "analytical_solution: sqrt(2 h/g) (2 sum r^i - 1)",
            published=exact, ours=time, error=FLIGHT * number * time, kind=FORMULA,
        )  # fmt: skip


@registered(
    "resting-ball",
    "Budd and Dux, Phil. Trans. R. Soc. A 347 (1994) 365; Nordmark and Piiroinen, Nonlinear Dyn. "
    "58 (2009) 85; Tufillaro, Abbott, Reilly (1992)",
    quick=True,
)
def _resting_ball(problem: Problem) -> Iterator[Claim]:
    """A complete chatter ends where the geometric series of its hops does."""
    rest = _rests_from(problem.loaded())
    yield Claim(
        "time from which the ball rests, s",
        "sum of the hops: sqrt(2 h/g) (1 + r)/(1 - r)",
        published="4.063712768871579039623391224498093229330",
        ours=rest,
        error=10.0 * FLIGHT * rest,
        kind=FORMULA,
    )


@registered("sciml-ball", "SciMLSensitivity.jl, test of callbacks", quick=True)
def _sciml_ball(problem: Problem) -> Iterator[Claim]:
    """The impact of a ball that falls from 50 m."""
    from camcli.api.simulate import simulate

    events = rows_of(simulate(problem.loaded()).tables["events"])
    first = next(row for row in events if row["event"] == "impact")
    place = "test_continuous_wrt_discrete_callback"
    for quantity, column, printed, exact in (
        ("time of the impact, s", "t_s", "3.1943828249997",
         "3.194382824999699450495477101230202804852"),
        ("velocity before it, m/s", "u_minus_m_per_s", "-31.30495168499705",
         "-31.30495168499705688460118713241978824640"),
        ("velocity after it, m/s", "u_plus_m_per_s", "25.04396134799764",
         "25.04396134799764689790007552440875935887"),
    ):  # fmt: skip
        value = float(first[column])
        yield Claim(
            quantity,
            place,
            published=printed,
            ours=value,
            error=FLIGHT * abs(value),
            independent=exact,
        )


@registered(
    "fmu-ball",
    "FMU SDK, model bouncingBall: tests of FMIFlux.jl, examples of PyFMI",
    quick=True,
)
def _fmu_ball(problem: Problem) -> Iterator[Claim]:
    """The first event, and the height at 2 s."""
    from camcli.api.simulate import simulate

    found = impacts(problem)
    yield from times(
        found,
        "FMIFlux.jl, t_first_event_time",
        {1: ("0.451523640985728", "0.4515236409857308930043896060683300235152")},
    )
    place = "FMIFlux.jl, x_first_event_right"
    yield from speeds(
        found, place, {1: ("3.1006128426489954", "3.100612842649014002759338364937826022442")}
    )
    trajectory = simulate(problem.loaded()).tables["trajectory"]
    at_two_seconds = abs(trajectory["t_s"] - 2.0) < 1e-9
    (height,) = trajectory["q_m"][at_two_seconds]
    place = "PyFMI, examples/fmi_bouncing_ball.py, h at the end"
    yield Claim(
        "height at 2 s, m",
        place,
        published="0.0424044",
        ours=height,
        error=1e-14,
        independent="0.04243354780262757421871756518835157305879",
    )


@registered("vip-ball", "vip_ivp (a Python package), documentation of events", quick=True)
def _vip_ball(problem: Problem) -> Iterator[Claim]:
    """When a stone reaches the ground."""
    place = "print_collision_time"
    yield from times(
        impacts(problem),
        place,
        {1: ("1.4278431229270645", "1.427843122927064430770517131655595201813")},
    )


@registered("prismal-ball", "Prismal, reference program RP-03 (2026)", quick=True)
def _prismal_ball(problem: Problem) -> Iterator[Claim]:
    """Ten impacts, and the time from which the ball rests."""
    yield from times(impacts(problem), "RP-03, expected results of case A", {
        1: ("0.451523640985731", "0.4515236409857308930043896060683300235152"),
        2: ("1.17396146656290", "1.173961466562900361914768366572974077113"),
        3: ("1.75191172702464", "1.751911727024635969125755687612943913718"),
        4: ("2.21427193539402", "2.214271935394024480560692994553924882740"),
        5: ("2.58416010208954", "2.584160102089535310241560800193914877554"),
        10: ("3.57889295102044", "3.578892951020438815815021887834532181216"),
    })  # fmt: skip
    yield resting(problem, "4.06371276887158", "RP-03, expected results")


@registered(
    "kinopulse-ball", "KinoPulse, exhibit Hybrid Bouncing Ball and Event Accumulation", quick=True
)
def _kinopulse_ball(problem: Problem) -> Iterator[Claim]:
    """How many impacts there are in four of the 4.06 seconds until it rests."""
    found = impacts(problem)
    before = sum(impact.time < 4.0 for impact in found)
    yield Claim("impacts before 4.0 s", "results", published="19", ours=before, kind=COUNT)
    place = "results, first analytical impact"
    yield from times(
        found, place, {1: ("0.45152364", "0.4515236409857308930043896060683300235152")}
    )
    yield resting(problem, "4.06371", "results, analytical accumulation time")


def resting(problem: Problem, published: str, place: str) -> Claim:
    """The time from which the ball rests, in turns of the floor that are long enough for it."""
    rest = _rests_from(problem.loaded({"run.rpm": 6, "run.chatter_tolerance": 1e-9}))
    exact = "4.063712768871579039623391224498093229330"
    error = 10.0 * FLIGHT * rest
    return Claim(
        "time from which the ball rests, s",
        place,
        published=published,
        ours=rest,
        error=error,
        independent=exact,
    )


def _rests_from(scene: Scene) -> float:
    """The time (s) at which the one chatter of a motion is complete."""
    from camcli.api.simulate import simulate

    events = rows_of(simulate(scene).tables["events"])
    (rest,) = (float(row["t_s"]) for row in events if row["event"] == "chatter")
    return rest
