"""Whatever a scene, an option or a table says: done, refused in words, or a status. Never more."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from camcli.scene import parse_rpm
from tests.hostile.bounds import (
    NUMBERS,
    ODD,
    VALUES,
    accepted,
    command_line,
    fuzz,
    load_and_run,
    plain_kernel,
)

CONFIGS = Path(__file__).parents[2] / "configs"
SCENES = {path.name: yaml.safe_load(path.read_text()) for path in sorted(CONFIGS.glob("*.yaml"))}
TABLE = (CONFIGS / "valve-lift.csv").read_text()
COMMANDS = ("simulate", "sweep", "detach", "orbits", "classify", "basins", "bench")
SHORT = ("run.transient=0", "run.record=1", "run.impact_budget=50")
SPEEDS = st.one_of(
    NUMBERS, st.tuples(NUMBERS, NUMBERS).map(":".join), ODD, st.text(max_size=10),
    st.lists(NUMBERS, max_size=4).map(":".join),
)  # fmt: skip
KEYS = sorted(
    {
        ".".join((section, *more))
        for scene in SCENES.values()
        for section, values in scene.items()
        for more in [(), *((key,) for key in (values or {}))]
    }
    | {"run.start.q", "run.start.v", "run.start.theta_deg", "sweep.rpm.num", "sweep.rpm.start",
       "basins.rpm.num", "cam.rise.law", "cam.rise.length_deg", "cam.rise.start_deg",
       "cam.fall.length_deg", "cam.sha256", "cam.allow_outside", "cam.max_lift", "x.y", "cam.x"}
)  # fmt: skip
SETS = st.lists(
    st.one_of(
        st.tuples(st.sampled_from(KEYS), VALUES).map("=".join),
        st.tuples(st.text(max_size=10), VALUES).map("=".join),
        st.text(st.characters(), max_size=20),
    ),
    max_size=4,
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("hostile")
    (place / "valve-lift.csv").write_text(TABLE)
    return place


@pytest.fixture(scope="module", autouse=True)
def _plain():
    with plain_kernel():
        yield


class Raw(str):
    """Text that is written into the scene as it stands."""


def written(value: object, indent: str = "") -> str:
    """A value as block YAML, raw texts unchanged; what is no YAML then is what we want to see."""
    if isinstance(value, dict) and value:
        lines = [f"\n{indent}{key}: {written(item, indent + '  ')}" for key, item in value.items()]
        return "".join(lines)
    return value if isinstance(value, Raw) else json.dumps(value, allow_nan=True)


@st.composite
def mutated(draw) -> str:
    """A shipped scene with some keys changed, lost, doubled, misspelt or moved."""
    scene = json.loads(json.dumps(SCENES[draw(st.sampled_from(sorted(SCENES)))]))
    for _ in range(draw(st.integers(1, 4))):
        node = scene
        while True:
            key = draw(st.sampled_from(sorted(node, key=str)))
            if not isinstance(node[key], dict) or not node[key] or draw(st.booleans()):
                break
            node = node[key]
        how = draw(st.sampled_from(["value"] * 6 + ["lost", "double", "misspelt", "moved"]))
        if how == "value":
            node[key] = Raw(draw(VALUES))
        elif how == "double":
            node[Raw(f'"{key}"')] = node[key]
        else:
            value = node.pop(key)
            if how == "misspelt":
                node[draw(st.sampled_from([f"{key}s", key[1:] or "k", key.upper()]))] = value
            elif how == "moved":
                scene[key] = value
        if not scene:
            break
    return written(scene).lstrip("\n") + "\n"


@fuzz(40)
@given(st.one_of(mutated(), mutated().map(lambda text: text.replace("\n", "\r\n"))))
def test_fuzz_of_scenes_with_mutations(folder, text):
    path = folder / "scene.yaml"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    load_and_run(path)


@fuzz(40)
@given(st.one_of(st.binary(max_size=300), st.text(max_size=300).map(str.encode)), st.integers(0, 9))
def test_fuzz_of_random_bytes_in_a_scene(folder, data, cut):
    path = folder / "scene.yaml"
    text = (CONFIGS / "eccentric.yaml").read_bytes()
    at = len(text) * cut // 10
    path.write_bytes(data if cut == 0 else text[:at] + data + text[at:])
    load_and_run(path)


@fuzz(40)
@given(st.sampled_from(sorted(SCENES)), SETS)
def test_fuzz_of_sets(name, sets):
    load_and_run(CONFIGS / name, sets)


@fuzz(100)
@given(SPEEDS)
def test_fuzz_of_speeds(text):
    speeds = accepted(lambda: parse_rpm(text))
    for speed in () if speeds is None else speeds if isinstance(speeds, tuple) else (speeds,):
        assert 1e-9 <= speed <= 1e9


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
    "run.chatter_tolerance": ["1e-13", "1e-3"],
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
    name = draw(st.sampled_from([n for n in SCENES if n not in ("lift-table.yaml",)]))
    cam = SCENES[name]["cam"]
    known = [k for k in CAMS if k.split(".")[1] in cam]
    keys = draw(st.lists(st.sampled_from([*PHYSICS, *PHYSICS, *known]), max_size=5, unique=True))
    choices = {**PHYSICS, **CAMS}
    return CONFIGS / name, [f"{key}={draw(st.sampled_from(choices[key]))}" for key in keys]


@fuzz(40)
@given(extremes())
def test_fuzz_of_extreme_machines(machine):
    load_and_run(*machine)


@fuzz(40)
@given(
    st.sampled_from(COMMANDS),
    st.sampled_from(sorted(SCENES)),
    SETS,
    st.none() | SPEEDS,
    st.none() | NUMBERS | ODD | st.integers(-3, 10**12).map(str),
    st.none() | NUMBERS,
)
def test_fuzz_of_the_command_line(command, name, sets, rpm, points, threads):
    given_ = (("--rpm", rpm), ("--points", points), ("--threads", threads))
    words = [f"{option}={text}" for option, text in given_ if text is not None]
    words += [word for text in (*sets, *SHORT) for word in ("--set", text)]
    code, said = command_line([command, "--dry-run", "-c", str(CONFIGS / name), *words])
    assert code in (0, 2), said
    assert "internal fault" not in said
    assert (code == 0) or said.strip()
    assert all(line.isprintable() for line in said.splitlines())


@fuzz(40)
@given(
    st.sampled_from(["--cells", "--q", "--v", "--refine", "--method"]),
    st.one_of(SPEEDS, NUMBERS, ODD, st.text(max_size=10)),
)
def test_fuzz_of_a_window(option, text):
    words = ("basins", "--dry-run", f"{option}={text}", *(f"--set={s}" for s in SHORT))
    code, said = command_line(words)
    assert code in (0, 2), said


@fuzz(40)
@given(st.data())
def test_fuzz_of_lift_tables(folder, data):
    lines = TABLE.splitlines(keepends=True)
    for _ in range(data.draw(st.integers(1, 3))):
        k = data.draw(st.integers(0, len(lines) - 1))
        bits = st.one_of(VALUES, st.tuples(NUMBERS, NUMBERS).map(",".join), st.just(""))
        lines[k] = data.draw(bits) + data.draw(st.sampled_from(["\n", "\r\n", "\r", ""]))
    (folder / "bad.csv").write_bytes("".join(lines).encode("utf-8", "surrogatepass"))
    path = folder / "table.yaml"
    path.write_text((CONFIGS / "lift-table.yaml").read_text().replace("valve-lift", "bad"))
    load_and_run(path)
