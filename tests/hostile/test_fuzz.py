"""Whatever a scene, an option or a table says: done, refused in words, or a status. Never more.

CAMCLI_FUZZ=10000 tries that many examples of each, with other seeds at every run; without it they
are always the same.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from camcli.cams.compile import build, phase_of
from camcli.cams.lift_guess import guess
from camcli.scene import document, load_scene
from tests.support.bounds import (
    NUMBERS,
    ODD,
    VALUES,
    accepted,
    command_line,
    fuzz,
    load_and_run,
    plain_kernel,
    run_one_turn,
)
from tests.support.lift_tables import Lobe, cycloidal, polynomial, scene, table

CONFIGS = Path(__file__).parents[2] / "configs"
SCENES = {path.name: yaml.safe_load(path.read_text()) for path in sorted(CONFIGS.glob("*.yaml"))}
SHIPPED = (CONFIGS / "chapter.yaml").read_text()
COMMANDS = ("simulate", "sweep", "detach", "orbits", "classify", "basins", "explore", "bench")
SHORT = ("run.transient=0", "run.record=1", "run.impact_budget=50")
WORDS = """
run rpm cam kind follower mass sweep sections arcs null true on 1:30 010 1e-3 .nan -.inf 1e999
: - ? [ ] { } , # & * &a *a << ! !!int % @ ` | > ' " --- ... ~ 0 -1 700 é 😀
"""
SPACES = (" ", "\n", "\n  ", "\t", "\x00", "\x1b", "\ufeff", "\u2028", "\x85", ": ", "- ", "\r")
BITS = st.sampled_from([*WORDS.split(), *SPACES])
YAMLISH = st.lists(BITS, max_size=40).map("".join)
KEYS = sorted(
    {
        ".".join((section, *more))
        for scene in SCENES.values()
        for section, values in scene.items()
        for more in [(), *((key,) for key in (values or {}))]
    }
    | {"run.start.q", "run.start.v", "run.start.theta_deg", "sweep.rpm.num", "sweep.rpm.start",
       "basins.rpm.num", "cam.rise.law", "cam.rise.length_deg", "cam.rise.start_deg",
       "cam.fall.length_deg", "cam.sha256", "cam.allow_outside", "cam.max_lift", "x.y", "cam.x",
       "sweep.sections.0", "run.x.y"}
)  # fmt: skip
SETS = st.lists(
    st.one_of(
        st.tuples(st.sampled_from(KEYS), VALUES).map("=".join),
        st.tuples(st.text(max_size=10) | YAMLISH, VALUES).map("=".join),
        st.text(st.characters(), max_size=20),
    ),
    max_size=4,
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("hostile")
    (place / "valve-lift.csv").write_bytes((CONFIGS / "valve-lift.csv").read_bytes())
    return place


@pytest.fixture(scope="module", autouse=True)
def _plain():
    with plain_kernel():
        yield


# -- scenes ------------------------------------------------------------------------------------


@fuzz(100)
@given(st.data())
def test_scenes_with_text_changed_by_either_parser(folder, data):
    text = data.draw(st.sampled_from([SHIPPED, SHIPPED, ""]))
    for _ in range(data.draw(st.integers(1, 3))):
        start = data.draw(st.integers(0, len(text)))
        stop = data.draw(st.integers(start, min(len(text), start + 30)))
        new = data.draw(st.one_of(BITS, YAMLISH, st.just(""), st.text(max_size=99)))
        text = text[:start] + new + text[stop:]
    encoded = text.encode("utf-8", "surrogatepass")
    path = folder / "scene.yaml"
    path.write_bytes(data.draw(st.sampled_from([encoded] * 4 + [encoded[::2], encoded[-99::-1]])))
    with pytest.MonkeyPatch.context() as patch:
        if data.draw(st.booleans()):
            patch.setattr(document, "LOADER", yaml.BaseLoader)
        accepted(lambda: load_scene(path))


@fuzz(40)
@given(st.sampled_from(sorted(SCENES)), SETS)
def test_texts_of_set(name, sets):
    load_and_run(CONFIGS / name, sets)


PYTHON = st.recursive(
    st.one_of(st.none(), st.booleans(), st.floats(), st.integers(), st.text(), st.binary()),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=5,
)


@fuzz(100)
@given(st.none() | st.dictionaries(st.sampled_from(["cam", "run", "follower", "x"]), PYTHON),
       st.dictionaries(st.sampled_from(KEYS), PYTHON, max_size=3))  # fmt: skip
def test_values_of_python(source, overrides):
    accepted(lambda: load_scene(source, overrides))


# -- machines and commands ---------------------------------------------------------------------

PHYSICS = {
    "follower.mass": ["1e-15", "1e-9", "1e9", "1e15"],
    "follower.stiffness": ["0", "5e-324", "1e-300", "1e-9", "1e9", "1e15"],
    "follower.damping": ["0", "5e-324", "1e-160", "1e3", "1e9", "1e15"],
    "follower.gravity": ["-1e15", "-9.81", "-1e-300", "5e-324", "1e15"],
    "follower.preload": ["-1e15", "-1", "-5e-324", "1e-300", "1e15"],
    "follower.restitution": ["0", "5e-324", "1e-16", "0.9999999999999999", "1"],
    "run.rpm": ["1e-9", "1e-3", "1e6", "1e9"],
    "run.start.q": ["1e9", "1", "0.5"],
    "run.start.v": ["-1e12", "-5e-324", "1e-300", "1e12"],
    "run.start.theta_deg": ["-1e9", "-5e-324", "139.99999999999997", "140", "360", "1e9"],
    "run.strobe_deg": ["5e-324", "1e-13", "139.99999999999997", "140.00000000000003",
                       "359.99999999999994"],
    "run.chatter_tolerance": ["1e-15", "1e-3"],
}  # fmt: skip
CAMS = {
    "cam.base": ["-1e6", "1e-300", "1e6"],
    "cam.lift": ["5e-324", "1e-300", "1e-12", "1e6"],
    "cam.offset": ["-1e6", "1e-300", "1e6"],
    "cam.top_dwell_deg": ["0", "5e-324", "1e-13", "359"],
    "cam.rise.start_deg": ["-360", "1e-310", "1e-13", "359.9999999999999", "360"],
    "cam.rise.length_deg": ["1e-6", "180", "359"],
    "cam.fall.length_deg": ["1e-6", "180"],
    "cam.rise.law": ["harmonic", "{scca: {b: 5e-324, c: 1, d: 0}}", "constant-velocity"],
}


@st.composite
def extremes(draw) -> tuple[Path, list[str]]:
    """A shipped scene and numbers at the ends of their ranges, all valid by themselves."""
    name = draw(st.sampled_from([n for n in SCENES if n != "lift-table.yaml"]))
    known = [k for k in CAMS if k.split(".")[1] in SCENES[name]["cam"]]
    keys = draw(st.lists(st.sampled_from([*PHYSICS, *PHYSICS, *known]), max_size=5, unique=True))
    choices = {**PHYSICS, **CAMS}
    return CONFIGS / name, [f"{key}={draw(st.sampled_from(choices[key]))}" for key in keys]


@fuzz(40)
@given(extremes())
def test_extreme_machines(machine):
    load_and_run(*machine)


SMALL_PAGE = [*SHORT, "run.patience=0", "run.work_budget=2000", "orbits.starts=0",
              "sweep.rpm={start: 700, stop: 710, num: 2}"]  # fmt: skip


@pytest.mark.ci
@fuzz(4)
@given(extremes())
def test_pages_of_extreme_machines(folder, machine):
    """Each is written, with a status in words where something is left out, or refused in words."""
    path, sets = machine
    page = folder / "page"
    shutil.rmtree(page, ignore_errors=True)
    words = [word for text in (*SMALL_PAGE, *sets) for word in ("--set", text)]
    code, said = command_line(["explore", "-q", "-o", str(page), "-c", str(path), *words])
    assert code in (0, 2, 3), said
    assert "internal fault" not in said
    assert code == 0 or said.strip()
    assert all(line.isprintable() for line in said.splitlines())
    if (page / "explore.html").exists():
        assert (page / "explore.html").read_text(encoding="utf-8").rstrip().endswith("</html>")
    else:
        assert code != 0


@pytest.mark.parametrize(
    ("name", "sets"),
    [
        ("law-harmonic", ["cam.rise.start_deg=1e-310"]),  # no stretch began at 0
        ("law-smooth", ["cam.rise.start_deg=1e-300", "run.start.theta_deg=1e-301"]),
        ("law-smooth", ["cam.rise.start_deg=359.9999999999999"]),
        ("law-cycloidal", ["cam.rise.law={scca: {b: 5e-324, c: 1, d: 0}}"]),
        ("law-harmonic", ["cam.rise.length_deg=1e-6", "cam.fall.length_deg=1e-6"]),
        ("law-harmonic", ["cam.top_dwell_deg=5e-324"]),
        ("bouncing-ball", ["run.strobe_deg=359.99999999999994", "cam.base=1e-30"]),  # width 0
        ("chapter", ["run.strobe_deg=5e-324", "run.start.v=1e-300", "follower.restitution=1e-300"]),
        ("chapter", ["run.strobe_deg=139.99999999999997"]),
        ("chapter", ["run.strobe_deg=140.00000000000003"]),
        ("lift-table", ["run.strobe_deg=5e-324"]),
        ("eccentric", ["cam.lift=5e-324", "follower.restitution=1"]),
        ("eccentric", ["run.start.q=1e9", "run.start.v=1e12", "run.rpm=1e-9"]),
        ("chapter", ["follower.mass=1e-15", "follower.stiffness=1e15", "run.rpm=1e-9"]),
        ("chapter", ["follower.damping=1e15", "follower.stiffness=0", "run.rpm=1e9"]),
    ],
)
def test_a_machine_that_once_raised_or_hung_gives_a_status(name, sets):
    run_one_turn(load_scene(CONFIGS / f"{name}.yaml", sets))


@fuzz(25)
@given(
    st.sampled_from(COMMANDS),
    st.sampled_from(sorted(SCENES)),
    SETS,
    st.none() | NUMBERS | ODD | st.tuples(NUMBERS, NUMBERS).map(":".join),
    st.none() | NUMBERS | ODD | st.integers(-3, 10**12).map(str),
    st.none() | NUMBERS,
)
def test_command_lines(command, name, sets, rpm, points, threads):
    given_ = (("--rpm", rpm), ("--points", points), ("--threads", threads))
    words = [f"{option}={text}" for option, text in given_ if text is not None]
    words += [word for text in (*sets, *SHORT) for word in ("--set", text)]
    code, said = command_line([command, "--dry-run", "-c", str(CONFIGS / name), *words])
    assert code in (0, 2), said
    assert "internal fault" not in said
    assert (code == 0) or said.strip()
    assert all(line.isprintable() for line in said.splitlines())


# -- lift tables -------------------------------------------------------------------------------

CELLS = st.sampled_from(
    ["nan", "inf", "-", ",", ";", "\t", " ", "\n", "\r\n", "\r", "#", '"', ".", "e", "E9", "1e9",
     "1e-40", "0", "-0", "-1", "360", "720", "\x00", "\ufeff", "\x85", "\u2028", "٣", "é", "😀",
     "1,5", "0.0000000000000000001", "9" * 40, "0,0\n", "359.9,0\n"]
)  # fmt: skip
TEXT = table(Lobe(cycloidal), 5, decimals=3)
TABLES = [
    TEXT,
    table(Lobe(polynomial, 60, 40), 5, decimals=2),
    table(Lobe(cycloidal), 4, low=100, high=264),
    TEXT.replace(",", ";"),
    TEXT.replace(",", " "),
    "",
]
CHANGES = st.dictionaries(
    st.sampled_from(["zero_deg", "base", "rocker_ratio", "smoothing", "angle", "direction", "lift",
                     "subtract", "measured_at", "angle_column", "lift_column", "header"]),
    st.sampled_from(["0", "1e-9", "0.5", "-3", "7.5", "1e6", "crank", "reversed", "inch", "m", "um",
                     "thou", "valve", "1", "2", "lift", "false", "true", "null", "''"]),
    max_size=2,
)  # fmt: skip


def judge(folder, data: bytes, changes: dict[str, str]) -> None:
    """A scene whose cam compiles and is judged in finite numbers, or faults; so of `cam init`."""
    accepted(lambda: guess(data, "lift.csv"))
    cam = accepted(lambda: scene(folder, data, **changes).cam)
    if cam is not None:
        compiled = build(cam, phase_of(77.7))
        values = [x for row in (*compiled.stretches, compiled.pieces) for x in row]
        values += [cam.accuracy.bound, *cam.errors.bounds]
        assert all(abs(value) < float("inf") for value in values)


@fuzz(80)
@given(st.data())
def test_tables_with_text_changed(folder, data):
    text = data.draw(st.sampled_from(TABLES))
    for _ in range(data.draw(st.integers(0, 3))):
        start = data.draw(st.integers(0, len(text)))
        stop = data.draw(st.integers(start, min(len(text), start + 12)))
        new = data.draw(st.one_of(CELLS, st.just(""), VALUES, st.lists(CELLS).map("".join)))
        text = text[:start] + new + text[stop:]
    if data.draw(st.integers(0, 4)) == 0:
        lines = text.splitlines(keepends=True)
        a, b = (data.draw(st.integers(0, len(lines))) for _ in range(2))
        text = "".join(lines[: min(a, b)] + lines[max(a, b) :])
    judge(folder, text.encode("utf-8", "surrogatepass"), data.draw(CHANGES))


@fuzz(60)
@given(st.data())
def test_tables_of_curves_that_no_cam_has(folder, data):
    """Well-formed: noise, steps, spikes, few digits."""
    count = data.draw(st.integers(16, 120))
    height = data.draw(st.sampled_from([1, 9, 300]))
    shape = data.draw(st.lists(st.integers(0, height), min_size=4, max_size=40))
    gap = data.draw(st.sampled_from([1.0, 0.999, 0.4, 1.002]))
    decimals = data.draw(st.integers(0, 9))
    lines = ["deg,lift"]
    for k in range(count):
        lift = shape[k * len(shape) // count]
        lines.append(f"{360 * gap * k / count:.5f},{lift / max(1, height):.{decimals}f}")
    judge(folder, "\n".join(lines).encode(), data.draw(CHANGES))
