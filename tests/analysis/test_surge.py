"""Spring surge: harmonics of the cam against quadrature, the spring's frequency against a chain."""

from functools import cache
from itertools import pairwise
from math import pi, sqrt

import numpy as np
import pytest
from mpmath import mp

import camcli
from camcli.analysis.surge import fourier, own_frequency
from camcli.api.machine import machine_of
from camcli.errors import SceneError
from camcli.scene import resolved, scene_hash
from tests.support.law_oracle import LAWS
from tests.support.looks import hold_to_the_sheet
from tests.support.machines import ECCENTRIC, TABLE, VALVE
from tests.support.picture_reader import Panel

SPRING = {"mass": 0.06}
SCENE = {
    **VALVE.scene,
    "spring": SPRING,
    "detach": {"rpm": {"start": 2500, "stop": 3000, "num": 3}},
}


@cache
def detached():
    """What detach finds of it."""
    return camcli.detach(camcli.load_scene(SCENE))


def quadrature(parts, n):
    """(a_n, b_n) of a function of theta (rad) in parts (begin, end, function), at 30 digits."""
    with mp.workdps(30):
        found = [
            sum(mp.quad(lambda x, f=f, g=g: f(x) * g(n * x), [a, b]) for a, b, f in parts) / mp.pi
            for g in (mp.cos, mp.sin)
        ]
        return [float(value) for value in found]


def arcs():
    """The default cam, in mpmath; the lobe is symmetric about 180 deg."""
    k1, k2, nose = mp.mpf("0.45"), mp.mpf("0.40393320723821"), mp.mpf("0.15")
    rho = mp.mpf("0.4") + k1

    # the centres and the axis make a triangle, from which the base circle ends near 90 deg
    reach = rho - nose
    begin = 8 * mp.pi / 9 - mp.pi + mp.acos((k1**2 + k2**2 - reach**2) / (2 * k1 * k2))

    def flank(x):
        y = x - begin
        return -k1 * mp.cos(y) + mp.sqrt(rho**2 - k1**2 * mp.sin(y) ** 2) - mp.mpf("0.3")

    def tip(x):
        y = 8 * mp.pi / 9 - x
        return k2 * mp.cos(y) + mp.sqrt(nose**2 - k2**2 * mp.sin(y) ** 2) - mp.mpf("0.3")

    angle = mp.acos((k1**2 + reach**2 - k2**2) / (2 * k1 * reach))
    meet = mp.atan2(rho * mp.sin(angle), rho * mp.cos(angle) - k1) + begin
    edges = [mp.mpf(0), begin, meet, 8 * mp.pi / 9, 10 * mp.pi / 9]
    edges += [2 * mp.pi - meet, 2 * mp.pi - begin, 2 * mp.pi]
    mirrored = [lambda x, f=f: f(2 * mp.pi - x) for f in (tip, flank)]
    base, top = (lambda x: mp.mpf("0.1")), (lambda x: k2 + nose - mp.mpf("0.3"))
    functions = [base, flank, tip, top, *mirrored, base]
    return list(zip(edges, edges[1:], functions, strict=False))


def law(name):
    """VALVE with another law: rise from 100 over 70 deg, dwell, fall from 190 over 60 deg."""
    own = LAWS[name]
    deg = mp.pi / 180
    parts = [(170 * deg, 190 * deg, lambda x: mp.mpf(0.010))]
    joints = list(own.joints)
    for a, b in pairwise(joints):
        middle = (a + b) / 2

        def height(x, middle=middle):
            return own._at(next(z for z in own.zones if z[0] <= middle < z[1]), x)[1] * own.scale

        rise = lambda x, h=height: mp.mpf(0.010) * h((x / deg - 100) / 70)  # noqa: E731
        fall = lambda x, h=height: mp.mpf(0.010) * (1 - h((x / deg - 190) / 60))  # noqa: E731
        parts += [((100 + 70 * a) * deg, (100 + 70 * b) * deg, rise)]
        parts += [((190 + 60 * a) * deg, (190 + 60 * b) * deg, fall)]
    return parts


def cam_of(name):
    motion = {"length_deg": 60, "law": name}
    rise = {"start_deg": 100, "length_deg": 70, "law": name}
    return {**VALVE.scene["cam"], "rise": rise, "fall": motion}


@pytest.mark.parametrize("name", ["arcs", "modified-sine"])
def test_harmonics_are_those_of_quadrature_at_30_digits(name):
    if name == "arcs":
        system, lift = machine_of(None).system, 0.154
    else:
        system, lift = machine_of({**VALVE.scene, "cam": cam_of(name)}).system, 0.010
    with mp.workdps(30):
        parts = arcs() if name == "arcs" else law(name)
        for n, found in zip((1, 12), fourier(system.cam, (1, 12)), strict=True):
            assert found == pytest.approx(quadrature(parts, n), abs=2e-17 * lift, rel=1e-14), n


def test_harmonics_of_an_eccentric_and_of_a_table():
    system = machine_of(ECCENTRIC.load()).system
    first, second, last = fourier(system.cam, (1, 2, 40))
    assert first == pytest.approx((-0.01, 0.0), abs=1e-18)
    assert np.abs([second, last]).max() < 1e-18
    system = machine_of(TABLE.load()).system
    phase = np.linspace(0.0, 360.0, 72_001)[:-1]
    lift = TABLE.cam.lift(phase)[0]
    for n, found in zip((1, 4, 9), fourier(system.cam, (1, 4, 9)), strict=True):
        wanted = [2.0 * np.mean(lift * f(n * np.radians(phase))) for f in (np.cos, np.sin)]
        assert found == pytest.approx(wanted, abs=5e-7)


def test_the_frequency_of_a_spring_is_that_of_a_chain_of_masses():
    """Fixed at both ends: 400 equal masses on 401 springs."""
    links, k, mass = 401, 40_000.0, 0.06
    stiff = k * links * (2.0 * np.eye(400) - np.eye(400, k=1) - np.eye(400, k=-1))
    slowest = sqrt(np.linalg.eigvalsh(stiff)[0] / (mass / links)) / (2.0 * pi)
    assert own_frequency(k, mass) == pytest.approx(slowest, rel=1e-5)


def test_a_third_of_the_spring_moves_with_the_follower_once():
    scene = camcli.load_scene(SCENE)
    assert scene.follower.mass == pytest.approx(0.12 + 0.02)
    assert machine_of(scene).system.follower.mass == scene.follower.mass
    again = camcli.load_scene(resolved(scene))
    assert again.follower.mass == scene.follower.mass
    assert scene_hash(again) == scene_hash(scene)
    held = camcli.load_scene({**SCENE, "spring": {**SPRING, "in_follower": True}})
    assert held.follower.mass == 0.12
    loads = {"seat_load": 250.0, "nose_load": 650.0, "mass": 0.06}
    follower = {k: v for k, v in SCENE["follower"].items() if k not in ("stiffness", "preload")}
    scene = camcli.load_scene({**SCENE, "follower": follower, "spring": loads})
    assert (scene.spring.mass, scene.follower.mass) == (0.06, pytest.approx(0.14))


@pytest.mark.ci
def test_detach_has_the_harmonics_that_meet_the_spring():
    result = detached()
    table, found = result.tables["surge"], result.summary["surge"]
    hertz = 0.5 * sqrt(40_000.0 / 0.06)
    assert found["frequency_hz"] == pytest.approx(hertz)
    n, amplitude = (np.array(table[name]) for name in ("harmonic", "amplitude_m"))
    assert n.tolist() == list(range(1, 41))
    assert table["rpm"] == pytest.approx(60.0 * hertz / n)
    assert table["resonance_factor"] == pytest.approx(n * n * amplitude / 0.0254)
    phase = np.linspace(0.0, 360.0, 36_001)[:-1]
    series = np.fft.rfft(VALVE.cam.lift(phase)[0])
    assert amplitude == pytest.approx(2.0 / 36_000 * np.abs(series[1:41]), abs=1e-10)
    strong = n[np.array(table["resonance_factor"]) > 0.12]
    assert sorted(one["harmonic"] for one in found["strong"]) == strong.tolist()
    (words,) = found["words"]
    assert "surge itself is not simulated" in words
    assert words.endswith("and that the limit counts in inches is inferred, not published")
    below = [one for one in found["strong"] if one["rpm"] < 2678.0]
    assert f"harmonic {below[0]['harmonic']} meets it at {below[0]['rpm']:.4g} rpm" in words
    worst = max(below, key=lambda one: one["factor"])
    strongest = f"harmonic {worst['harmonic']} at {worst['rpm']:.4g} rpm."
    assert result.verdict[1].startswith("What gives first may be surge")
    assert result.verdict[1].endswith(strongest)
    told = result.verdict_details[0]
    lowest = min(one["rpm"] for one in below)
    assert f"{len(below)} harmonics of the cam over the usual 0.12 meet" in told
    assert f"from {lowest:.0f} rpm; the strongest is {worst['harmonic']}, at " in told


def test_the_chart_has_a_line_for_each_harmonic_and_the_limit():
    result = detached()
    axes = camcli.plot(result, panels=["surge"]).axes[1]
    hold_to_the_sheet("surge", Panel("surge", axes).looks)
    table = result.tables["surge"]
    lines = {
        round(float(a.get_xdata()[0]), 6): float(a.get_ydata()[1])
        for a in axes.lines
        if len(a.get_xdata()) == 2 and a.get_xdata()[0] == a.get_xdata()[1] > 1.0
        and a.get_ydata()[0] == 0.0 and a.get_label().startswith("_")
    }  # fmt: skip
    shown = np.array(table["rpm"]) <= 1.25 * 3000.0
    assert lines == {
        round(rpm, 6): factor
        for rpm, factor in zip(
            np.array(table["rpm"])[shown], np.array(table["resonance_factor"])[shown], strict=True
        )
    }
    assert any(list(a.get_ydata()) == [0.12, 0.12] for a in axes.lines)
    assert axes.get_title(loc="right") == "spring of 408.2 Hz"


def test_numbers_stand_at_the_strongest_harmonics_of_their_neighbourhood():
    result = detached()
    table = result.tables["surge"]
    factors = dict(zip(table["harmonic"], table["resonance_factor"], strict=True))
    places = dict(zip(table["harmonic"], table["rpm"], strict=True))
    shown = [n for n, rpm in places.items() if rpm <= 1.25 * 3000.0]
    for width in (60.0, 85.0, 170.0):
        axes = camcli.plot(result, panels=["surge"], width=width).axes[1]
        named = {int(a.get_text()): a.xy for a in axes.texts if a.get_text()}
        assert max(shown, key=factors.get) in named
        for n, (rpm, factor) in named.items():
            assert (rpm, factor) == pytest.approx((places[n], factors[n]))
        for n in set(shown) - set(named):  # it gives way to a stronger one, and that is near
            near = min((m for m in named if factors[m] >= factors[n]),
                       key=lambda m: abs(places[m] - places[n]))  # fmt: skip
            assert abs(places[near] - places[n]) < 0.1 * (170.0 / width) * np.ptp(axes.get_xlim())


def test_without_a_mass_nothing_is_computed():
    few = {"detach.rpm": {"start": 1000, "stop": 1000, "num": 1}}
    result = camcli.detach(camcli.load_scene({**SCENE, "spring": None}, few))
    assert "surge" not in result.tables
    assert "surge" not in result.summary


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"spring": {"mass": 0.0}}, "greater than 0"),
        ({"spring": {"in_follower": True}}, "in_follower without mass"),
        ({"follower.stiffness": 0.0}, "a mass of a spring"),
        ({"spring": {"mass": "60 g"}}, "60 g"),
    ],
)
def test_a_spring_without_sense_is_refused(values, told):
    with pytest.raises(SceneError) as fault:
        camcli.load_scene(SCENE, values)
    assert told in str(fault.value)
    assert len(fault.value.faults) == 1
