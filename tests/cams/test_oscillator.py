"""`kind: oscillator` against the oscillator itself, in its own coordinate x.

The oracle here knows no cam: between impacts x is the steady motion and a decaying oscillation in
closed form, in 30 digits; a step of a thousandth of a period finds where x passes the clearance.
"""

from __future__ import annotations

from math import pi

import mpmath
import numpy as np
import pytest

import camcli
from camcli.api import family
from camcli.api.machine import machine_of
from camcli.errors import SceneError
from camcli.scene import load_scene, resolved, scene_hash

MACHINES = [  # mass, stiffness, damping, amplitude, frequency, clearance, restitution
    (1.0, 1.0, 0.1, 1.0, 1.0, 1.0, 0.8),
    (1.0, 1.0, 0.0, 1.0, 2.6, 0.0, 0.8),
    (2.5, 40.0, 1.5, 30.0, 3.1, -0.3, 0.6),
    (0.2, 7.0, 0.3, 4.0, 9.0, 0.05, 0.9),
    (1.0, 1.0, 3.0, 5.0, 0.8, 0.4, 0.7),
]
IMPACTS = 12


def scene_of(mass, stiffness, damping, amplitude, frequency, clearance, restitution, **more):
    """The machine as a scene that starts at once."""
    cam = {
        "kind": "oscillator", "mass": mass, "stiffness": stiffness, "damping": damping,
        "amplitude": amplitude, "frequency": frequency, "clearance": clearance,
    }  # fmt: skip
    run = {"transient": 0, "record": 40, **more.pop("run", {})}
    return load_scene({"cam": cam, "follower": {"restitution": restitution}, "run": run, **more})


def steady(mass, stiffness, damping, amplitude, frequency):
    """p(t), the motion without a stop, and its derivative: by a complex amplitude."""
    mp = mpmath.mp
    response = amplitude / mp.mpc(stiffness - mass * mp.mpf(frequency) ** 2, damping * frequency)

    def p(t):
        return mp.re(response * mp.expj(frequency * t))

    def velocity(t):
        return mp.re(1j * frequency * response * mp.expj(frequency * t))

    return p, velocity


def impacts(machine, x, v):
    """(t, speed at the stop) of the first impacts from x and v at t = 0."""
    mass, stiffness, damping, amplitude, frequency, clearance, restitution = map(
        mpmath.mpf, machine
    )
    p, p_dot = steady(mass, stiffness, damping, amplitude, frequency)
    decay = damping / (2 * mass)
    root = mpmath.sqrt(mpmath.mpc(decay**2 - stiffness / mass))  # of m s^2 + b s + k = 0
    step = 2 * mpmath.pi / frequency / 1000
    t, found = mpmath.mpf(0), []
    while len(found) < IMPACTS:
        y, w = x - p(t), v - p_dot(t)
        if abs(root) < 1e-20:
            raise ValueError("a critically damped machine is not among these")
        first = (w + (decay + root) * y) / (2 * root)
        second = y - first

        def flight(s, start=t, first=first, second=second):
            free = first * mpmath.exp((root - decay) * s) + second * mpmath.exp(-(root + decay) * s)
            return mpmath.re(free) + p(start + s)

        low = step / 1000
        high = step
        while flight(high) < clearance:
            low, high = high, high + step
        landed = mpmath.findroot(lambda s: flight(s) - clearance, (low, high), solver="anderson")
        speed = mpmath.diff(flight, landed)
        t += landed
        found.append((t, speed))
        x, v = clearance, -restitution * speed
    return found


@pytest.mark.parametrize("machine", MACHINES)
def test_the_impacts_are_those_of_the_oscillator(machine):
    mass, stiffness, damping, amplitude, frequency, clearance, _ = machine
    p, p_dot = steady(mass, stiffness, damping, amplitude, frequency)
    with mpmath.workdps(30):
        x, v = mpmath.mpf(clearance) - 2, mpmath.mpf("0.3")
        start = {"q": float(p(0) - x), "v": float(p_dot(0) - v), "theta_deg": 0.0}
        expected = impacts(
            machine, p(0) - mpmath.mpf(start["q"]), p_dot(0) - mpmath.mpf(start["v"])
        )
    events = camcli.simulate(scene_of(*machine, run={"start": start})).tables["events"]
    hits = np.flatnonzero(events["event"] == "impact")[:IMPACTS]
    turns = events["period"][hits] + events["theta_deg"][hits] / 360.0
    times = turns * 2 * np.pi / frequency
    assert times == pytest.approx([float(t) for t, _ in expected], rel=1e-10)
    speeds = [float(speed) for _, speed in expected]
    assert -events["u_minus_m_per_s"][hits] == pytest.approx(speeds, rel=1e-9)
    heights = [float(p(t)) - clearance for t, _ in expected]  # q = p - x with x at the stop
    assert events["q_m"][hits] == pytest.approx(heights, rel=1e-9, abs=1e-10)


def test_the_impact_velocity_that_another_program_publishes():
    """COCO's impact oscillator (k 1, c 0.1, A 1, w 1, clearance 1, e 0.8): 1.69573293759488."""
    scene = scene_of(1.0, 1.0, 0.1, 1.0, 1.0, 1.0, 0.8, run={"transient": 600, "record": 1})
    events = camcli.simulate(scene).tables["events"]
    assert -events["u_minus_m_per_s"] == pytest.approx([1.69573293759488], rel=1e-13)


def test_the_stop_is_reached_where_the_free_amplitude_is_the_clearance():
    """At resonance the amplitude is A/(b w) = 10 A; it grazes the clearance 1 at A = 0.1."""
    vary = [{"key": "cam.amplitude", "start": 0.0999, "stop": 0.1001, "num": 2}]
    scene = scene_of(
        1.0, 1.0, 0.1, 1.0, 1.0, 1.0, 0.8, sweep={"vary": vary}, run={"transient": 600}
    )
    free, touching = camcli.sweep(scene).tables["speeds"]["impacts"]
    assert free == 0
    assert touching > 0


def test_a_damping_ratio_is_a_damping():
    cam = {
        "kind": "oscillator", "mass": 2.0, "stiffness": 8.0, "damping_ratio": 0.05,
        "frequency": 1.5, "clearance": 0.2,
    }  # fmt: skip
    scene = load_scene({"cam": cam, "follower": {"restitution": 0.8}})
    assert scene.follower.damping == pytest.approx(2 * 0.05 * 4.0, rel=1e-15)
    assert (scene.follower.mass, scene.follower.stiffness) == (2.0, 8.0)
    assert scene.run.rpm == pytest.approx(1.5 * 30 / np.pi, rel=1e-15)


def test_a_frequency_that_is_varied_is_the_scene_at_that_frequency():
    vary = [{"key": "cam.frequency", "start": 0.9, "stop": 1.3, "num": 3}]
    rows = camcli.sweep(scene_of(*MACHINES[0], sweep={"vary": vary}, run={"transient": 50}))
    for k, frequency in enumerate((0.9, 1.1, 1.3)):
        machine = (*MACHINES[0][:4], frequency, *MACHINES[0][5:])
        one = {"vary": [{"key": "follower.restitution", "start": 0.8, "stop": 0.8, "num": 1}]}
        alone = camcli.sweep(scene_of(*machine, sweep=one, run={"transient": 50}))
        column = "max_impact_m_per_s"
        assert rows.tables["speeds"][column][k] == alone.tables["speeds"][column][0]


def test_without_a_range_the_frequency_is_varied_around_its_own():
    scene = scene_of(*MACHINES[0])
    (axis,) = scene.sweep.vary
    assert (axis.key, axis.start, axis.stop) == ("cam.frequency", 0.8, 1.2)


def test_the_full_scene_is_the_same_scene_again():
    scene = scene_of(*MACHINES[2])
    again = load_scene(resolved(scene))
    assert scene_hash(again) == scene_hash(scene)
    assert again.follower == scene.follower
    assert again.run.rpm == scene.run.rpm


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"follower.mass": 2.0}, "found mass beside an oscillator"),
        ({"run.rpm": 20.0}, "found rpm beside an oscillator"),
        ({"sweep.rpm.start": 5.0}, "found a range of speeds for an oscillator"),
        ({"orbits.at": 20.0}, "found 20.0 rpm for an oscillator"),
        ({"spring": {"rate": 2.0, "preload": 1.0}}, "beside an oscillator"),
        ({"orbits.vary": [{"key": "rpm", "start": 5, "stop": 9}]}, "found rpm beside"),
        ({"sweep.vary": [{"key": "follower.mass", "start": 1, "stop": 2}]}, "found follower.mass"),
        ({"cam.damping": 0.0}, "without damping the oscillator has no steady motion"),
        ({"cam.damping_ratio": 0.1}, "found damping and damping_ratio"),
        ({"cam.damping": 1e-9, "cam.amplitude": 1e3}, "high: at most 1e6 m"),
    ],
)
def test_what_contradicts_an_oscillator_is_refused(change, found):
    scene = resolved(scene_of(*MACHINES[0]))
    with pytest.raises(SceneError) as refused:
        load_scene(scene, change)
    (fault,) = refused.value.faults
    assert found in fault.found


@pytest.mark.parametrize("command", ["detach", "explore"])
def test_commands_about_one_cam_at_many_speeds_refuse_an_oscillator(command):
    with pytest.raises(SceneError, match="an oscillator, whose cam changes with its speed"):
        getattr(camcli, command)(scene_of(*MACHINES[0]))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("mass", 1.75),
        ("stiffness", 33.0),
        ("damping", 2.25),
        ("frequency", 4.5),
        ("amplitude", 9.0),
    ],
)
def test_a_member_of_a_family_is_the_machine_of_a_scene_with_that_constant(name, value):
    names = ["mass", "stiffness", "damping", "amplitude", "frequency", "clearance", "restitution"]
    own = dict(zip(names, MACHINES[0], strict=True))
    machine = machine_of(scene_of(**own))
    cam = machine.scene.cam.model_copy(update={name: value})
    system, rpm = family._on(machine, cam, 0.0)
    wanted = machine_of(scene_of(**{**own, name: value}))
    assert system.follower == wanted.system.follower
    assert rpm == wanted.scene.run.rpm
    known = {**own, name: value}
    assert system.follower.damping == known["damping"]
    assert system.follower.mass == known["mass"]
    assert rpm == pytest.approx(known["frequency"] * 30.0 / pi, rel=1e-15)
