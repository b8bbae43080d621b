"""Certificates of proofs, and the checker that confirms or refuses what they state.

The judge of a changed certificate is mpmath at 60 digits (`tests.support.orbit_oracle`): whether
the orbit, with the numbers that the certificate now has, still lies where it says.
"""

import json
import re
import subprocess
import sys
from copy import deepcopy
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from random import Random
from time import monotonic
from types import SimpleNamespace

import pytest
from flint import arb, arb_mat
from mpmath import mp, mpf

import camcli
from camcli import check
from camcli.analysis.orbits import certificate as module
from camcli.cams.formula import formula_of
from camcli.scene import load_scene
from tests.support import orbit_oracle
from tests.support.oracle import ArcsCam, Flight
from tests.support.refusals import reasons

pytestmark = pytest.mark.slow
UPPER = {"orbits.rpm.start": 672.0, "orbits.rpm.stop": 741.0, "orbits.rpm.num": 21,
         "orbits.label": "P(1;1)", "orbits.branches": 0, "orbits.starts": 0}  # fmt: skip
WORDS = ("P(1;1)", "P(1;2)", "P(2;1:1)", "orbit", "branch", "fold", "period-doubling",
         "corner-impact", "rpm", "mass", "restitution")  # fmt: skip
AUXILIARY = ("inverse", "flights")  # what a statement does not say, but rests on


def certificate(folder: Path, **changes) -> dict:
    """The content of the proof.json of a run."""
    result = camcli.orbits(load_scene(None, {k.replace("__", "."): v for k, v in changes.items()}),
                           prove=True)  # fmt: skip
    result.save(folder, plot=False)
    return json.loads((folder / "proof.json").read_text())


@pytest.fixture(scope="module")
def upper(tmp_path_factory):
    """The certificate of P(1;1) from its corner impact beyond its doubling, and at 700 rpm."""
    return certificate(tmp_path_factory.mktemp("upper"), **UPPER)


def only(content: dict, *kinds: str) -> dict:
    """The certificate with the statements of these kinds only."""
    statements = [one for one in content["statements"] if one["kind"] in kinds]
    return {**content, "statements": statements}


def test_every_statement_of_a_run_is_confirmed(upper, checked):
    code, text = checked(upper)
    kinds = [one["kind"] for one in upper["statements"]]
    counts = kinds.count("orbit"), kinds.count("branch"), kinds.count("attractor")
    assert (code, counts) == (0, (2, 3, 1))
    assert text.count("\nconfirmed: ") + text.startswith("confirmed: ") == len(kinds)
    assert upper["uncovered"] == []


@pytest.mark.soak
def test_the_branches_of_the_example_are_confirmed_within_a_minute(checked, tmp_path):
    """All that `cam orbits --prove` says of the example, and P(3;3:3:2) from fold to doubling."""
    three = {"orbits.label": "P(3;3:3:2)", "orbits.at": 358.5, "orbits.rpm.start": 357.0,
             "orbits.rpm.stop": 362.0, "orbits.rpm.num": 11, "orbits.branches": 0}  # fmt: skip
    for values, least in (({}, 12), (three, 9)):
        content = certificate(tmp_path / "out", **values)
        begun = monotonic()
        code, text = checked(content)
        assert code == 0, text
        assert monotonic() - begun < 60
        assert len(content["statements"]) >= least
        assert content["uncovered"] == []


FOLLOWER = {"mass": 1.0, "stiffness": 100.0, "preload": 20.0, "restitution": 0.7}
BALL = {"mass": 1.0, "stiffness": 0.0, "gravity": 9.81, "damping": 0.5, "restitution": 0.5}


def law(rise, fall="3-4-5", start=60.0):
    motions = {"rise": {"start_deg": start, "length_deg": 80.5, "law": rise},
               "fall": {"length_deg": 90.0, "law": fall}}  # fmt: skip
    return {"kind": "law", "base": 0.1, "lift": 0.05, "top_dwell_deg": 20.0, **motions}


KINKED = {"orbits.rpm.start": 215.0, "orbits.rpm.stop": 265.0, "orbits.rpm.num": 11,
          "orbits.at": 250.0, "orbits.starts": 0, "orbits.branches": 0,
          "orbits.label": "P(1;2)"}  # fmt: skip
SLOW = "a measured cam", "weak damping", "a ball in air", "widths of one's own"
MACHINES = {  # scene and speed
    "widths of one's own": (FOLLOWER, law({"scca": {"b": 0.3, "c": 0.2, "d": 0.5}}), 250.0),
    "jumps of the slope": (FOLLOWER, law("constant-velocity", "harmonic"), 250.0),
    "a lobe through zero": (FOLLOWER, law("cycloidal", "modified-sine", 310.0), 400.0),
    "weak damping": ({**FOLLOWER, "damping": 5.0}, law("modified-trapezoid"), 400.0),
    "critical": ({**FOLLOWER, "damping": 20.0}, law("4-5-6-7"), 400.0),
    "strong damping": ({**FOLLOWER, "damping": 60.0}, law("constant-acceleration"), 400.0),
    "a ball in air": (BALL, {"kind": "eccentric", "base": 0.0, "lift": 0.02}, 350.0),
    "an oscillator": ({"restitution": 0.8}, {"kind": "oscillator", "damping_ratio": 0.02,
                                             "frequency": 2.8, "clearance": 0.0}, None),
    "a measured cam": ({"mass": 1.221, "stiffness": 1430.8, "damping": 0.0, "preload": 15.0},
                       None, 1200.0),
}  # fmt: skip


@pytest.mark.parametrize(
    "name", [pytest.param(x, marks=pytest.mark.soak) if x in SLOW else x for x in MACHINES]
)
def test_every_kind_of_cam_and_of_damping_has_its_certificate(name, checked, tmp_path):
    follower, cam, rpm = MACHINES[name]
    section = {"orbits.starts": 0, "orbits.branches": 0}
    if rpm:
        section |= {"orbits.rpm.start": 0.999 * rpm, "orbits.rpm.stop": 1.001 * rpm,
                    "orbits.rpm.num": 3, "orbits.at": rpm}  # fmt: skip
    if cam is None:
        numbers = {f"follower.{key}": value for key, value in follower.items()}
        scene = load_scene("configs/lift-table.yaml", section | numbers)
    else:
        scene = load_scene({"follower": follower, "cam": cam}, section)
    result = camcli.orbits(scene, prove=True)
    result.save(tmp_path / "out", plot=False)
    code, text = checked((tmp_path / "out/proof.json").read_text())
    assert code == 0, text
    assert text.startswith("confirmed: P(1;")
    if name == "a measured cam":  # a step up behind the impact, which the follower would meet
        content = json.loads((tmp_path / "out/proof.json").read_text())
        after = content["statements"][0]["impacts"][0]["stretch"] + 1
        level = content["cam"]["stretches"][after]["polynomial"]
        level[0] = str(float(level[0]) + 0.01)
        code, text = checked(content)
        assert code == 1
        assert "flight 1 may meet an edge of the cam" in reasons(text)


@pytest.mark.ci
def test_a_corner_impact_where_the_slope_jumps_has_no_signs(checked, tmp_path):
    """Behind the kink the same impact would leave the cam at another rate: no map to compare."""
    scene = {"follower": FOLLOWER, "cam": law("constant-velocity", "harmonic")}
    result = camcli.orbits(load_scene(scene, KINKED), prove=True)
    result.save(tmp_path / "out", plot=False)
    content = json.loads((tmp_path / "out/proof.json").read_text())
    corners = [one for one in content["statements"] if one["kind"] == "event"
               and one["event"]["event"] == "corner-impact"]  # fmt: skip
    content["statements"] = [one for one in corners if not one["signs"]]
    assert content["statements"]
    assert checked(content)[0] == 0
    for one in content["statements"]:
        one["signs"] = [1, 1]
    code, text = checked(content)
    assert code == 1
    assert "where the slope of the cam jumps a corner impact has no signs" in reasons(text)


def test_the_checker_runs_alone_where_camcli_cannot_be_imported(cam, tmp_path):
    cam("orbits --rpm 700 --label P(1;1) --prove --with-checker --no-plot -o out", code=0)
    alone = "import sys, runpy; sys.modules['camcli'] = None; sys.argv = sys.argv[1:]; "
    alone += "runpy.run_path('out/check.py', run_name='__main__')"
    words = [sys.executable, "-c", alone, "check.py", "out/proof.json"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.endswith("3 of 3 statements are confirmed\n")
    assert (tmp_path / "out/check.py").read_bytes() == Path(check.__file__).read_bytes()


@pytest.mark.parametrize("true", [True, False])
def test_who_reads_no_line_has_the_exit_code(upper, tmp_path, true):
    """As behind `| head -0`: the pipe is closed before the first line is printed."""
    content = only(upper, "orbit")
    if not true:
        content = {**content, "statements": [{**content["statements"][0], "stable": False}]}
    (tmp_path / "proof.json").write_text(json.dumps(content))
    words = [sys.executable, check.__file__, "proof.json"]
    with subprocess.Popen(
        words, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as run:
        run.stdout.close()
        said = run.stderr.read()
    assert (run.returncode, said) == (0 if true else 1, b"")


# -- changed certificates


def leaves(value, path=()):
    """The path of every value of a certificate, those of objects and lists included."""
    yield path
    if isinstance(value, dict | list):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from leaves(value[key], (*path, key))


def at(content, path):
    for key in path:
        content = content[key]
    return content


def name_of(path) -> str:
    """The last key of an object on a path."""
    return next((key for key in reversed(path) if isinstance(key, str)), "")


def changed(content: dict, rng: Random) -> tuple[dict, str]:
    """A certificate in which one thing is another, and what that is."""
    content = deepcopy(content)
    paths = [path for path in leaves(content) if path]
    chosen = rng.choice(sorted({name_of(path) for path in paths}))
    path = rng.choice([path for path in paths if name_of(path) == chosen])
    inside, key, value = at(content, path[:-1]), path[-1], at(content, path)
    if isinstance(value, bool):
        inside[key] = not value
    elif isinstance(value, int):
        inside[key] = value + rng.choice([-1, 1])
    elif value is None:
        inside[key] = "1"
    elif isinstance(value, dict) or (isinstance(value, list) and not value):
        del inside[key]
    elif isinstance(value, list):
        others = list(value)
        if len(value) > 1 and rng.random() < 0.5:
            rng.shuffle(others)
        else:
            others.pop(rng.randrange(len(others)))
        inside[key] = others
    elif chosen in ("label", "kind", "event", "parameter", "format"):
        inside[key] = rng.choice([word for word in WORDS if word != value])
    else:
        places = [k for k, sign in enumerate(value) if sign.isdigit()]
        if not places:  # a name, or a formula of names
            inside[key] = f"-({value})"
            return content, "/".join(map(str, path))
        k = rng.choice(places)
        digit = rng.choice([x for x in "0123456789" if x != value[k]])
        inside[key] = value[:k] + digit + value[k + 1 :]
        if rng.random() < 0.1:
            inside[key] = value.removeprefix("-") if value.startswith("-") else f"-{value}"
    return content, "/".join(map(str, path))


def bare(content: dict) -> dict:
    """What a certificate states, without what it rests on."""

    def stated(value):
        if isinstance(value, dict):
            return {key: stated(x) for key, x in value.items() if key not in AUXILIARY}
        return list(map(stated, value)) if isinstance(value, list) else value

    return stated(content)


def oracle_of(statement: dict, cam: dict) -> tuple[orbit_oracle.Machine, ArcsCam]:
    """The machine and the cam of a statement, as the oracle has them."""
    constants = {k: mpf(x) for k, x in statement["constants"].items() if k != "rpm"}
    names = "base_radius", "flank_center", "nose_center", "nose_radius", "offset"
    lengths = {key: mpf(cam["numbers"][key]) for key in names}
    flank = lengths["base_radius"] + lengths["flank_center"]
    shape = ArcsCam(
        **lengths, flank_radius=flank, top_dwell_deg=mpf(cam["numbers"]["top_dwell_deg"])
    )
    return orbit_oracle.Machine(**constants), shape


def holds_at(statement: dict, cam: dict, box: dict, eta, stable: bool | None) -> bool:
    """Whether the orbit of one impact at this eta is, by the oracle, in its box and as said."""
    machine, shape = oracle_of(statement, cam)
    numbers = [list(map(mpf, box[key])) for key in ("middle", "tangent", "error")]
    theta, v, rpm = (m + t * eta for m, t in zip(*numbers[:2], strict=True))
    omega = rpm * mp.pi / 30
    found = orbit_oracle.solve(shape, machine, rpm, [(theta, v * omega)], statement["turns"])
    errors = numbers[2]
    inside = abs(found.thetas[0] - theta) <= errors[0]
    inside = inside and abs(found.u_plus[0] / omega - v) <= errors[1]
    jury = found.det < 1 and abs(found.trace) < 1 + found.det
    return inside and stable in (None, jury) and orbit_oracle.admissible(shape, machine, rpm, found)


def from_the_rim(statement: dict, cam: dict, k: float, impacts: int) -> list:
    """|u| of an ellipse's rim at the angle k, and after each impact, by mpmath's first contacts."""
    machine, shape = oracle_of({"constants": {**statement["constants"], "rpm": "1"}}, cam)
    theta, v, rpm = map(mpf, statement["box"]["middle"])
    (axes,) = (mp.matrix([[mpf(a), mpf(b)], [mpf(c), mpf(d)]]) for a, b, c, d in statement["axes"])
    omega = rpm * mp.pi / 30
    u = mp.matrix([mp.cos(k), mp.sin(k)])
    lengths = [mp.norm(u)]
    for _ in range(impacts):
        start = mp.matrix([theta, v]) + axes * u
        c, c1, _ = shape.laws(start[0])
        speed = omega * (c1 + start[1])
        flight = Flight(shape, machine.follower(), omega, start[0], c, speed)
        hit = flight.first_contact(4 * mp.pi / omega, contact=True)
        phase = start[0] + omega * hit.t
        _, speed = machine.follower().flow(hit.t, c, speed)
        u_plus = -machine.restitution * (speed / omega - shape.laws(phase)[1])
        back = mp.matrix([phase - 2 * mp.pi, u_plus]) - mp.matrix([theta, v])
        u = mp.lu_solve(axes, back)
        lengths.append(mp.norm(u))
    return lengths


def still_true(content: dict, before: dict) -> bool:
    """Whether a changed certificate of orbits with one impact states the truth, by the oracle."""
    if bare(content) == bare(before):
        return True
    for statement in content["statements"]:
        if content["cam"] == before["cam"] and bare(statement) in map(bare, before["statements"]):
            continue
        one_impact = statement["label"], statement["turns"], statement["impacts"][0]["turn"]
        if one_impact != ("P(1;1)", 1, 0):  # which has that label at any strobe
            return False
        boxes = [*statement.get("boxes", []), *([statement["box"]] if "box" in statement else [])]
        for box in boxes:
            half = mpf(box["half"])
            for eta in (-half, 0, half):
                beside = statement["kind"] == "event" or (
                    box is boxes[0] and statement["kind"] == "branch"
                )
                stable = None if beside else statement.get("stable")
                if box["fixed"] != 2 or not holds_at(statement, content["cam"], box, eta, stable):
                    return False
        middle, half = mpf(boxes[0]["middle"][2]), mpf(boxes[0]["half"])
        if statement["kind"] in ("orbit", "attractor"):
            low, high = mpf(statement["low"]), mpf(statement["high"])
            if not middle - half <= low <= high <= middle + half:
                return False
            rim = range(4 if statement["kind"] == "attractor" else 0)
            lengths = [from_the_rim(statement, content["cam"], k, 1) for k in rim]
            if not all(after < before for before, after in lengths):
                return False
            continue
        machine, shape = oracle_of(statement, content["cam"])
        doubling = orbit_oracle.period_doubling_rpm(
            shape, machine, orbit_oracle.STABLE, 1, mpf(700), mpf(745)
        ).rpm
        low, high = statement["low"], statement["high"]
        ends = (low, high) if statement["kind"] == "event" else low
        if not mpf(ends[0]) <= doubling <= mpf(ends[1]):
            return False
        if statement["kind"] == "branch" and not mpf(high[0]) <= 741 <= mpf(high[1]):
            return False
    return True


@pytest.fixture(scope="module")
def small(upper):
    """Two orbits, a doubling, and the branch behind it."""
    doubling = {"event": "period-doubling", "impact": 0, "side": 0}
    statements = [
        one
        for one in upper["statements"]
        if one["kind"] in ("orbit", "attractor")
        or doubling in (one.get("event"), one.get("ends", [None])[0])
    ]
    kinds = [one["kind"] for one in statements]
    assert kinds == ["orbit", "attractor", "orbit", "event", "branch"]
    return {**upper, "statements": statements}


def refuse(checked, before: dict, seed: int, count: int) -> int:
    """Change a certificate so many times; how many of them were refused."""
    rng = Random(seed)
    refused = 0
    with mp.workdps(60):
        for _ in range(count):
            after, what = changed(before, rng)
            code, text = checked(after)
            assert code in (0, 1, 2)
            assert "Traceback" not in text
            if code == 0:
                assert still_true(after, before), (seed, what)
            refused += code != 0
    return refused


def test_a_hundred_random_changes_are_refused_unless_the_statement_is_still_true(small, checked):
    orbits = only(small, "orbit")
    assert checked(small)[0] == checked(orbits)[0] == 0
    assert refuse(checked, orbits, seed=39, count=100) >= 60


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(6))
def test_so_are_those_of_an_event_and_of_a_branch(small, checked, seed):
    assert refuse(checked, small, seed=seed, count=100) >= 50


# -- each thing that the checker asks for, wrong once


def put(*path_and_value):
    """A change of one statement: the value of a path in it."""
    *path, last, value = path_and_value

    def change(statement: dict) -> None:
        at(statement, path)[last] = value

    return change


def drop(*path):
    def change(statement: dict) -> None:
        del at(statement, path[:-1])[path[-1]]

    return change


def moved(*path, by: str):
    """A change of one number."""

    def change(statement: dict) -> None:
        at(statement, path[:-1])[path[-1]] = mp.nstr(mpf(at(statement, path)) + mpf(by), 50)

    return change


def swap(*path):
    """The first two of a list change their places."""

    def change(statement: dict) -> None:
        rows = at(statement, path)
        rows[0], rows[1] = rows[1], rows[0]

    return change


def both(*changes):
    def change(statement: dict) -> None:
        for one in changes:
            one(statement)

    return change


def uncut(statement: dict) -> None:
    """No passage of the flight is cut, and the gap is said to rise on one of two parts."""
    statement["box"]["flights"][0]["rise"] = len(statement["box"]["flights"][0]["passages"])
    for one in statement["box"]["flights"][0]["passages"]:
        one["cuts"] = []


def one_box(statement: dict) -> None:
    """The first box alone, which is said to end at two events."""
    event = statement["ends"][0]
    high = [statement["joints"][1]["middle"][2]] * 2
    statement |= {
        "boxes": statement["boxes"][:1],
        "joints": statement["joints"][:2],
        "ends": [event, event],
    }
    statement["high"] = [mp.nstr(mpf(high[0]) + sign * mpf("1e-20"), 50) for sign in (-1, 1)]


def by_another_name(statement: dict) -> None:
    """A stretch of the next turn is named as one beyond the last."""
    for one in statement["box"]["flights"][0]["passages"][1:-1]:
        if one["turn"] == 1:
            one |= {"stretch": one["stretch"] + 7, "turn": 0}


def open_constant(name: str, value: str, half: str = "0"):
    """A constant is the parameter, at this value."""

    def change(statement: dict) -> None:
        statement["constants"] |= {"rpm": "700", name: None}
        statement |= {"parameter": name, "low": value, "high": value}
        statement["box"]["middle"][2], statement["box"]["half"] = value, half

    return change


BOX, FLIGHT = "no box was shown to hold exactly one orbit", "flight 1 may meet the cam on its way"
PASSES = "flight 1 does not pass stretch after stretch from impact to impact"
WRONG = {
    "orbit": [
        (put("label", "P(1;2)"), "its label is P(1;1)"),
        (put("stable", False), "both multipliers may lie inside the unit circle"),
        (moved("box", "middle", 0, by="1e-6"), BOX),
        (moved("box", "middle", 2, by="1e-15"), BOX),
        (moved("constants", "mass", by="1e-9"), BOX),
        (put("constants", "mass", "-1.221"), "speed or mass is not positive"),
        (put("constants", "stiffness", "-1"), "a constant is negative"),
        (put("constants", "restitution", "1.2"), "the restitution lies outside 0 to 1"),
        (put("constants", "rpm", "700"), "exactly the parameter has to be left open"),
        (put("constants", "damping", "200"), BOX),
        (put("box", "error", 0, "1e-60"), BOX),
        (put("box", "error", 2, "1"), "a box does not lean along its unknown"),
        (put("box", "error", 0, "-1"), "a box has a negative width"),
        (put("box", "tangent", 2, "2"), "a box does not lean along its unknown"),
        (put("box", "fixed", 0), "the box of an orbit leans along the parameter"),
        (put("box", "half", "1e-20"), "its box does not cover the range of the parameter"),
        (put("box", "middle", ["1", "2"]), "a box has not one entry for each unknown"),
        (
            put("box", "inverse", [["1"]]),
            "a matrix has not one row and column for each free unknown",
        ),
        (put("box", "inverse", [["0", "0"], ["0", "0"]]), BOX),
        (put("low", "700.1"), "its range is empty"),
        (put("low", "699"), "its box does not cover the range of the parameter"),
        (put("turns", 2), BOX),
        (put("impacts", 0, "stretch", 1), BOX),
        (put("impacts", 0, "stretch", 99), "the cam has no such stretch"),
        (put("impacts", 0, "turn", 2), "an impact lies beyond the period"),
        (put("impacts", 0, "turn", 1), PASSES),
        (put("impacts", []), "an orbit without impacts is not checked here"),
        (drop("box", "flights", 0), "not every impact has its flight"),
        (drop("box", "flights", 0, "passages", 3), PASSES),
        (drop("box", "flights", 0, "passages", -1), PASSES),
        (put("box", "flights", 0, "passages", []), PASSES),
        (put("box", "flights", 0, "rise", 0), "flight 1 does not rise first and fall last"),
        (put("box", "flights", 0, "fall", 0), "flight 1 does not rise first and fall last"),
        (put("box", "flights", 0, "fall", 99), "flight 1 does not rise first and fall last"),
        (put("box", "flights", 0, "rise", 10), FLIGHT),
        (put("box", "flights", 0, "fall", 8), FLIGHT),
        (uncut, "flight 1 does not rise first and fall last"),
        (by_another_name, "the cam has no such stretch"),
        (open_constant("restitution", "1.1"), "the restitution exceeds 1"),
        (open_constant("mass", "-1"), "the parameter is no such constant"),
        (open_constant("damping", "83.6", half="1"), BOX),  # about critical damping
        (put("strobe", "360"), "the strobe lies outside the turn"),
        (put("strobe", "-1e-30"), "the strobe lies outside the turn"),
    ],
    "attractor": [
        (put("label", "P(1;2)"), "its label is P(1;1)"),
        (put("axes", []), "not every impact has an ellipse"),
        (put("axes", 0, ["1e-9"] * 4), "an ellipse is flat"),
        (put("axes", 0, ["1e-9", "0", "0", "1e-9"]), "flight 1 may not come nearer to the orbit"),
        (put("axes", 0, ["1e-9", "0", "0", "1e-7"]), "flight 1 may land outside the next ellipse"),
        (
            put("axes", 0, ["0.1", "0", "0", "0.1"]),
            "impact 1 may lie outside its stretch of the cam",
        ),
        (put("axes", 0, ["1e-3", "0", "0", "1.5"]), "impact 1 may not bounce"),
        (moved("box", "middle", 0, by="1e-6"), BOX),
    ],
    "unstable": [(put("stable", True), "a multiplier may lie outside the unit circle")],
    "event": [
        (put("label", "P(1;2)"), "its label is P(1;1)"),
        (put("event", "event", "fold"), "the function of an event may have no zero"),
        (put("event", "side", 1), "an event has more than its kind needs"),
        (put("signs", [1, 1]), "it has more than its kind needs"),
        (moved("box", "middle", 2, by="1e-20"), BOX),
        (put("high", "739"), "its parameter may lie elsewhere"),
        (put("low", "740"), "its parameter may lie elsewhere"),
        (put("box", "half", "1e-60"), "the function of an event may have no zero"),
    ],
    "corner": [
        (put("signs", [1, 1]), "a sign of a corner impact is another, or open"),
        (put("signs", [0, 1]), "a sign of a corner impact is another, or open"),
        (put("signs", [-1]), "a corner impact has two signs"),
        (put("event", "impact", 1), "a corner impact names its impact and side"),
        (put("event", "side", 0), "a corner impact names its impact and side"),
        (put("event", "event", "period-doubling"), "an event has more than its kind needs"),
        (
            put("event", {"event": "period-doubling", "impact": 0, "side": 0}),
            "impact 1 may lie outside its stretch of the cam",
        ),
    ],
    "branch": [
        (put("stable", True), "the stability beside an event is another"),
        (put("label", "P(2;1:1)"), "its label is P(1;1)"),
        (drop("joints", 1), "a chain has one joint more than boxes"),
        (drop("boxes", 1), "a chain has one joint more than boxes"),
        (both(drop("joints", -2), drop("boxes", -1)), "neighbouring boxes do not overlap"),
        (swap("boxes"), "neighbouring boxes do not overlap"),
        (swap("joints"), "neighbouring boxes do not overlap"),
        (put("ends", [None, None]), "both multipliers may lie inside the unit circle"),
        (put("ends", [None]), "a branch has two ends"),
        (one_box, "one box can have one event only"),
        (put("ends", 0, "event", "fold"), "the function of an event may have no zero"),
        (put("ends", 0, "side", 1), "an event has more than its kind needs"),
        (put("low", ["738", "738.5"]), "an end of the branch may lie elsewhere"),
        (put("high", ["741"]), "an end of the branch may lie elsewhere"),
        (put("high", ["742", "743"]), "an end of the branch may lie elsewhere"),
        (both(put("low", ["1", "900"]), put("high", ["1", "900"])), "its range is empty"),
        (moved("boxes", 1, "middle", 0, by="1e-3"), BOX),
    ],
}


def statement_of(content: dict, kind: str) -> dict:
    """A statement: a stable or unstable orbit, a doubling, a corner impact, a doubled branch."""
    for statement in content["statements"]:
        event = (statement.get("event") or statement.get("ends", [{}])[0] or {}).get("event", "")
        found = {
            "orbit": "orbit" if statement.get("stable") else "unstable",
            "attractor": "attractor",
            "event": {"period-doubling": "event", "corner-impact": "corner"}.get(event),
            "branch": "branch" if event == "period-doubling" else None,
        }
        if found[statement["kind"]] == kind:
            return deepcopy(statement)
    raise AssertionError(kind)


def unknowns(orbit: check.Orbit, near: list[arb]) -> dict:
    """A box of the only orbit near some unknowns, at their parameter, as a certificate has it."""
    size = 2 * orbit.n
    z = [x.mid() for x in near]
    for _ in range(9):
        value, slopes = orbit.equations(z, True)
        inverse = arb_mat([[slopes[i, k] for k in range(size)] for i in range(size)]).mid().inv()
        step = (inverse.mid() * value).mid().entries()
        z = [*((x - by).mid() for x, by in zip(z, step, strict=False)), z[-1]]
    numbers = [x.str(60, radius=False) for x in z]
    rows = [[inverse[i, k].mid().str(20, radius=False) for k in range(size)] for i in range(size)]
    return {"middle": numbers, "tangent": [*["0"] * size, "1"], "error": [*["1e-40"] * size, "0"],
            "fixed": size, "half": "0", "inverse": rows}  # fmt: skip


def equations(content: dict, statement: dict) -> check.Orbit:
    """The checker's own equations of a statement."""
    cam = check.cam_of(content["cam"], "")
    return check.orbit_of(cam, check.statement_of(statement, ""))


def twice(content: dict, statement: dict) -> dict:
    """The orbit of a statement gone through twice, as one of two turns."""
    statement = deepcopy(statement)
    first, (flight,) = statement["impacts"][0], statement["box"]["flights"]
    later = [{**one, "turn": one["turn"] + 1} for one in flight["passages"]]
    statement |= {"turns": 2, "impacts": [first, {**first, "turn": 1}], "label": "P(2;1:1)"}
    theta, v, rpm = map(arb, statement["box"]["middle"])
    flights = [flight, {**flight, "passages": later}]
    box = unknowns(equations(content, statement), [theta, v, theta, v, rpm])
    return {**statement, "box": {**box, "flights": flights}, "low": box["middle"][-1],
            "high": box["middle"][-1]}  # fmt: skip


def test_motions_from_the_rim_of_an_ellipse_come_nearer(upper):
    one = statement_of(upper, "attractor")
    with mp.workdps(40):
        for k in range(8):
            lengths = from_the_rim(one, upper["cam"], k, 6)
            assert all(after < before for before, after in pairwise(lengths))
            assert lengths[-1] < 0.5 * lengths[0]


def test_an_orbit_gone_through_twice_has_not_two_turns(upper, checked, bits):
    one = twice(upper, statement_of(upper, "orbit"))
    code, text = checked({**upper, "statements": [one]})
    assert code == 1
    assert "it may be an orbit of 1 turn gone through several times" in reasons(text)


def said_of(turns: int, at_turn: list[int], label: str, strobe=Fraction(0)) -> SimpleNamespace:
    """A statement of which no more is known than the turns of its impacts."""
    impacts = [SimpleNamespace(turn=turn) for turn in at_turn]
    return SimpleNamespace(turns=turns, impacts=impacts, label=label, strobe=strobe)


@pytest.mark.parametrize("turns", [1, 2, 3, 4, 6, 8, 9, 12])
def test_a_label_is_that_of_the_shortest_period(turns):
    """Sequences of impacts that come again after each divisor of their turns, by plain counting."""
    random = Random(turns)
    for period in (d for d in range(1, turns + 1) if turns % d == 0):
        counts = [random.randint(0, 3) for _ in range(period)]
        counts[random.randrange(period)] = 4 if period > 1 else random.randint(1, 4)
        states = [
            (turn, f"{turn + 1}.{k + 1}", f"{k + 1}.{turn + 1}")
            for turn, count in enumerate(counts)
            for k in range(count)
        ]
        states = [
            (turn + again * period, theta[-1], v)
            for again in range(turns // period)
            for turn, theta, v in states
        ]
        whole = counts * (turns // period)
        name = max(whole[k:] + whole[:k] for k in range(turns))
        label = f"P({turns};{':'.join(map(str, name))})"
        said = said_of(turns, [turn for turn, _, _ in states], label)
        hull = [arb(x) for _, *state in states for x in state]
        if period == turns:
            check.named(said, hull)
            said.label = f"P({turns};{':'.join(map(str, [*name[:-1], name[-1] + 1]))})"
            with pytest.raises(check.RefusedError, match="its label is"):
                check.named(said, hull)
        else:
            with pytest.raises(check.RefusedError, match="gone through several times"):
                check.named(said, hull)


def test_an_impact_at_the_strobe_is_counted_on_both_sides():
    """One impact a turn has its label there too, three of four have not."""
    near = [arb(1) + arb(0, "1e-9"), *map(arb, ("0.5", "2", "0.5", "3", "0.5", "2", "0.5"))]
    strobe = Fraction("57.29577951308232")  # 1 rad
    for turns, places, label in ((1, [0], "P(1;1)"), (2, [0, 0, 0, 1], "P(2;3:1)")):
        said = said_of(turns, places, label, strobe)
        if turns == 1:
            check.counted(said, near)
        else:
            with pytest.raises(check.RefusedError, match=re.escape("P(2;2:2) or P(2;3:1)")):
                check.counted(said, near)


@pytest.mark.ci
def test_a_branch_has_its_label_from_end_to_end(checked, tmp_path):
    """Where an impact passes the strobe on the way, both impacts of P(2;1:1) are in one turn."""
    section = {"rpm.start": 742.0, "rpm.stop": 748.0, "rpm.num": 3, "at": 745.0, "starts": 0,
               "branches": 0, "label": "P(2;1:1)"}  # fmt: skip
    content = certificate(tmp_path, **{f"orbits.{key}": value for key, value in section.items()})
    (one,) = only(content, "branch")["statements"]
    assert checked(only(content, "branch"))[0] == 0
    ends = [one["joints"][k]["middle"] for k in (0, -1)]
    k = max((0, 2), key=lambda k: abs(mpf(ends[0][k]) - mpf(ends[1][k])))
    with mp.workdps(40):
        middle = mpf(one["joints"][len(one["joints"]) // 2]["middle"][k])
        for strobe in [middle + (mpf(end[k]) - middle) / 2 for end in ends]:
            moved_one = {**one, "strobe": mp.nstr(strobe * 180 / mp.pi, 30)}
            for label in ("P(2;1:1)", "P(2;2:0)"):
                code, text = checked({**content, "statements": [{**moved_one, "label": label}]})
                assert code == 1, text
                assert "its label is" in text


@pytest.mark.ci
def test_where_the_label_changes_at_the_strobe_the_branch_is_cut(checked, tmp_path):
    """The impact of P(2;1:1) that moves most passes the strobe on the way from 742 to 748 rpm.

    So the orbit is P(2;2:0) on one side, and a period, which begins at the strobe, ends a turn
    later than one from the angle zero. Where the impact is at the strobe neither label is proved,
    and beside it the last box of a branch does not reach over the strobe.
    """
    section = {"orbits.rpm.start": 742.0, "orbits.rpm.stop": 748.0, "orbits.at": 745.0}
    before = certificate(tmp_path, **{**section, "orbits.label": "P(2;1:1)"})
    (one,) = only(before, "orbit")["statements"]
    ends = only(before, "branch")["statements"][0]["joints"]
    first, last = ([mpf(x) for x in ends[k]["middle"][:4:2]] for k in (0, -1))
    k = 2 * (abs(first[1] - last[1]) > abs(first[0] - last[0]))
    own, other = (mpf(one["box"]["middle"][i]) * 180 / mp.pi for i in (k, 2 - k))
    label = "P(2;1:1)" if other < own else "P(2;2:0)"
    for before_it, proved in ((1e-11, False), (1e-9, True)):  # deg, of the impact, to the strobe
        section["run.strobe_deg"] = float(own) + before_it
        content = certificate(tmp_path, **{**section, "orbits.label": label})
        labels = {said["label"] for said in only(content, "branch")["statements"]}
        assert labels == {"P(2;1:1)", "P(2;2:0)"}
        assert bool(only(content, "orbit")["statements"]) == proved
        code, text = checked(content)
        assert code == 0, text


@pytest.mark.parametrize("places", [28, 35, 200])
def test_what_is_printed_is_no_more_than_was_shown(places):
    """Ranges of orbits are rounded inwards, those of events outwards."""
    low, high = Fraction(f"1.{'0' * places}4"), Fraction(f"1.{'0' * places}6")
    printed = check.span(SimpleNamespace(low=low, high=high)).split()[1::2]
    assert low <= Fraction(printed[0]) <= Fraction(printed[1]) <= high
    assert Fraction(check.shown(low, check.ROUND_FLOOR)) <= low
    assert Fraction(check.shown(high, check.ROUND_CEILING)) >= high


@pytest.mark.parametrize(
    ("size", "printed"),
    [("0.42199", "0.421"), ("2.931e-5", "0.0000293"), ("0.5 +/- 0.01", "0.489")],
)
def test_the_size_of_an_ellipse_is_printed_no_larger_than_it_is(size, printed):
    shown = check.at_least(arb(f"[{size}]" if "+" in size else size))
    assert Decimal(shown) == Decimal(printed)


def test_a_branch_does_not_end_on_the_wrong_side_of_a_corner(upper, checked, bits):
    """Half of the orbits in the box about a corner impact have it on another stretch."""
    for one in upper["statements"]:
        if one["kind"] != "branch" or one["ends"][0]["event"] != "corner-impact":
            continue
        one = deepcopy(one)
        box, joints = one["boxes"][0], one["joints"]
        orbit = equations(upper, one)
        known = check.read({key: box[key] for key in check.POINT}, check.POINT, "")
        exact, beside = (mpf(joint["middle"][box["fixed"]]) for joint in joints[:2])
        for side, code_of in ((1, 0), (-1, 1)):
            eta = exact + side * (beside - exact) / 2 - mpf(box["middle"][box["fixed"]])
            near = [m + t * arb(mp.nstr(eta, 40)) for m, t in zip(known.middle, known.tangent,
                                                                  strict=True)]  # fmt: skip
            joint = unknowns(orbit, near)
            p = mpf(joint["middle"][2])
            ends = [[mp.nstr(p + by, 50) for by in (-mpf("1e-20"), mpf("1e-20"))], one["low"]]
            changed_one = {**one, "boxes": [box], "joints": [joint, joints[0]], "low": ends[0],
                           "high": ends[1], "ends": [None, one["ends"][0]]}  # fmt: skip
            if side > 0:  # from the corner on, as it was
                changed_one |= {"low": ends[1], "high": ends[0], "joints": [joints[0], joint],
                                "ends": [one["ends"][0], None]}  # fmt: skip
            code, text = checked({**upper, "statements": [changed_one]})
            assert code == code_of, text
            assert code == 0 or "the branch goes to the wrong side of a corner" in reasons(text)


def test_a_branch_is_confirmed_on_both_sides_of_a_corner(checked, tmp_path):
    """P(2;1:1) has its second impact at the corner c at 739.378 rpm, and loses its stability.

    Its branch ends there from below on the side before the corner (1), from above on the one behind
    it (-1). The signs are those of mpmath's maps with the impact on either side.
    """
    section = {"rpm.start": 739.377, "rpm.stop": 739.3798, "rpm.num": 9, "at": 739.377, "starts": 0,
               "branches": 0, "label": "P(2;1:1)", "stability": "stable"}  # fmt: skip
    content = certificate(tmp_path, **{f"orbits.{key}": x for key, x in section.items()})
    assert content["uncovered"] == []
    code, text = checked(content)
    assert code == 0, text
    (event,) = only(content, "event")["statements"]
    with mp.workdps(60):
        machine, shape = oracle_of({"constants": {**event["constants"], "rpm": "1"}},
                                   content["cam"])  # fmt: skip
        corner_c = shape.breakpoints[2]
        exact = orbit_oracle.corner_rpm(
            shape, machine, orbit_oracle.DOUBLED, 2, 1, corner_c, mpf("739.37")
        )
    assert Fraction(event["low"]) < Fraction(mp.nstr(exact.rpm, 30)) < Fraction(event["high"])
    at_one, at_minus_one = (
        (1 - s * exact.left.trace + exact.left.det) * (1 - s * exact.right.trace + exact.right.det)
        for s in (1, -1)
    )
    assert event["signs"] == [1 if x > 0 else -1 for x in (at_one, at_minus_one)] == [1, -1]
    ends = [one["ends"] for one in only(content, "branch")["statements"]]
    corner = {"event": "corner-impact", "impact": 1, "side": 1}
    assert ends == [[None, corner], [{**corner, "side": -1}, None]]
    assert [one["stable"] for one in only(content, "branch")["statements"]] == [True, False]
    for signs in ([-1, -1], [1, 1], [1, 0]):
        code, text = checked({**content, "statements": [{**event, "signs": signs}]})
        assert reasons(text) == ["a sign of a corner impact is another, or open"]


def test_an_orbit_that_would_pull_is_refused(upper, checked, bits):
    """The same equations have solutions whose impacts leave the cam towards it."""
    result = camcli.orbits(load_scene(None, {"orbits.rpm.start": 700.0, "orbits.rpm.stop": 700.0,
                                             "orbits.rpm.num": 1, "orbits.starts": 0}))  # fmt: skip
    one = statement_of(upper, "orbit")
    pulling = [o.root for o in result.values.virtual if o.root.count == 1 and o.root.x[1] < 0]
    for root in pulling:
        z = list(map(arb, root.x))
        stretches = [k for k in range(7) if equations(upper, one).cam.stretches[k].start < z[0]]
        changed_one = {**one, "turns": root.turns, "low": "700", "high": "700"}
        changed_one["impacts"] = [{"stretch": stretches[-1], "turn": 0}]
        box = unknowns(equations(upper, changed_one), z)
        changed_one["box"] = {**box, "flights": one["box"]["flights"]}
        code, text = checked({**upper, "statements": [changed_one]})
        assert code == 1
        assert "impact 1 may not bounce" in reasons(text)
    assert pulling


@pytest.mark.parametrize("name", ["preload", "stiffness", "gravity"])
def test_a_constant_that_does_not_move_the_determinant_may_be_the_parameter(
    name, checked, tmp_path
):
    """Without damping the determinant is r^2 whatever these are: its slope is zero."""
    changes = {"orbits.rpm.start": 700.0, "orbits.rpm.stop": 700.0, "orbits.rpm.num": 1,
               "orbits.label": "P(1;1)", "orbits.starts": 0, "orbits.branches": 0}  # fmt: skip
    value = {"preload": 0.0, "stiffness": 1430.8, "gravity": 0.0}[name]
    varied = {"orbits.parameter": name, "orbits.range": [value, value + 5.0]}
    content = certificate(tmp_path / "out", **changes, **varied)
    branches = [one for one in content["statements"] if one["kind"] == "branch"]
    assert {one["parameter"] for one in branches} == {name}
    code, text = checked(content)
    assert code == 0, text


@pytest.mark.ci
def test_a_box_too_wide_for_its_flights_is_cut_in_two(checked, tmp_path):
    """With few points the boxes of P(1;2) are long: one of them holds flights near to the cam."""
    section = {"rpm.start": 355.0, "rpm.stop": 380.0, "rpm.num": 51, "at": 358.5, "starts": 0,
               "branches": 0, "label": "P(1;2)"}  # fmt: skip
    content = certificate(tmp_path, **{f"orbits.{key}": value for key, value in section.items()})
    assert content["uncovered"] == []
    code, text = checked(content)
    assert code == 0
    assert "P(1;2) exists and is stable for all rpm between 355.15452371644794830167175559" in text


def test_where_the_multipliers_turn_real_is_confirmed_and_no_branch_ends_there(upper, checked):
    """At 738.7743752 rpm, where trace^2 = 4 det, as mpmath has it."""
    (one,) = [x for x in upper["statements"] if x["kind"] == "event"
              and x["event"]["event"] == "multipliers-meet"]  # fmt: skip
    code, text = checked({**upper, "statements": [one]})
    assert code == 0
    assert text.count("738.7743752038817473") == 2
    with mp.workdps(60):
        for change, why in (
            (put("event", "event", "period-doubling"), "the function of an event may have no zero"),
            (put("event", "side", 1), "an event has more than its kind needs"),
            (put("low", "738.8"), "its parameter may lie elsewhere"),
            (moved("box", "middle", 2, by="1e-20"), BOX),
        ):
            other = deepcopy(one)
            change(other)
            code, text = checked({**upper, "statements": [other]})
            assert code == 1
            assert why in reasons(text)
    branch = statement_of(upper, "branch")
    branch["ends"][0] = one["event"]
    code, text = checked({**upper, "statements": [branch]})
    assert code == 2
    assert (
        "the file.statements[0].ends[0].event: expected one of period-doubling, fold, corner-impact"
        in reasons(text)
    )


def test_what_is_named_in_a_file_cannot_look_like_a_confirmed_statement(upper, checked):
    for name in ("x\nconfirmed: P(1;2)", "x\rconfirmed: P(1;2)", "\x1b[2J"):
        code, text = checked({**upper, "uncovered": [name]})
        assert (code, text.count("\n")) == (2, 1)
        assert "confirmed" not in text
        assert "the file.uncovered[0]: expected a short text in one line" in reasons(text)


def test_a_file_without_statements_says_so_in_words(upper, checked):
    """Nothing in it is damaged, and nothing in it is confirmed: an exit code of its own."""
    for cam in (upper["cam"], None):
        empty = {**upper, "cam": cam, "statements": [], "uncovered": ["P(1;inf) at 190 rpm"]}
        code, text = checked(empty)
        assert code == 3
        assert text.splitlines() == [
            "the file holds no statement: nothing was proved, or nothing that a certificate can "
            "have",
            "without a certificate: P(1;inf) at 190 rpm",
        ]
        code, text = checked({**empty, "uncovered": []})
        assert (code, text.count("\n")) == (3, 1)


def test_a_cam_with_a_step_is_no_cam(upper, checked):
    """Also where its parts fill the turn; and they have to fill it."""
    smooth = formula_of(load_scene({"follower": FOLLOWER, "cam": law("cycloidal")}).cam)
    assert checked({**upper, "cam": smooth})[0] == 1  # a cam, of which nothing in the file is true
    for change, why in (
        (
            lambda cam: cam["stretches"].pop(1),
            "the file.cam: these numbers make no cam, it has a step",
        ),
        (
            lambda cam: cam["stretches"][0].update(polynomial=["base + 1"]),
            "the file.cam: these numbers make no cam, it has a step",
        ),
        (lambda cam: cam["stretches"].pop(), "cam: its stretches do not fill one turn"),
        (
            lambda cam: cam["stretches"][-1].update(end="4*pi"),
            "cam: its stretches do not fill one turn",
        ),
        (lambda cam: cam["stretches"][0].update(polynomial=[]), "cam: these numbers make no cam"),
        (lambda cam: cam["stretches"][1].update(wave=["1", "2"]), "cam: these numbers make no cam"),
        (lambda cam: cam["stretches"][1].update(end="-pi"), "cam: these numbers make no cam"),
    ):
        cam = deepcopy(smooth)
        change(cam)
        code, text = checked({**upper, "cam": cam})
        assert code == 2
        assert why in reasons(text)


UNKNOWN = "cam: a formula has what is not known here"
NO_FORMULA = "the file.cam.stretches[0].polynomial[0]: expected a formula"
FORMULAS = ["", "nobody", "base +", "base**2", "exec(base)", "sqrt(base, lift)", "base.real", "[1]",
            "0.5*base", "lambda: 1", "base if 1 else 2", "sqrt(x=base)", "'base'", "1 < base",
            "(" * 1000 + ")" * 1000, "-" * 1999 + "1", "base;base", "f'{base}'", "True", None, 7,
            "base + \N{MATHEMATICAL BOLD SMALL L}ift", "base\n"]  # fmt: skip


@pytest.mark.parametrize("formula", FORMULAS)
def test_a_formula_has_numbers_by_name_and_few_signs(formula, upper, checked):
    cam = formula_of(load_scene({"follower": FOLLOWER, "cam": law("cycloidal")}).cam)
    cam["stretches"][0]["polynomial"] = [formula]
    code, text = checked({**upper, "cam": cam})
    assert (code, text.count("\n")) == (2, 1)
    names = formula in ("nobody", "exec(base)", "sqrt(base, lift)", "True", "base**2")
    deep = formula == "-" * 1999 + "1"  # that is told by Python itself
    assert deep or reasons(text) in ([UNKNOWN], [NO_FORMULA])
    assert not names or reasons(text) == [UNKNOWN]


@pytest.mark.parametrize("kind", WRONG)
def test_each_thing_that_is_wrong_is_refused_for_its_reason(upper, checked, kind):
    for change, why in WRONG[kind]:
        one = statement_of(upper, kind)
        with mp.workdps(60):
            change(one)
        code, text = checked({**upper, "statements": [one]})
        assert code == 1
        assert why in reasons(text)
        assert text.endswith("0 of 1 statement are confirmed\n")


def test_another_multiplier_at_an_event_is_refused(upper, checked, monkeypatch):
    """No machine of ours has one, as each impact and the damping make the determinant smaller."""
    monkeypatch.setattr(check.Orbit, "multipliers", lambda self, box: [arb(-3), arb(2)])
    for kind, why in (
        ("event", "another multiplier may lie on the unit circle"),
        ("branch", "another multiplier may cross the unit circle"),
    ):
        code, text = checked({**upper, "statements": [statement_of(upper, kind)]})
        assert code == 1
        assert reasons(text) == [why]


def test_a_flight_ends_after_it_begins(upper, bits, monkeypatch):
    one = statement_of(upper, "orbit")
    orbit = equations(upper, one)
    hull = list(map(arb, one["box"]["middle"]))
    monkeypatch.setattr(orbit, "turned", lambda k: -2 * arb.pi())
    flight = check.read(one["box"]["flights"][0], check.FLIGHT, "")
    with pytest.raises(check.RefusedError, match=r"^flight 1 ends before it begins$"):
        orbit.clear(hull, 0, flight)


def test_a_joint_lies_in_the_boxes_on_both_sides():
    """Also in the unknowns that are not given: else it may be of another branch."""
    box = SimpleNamespace(
        middle=[arb(1), arb(2)], tangent=[arb("0.5"), arb(1)], half=arb("0.1"), fixed=1,
        reach=[check.around(0, arb("0.01")), arb(0)],
    )  # fmt: skip
    for place, holds in (("1.025", True), ("1.045", False), ("1.005", False)):
        point = SimpleNamespace(hull=[arb(place), arb("2.05")])
        if holds:
            check.joins(box, point)
        else:
            with pytest.raises(check.RefusedError, match=r"^neighbouring boxes do not overlap$"):
                check.joins(box, point)


BAD = [
    "", "{", "[]", "null", "7", '"x"', "{}", '{"a": NaN}', "[" * 100_000, '{"a": 1, "a": 2}',
    '{"a": ' + "9" * 5000 + "}", "\x00", "\ud800".encode("utf-8", "surrogatepass").decode("latin1"),
]  # fmt: skip
BAD_VALUES = [
    ("statements", {}), ("statements", None), ("format", "another"),
    ("cam", None), ("cam", {}), ("cam", {"kind": "square"}), ("cam", {"kind": ["arcs"]}),
    ("uncovered", [1]), ("more", 1),
]  # fmt: skip
BAD_PARTS = [
    put("box", "middle", 0, "1e9999"), put("box", "middle", 0, "1e999999999"),
    put("box", "middle", 0, "nan"), put("box", "middle", 0, 2.71), put("box", "middle", 0, None),
    put("box", "middle", 0, "9" * 5000), put("box", "fixed", True), put("box", "fixed", 10**30),
    put("turns", 0), put("turns", "1"), put("stable", 1), put("stable", None), drop("box"),
    put("kind", "theorem"), put("kind", None), put("impacts", {}), put("parameter", "cam"),
    put("constants", "mass", []), put("box", "flights", "all"), put("label", "P" * 500),
    put("box", "middle", 0, "\u0662.7"), put("low", "+700"), put("low", " 700"), put("low", "7_00"),
    put("low", "inf"), put("low", "0x1p3"), put("low", "700\n"), put("low", "1/3"),
    put("more", 1), put("box", "error", 0, "-"), put("box", "error", 0, "1.2.3"),
]  # fmt: skip


def test_what_is_no_certificate_has_one_clear_message(upper, checked, tmp_path):
    files = [*BAD, *({**upper, key: value} for key, value in BAD_VALUES)]
    for number in ({"top_dwell_deg": "300"}, {"nose_center": "2"}):  # more than a turn; no circles
        changed_numbers = {**upper["cam"]["numbers"], **number}
        files.append({**upper, "cam": {**upper["cam"], "numbers": changed_numbers}})
    for change in BAD_PARTS:
        one = statement_of(upper, "orbit")
        change(one)
        files.append({**upper, "statements": [one]})
    for content in files:
        code, text = checked(content)
        assert code == 2, text
        assert text.count("\n") == 1
        assert ": no certificate: " in text
    assert check.main([str(tmp_path / "nowhere.json")]) == check.main([str(tmp_path)]) == 2
    assert check.main([]) == check.main(["a", "b"]) == 2
    assert check.main(["--help"]) == 0


def test_multipliers_meet_wherever_they_turn_complex_or_real(monkeypatch):
    """trace 1, 3, 3, 1 with the determinant 1: real where it is beyond 2."""
    at = [arb(one) for one in (1, 3, 3, 1)]
    met = []

    def zero(guess, fixed, apart):
        met.append(float(guess[fixed]))
        return SimpleNamespace(hull=lambda: [arb(2)]), None

    boxes = [
        SimpleNamespace(fixed=0, middle=[x], orbit_at=lambda off, x=x: [x + off]) for x in at[:3]
    ]
    shooting = SimpleNamespace(trace_det=lambda z: (z[0], arb(1)), zero=zero)
    evidence = SimpleNamespace(
        bits=80, shooting=shooting, boxes=boxes, joints=[SimpleNamespace(middle=[x]) for x in at]
    )
    monkeypatch.setattr(module, "_statement", lambda evidence, claims, strobe: claims)
    branch = SimpleNamespace(failed_step=None, evidence=evidence, label="P(1;1)")
    found = module._meetings(branch, 0.0)
    assert [one["event"]["event"] for one in found] == ["multipliers-meet"] * 2
    assert met == pytest.approx([1.0 + 2.0 * 3.0 / 8.0, 3.0 - 2.0 * 5.0 / 8.0])
    assert module._meetings(SimpleNamespace(failed_step="any", evidence=evidence), 0.0) == []
