"""Every shipped scene by every command, and every number of a scene varied and toleranced.

Small sizes, the scene's own machine, ranges and options. A run ends in 0 or 3, never in an internal
fault; its statuses are those that the program documents; its tables are whole.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml
from conftest import cam_in, rows

from camcli.errors import Status
from camcli.scene import load_scene, resolved

CONFIGS = Path(__file__).parents[2] / "configs"
SCENES = [*sorted(CONFIGS.glob("*.yaml")), *sorted((CONFIGS / "figures").glob("*.yaml"))]
MACHINES = [scene for scene in SCENES if scene.parent == CONFIGS]
SHORT = "--set run.transient=200 --set run.record=140 --set run.patience=300"
SMALL = {  # options that make a command small; its scene decides the rest
    "simulate": f"{SHORT} --points 200",
    "sweep": "--points 21",
    "detach": "--points 5",
    "orbits": f"--prove --points 8 --set orbits.starts=3 --set orbits.simulated=0 {SHORT} "
    "--set run.work_budget=20000",
    "basins": f"{SHORT} --cells 12,12 --set basins.refine=0 --set basins.budget=300",
    "classify": "--points 7",
    "explore": f"--set sweep.rpm.num=5 {SHORT} --set run.work_budget=5000",
}
# What a column `status` may hold: the statuses of the program, and those of what a command solves.
STATUSES = {status.text for status in Status} | {""}


def _names(path: Path) -> str:
    return str(path.relative_to(CONFIGS)).removesuffix(".yaml")


def _line(command: str, scene: Path) -> str:
    """The command's line; a scene of one speed or of another parameter keeps its own range."""
    options = SMALL[command]
    if scene not in MACHINES and SHORT not in options:
        options += f" {SHORT}"  # the command of a figure runs whole in cam figures --check
    if scene not in MACHINES and command == "sweep":
        options += " --set sweep.zoom=[]"
    section = yaml.safe_load(scene.read_text()).get(command) or {}
    vary = section.get("vary")
    if vary and "--points" in options:
        head, _, tail = options.partition("--points ")
        number, *rest = tail.split(" ", 1)
        sizes = ",".join([str(min(int(number), 5))] * len(vary))
        options = f"{head} --set {command}.rpm.num=3 " + " ".join(rest)
        axes = [{**axis, "num": int(sizes.split(",")[0])} for axis in vary]
        options += f" --set '{command}.vary={json.dumps(axes)}'"
    if command != "explore":
        options += " --no-plot"
    return f"{command} -c {scene} {options} --quiet -o out"


USED = {"explore": ("sweep", "orbits", "basins", "explore")}  # sections, beside those of a machine


def _different() -> list[tuple[Path, str]]:
    """Each scene with each command, but not where both are another one's to the last number."""
    seen, found = set(), []
    for scene in SCENES:
        whole = resolved(load_scene(scene))
        for command in SMALL:
            parts = ("follower", "cam", "run", "spring", "contact", *USED.get(command, (command,)))
            asked = command + json.dumps([whole.get(part) for part in parts])
            if asked not in seen:
                found.append((scene, command))
            seen.add(asked)
    return found


def _marks(scene, command) -> list:
    """CI runs figures by all commands, and by their own in whole with `cam figures --check`.

    The sweep of an atlas, which follows its curves, is left to that.
    """
    if scene in MACHINES:
        return []
    is_long = scene.stem.startswith("atlas") and command == "sweep"
    return [pytest.mark.soak if is_long else pytest.mark.ci]


@pytest.mark.parametrize(
    ("scene", "command"),
    [
        pytest.param(
            *pair,
            id=f"{_names(pair[0])}-{pair[1]}",
            marks=_marks(*pair),
        )
        for pair in _different()
    ],
)
def test_every_scene_by_every_command(tmp_path, scene, command):
    done = cam_in(tmp_path, _line(command, scene))
    assert done.returncode in (0, 3), done.stderr
    assert "internal fault" not in done.stderr
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    assert record["command"] == command
    for name in record["artefacts"]:
        if not name.endswith(".csv"):
            continue
        for row in rows(tmp_path / "out" / name):
            assert None not in row
            assert None not in row.values(), name
            assert row.get("status", "") in STATUSES, row
            assert "nan" not in row.values(), row


def _numbers(value: object, path: str) -> Iterator[tuple[str, float]]:
    """Every number below a key of a scene, with its path."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _numbers(inner, f"{path}.{key}")
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield path, float(value)


def _keys(name: str, *parts: str) -> list[tuple[Path, str, float]]:
    """The numbers in parts of a shipped scene, defaults included."""
    scene = CONFIGS / f"{name}.yaml"
    whole = resolved(load_scene(scene))
    return [(scene, *number) for part in parts for number in _numbers(whole.get(part), part)]


KEYS = [  # each number once; those of the follower and the run are the same in every scene
    *_keys("chapter", "follower", "cam", "run"),
    *_keys("bouncing-ball", "cam"),
    *_keys("law-smooth", "cam"),
    *_keys("lift-table", "cam", "spring", "contact"),
]


@pytest.mark.ci
@pytest.mark.parametrize(("scene", "key", "value"), KEYS, ids=lambda x: getattr(x, "stem", str(x)))
def test_every_number_varies_and_has_a_tolerance_or_says_why_not(tmp_path, scene, key, value):
    """Where it cannot, the message names the key and the exit code is 2."""
    low, high = sorted((value * 0.97, value * 1.03)) if value else (0.0, 0.01)
    vary = f"sweep -c {scene} --vary {key}={low}:{high} --points 2 --no-plot {SHORT} -o a"
    spread = f"detach -c {scene} --tolerance {key}=1% --points 2 --no-plot {SHORT} -o b"
    for line in (vary, f"{spread} --set detach.machines=2"):
        done = cam_in(tmp_path, line)
        assert done.returncode in (0, 2, 3), done.stderr
        if done.returncode == 2:
            assert key.rpartition(".")[2] in done.stderr, done.stderr


SPRING = {"spring": {"seat_load": 260.0, "nose_load": 640.0, "solid_at": 0.02},
          "contact": {"width": 0.01, "follower_radius": 0.02, "base_radius": 0.018,
                      "modulus": 1.1e11}}  # fmt: skip


def test_numbers_of_spring_and_contact_are_set_and_not_varied(tmp_path):
    """Two loads are a line through both; what cannot be varied is refused by its name."""
    cam = {"kind": "eccentric", "base": 0.001, "lift": 0.01}
    scene = {"follower": {"mass": 0.1, "restitution": 0.4}, "cam": cam, **SPRING}
    (tmp_path / "s.yaml").write_text(yaml.safe_dump(scene))
    for section, numbers in SPRING.items():
        for key, value in numbers.items():
            name = f"{section}.{key}"
            own = load_scene(scene, {name: value * 1.1})
            loads = {**SPRING["spring"], **({key: value * 1.1} if section == "spring" else {})}
            rate = (loads["nose_load"] - loads["seat_load"]) / 0.01
            assert own.follower.stiffness == pytest.approx(rate)
            assert own.follower.preload == pytest.approx(loads["seat_load"] - rate * 0.001)
            assert own.spring.solid_at == loads["solid_at"]
            if section == "contact":
                assert getattr(own.contact, key) == value * 1.1
            for line in (f"sweep --vary {name}=1:2", f"detach --tolerance {name}=1%"):
                done = cam_in(tmp_path, f"{line} -c s.yaml --no-plot -o out", code=2)
                assert f"found the key '{name}'" in done.stderr


@pytest.mark.parametrize("inside", [True, False])
def test_a_third_of_a_spring_given_by_two_loads_is_added_once(inside):
    cam = {"kind": "eccentric", "base": 0.001, "lift": 0.01}
    own = {**SPRING["spring"], "mass": 0.06, "in_follower": inside}
    scene = load_scene({"follower": {"mass": 0.1, "restitution": 0.4}, "cam": cam, "spring": own})
    assert scene.follower.mass == pytest.approx(0.1 if inside else 0.12)
    assert (scene.spring.mass, scene.spring.in_follower) == (0.06, True)
    again = load_scene(resolved(scene))
    assert again.follower.mass == scene.follower.mass
