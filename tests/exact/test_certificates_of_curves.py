"""Certificates of curves: the statement, its checker, and what it refuses.

The judge of numbers is mpmath, which knows nothing of the package: at a value of one number it
solves for the other one, at which the orbit has its bifurcation.
"""

import json
from copy import deepcopy
from math import tau
from random import Random
from types import SimpleNamespace

import pytest
from flint import arb, arb_mat
from mpmath import mp, mpf

import camcli
from camcli import check
from camcli.cams.formula import formula_of
from camcli.scene import load_scene
from tests.exact.test_certificates import (
    BOX,
    bare,
    both,
    changed,
    drop,
    moved,
    oracle_of,
    put,
    swap,
)
from tests.support import orbit_oracle
from tests.support.followed import Machines, Wave, arcs, at_corner, doubling, event, fold
from tests.support.oracle import Follower
from tests.support.refusals import reasons

pytestmark = pytest.mark.slow
RPM, RESTITUTION = 2, 3  # their places among the unknowns of P(1;1)
DOUBLING = ("period-doubling", ("rpm", 735.0, 745.0), ("follower.restitution", 0.78, 0.82), 738.0)
CORNER = ("corner-impact", ("rpm", 668.0, 682.0), ("cam.nose_radius", 0.149, 0.151), 680.0)
OSCILLATOR = {
    "follower": {"restitution": 0.8},
    "cam": {"kind": "oscillator", "damping": 0.1, "amplitude": 0.6, "frequency": 4,
            "clearance": -0.5},
}  # fmt: skip


def certificate(folder, kind, first, second, rpm=None, scene=None, label="P(1;1)", **more) -> dict:
    """The proof.json of a curve in two numbers, with its own statements only."""
    axes = [dict(zip(("key", "start", "stop"), one, strict=True), num=5) for one in (first, second)]
    changes = {"orbits.vary": axes, "orbits.curve": kind, "orbits.label": label, **more}
    changes |= {"orbits.branches": 0, "orbits.starts": 4, "orbits.stability": "stable"}
    if rpm is not None:
        changes["run.rpm"] = rpm
    camcli.orbits(load_scene(scene, changes), prove=True).save(folder, plot=False)
    content = json.loads((folder / "proof.json").read_text())
    curves = [one for one in content["statements"] if one["kind"] == "curve"]
    return {**content, "statements": curves, "uncovered": []}


@pytest.fixture(scope="module")
def doublings(tmp_path_factory):
    """P(1;1) of the example doubles, in the speed and the restitution."""
    return certificate(tmp_path_factory.mktemp("doublings"), *DOUBLING)


@pytest.fixture(scope="module")
def corners(tmp_path_factory):
    """P(1;1) of the example has its impact at b, in the speed and the nose of the cam."""
    return certificate(tmp_path_factory.mktemp("corners"), *CORNER)


@pytest.fixture(scope="module")
def folds(tmp_path_factory):
    """P(1;1) of an oscillator with a stop that presses turns round, in two numbers of its cam."""
    window = ("cam.amplitude", 0.2, 0.7), ("cam.frequency", 3.8, 4.4)
    return certificate(tmp_path_factory.mktemp("folds"), "fold", *window, scene=OSCILLATOR)


@pytest.fixture(scope="module")
def grazes(tmp_path_factory):
    """P(1;1) of that oscillator touches the stop on its way, in two numbers of its cam."""
    window = ("cam.amplitude", 0.2, 1.4), ("cam.frequency", 4.0, 4.5)
    return certificate(tmp_path_factory.mktemp("grazes"), "grazing", *window, scene=OSCILLATOR)


def pressed(amplitude, frequency) -> Wave:
    """The stop of that oscillator."""
    spring, damper = 1 - frequency**2, mpf(0.1) * frequency
    share = amplitude / (spring**2 + damper**2)
    return Wave(mpf("0.5"), spring * share, damper * share)


def solved(machines, condition, near) -> list:
    """(theta, v, number) of an orbit with one impact at an event: near (theta, v, number, rpm)."""
    theta, v, value, rpm = near
    exact, (phase,) = event(machines, condition, [(theta, v * rpm * mp.pi / 30)], 1, value)
    return [phase, exact]


def doubles_at(z: list, fixed: int, one: dict, cam: dict) -> list | None:
    """(theta, rpm, restitution) where P(1;1) of the example doubles, one number fixed, near z.

    None where that is no motion.
    """
    constants = {**one["constants"], "rpm": "1", "restitution": "1"}
    machine, shape = oracle_of({"constants": constants}, cam)
    known = {"mass": machine.mass, "stiffness": machine.stiffness}
    assert machine.damping == machine.gravity == machine.preload == 0

    def numbers(p) -> tuple:
        return (z[RPM], p) if fixed == RPM else (p, z[RESTITUTION])

    machines = Machines(
        lambda p: {**known, "restitution": numbers(p)[1]}, lambda p: numbers(p)[0],
        lambda p: [shape.arcs[1]],
    )  # fmt: skip
    free = RPM + RESTITUTION - fixed
    phase, exact = solved(machines, doubling, (*z[:2], z[free], z[RPM]))
    rpm, r = numbers(exact)
    machine = machine._replace(restitution=r)
    start = [(phase, z[1] * rpm * mp.pi / 30)]
    found = orbit_oracle.solve(shape, machine, rpm, start, 1)
    near = abs(found.thetas[0] - phase) < mpf("1e-30")
    motion = near and orbit_oracle.admissible(shape, machine, rpm, found)
    return [phase, rpm, r] if motion else None


def doubles_in(box: dict, one: dict, cam: dict) -> bool:
    """Whether P(1;1) doubles in a box, at both ends of it and in the middle."""
    fixed = box["fixed"]
    if fixed not in (RPM, RESTITUTION):
        return False
    middle, tangent, error = (list(map(mpf, box[key])) for key in ("middle", "tangent", "error"))
    for eta in (-mpf(box["half"]), 0, mpf(box["half"])):
        z = [m + t * eta for m, t in zip(middle, tangent, strict=True)]
        found = doubles_at(z, fixed, one, cam)
        if found is None:
            return False
        off = [abs(found[0] - z[0]), *(abs(x - y) for x, y in zip(found[1:], z[2:], strict=True))]
        if any(x > e for x, e in zip(off, (error[0], *error[2:]), strict=True)):
            return False
    return True


def test_a_curve_of_doublings_is_confirmed_and_mpmath_is_on_it(doublings, checked):
    (one,) = doublings["statements"]
    code, text = checked(doublings)
    assert (code, text.splitlines()[-1]) == (0, "1 of 1 statement is confirmed")
    assert text.startswith("confirmed: period-doubling of P(1;1) all along a curve without a gap ")
    assert (one["parameter"], one["second"]) == ("rpm", "restitution")
    with mp.workdps(50):
        assert all(doubles_in(box, one, doublings["cam"]) for box in one["boxes"])
        ends = [
            mpf(one[key]["second"][side]) for key in ("begin", "end") for side in ("low", "high")
        ]
        assert [float(x) for x in ends] == [0.78, 0.78, 0.82, 0.82]


@pytest.mark.ci
def test_a_curve_of_corner_impacts_is_confirmed_and_mpmath_is_on_it(corners, checked):
    """Over a number of the cam, whose corner moves with it."""
    (one,) = corners["statements"]
    assert checked(corners)[0] == 0
    assert (one["event"]["event"], one["second"]) == ("corner-impact", "cam.nose_radius")
    with mp.workdps(50):
        for joint in one["joints"]:
            theta, v, rpm, nose = map(mpf, joint["middle"])
            cam = arcs(nose_radius=lambda p, nose=nose: nose)(0)
            machines = Machines(
                lambda p: {"mass": 1.221, "stiffness": 1430.8}, lambda p: p,
                lambda p, cam=cam: [cam.arcs[1]],
            )  # fmt: skip
            corner = at_corner(0, lambda p, cam=cam: cam.breakpoints[1])
            phase, exact = solved(machines, corner, (theta, v, rpm, rpm))
            assert abs(phase - theta) < mpf("1e-24")
            assert abs(exact - rpm) < mpf("1e-22")


@pytest.mark.ci
def test_a_curve_of_folds_in_two_numbers_of_the_cam_is_confirmed_and_mpmath_is_on_it(
    folds, checked
):
    (one,) = folds["statements"]
    assert checked(folds)[0] == 0
    assert (one["parameter"], one["second"]) == ("cam.amplitude", "cam.frequency")
    with mp.workdps(50):
        for joint in one["joints"][:: len(one["joints"]) // 4]:
            theta, v, amplitude, frequency = map(mpf, joint["middle"])

            machines = Machines(
                lambda p: {"mass": 1, "stiffness": 1, "damping": 0.1},
                lambda p, frequency=frequency: frequency * 30 / mp.pi,
                lambda p, frequency=frequency: [pressed(p, frequency)],
            )  # fmt: skip
            rpm = frequency * 30 / mp.pi
            phase, exact = solved(machines, fold, (theta, v, amplitude, rpm))
            assert abs(phase - theta) < mpf("1e-22")
            assert abs(exact - amplitude) < mpf("1e-22")


@pytest.mark.ci
def test_a_curve_of_grazes_is_confirmed_and_mpmath_is_on_it(grazes, checked):
    """mpmath's own flight comes back to its impact, and touches the stop on its way."""
    (one,) = grazes["statements"]
    assert checked(grazes)[0] == 0
    assert (one["event"]["event"], one["turns"]) == ("grazing", 1)
    with mp.workdps(50):
        small = mpf("1e-20")
        for joint in one["joints"][:: len(one["joints"]) // 4]:
            theta, v, amplitude, frequency, s = map(mpf, joint["middle"])
            stop = pressed(amplitude, frequency)
            follower = Follower.make(mass=1, stiffness=1, damping=0.1)
            c, c1, _ = stop.laws(mp, theta)

            def gap(
                angle,
                c=c,
                c1=c1,
                v=v,
                theta=theta,
                frequency=frequency,
                stop=stop,
                follower=follower,
            ) -> tuple:
                q, speed = follower.flow(angle / frequency, c, frequency * (c1 + v))
                lift, lift1, _ = stop.laws(mp, theta + angle)
                return q - lift, speed / frequency - lift1

            assert max(map(abs, gap(s))) < small
            landed, rate = gap(2 * mp.pi)
            assert abs(landed) < small
            assert abs(mpf(0.8) * rate + v) < small


@pytest.mark.ci
def test_each_thing_that_is_wrong_with_a_graze_is_refused_for_its_reason(
    grazes, doublings, checked
):
    def rises_nowhere(one: dict) -> None:
        """The part that holds the graze is cut where the cam is touched."""
        for box in one["boxes"]:
            touch = float(box["middle"][0]) + float(box["middle"][-1])
            for passage in box["flights"][0]["passages"]:
                here = touch - tau * passage["turn"]
                cuts = sorted([*map(float, passage["cuts"]), here])
                passage["cuts"] = [f"{x:.17f}" for x in cuts]

    def all_in_one(one: dict) -> None:
        """The part that holds the graze reaches from where the gap rises to where it falls."""
        for box in one["boxes"]:
            (flight,) = box["flights"]
            passages = flight["passages"]
            touch = float(box["middle"][0]) + float(box["middle"][-1])
            index = int(touch // tau)
            cuts = passages[index]["cuts"]
            before, behind = (
                sum(len(one["cuts"]) + 1 for one in others)
                for others in (passages[:index], passages[index + 1 :])
            )
            rising = cuts[: max(0, flight["rise"] - before)]
            falling = cuts[len(cuts) - max(0, flight["fall"] - behind) :]
            passages[index]["cuts"] = rising + falling

    for change, why in (
        (all_in_one, "flight 1 may meet the cam on its way"),
        (put("event", "touch", None), "a graze names its flight and its stretch"),
        (
            put("event", "touch", {"stretch": 7, "turn": 0}),
            "a graze names its flight and its stretch",
        ),
        (put("event", "impact", 1), "a graze names its flight and its stretch"),
        (put("event", "side", 1), "a graze names its flight and its stretch"),
        (put("event", "touch", {"stretch": 0, "turn": 7}), "flight 1 may meet the cam on its way"),
        (
            both(put("event", "event", "fold"), put("event", "touch", None)),
            "a box has not one entry for each unknown",
        ),
        (moved("joints", 0, "middle", 4, by="1e-3"), BOX),
        (moved("joints", 0, "middle", 3, by="1e-12"), BOX),
        (rises_nowhere, "flight 1 may meet the cam on its way"),
        (with_a_hole, APART),
    ):
        one = deepcopy(grazes["statements"][0])
        with mp.workdps(60):
            change(one)
        code, text = checked({**grazes, "statements": [one]})
        assert code == 1, change
        assert why in reasons(text)
    one = deepcopy(doublings["statements"][0])
    one["event"]["touch"] = {"stretch": 0, "turn": 0}
    code, text = checked({**doublings, "statements": [one]})
    assert code == 1
    assert "an event has more than its kind needs" in reasons(text)


# -- each thing that the checker asks for, wrong once


def with_a_hole(one: dict) -> None:
    """A box is missing, and one of its joints: both neighbours are what they were."""
    del one["boxes"][1], one["joints"][1]


def across(one: dict) -> None:
    """A joint has the next one's speed: it lies between the boxes in the restitution only."""
    one["joints"][1]["middle"][RPM] = one["joints"][2]["middle"][RPM]


def beside(one: dict) -> None:
    """All joints are one and the same orbit, in all boxes but two another one's."""
    one["joints"] = [deepcopy(one["joints"][0]) for _ in one["joints"]]
    one["end"] = one["begin"]


def along_the_phase(one: dict) -> None:
    """A box leans along the phase, not along a number."""
    (box, *_) = one["boxes"]
    box |= {"fixed": 0}


def closed(one: dict) -> None:
    """The chain is said to come back to where it began."""
    one["end"] = one["begin"]


APART, ELSEWHERE = "neighbouring boxes do not overlap", "an end of the curve may lie elsewhere"
OPEN = "whether this cam has a step is not known over two of its numbers"
NAMED = "a corner impact names its impact and side"
SQUARE = "a matrix has not one row and column for each free unknown"
WRONG = [
    (with_a_hole, APART),
    (across, BOX),
    (beside, APART),
    (along_the_phase, "a box does not lean along its unknown"),
    (closed, ELSEWHERE),
    (swap("boxes"), APART),
    (swap("joints"), APART),
    (drop("joints", 0), "a chain has one joint more than boxes"),
    (drop("boxes", 0), "a chain has one joint more than boxes"),
    (both(put("boxes", []), put("joints", [])), "a chain has one joint more than boxes"),
    (put("event", "event", "fold"), BOX),
    (put("event", "event", "corner-impact"), NAMED),
    (put("event", {"event": "corner-impact", "impact": 0, "side": 1, "touch": None}), BOX),
    (both(put("event", "event", "corner-impact"), put("event", "impact", 9)), NAMED),
    (put("event", "side", 1), "an event has more than its kind needs"),
    (put("event", "impact", 1), "an event has more than its kind needs"),
    (put("label", "P(1;2)"), "its label is P(1;1)"),
    (both(put("parameter", "restitution"), put("second", "rpm")), "the restitution exceeds 1"),
    (put("second", "rpm"), "its parameters are one number"),
    (put("second", "cam.rpm"), "its parameters are one number"),
    (put("second", "cam.offset"), "exactly the parameter has to be left open"),
    (put("second", "cam.lash"), "the cam has no such number"),
    (put("second", "damping"), "exactly the parameter has to be left open"),
    (put("constants", "rpm", "738"), "exactly the parameter has to be left open"),
    (moved("constants", "mass", by="1e-9"), BOX),
    (moved("joints", 0, "middle", RPM, by="1e-15"), BOX),
    (moved("joints", 0, "middle", RESTITUTION, by="1e-15"), BOX),
    (moved("boxes", 0, "middle", RPM, by="1"), BOX),
    (put("boxes", 0, "error", RPM, "0"), BOX),
    (put("boxes", 0, "middle", ["1", "2", "3"]), "a box has not one entry for each unknown"),
    (put("boxes", 0, "inverse", [["1", "0"], ["0", "1"]]), SQUARE),
    (put("boxes", 0, "flights", []), "not every impact has its flight"),
    (moved("begin", "parameter", "high", by="-1"), ELSEWHERE),
    (moved("end", "second", "low", by="1e-9"), ELSEWHERE),
    (put("impacts", 0, "stretch", 1), BOX),
    (put("turns", 2), BOX),
]  # fmt: skip


def test_each_thing_that_is_wrong_is_refused_for_its_reason(doublings, checked):
    for change, why in WRONG:
        one = deepcopy(doublings["statements"][0])
        with mp.workdps(60):
            change(one)
        code, text = checked({**doublings, "statements": [one]})
        assert code == 1, change
        assert why in reasons(text)


def test_numbers_that_are_one_number_of_an_oscillator_are_refused(checked):
    """Its speed is that of its force, and a machine's mass is that of its cam."""
    cam = check.cam_of(formula_of(load_scene(OSCILLATOR).cam), "")
    constants = dict.fromkeys(check.CONSTANTS, 1)
    for names, why in (
        (("cam.frequency", "rpm"), "an oscillator turns as fast as its force"),
        (("cam.frequency", "mass"), "the oscillator has other constants than its cam"),
        (("cam.mass", "mass"), "its parameters are one number"),
    ):
        opened = {**constants, "rpm": None, names[1]: None}
        with pytest.raises(check.RefusedError, match=f"^{why}$"):
            check.left_open(cam, opened, names)


def test_whether_a_cam_of_several_parts_steps_is_not_known_over_two_of_its_numbers(corners, bits):
    """One wave comes back to where it began, whatever its numbers; of arcs that is open."""
    box = SimpleNamespace(hull=[arb("0.15", 1e-9), arb("0.4", 1e-9)])
    arcs_cam = check.cam_of(corners["cam"], "")
    orbit = SimpleNamespace(
        cam=arcs_cam, values=list, parameters=("cam.nose_radius", "cam.base_radius")
    )
    with pytest.raises(check.RefusedError, match=f"^{OPEN}$"):
        check.without_steps(orbit, box)
    wave = formula_of(load_scene(OSCILLATOR).cam)
    names = "cam.amplitude", "cam.frequency"
    orbit = SimpleNamespace(cam=check.cam_of(wave, ""), values=list, parameters=names)
    check.without_steps(orbit, box)
    (whole,) = wave["stretches"]
    for other in ({"wave": [*whole["wave"][:2], "2"]}, {"polynomial": ["1", "0"]}):
        orbit.cam = (
            check.cam_of({**wave, "stretches": [{**whole, **other}]}, "")
            if "wave" in other
            else orbit.cam
        )
        with pytest.raises(check.RefusedError, match=f"^{OPEN}$"):
            check.without_steps(orbit, box)


def repeated(content: dict, times: int, fixed: int | None = None) -> dict:
    """The first orbit of a curve of P(1;1), gone through several times: a chain of this one box.

    fixed: the unknown that the box leans along, where it is another one.
    """
    one = deepcopy(content["statements"][0])
    place, (flight,), joint = one["impacts"][0], one["boxes"][0]["flights"], one["joints"][0]
    again = range(times)
    for key in ("middle", "tangent", "error"):
        joint[key] = joint[key][:2] * times + joint[key][2:]
    joint["fixed"] += 2 * (times - 1)
    joint["error"] = [mp.nstr(100 * mpf(x), 5) for x in joint["error"]]
    joint["inverse"] = []
    if fixed is not None:
        joint["error"][joint["fixed"]], joint["error"][fixed] = "1e-20", "0"
        joint["tangent"][fixed], joint["fixed"] = "1", fixed
        one["begin"] = {  # wide enough for both numbers, none of which is given now
            "parameter": {"low": "700", "high": "800"}, "second": {"low": "0.7", "high": "0.9"}
        }  # fmt: skip
    flights = [
        {**flight, "passages": [{**x, "turn": x["turn"] + k} for x in flight["passages"]]}
        for k in again
    ]
    one |= {
        "turns": times, "impacts": [{**place, "turn": place["turn"] + k} for k in again],
        "label": f"P({times};{':'.join('1' * times)})", "end": one["begin"],
        "joints": [joint, joint], "boxes": [{**joint, "half": "1e-30", "flights": flights}],
    }  # fmt: skip
    size = 2 * times + 1
    orbit = check.orbit_of(check.cam_of(content["cam"], ""), check.statement_of(one, ""))
    for box in (*one["boxes"], *one["joints"]):
        _, slopes = orbit.equations([arb(x) for x in box["middle"]], True)
        free = [k for k in range(size + 1) if k != box["fixed"]]
        inverse = arb_mat([[slopes[i, k] for k in free] for i in range(size)]).mid().inv()
        box["inverse"] = [
            [inverse[i, k].mid().str(20, radius=False).replace("e+", "e") for k in range(size)]
            for i in range(size)
        ]
    return {**content, "statements": [one]}


def test_the_doubling_of_an_orbit_gone_through_three_times_is_not_that_of_a_longer_one(
    doublings, checked, monkeypatch, bits
):
    """Three times the multiplier -1 is -1 too, and the equations are regular: all but the name."""
    content = repeated(doublings, 3)
    code, text = checked(content)
    assert code == 1
    assert "it may be an orbit of 1 turn gone through several times" in reasons(text)
    monkeypatch.setattr(check, "named", check.counted)
    assert checked(content)[0] == 0


def test_a_box_that_leans_along_a_phase_says_nothing_of_the_numbers(
    doublings, checked, monkeypatch, bits
):
    """Where the curve turns round in both numbers the event's function need not cross zero."""
    content = repeated(doublings, 1, fixed=0)
    code, text = checked(content)
    assert code == 1
    assert "a box of a curve leans along a parameter" in reasons(text)


def test_another_multiplier_on_the_unit_circle_is_refused(doublings, checked, monkeypatch):
    """Where an impact loses nothing and nothing damps, both multipliers are -1 at a doubling."""
    own = check.Orbit.trace_det

    def lossless(self, z, times_rates=False) -> tuple:
        trace, det, one = own(self, z, times_rates)
        return trace, det if times_rates else 1 + 0 * det, one

    monkeypatch.setattr(check.Orbit, "trace_det", lossless)
    code, text = checked(doublings)
    assert code == 1
    assert "another multiplier may lie on the unit circle" in reasons(text)


# -- random changes

OF_CHAIN = "boxes", "joints", "begin", "end", "strobe", "constants"  # the label: at any strobe


def lifts(cam: dict) -> list[float]:
    """The lift of a cam at many angles, by the formulas of its certificate."""
    found = []
    for one in check.cam_of(cam, "").stretches:
        for k in range(20):
            phase = one.start + (one.end - one.start) * k / 20
            found.append(float(one.derivatives(phase, 0)[0]))
    return found


def still_true(content: dict, before: dict) -> bool:
    """Whether a changed certificate of doublings states the truth, by mpmath."""
    if bare(content) == bare(before):
        return True
    (one,), (old,) = content["statements"], before["statements"]
    said = [{key: x for key, x in each.items() if key not in OF_CHAIN} for each in (one, old)]
    if said[0] != said[1]:
        return False
    if content["cam"]["numbers"] == before["cam"]["numbers"]:
        heights = [lifts(each["cam"]) for each in (content, before)]
        if any(abs(a - b) > 1e-12 for a, b in zip(*heights, strict=True)):
            return False
    boxes = *one["boxes"], *one["joints"]
    if not all(doubles_in(box, one, content["cam"]) for box in boxes):
        return False
    for key, k in (("begin", 0), ("end", -1)):
        z = list(map(mpf, one["joints"][k]["middle"]))
        found = doubles_at(z, RESTITUTION, one, content["cam"])
        if found is None:
            return False
        for value, there in zip(found[1:], one[key].values(), strict=True):
            if not mpf(there["low"]) <= value <= mpf(there["high"]):
                return False
    return True


def refuse(checked, before: dict, seed: int, count: int) -> int:
    """Change a certificate so many times; how many of them were refused."""
    rng, refused = Random(seed), 0
    with mp.workdps(60):
        for _ in range(count):
            after, what = changed(before, rng)
            code, text = checked(after)
            assert code in (0, 1, 2, 3)
            assert "Traceback" not in text
            if code == 0:
                assert still_true(after, before), (seed, what)
            refused += code != 0
    return refused


@pytest.mark.soak
def test_a_hundred_random_changes_are_refused_unless_the_statement_is_still_true(
    doublings, checked
):
    assert refuse(checked, doublings, seed=40, count=100) >= 60


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(8))
def test_so_are_a_thousand_others(doublings, checked, seed):
    assert refuse(checked, doublings, seed=seed, count=125) >= 70
