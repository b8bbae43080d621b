"""The recipes of CONTRIBUTING.md, followed word by word in a copy of the package."""

import csv
import json
import os
import re
import shutil
import subprocess
import sys
from functools import cached_property
from math import cos, pi, sin
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
BLOCK = re.compile(r"```(python|diff)\n# (camcli/[\w/]+\.py)\n(.*?)```", re.DOTALL)


DRIVER = """
import contextlib, io, json, sys
from camcli.cli.app import app
from camcli.cli.exit_codes import guarded
for line in sys.stdin:
    words, out, said = line.split(), io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(said):
        code = guarded(lambda: app(words, standalone_mode=False))
    print(json.dumps([code, out.getvalue(), said.getvalue()]), flush=True)
"""


class Copy:
    """A copy of the package in a folder, in which a recipe is followed."""

    def __init__(self, folder: Path, heading: str):
        self.folder = folder
        for part in ("camcli", "configs"):
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(ROOT / part, folder / part, ignore=ignored)
        text = (ROOT / "CONTRIBUTING.md").read_text()
        (recipe,) = re.findall(rf"^## {heading}\n(.*?)^## ", text, re.DOTALL | re.MULTILINE)
        blocks = BLOCK.findall(recipe)
        assert len(blocks) == recipe.count("```") // 2
        for kind, name, content in blocks:
            file = folder / name
            if kind == "python":
                assert not file.exists()
                file.write_text(content)
            else:
                file.write_text(changed(file.read_text(), content))

        self.env = {**os.environ, "PYTHONPATH": str(folder)}

    @cached_property
    def process(self) -> subprocess.Popen:
        """The process of the copy, begun by the first command that it is given."""
        return subprocess.Popen(
            [sys.executable, "-c", DRIVER],
            cwd=self.folder, env=self.env, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip

    def close(self) -> None:
        if "process" in vars(self):
            self.process.communicate()

    def cam(self, line: str, code: int = 0) -> subprocess.CompletedProcess:
        """The command, in the process of the copy."""
        self.process.stdin.write(f"{line}\n")
        self.process.stdin.flush()
        done = subprocess.CompletedProcess(line, *json.loads(self.process.stdout.readline()))
        assert done.returncode == code, done.stdout + done.stderr
        assert "Traceback" not in done.stderr
        return done

    def python(self, *words: str) -> subprocess.CompletedProcess:
        return subprocess.run(
            [sys.executable, *words],
            cwd=self.folder, env=self.env, capture_output=True, text=True, check=False,
        )  # fmt: skip

    def rows(self, name: str) -> list[dict[str, str]]:
        with open(self.folder / name, newline="") as file:
            return list(csv.DictReader(file))


def changed(text: str, diff: str) -> str:
    """The text after a change whose lines begin with ' ', '-' or '+'."""
    lines = diff.splitlines(keepends=True)
    before = "".join(line[1:] for line in lines if line[0] != "+")
    assert text.count(before) == 1, before
    return text.replace(before, "".join(line[1:] for line in lines if line[0] != "-"))


@pytest.mark.parametrize("heading", ["A new command", "A new column", "A new cam kind"])
def test_a_recipe_keeps_the_rules_of_the_house(tmp_path, heading):
    copy = Copy(tmp_path, heading)
    copy.close()
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for words in (("check",), ("format", "--check")):
        done = copy.python("-m", "ruff", *words, "camcli")
        assert done.returncode == 0, done.stdout


@pytest.fixture(scope="module")
def command(tmp_path_factory):
    copy = Copy(tmp_path_factory.mktemp("command"), "A new command")
    yield copy
    copy.close()


def test_a_new_command_runs(command):
    done = command.cam("standstill --points 36 --set follower.preload=10")
    assert "the cam bears at most" in done.stdout
    rows = command.rows("out/standstill/standstill.csv")
    assert [float(row["theta_deg"]) for row in rows] == [10.0 * n for n in range(36)]
    for row in rows:  # of the default machine
        force = 1430.8 * float(row["c_m"]) + 10.0
        assert float(row["force_n"]) == pytest.approx(force, rel=1e-14)
    record = json.loads(command.cam("standstill --json -o json").stdout)
    assert record["command"] == "standstill"
    assert set(record["artefacts"]) == {"standstill.csv"}


def test_a_new_command_has_its_help(command):
    assert "standstill" in command.cam("--help").stdout
    said = command.cam("standstill --help").stdout
    assert "standstill.csv   the force at each phase" in said
    assert "cam standstill --points 36" in said
    assert command.python("-m", "camcli.cli.reference").returncode == 0
    page = (command.folder / "camcli/guide/reference/standstill.md").read_text()
    for column, unit in (("theta_deg", "deg"), ("c_m", "m"), ("force_n", "N")):
        assert f"| `{column}` | {unit} |" in page


def test_a_new_command_plans_without_a_trace(command):
    said = command.cam("standstill --points 36 --dry-run --json -o planned").stdout
    plan = json.loads(said)["plan"]
    assert plan["orbits"] == 1
    assert plan["seconds"] < 1.0
    assert plan["bytes"] < 1e6
    assert not (command.folder / "planned").exists()


def test_a_new_command_is_run_again(command):
    command.cam("standstill --points 12 -o first")
    assert re.search(r"standstill\.csv +same bytes", command.cam("rerun first").stdout)
    (command.folder / "first" / "standstill.csv").write_text("theta_deg\n")
    command.cam("rerun first", code=3)


@pytest.mark.parametrize("line", ["--set follower.mass=-1", "--points 0", "--rpm 1:2", "--nope"])
def test_a_new_command_fails_well(command, line):
    done = command.cam(f"standstill {line} -o failed", code=2)
    assert len(done.stderr) < 500
    assert not (command.folder / "failed").exists()


def test_a_new_command_leaves_a_stranger_file_alone(command):
    (command.folder / "mine").mkdir()
    (command.folder / "mine" / "standstill.csv").write_text("mine")
    command.cam("standstill -o mine", code=2)
    assert (command.folder / "mine" / "standstill.csv").read_text() == "mine"


def test_a_new_command_is_in_the_library(command):
    script = "import camcli; r = camcli.standstill(); print(*r.tables['standstill'])"
    assert command.python("-c", script).stdout.split() == ["theta_deg", "c_m", "force_n"]


@pytest.fixture(scope="module")
def column(tmp_path_factory):
    copy = Copy(tmp_path_factory.mktemp("column"), "A new column")
    yield copy
    copy.close()


SHORT = "--set run.transient=100 --set run.record=20"


@pytest.mark.ci
def test_a_new_column_is_in_every_table_of_its_kind(column):
    column.cam(f"sweep --rpm 700:740 --points 3 {SHORT} --no-plot -o sweep")
    column.cam("detach --rpm 100:180 --points 3 --no-plot -o detach")
    vary = "--rpm 700:740 --vary follower.restitution=0.6:0.8"
    column.cam(f"sweep {vary} --points 2,2 {SHORT} --panels impact_energy_j -o map")
    for name in ("sweep/speeds.csv", "detach/speeds.csv", "map/map.csv"):
        rows = column.rows(name)
        assert rows
        for row in rows:  # of the default machine
            speed = float(row["max_impact_m_per_s"])
            energy = 0.5 * 1.221 * speed * speed
            assert float(row["impact_energy_j"]) == pytest.approx(energy, rel=1e-12)
    assert (column.folder / "map" / "map.png").stat().st_size > 10_000


@pytest.mark.ci
def test_a_new_column_is_told_in_the_reference_and_the_schema(column):
    assert column.python("-m", "camcli.cli.reference").returncode == 0
    for command in ("sweep", "detach"):
        page = (column.folder / f"camcli/guide/reference/{command}.md").read_text()
        assert "| `impact_energy_j` | J | energy of the hardest impact |" in page
    assert "impact_energy_j" in column.cam("schema").stdout
    said = column.cam("sweep --rpm 700:701 --panels impact_energies", code=2).stderr
    assert "did you mean 'impact_energy_j'?" in said


SCENE = """
follower: {mass: 1, stiffness: 1000, restitution: 0.6, preload: 40, damping: 1}
cam: {kind: two-lobes, lift: 0.05}
run: {rpm: 150, transient: 20, record: 20}
sweep: {rpm: {start: 120, stop: 160, num: 3}}
detach: {rpm: {start: 100, stop: 200, num: 3}}
orbits: {rpm: {start: 140, stop: 160, num: 3}, starts: 1}
classify: {rpm: {start: 140, stop: 160, num: 2}}
basins: {rpm: {start: 150, stop: 150, num: 1}, cells: [4, 4]}
"""


@pytest.fixture(scope="module")
def cam_kind(tmp_path_factory):
    copy = Copy(tmp_path_factory.mktemp("cam"), "A new cam kind")
    (copy.folder / "scene.yaml").write_text(SCENE)
    yield copy
    copy.close()


def test_a_new_cam_is_what_its_formula_says(cam_kind):
    cam_kind.cam("simulate -c scene.yaml --profile-only --no-plot -o profile")
    for row in cam_kind.rows("profile/profile.csv"):
        theta = float(row["theta_deg"]) * pi / 180.0
        assert float(row["c_m"]) == pytest.approx(0.025 * (1 - cos(2 * theta)), abs=1e-15)
        slope = 0.05 * sin(2 * theta)
        assert float(row["c_theta_m_per_rad"]) == pytest.approx(slope, abs=1e-15)


ALL = "simulate sweep detach orbits classify basins explore"


@pytest.mark.parametrize("command", ALL.split())
def test_every_command_knows_a_new_cam(cam_kind, command):
    drawn = "" if command in ("simulate", "explore") else "--no-plot"
    cam_kind.cam(f"{command} -c scene.yaml {drawn} -o {command}")
    record = json.loads((cam_kind.folder / command / "run.json").read_text())
    assert record["scene"]["cam"] == {"kind": "two-lobes", "lift": 0.05}


def test_a_new_cam_is_in_the_schema_and_fails_well(cam_kind):
    schema = json.loads(cam_kind.cam("schema").stdout)
    assert "two-lobes" in schema["properties"]["cam"]["discriminator"]["mapping"]
    said = cam_kind.cam("detach -c scene.yaml --set cam.lift=-1", code=2).stderr
    assert "cam.lift" in said
    assert "two-lobes" in cam_kind.cam("detach --set cam.kind=three-lobes", code=2).stderr
