"""`cam bench validation`: published numbers, ours, and independent values of both."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from decimal import Decimal
from functools import cache

import pytest
from mpmath import mp, mpf

from camcli.analysis.bench.validation import (
    COUNT,
    FAILED,
    FORMULA,
    MISPRINT,
    OK,
    Claim,
    half_unit,
    row_of,
)
from camcli.api import validation
from camcli.api.validation import PROBLEMS, chosen
from camcli.scene import load_scene
from tests.conftest import rows as csv_rows
from tests.support import orbit_oracle, published
from tests.support.oracle import region_filling_rpm

DIGITS = 50
WHOLE = bool({"CAMCLI_NO_SKIPS", "CAMCLI_SOAK"} & os.environ.keys())  # as CI runs them
RUN = [problem.scene for problem in chosen(not WHOLE)]


@pytest.fixture(autouse=True)
def _digits():
    with mp.workdps(DIGITS):
        yield


@cache
def rows(problem: str) -> list:
    """The rows of a problem, measured once."""
    return validation.measure(PROBLEMS[problem])


@cache
def coco() -> tuple[mpf, mpf]:
    return published.Forced.of("1", "0.1", "1", "1", "1", "0.8").orbit(1, ("0.076", "1.7"))


@cache
def corner(label: str) -> orbit_oracle.CornerImpact:
    o = orbit_oracle
    if label == "P(1;1)":
        return o.corner_rpm(o.CAM, o.CHAPTER, o.STABLE, 1, 0, o.B, 680)
    return o.corner_rpm(o.CAM, o.CHAPTER, o.DOUBLED, 2, 1, o.C, 739.37)


def multipliers(side: str) -> list:
    """Of P(1;1) at its corner impact, the larger real or imaginary part first."""
    orbit = getattr(corner("P(1;1)"), side)
    root = mp.sqrt(orbit.trace**2 - 4 * orbit.det)
    return [(orbit.trace + root) / 2, (orbit.trace - root) / 2]


def doubling() -> mpf:
    o = orbit_oracle
    return o.period_doubling_rpm(o.CAM, o.CHAPTER, o.STABLE, 1, 700, 745).rpm


def impact(found: list, row) -> mpf:
    """The time or velocity of the impact that the row is about."""
    number = int(re.search(r"impact (\d+)", row.quantity)[1])
    return found[number - 1][row.quantity.startswith("velocity")]


def of_ball(row) -> mpf:
    turns = int(re.search(r"in (\d)", row.quantity)[1]) if "impact in" in row.quantity else 0
    if not turns:
        return mpf(1)
    return (published.ball_doubling if "doubling" in row.quantity else published.ball_fold)(
        0.5, turns
    )


def of_cam_follower(row) -> mpf | None:
    """None: tests/published/test_proved_numbers.py has it."""
    o = orbit_oracle
    known = {
        "contact is lost all over": lambda: region_filling_rpm(o.CAM, mpf(1.221), mpf(1430.8)),
        "chatter accumulates at c": lambda: published.accumulation_rpm(160, "119.712481040"),
        "chatter accumulates at d": lambda: published.accumulation_rpm(200, "136.312372393"),
        "corner impact of P(1;1) at b": lambda: corner("P(1;1)").rpm,
        "period doubling of P(1;1)": doubling,
        "corner impact of P(2;1:1) at c": lambda: corner("P(2;1:1)").rpm,
        "corner impact of P(1;1), trace on the side of A1": lambda: corner("P(1;1)").left.trace,
        "corner impact of P(1;1), trace on the side of A2": lambda: corner("P(1;1)").right.trace,
        "corner impact of P(1;1), larger multiplier": lambda: multipliers("left")[0],
        "corner impact of P(1;1), smaller multiplier": lambda: multipliers("left")[1],
        "corner impact of P(1;1), real part": lambda: multipliers("right")[0].real,
        "corner impact of P(1;1), imaginary part": lambda: multipliers("right")[0].imag,
        "corner impact of P(1;1), determinant": lambda: corner("P(1;1)").left.det,
        "corner impact of P(2;1:1), trace before": lambda: corner("P(2;1:1)").left.trace,
        "corner impact of P(2;1:1), trace behind": lambda: corner("P(2;1:1)").right.trace,
    }
    if row.quantity.startswith(PROVED):
        return None
    return next(value for name, value in known.items() if row.quantity.startswith(name))()


def of_budd_dux(row) -> mpf:
    if row.quantity.startswith("trace"):
        return 2 * mpf(0.8)
    if row.quantity.startswith("clearance"):
        return published.one_n_fold(3.7, 0.8, 2)
    if "(1, 1)" in row.quantity:
        return published.one_n_velocities(2, 0.8, 0, 1)[1]
    clearance = 0.2 if "0.2" in row.quantity else 0
    return published.one_n_velocities(3.7, 0.8, clearance, 2)["lower" not in row.quantity]


def of_grazing(row) -> mpf:
    more = mpf(2) ** -int(re.search(r"2\^-(\d+)", row.quantity)[1])
    return mp.sqrt((1 + more) ** 2 - 1)


def of_shaw_holmes(row) -> mpf:
    w = published.doubling_frequency(0.8, "2.6533")
    return w if row.quantity.startswith("freq") else published.one_n_velocities(w, 0.8, 0, 1)[1]


def of_plastic(row) -> mpf:
    g = mpf(9.81)
    return mp.sqrt(2 / g) if row.quantity.startswith("time") else -mp.sqrt(2 * g)


def dropped(g, r, count, height=1):
    return lambda row: impact(published.ball_impacts(g, r, count, height=height), row)


def rest(_) -> mpf:
    return mp.sqrt(2 / mpf(9.81)) * (1 + mpf(0.8)) / (1 - mpf(0.8))


def of_fall(row) -> mpf:
    """From 50 m, g = 9.8."""
    time, after = published.ball_impacts(9.8, 0.8, 1, height=50)[0]
    named = {"time of": time, "velocity before": -after / mpf(0.8), "velocity after": after}
    return next(value for name, value in named.items() if row.quantity.startswith(name))


def of_fmu(row) -> mpf:
    found = published.ball_impacts(9.81, 0.7, 4, height=1)
    if not row.quantity.startswith("height"):
        return impact(found, row)
    time = 2 - found[3][0]
    return found[3][1] * time - mpf(9.81) / 2 * time**2


def resting_or(row) -> mpf:
    return rest(row) if "rests" in row.quantity else dropped(9.81, 0.8, 10)(row)


# problem: the value of a row by mpmath alone
EXACT: dict[str, Callable[..., mpf | None]] = {
    "impact-oscillator": lambda row: coco()[1] if "before" in row.quantity else mpf("0.1"),
    "bouncing-ball": of_ball,
    "cam-follower": of_cam_follower,
    "budd-dux": of_budd_dux,
    "shaw-holmes": of_shaw_holmes,
    "grazing": of_grazing,
    "siconos-ball": dropped(9.81, 0.9, 12),
    "siconos-ball-thrown": lambda row: impact(published.ball_impacts(9.81, 0.9, 10, speed=1), row),
    "siconos-ball-plastic": of_plastic,
    "siconos-oscillator": lambda row: impact(
        published.floor_impacts(1e-3, 100, 9.81, 0.9, 10, 1), row
    ),
    "modelica-ball": dropped(9.81, 0.8, 6),
    "qss-ball": dropped(9.80665, 0.8, 6),
    "numerous-ball": dropped(9.81, 0.95, 10),
    "resting-ball": rest,
    "sciml-ball": of_fall,
    "fmu-ball": of_fmu,
    "vip-ball": dropped(9.81, 0.5, 1, 10),
    "prismal-ball": resting_or,
    "kinopulse-ball": resting_or,
}
PROVED = ("first loss", "chatter is complete", "impact ")  # in tests/published/test_proved_numbers


@pytest.mark.parametrize("problem", RUN)
def test_every_published_number_comes_out(problem):
    found = rows(problem)
    assert found
    for row in found:
        assert row.status in (OK, MISPRINT), row
        if row.status == MISPRINT:
            assert abs(row.difference) > half_unit(row.published), row
        assert row.source
        assert row.place
        assert (row.digits == COUNT) == row.published.isdigit()  # all others have a fraction
        assert row.bound == 0.0 if row.digits == COUNT else row.bound > 0.0


@pytest.mark.parametrize("problem", RUN)
def test_independent_values_are_those_of_mpmath(problem):
    """Every formula and every value beside a wrong number, and ours, within our own error of it."""
    for row in rows(problem):
        text = row.published if row.digits == FORMULA else row.independent
        exact = EXACT[problem](row) if text else None
        if exact is None:
            continue
        unit = Decimal(text).as_tuple().exponent
        # The cam-follower's circles close exactly for some numbers beside the doubles of the scene.
        data = 2e-16 * abs(exact) if problem == "cam-follower" else mpf(0)
        assert abs(exact - mpf(text)) <= mpf(10) ** unit + data, row
        own = row.bound - half_unit(row.published)
        assert abs(exact - mpf(row.ours)) <= own + 1e-16, row
    if problem == "impact-oscillator":  # also those that are printed with two or three digits
        ours = {row.quantity: row.ours for row in rows(problem)}
        phase, speed = map(float, coco())
        assert ours["velocity after the impact"] == pytest.approx(-0.8 * speed, rel=1e-12)
        assert ours["phase of the impact, rad"] == pytest.approx(phase, rel=1e-10)


LOOSER = {"grazing": 1e-6, "cam-follower": 1e-9}  # of ours: what their own errors may be at most


@pytest.mark.parametrize("problem", RUN)
def test_our_own_errors_are_no_excuse(problem):
    """A bound that is much wider than the numbers are wrong would let any of them pass.

    Each has an error of its own beside the rounding of its last digit.
    """
    for row in rows(problem):
        if row.digits != COUNT:
            own = row.bound - half_unit(row.published)
            rounded = 1e-15 * row.bound  # by that difference
            assert own <= LOOSER.get(problem, 1e-11) * abs(row.ours) + rounded, row
            assert own > 2.0 * 2.0**-52 * abs(row.ours), row


@pytest.mark.skipif(not WHOLE, reason="the whole bench runs in CI")
@pytest.mark.parametrize("clearance", [0, 0.2, -0.06, 0.4])
def test_the_orbits_that_are_counted_by_a_computation_of_its_own(clearance):
    name = f"(1, 2) orbits at w = 3.7, r = 0.8, clearance {clearance:g}"
    (row,) = (row for row in rows("dux-orbits") if row.quantity == name)
    with mp.workdps(15):
        assert published.one_n_count(3.7, 0.8, clearance, 2) == row.ours == int(row.published)


def test_the_bound_is_half_a_unit_of_the_last_digit_and_our_own_error():
    assert half_unit("-1.36") == 0.005
    assert half_unit("119") == 0.5
    assert half_unit("0.1000") == 0.00005
    assert half_unit("1.5e-3") == 0.00005
    row = row_of(
        Claim("x", "there", published="1.36", ours=1.3649, error=1e-3), "who", "scene", 0.0
    )
    assert row.bound == pytest.approx(0.006)
    assert (row.status, row.digits) == (OK, "3")
    row = row_of(
        Claim("x", "there", published="1.36", ours=1.3649, error=1e-3, independent="1.3650"),
        "who",
        "scene",
        0.25,
    )
    assert (row.source, row.place, row.problem, row.seconds) == ("who", "there", "scene", 0.25)
    assert (row.quantity, row.published, row.independent) == ("x", "1.36", "1.3650")
    assert row.difference == pytest.approx(0.0049)
    assert (
        row_of(
            Claim("x", "there", published="1.36", ours=1.3661, error=1e-3), "who", "scene", 0.0
        ).status
        == FAILED
    )
    counted = row_of(
        Claim("orbits", "there", published="2", ours=2.0, kind=COUNT), "who", "scene", 0.0
    )
    assert (counted.bound, counted.status) == (0.0, OK)
    assert (
        row_of(Claim("n", "there", published="2", ours=1.0, kind=COUNT), "w", "s", 0.0).status
        == FAILED
    )


@pytest.mark.parametrize(
    ("published_as", "ours", "independent", "status"),
    [
        ("1.36", 1.4, "1.4000000000000000000", MISPRINT),
        ("1.36", 1.4, "", FAILED),
        ("1.36", 1.41, "1.4000000000000000000", FAILED),  # ours is neither
        ("1.40", 1.41, "1.4000000000000000000", FAILED),  # the published number is right
    ],
)
def test_a_number_is_only_called_wrong_where_an_independent_one_says_so(
    published_as, ours, independent, status
):
    claim = Claim(
        "x", "there", published=published_as, ours=ours, error=1e-12, independent=independent
    )
    assert row_of(claim, "who", "scene", 0.0).status == status


def test_a_number_that_is_not_reproduced_is_exit_code_3(cam, tmp_path, monkeypatch):
    def wrong(problem):
        yield Claim("a number, m", "page 3", published="1.0", ours=2.0)
        yield Claim("another", "page 4", published="2.00", ours=2.001)

    one = validation.Problem("bouncing-ball", "A. N. Other", wrong, quick=True)
    monkeypatch.setattr(validation, "PROBLEMS", {"bouncing-ball": one})
    done = cam("bench validation --json -o .", code=3)
    assert json.loads(done.stdout)["result"]["validation"] == {
        "problems": 1, "rows": 2, "published_off": [], "failed": ["bouncing-ball: a number, m"],
    }  # fmt: skip
    assert (tmp_path / "validation.png").read_bytes()[:4] == b"\x89PNG"
    first, second = csv_rows(tmp_path / "validation.csv")
    assert list(first)[:6] == ["source", "quantity", "published", "ours", "difference", "bound"]
    assert (first["difference"], first["bound"], first["status"]) == (
        "1.0", "0.05000000000000045", "failed",
    )  # fmt: skip
    assert second["status"] == "ok"
    said = cam("bench validation --no-plot -o .", code=3).stderr
    assert "bouncing-ball, a number, m: published 1.0, but ours is 2, 1 off" in said


def test_a_problem_that_raises_costs_its_rows_alone(cam, tmp_path, monkeypatch):
    def broken(problem):
        yield Claim("fine", "page 3", published="2.0", ours=2.0)
        raise RuntimeError("no such orbit")

    fine = validation.Problem(
        "b", "who", lambda p: iter([Claim("x", "y", published="1", ours=1.0)]), quick=False
    )
    problems = {"a": validation.Problem("a", "who", broken, quick=True), "b": fine}
    monkeypatch.setattr(validation, "PROBLEMS", problems)
    done = cam("bench validation --no-plot -o .", code=1)
    assert [row["problem"] for row in csv_rows(tmp_path / "validation.csv")] == ["b"]
    assert "fault: validation: a" in done.stderr
    plan = json.loads(cam("bench validation --dry-run --json --quick", code=0).stdout)["plan"]
    assert plan["validation"]["runs"] == 1


def test_every_scene_of_the_folder_is_a_problem_and_says_where_it_is_from():
    files = {path.stem: path for path in validation.folder().glob("*.yaml")}
    assert set(files) == set(PROBLEMS)
    for path in files.values():
        load_scene(path)
        text = path.read_text(encoding="utf-8")
        assert text.startswith("# ")
        assert "yaml-language-server" in text
