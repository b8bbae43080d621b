"""Published oscillators with a stop."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import pi, radians

from camcli.analysis.bench.validation import COUNT, FORMULA, ROUNDING, Claim
from camcli.api.validation.problem import (
    SOLVED,
    Overrides,
    Problem,
    bifurcations,
    event,
    found_orbits,
    one_impact_in,
    register_in,
    rows_of,
    steady,
    vary,
)

PROBLEMS: list[Problem] = []
registered = partial(register_in, PROBLEMS)


@registered(
    "impact-oscillator",
    "COCO, example impact of its po toolbox; Dankowicz and Schilder: Recipes for Continuation, "
    "SIAM 2013, example 15.2",
    quick=True,
)
def _coco(problem: Problem) -> Iterator[Claim]:
    """The orbit that COCO starts from, and where its family grazes."""
    scene = problem.loaded({"run.strobe_deg": 180})
    (orbit,) = found_orbits(scene, "P(1;1)")
    speed = -orbit["u_minus_m_per_s_1"]
    yield Claim(
        "velocity before the impact",
        "quoted for the example impact; not in its files that were read",
        published="1.69573293759488",
        ours=speed,
        error=SOLVED * speed,
        independent="1.695732937594882009658779747363702559575",
    )
    after = -scene.follower.restitution * speed
    demo = "po/examples/impact/demo.m, start of the second segment"
    yield Claim("velocity after the impact", demo, published="-1.36", ours=after, error=SOLVED)
    phase = radians(orbit["theta_deg_1"])
    yield Claim("phase of the impact, rad", demo, published="0.076", ours=phase, error=SOLVED)
    p, p_dot = steady(scene.cam, pi)
    start = "po/examples/impact/demo.m, start of the first segment"
    yield Claim("x at phase -pi", start, published="-0.98", ours=p - orbit["q_m"], error=1e-13)
    yield Claim(
        "x' at phase -pi", start, published="-0.29", ours=p_dot - orbit["v_m_per_s"], error=1e-13
    )
    keys = {"cam.amplitude": 0.07, "orbits.label": "P(1;0)"}
    rows = bifurcations(problem.loaded({**keys, **vary("cam.amplitude", 0.06, 0.14)}))
    graze = event(rows, "grazing", "P(1;0)")
    grazes = graze["cam.amplitude"]
    error = graze["cam.amplitude_error"]
    yield Claim(
        "amplitude of the force at which the orbit grazes",
        "Recipes for Continuation, figures 15.4 and 15.6: d c w at w^2 = k",
        published="0.1000000000000000",
        ours=grazes,
        error=error + SOLVED,
        kind=FORMULA,
    )


@registered(
    "dux-orbits",
    "Dux, tests of his program impact-oscillator (2023); The Dynamics of Impact Oscillators, "
    "PhD thesis, Bristol (1992)",
)
def _dux_orbits(problem: Problem) -> Iterator[Claim]:
    """How many orbits with one impact in n periods there are."""
    place = "apps/imposc/test/parametric/one_n_params_test.exs, velocities for valid parameters"
    for clearance, count in ((0.0, "1"), (0.2, "2"), (-0.06, "0"), (0.4, "0")):
        found = found_orbits(problem.loaded({"cam.clearance": clearance}))
        yield Claim(
            f"(1, 2) orbits at w = 3.7, r = 0.8, clearance {clearance:g}",
            place,
            published=count,
            ours=len(found),
            kind=COUNT,
        )
    place = "apps/imposc/test/parametric/one_n_params_test.exs, orbits for valid parameters"
    total = 0
    for turns in range(1, 11):
        overrides = {
            "cam.frequency": 2 * turns,
            "cam.clearance": 0.001,
            "follower.restitution": 0.4,
            "orbits.label": one_impact_in(turns),
        }
        total += len(found_orbits(problem.loaded(overrides)))
    yield Claim(
        "(1, n) orbits at w = 2 n, r = 0.4, clearance 0.001, n = 1 to 10 together",
        place,
        published="10",
        ours=total,
        kind=COUNT,
    )
    p, _ = steady(problem.loaded({"cam.frequency": 3}).cam, 0.0)
    place = "apps/imposc/test/dynamics/evolution_coefficients_test.exs"
    yield Claim(
        "motion without the stop at w = 3, phase 0", place, published="-0.125", ours=p, error=SOLVED
    )


@registered(
    "budd-dux",
    "Budd and Dux, Phil. Trans. R. Soc. A 347 (1994) 365; Nonlinearity 7 (1994) 1191",
)
def _budd_dux(problem: Problem) -> Iterator[Claim]:
    """Velocities of (1, n) orbits, and the orbit at resonance."""
    both = sorted(-row["u_minus_m_per_s_1"] for row in found_orbits(problem.loaded()))
    place = "(s + k V/2)^2 + ((1 - r) V/(2 w))^2 = G^2"
    for which, speed, printed in zip(
        ("lower", "upper"), both, ("1.1023656826164447567", "2.1874438808293770076"), strict=True
    ):
        yield Claim(
            f"velocity of the {which} (1, 2) orbit at w = 3.7, clearance 0.2",
            place,
            published=printed,
            ours=speed,
            error=SOLVED * speed,
            kind=FORMULA,
        )
    near = {"cam.clearance": 0.3, "orbits.branches": 0}
    rows = bifurcations(problem.loaded({**near, **vary("cam.clearance", 0.29, 0.35)}))
    fold = event(rows, "fold", "P(2;1:0)")
    yield Claim(
        "clearance at which the two meet",
        "abs(G) sqrt(1 + (k w/(1 - r))^2)",
        published="0.3451471244528094351",
        ours=fold["cam.clearance"],
        error=fold["cam.clearance_error"],
        kind=FORMULA,
    )
    (orbit,) = found_orbits(problem.loaded({"cam.clearance": 0}))
    speed = -orbit["u_minus_m_per_s_1"]
    yield Claim(
        "velocity of the (1, 2) orbit at w = 3.7, clearance 0",
        place,
        published="0.6656933528399856071",
        ours=speed,
        error=SOLVED,
        kind=FORMULA,
    )
    keys: Overrides = {"cam.frequency": 2, "cam.clearance": 0, "orbits.label": "P(1;1)"}
    (orbit,) = found_orbits(problem.loaded(keys))
    speed = -orbit["u_minus_m_per_s_1"]
    yield Claim(
        "velocity of the (1, 1) orbit at resonance, w = 2, clearance 0",
        "V = 2 w G/(1 - r)",
        published="6.6666666666666681470",
        ours=speed,
        error=SOLVED * speed,
        kind=FORMULA,
    )
    yield Claim(
        "trace of its return map",
        "2 r",
        published="1.6000000000000000888",
        ours=orbit["trace"],
        error=SOLVED,
        kind=FORMULA,
    )


@registered("shaw-holmes", "Shaw and Holmes, J. Sound Vib. 90 (1983) 129")
def _shaw_holmes(problem: Problem) -> Iterator[Claim]:
    """Where the orbit with one impact a period doubles it, and its velocity there."""

    rows = bifurcations(problem.loaded(vary("cam.frequency", 2.58, 2.68)))
    doubling = event(rows, "period-doubling", "P(1;1)")
    frequency = doubling["cam.frequency"]
    error = doubling["cam.frequency_error"]
    yield Claim(
        "frequency of the period doubling, r = 0.8",
        "trace = -(1 + r^2)",
        published="2.6533477278553229339",
        ours=frequency,
        error=error,
        kind=FORMULA,
    )
    (orbit,) = found_orbits(problem.loaded({"cam.frequency": frequency}))
    speed = -orbit["u_minus_m_per_s_1"]
    yield Claim(
        "velocity before the impact there",
        "(k V/2)^2 + ((1 - r) V/(2 w))^2 = G^2",
        published="0.4492647099038989543",
        ours=speed,
        error=SOLVED + error,
        kind=FORMULA,
    )


@registered(
    "grazing",
    "Nordmark, J. Sound Vib. 145 (1991) 279; Chin, Ott, Nusse, Grebogi, Phys. Rev. E 50 (1994) "
    "4427",
    quick=True,
)
def _grazing(problem: Problem) -> Iterator[Claim]:
    """The velocity of the first impact grows with the square root of the excess over grazing."""
    from camcli.api.simulate import simulate

    for power, exact in (
        (10, "0.0442049621006104500"),
        (20, "0.00138106826127719037"),
        (30, "0.00004315837288520408"),
    ):
        more = 2.0**-power
        motion = simulate(problem.loaded({"cam.amplitude": 0.125 * (1.0 + more)}))
        first = next(row for row in rows_of(motion.tables["events"]) if row["event"] == "impact")
        speed = -first["u_minus_m_per_s"]
        # Heights about 1 m are good to 4 roundings; the velocity's square is twice the height.
        yield Claim(
            f"velocity of the first impact, amplitude 2^-{power} above grazing",
            "sqrt((1 + e)^2 - 1)",
            published=exact,
            ours=speed,
            error=8.0 * ROUNDING / speed,
            kind=FORMULA,
        )
