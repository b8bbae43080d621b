"""Certificates of proofs, and the checker that confirms or refuses what they state.

The judge of a changed certificate is mpmath at 60 digits (`tests.support.orbit_oracle`): whether
the orbit, with the numbers that the certificate now has, still lies where it says.
"""

import json
import subprocess
import sys
from copy import deepcopy
from pathlib import Path
from random import Random

import pytest
from mpmath import mp, mpf

import camcli
from camcli import check
from camcli.scene import load_scene
from tests.support import orbit_oracle
from tests.support.oracle import ArcsCam

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


@pytest.fixture
def said(tmp_path, capsys):
    """(exit code, what is printed) of the checker for the content of a file."""

    def run(content) -> tuple[int, str]:
        file = tmp_path / "changed.json"
        file.write_text(content if isinstance(content, str) else json.dumps(content))
        code = check.main([str(file)])
        printed = capsys.readouterr()
        return code, printed.out + printed.err

    return run


def only(content: dict, *kinds: str) -> dict:
    """The certificate with the statements of these kinds only."""
    statements = [one for one in content["statements"] if one["kind"] in kinds]
    return {**content, "statements": statements}


def test_every_statement_of_a_run_is_confirmed(upper, said):
    code, text = said(upper)
    kinds = [one["kind"] for one in upper["statements"]]
    assert (code, kinds.count("orbit"), kinds.count("branch")) == (0, 2, 3)
    assert text.count("\nconfirmed: ") + text.startswith("confirmed: ") == len(kinds)
    assert upper["uncovered"] == []


def test_the_checker_runs_alone_where_camcli_cannot_be_imported(cam, tmp_path):
    cam("orbits --rpm 700 --label P(1;1) --prove --with-checker --no-plot -o out", code=0)
    alone = "import sys, runpy; sys.modules['camcli'] = None; sys.argv = sys.argv[1:]; "
    alone += "runpy.run_path('out/check.py', run_name='__main__')"
    words = [sys.executable, "-c", alone, "check.py", "out/proof.json"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.endswith("2 of 2 statements are confirmed\n")
    assert (tmp_path / "out/check.py").read_bytes() == Path(check.__file__).read_bytes()


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


def oracle_of(said: dict, cam: dict) -> tuple[orbit_oracle.Machine, ArcsCam]:
    """The machine and the cam of a statement, as the oracle has them."""
    constants = {k: mpf(x) for k, x in said["constants"].items() if k != "rpm"}
    names = "base_radius", "flank_center", "nose_center", "nose_radius", "offset"
    lengths = {key: mpf(cam[key]) for key in names}
    flank = lengths["base_radius"] + lengths["flank_center"]
    shape = ArcsCam(**lengths, flank_radius=flank, top_dwell_deg=mpf(cam["top_dwell_deg"]))
    return orbit_oracle.Machine(**constants), shape


def holds_at(said: dict, cam: dict, box: dict, eta, stable: bool | None) -> bool:
    """Whether the orbit of one impact at this eta is, by the oracle, in its box and as said."""
    machine, shape = oracle_of(said, cam)
    numbers = [list(map(mpf, box[key])) for key in ("middle", "tangent", "error")]
    theta, v, rpm = (m + t * eta for m, t in zip(*numbers[:2], strict=True))
    omega = rpm * mp.pi / 30
    found = orbit_oracle.solve(shape, machine, rpm, [(theta, v * omega)], said["turns"])
    errors = numbers[2]
    inside = abs(found.thetas[0] - theta) <= errors[0]
    inside = inside and abs(found.u_plus[0] / omega - v) <= errors[1]
    jury = found.det < 1 and abs(found.trace) < 1 + found.det
    return inside and stable in (None, jury) and orbit_oracle.admissible(shape, machine, rpm, found)


def still_true(content: dict, before: dict) -> bool:
    """Whether a changed certificate of orbits with one impact states the truth, by the oracle."""
    if bare(content) == bare(before):
        return True
    for said in content["statements"]:
        one_impact = said["label"], said["turns"], said["impacts"][0]["turn"]
        if one_impact != ("P(1;1)", 1, 0):  # which has that label at any strobe
            return False
        boxes = [*said.get("boxes", []), *([said["box"]] if "box" in said else [])]
        for box in boxes:
            half = mpf(box["half"])
            for eta in (-half, 0, half):
                beside = said["kind"] == "event" or (box is boxes[0] and said["kind"] == "branch")
                stable = None if beside else said["stable"]
                if box["fixed"] != 2 or not holds_at(said, content["cam"], box, eta, stable):
                    return False
        middle, half = mpf(boxes[0]["middle"][2]), mpf(boxes[0]["half"])
        if said["kind"] == "orbit":
            low, high = mpf(said["low"]), mpf(said["high"])
            if not middle - half <= low <= high <= middle + half:
                return False
            continue
        machine, shape = oracle_of(said, content["cam"])
        doubling = orbit_oracle.period_doubling_rpm(
            shape, machine, orbit_oracle.STABLE, 1, mpf(700), mpf(745)
        ).rpm
        low, high = said["low"], said["high"]
        ends = (low, high) if said["kind"] == "event" else low
        if not mpf(ends[0]) <= doubling <= mpf(ends[1]):
            return False
        if said["kind"] == "branch" and not mpf(high[0]) <= 741 <= mpf(high[1]):
            return False
    return True


@pytest.fixture(scope="module")
def small(upper):
    """Two orbits, a doubling, and the branch behind it."""
    statements = [
        one
        for one in upper["statements"]
        if one["kind"] == "orbit"
        or (one.get("event") or one["ends"][0] or {}).get("event") == "period-doubling"
    ]
    assert [one["kind"] for one in statements] == ["orbit", "orbit", "event", "branch"]
    return {**upper, "statements": statements}


def refuse(said, before: dict, seed: int, count: int) -> int:
    """Change a certificate so many times; how many of them were refused."""
    rng = Random(seed)
    refused = 0
    with mp.workdps(60):
        for _ in range(count):
            after, what = changed(before, rng)
            code, text = said(after)
            assert code in (0, 1, 2)
            assert "Traceback" not in text
            if code == 0:
                assert still_true(after, before), (seed, what)
            refused += code != 0
    return refused


def test_a_hundred_random_changes_are_refused_unless_the_statement_is_still_true(small, said):
    orbits = only(small, "orbit")
    assert said(small)[0] == said(orbits)[0] == 0
    assert refuse(said, orbits, seed=39, count=100) >= 60


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(6))
def test_so_are_those_of_an_event_and_of_a_branch(small, said, seed):
    assert refuse(said, small, seed=seed, count=100) >= 50
