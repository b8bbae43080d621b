"""Promises in small print: thresholds, units of a start, names in a list, a rest above the cam."""

from __future__ import annotations

from dataclasses import replace
from math import inf, log, log2, pi
from types import SimpleNamespace as Made

import numpy as np
import pytest

import camcli
from camcli.analysis import after_rest, natural_speed, patience
from camcli.analysis.basins.measures import uncertainty
from camcli.analysis.basins.window import Window
from camcli.analysis.exponents import sum_rule
from camcli.analysis.integrate import Settings, Start
from camcli.analysis.orbits.orbit import free_orbit
from camcli.analysis.orbits.proofs import prove_orbit
from camcli.cams.eccentric import EccentricCam
from camcli.errors import Status
from camcli.plots import basins
from camcli.system import Follower, System
from camcli.words.speeds import chosen_speeds, number_range, range_words
from camcli.words.sweep import start_words


@pytest.mark.parametrize(("mean", "calm"), [(-0.31, True), (-0.29, False), (0.3, False)])
def test_a_motion_calms_where_its_exponent_is_below_zero_by_three_errors(monkeypatch, mean, calm):
    found = Made(largest=mean, spread=0.1)
    monkeypatch.setattr(patience, "of_record", lambda *_: found)
    assert patience._calms(Made(system=None), 700.0, None) == calm
    monkeypatch.setattr(patience, "of_record", lambda *_: None)
    assert not patience._calms(Made(system=None), 700.0, None)


def test_the_error_of_an_exponent_grows_with_the_misfit_of_its_line():
    """Weighted least squares in its own words: sqrt(cov misfit), with n - 2 degrees of freedom."""

    class Finder:
        def settle(self, q, v):
            return np.where((q > 0.5) | ((q < 0.02) & (q > 0.0)), 1, 0), None

    found = uncertainty(Finder(), Window((0.0, 1.0), (0.0, 1.0), 4, 4), 4000)
    error, share, count = np.array(found.rows).T
    x, y, w = np.log(error), np.log(share), count
    mx, my = np.sum(w * x) / np.sum(w), np.sum(w * y) / np.sum(w)
    sxx = np.sum(w * (x - mx) ** 2)
    slope = np.sum(w * (x - mx) * (y - my)) / sxx
    misfit = np.sum(w * (y - my - slope * (x - mx)) ** 2) / (len(x) - 2)
    assert misfit > 1.2
    assert found.exponent == pytest.approx(slope, rel=1e-9)
    assert found.error == pytest.approx(np.sqrt(misfit / sxx), rel=1e-9)


def test_a_start_is_told_with_its_units():
    settings = Settings(3, 5, 1e-9, 10, Start(0.25, 1.5))
    sweep = camcli.sweep(camcli.load_scene(None, {"sweep.rpm.num": 1, "run.record": 2})).values[0]
    also = (Start(None, -2.5), Start(0.75, None), Start())
    said = start_words(replace(sweep, also=also), settings)
    for text in ("q = 0.25 m, v = 1.5 m/s", "on the cam, v = -2.5 m/s", "q = 0.75 m, the cam's v",
                 "at rest on the cam"):  # fmt: skip
        assert text in said


def test_cells_without_an_attractor_are_listed_by_what_happened_to_them():
    """Their codes are those of the statuses with a minus sign; cells below the cam come last."""
    shares = {-int(status): (0.01 * int(status), 0.0) for status in Status if status >= 2}
    speed = Made(branches=(), attractors=(), fractions={0: (0.25, 0.01), **shares},
                 codes=np.array([-1, 0]))  # fmt: skip
    rows = [row[2:] for row in basins._attractor_rows([speed], {}, {}, "rpm")][1:]
    assert rows[0][0] == "undecided"
    assert rows[-1] == ["none: below the cam", ""]  # no share
    wanted = {status.text: int(status) for status in Status if status >= 2}
    found = {name: float(said.split()[0]) for name, said in rows[1:-1]}
    assert found == pytest.approx(wanted)


@pytest.mark.parametrize("strobe_deg", [0.0, 100.0])
@pytest.mark.parametrize(("above", "proved"), [(1e-6, True), (-1e-6, False), (-1e-3, False)])
def test_a_follower_at_rest_above_the_cam_is_proved_where_it_clears_its_top(
    strobe_deg, above, proved
):
    """It rests at -preload/k; the cam's top is 0.03 m, inside a piece."""
    cam = EccentricCam(kind="eccentric", base=0.01, lift=0.02)

    def system(height: float) -> System:
        follower = Follower(1.0, 1000.0, damping=5.0, preload=-1000.0 * height)
        return System.build(follower, cam, strobe_deg)

    orbit = free_orbit(system(0.04), 700.0)
    assert prove_orbit(system(0.04), orbit).proved
    assert prove_orbit(system(0.03 + above), orbit).proved == proved


@pytest.mark.parametrize(
    ("follower", "wanted"),
    [
        ({"stiffness": 1800.0, "gravity": 9.81}, (1800.0 / 0.5) ** 0.5),  # the natural frequency
        ({"stiffness": 0.0, "gravity": 9.0, "preload": 3.0}, ((9.0 + 3.0 / 0.5) / 0.02) ** 0.5),
        ({"stiffness": 0.0, "gravity": 9.0, "preload": -7.0}, 0.0),  # nothing presses it
    ],
)
def test_the_speed_of_a_machine_that_never_loses_contact_for_the_first_time(
    monkeypatch, follower, wanted
):
    """Of its spring; without one where the cam accelerates by all that presses the follower."""
    monkeypatch.setattr(natural_speed, "detachment", lambda _: Made(first=None))
    cam = EccentricCam(kind="eccentric", base=0.01, lift=0.02)
    found = natural_speed.natural_speed(System.build(Follower(0.5, **follower), cam))
    assert found.rpm == pytest.approx(wanted * 30.0 / pi, rel=1e-12)
    said = chosen_speeds("orbits", natural_speed.Chosen(123.0, 456.0, found))
    assert "orbits.rpm" in said
    assert "123 to 456 rpm" in said
    assert (f"{found.rpm:.5g}" in said) == (follower["stiffness"] > 0.0)
    assert " 77 rpm" in chosen_speeds("basins", natural_speed.Chosen(77.0, 77.0, None))


def test_the_ends_of_a_range_have_the_digits_of_its_width():
    assert range_words(4110.9, 4378.2) == "4111 to 4378 rpm"
    assert range_words(4111.234, 4111.279) == "4111.234 to 4111.279 rpm"
    assert "4111 rpm on" in range_words(4111.3, inf)
    assert range_words(inf, inf) == "never"


def test_the_sum_of_exponents_without_restitution():
    const = Made(r=0.0, Z=0.25)
    assert sum_rule(const, 1.5) == -inf
    assert sum_rule(const, 0.0) == pytest.approx(-pi)
    assert sum_rule(Made(r=0.5, Z=0.25), 1.5) == pytest.approx(3.0 * log(0.5) - pi)


class Ball(float):
    """A number that is known exactly."""

    def rad(self) -> float:
        return 0.0


@pytest.mark.parametrize(("q", "w"), [(1e-3, 1.0), (1.0, 1e-3), (1e3, 1.0)])
def test_states_settle_relative_to_the_largest_of_each_coordinate(q, w):
    """Both halve their distance from a state of any size turn by turn, and are close alike."""
    states = [(Ball(q * (1.0 + 0.5**k)), Ball(w * (1.0 + 0.5**k))) for k in range(80)]
    trail = Made(states=states, symbols=[1.0] * 80, impacts=[])
    found = after_rest._until_it_repeats(Made(trail=trail), 1.0)
    assert found.kind == after_rest.SETTLED
    assert abs(found.turns + log2(2.0 * after_rest.CLOSE)) <= 2.0


@pytest.mark.parametrize(("num", "refused"), [(2_500_000, False), (2_500_001, True)])
def test_motions_of_classify_are_speeds_times_all_starts(num, refused):
    """The scene's start and three more at each speed: ten million at most."""
    values = {"classify.rpm": {"start": 600.0, "stop": 700.0, "num": num}, "classify.starts": 3}
    if not refused:
        assert camcli.load_scene(None, values).classify.starts == 3
        return
    with pytest.raises(camcli.SceneError, match="10000004 motions"):
        camcli.load_scene(None, values)


@pytest.mark.parametrize(
    ("low", "high", "digits", "words"),
    [
        (198.55, 198.6, 10, "198.55 to 198.60"),
        (660.0, 760.0, 10, "660 to 760"),
        (-12.3456, 250.0, 4, "-12.3 to 250.0"),  # 4 digits of 250 leave one decimal
        (-0.7074, 14.32, 4, "-0.71 to 14.32"),
        (-0.001, 14.3, 4, "0.0 to 14.3"),
        (700.0, 700.0, 10, "700"),
        (1e-9, 1.0, 10, "1e-09 to 1"),
    ],
)
def test_both_ends_of_a_range_have_as_many_decimals(low, high, digits, words):
    assert number_range(low, high, digits) == words
