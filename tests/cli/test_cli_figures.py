"""cam figures: what is computed and why, the page, the comparison with the reference."""

import json
import shutil
import signal
import subprocess
import sys
import time
from html.parser import HTMLParser
from pathlib import Path

import pytest

from camcli.cli.figures_check import check
from camcli.cli.figures_plan import chosen, figures
from camcli.errors import SceneError

ROOT = Path(__file__).parents[2]
REAL = ROOT / "configs" / "figures"
NAMES = [
    "3.2a", "3.2b", "3.2c", "3.3", "3.4", "3.5", "3.6a", "3.6b", "3.6c", "3.6d", "3.6e", "3.6f",
    "3.7a", "3.7b", "3.7c", "3.8a", "3.8b", "3.9a", "3.9b", "3.9c", "3.9d", "3.10", "3.11", "3.12",
    "3.13", "3.14",
]  # fmt: skip
MACHINE = """
follower: {mass: 1.221, stiffness: 1430.8, restitution: 0.8}
cam: {kind: arcs, base_radius: 0.4, flank_center: 0.45, flank_radius: 0.85,
      nose_center: 0.40393320723821, nose_radius: 0.15, top_dwell_deg: 40, offset: 0.3}
"""
RUN = "run: {rpm: 190, transient: 5, record: 2}"
SWEEP = "run: {transient: 20, record: 10}\nsweep: {rpm: {start: 700, stop: 745, num: 4}}"
FIGURES = {
    "1.1": ("simulate", RUN),
    "1.2a": ("sweep", SWEEP),
    "1.10": ("simulate --profile-only", RUN),
}


def write(folder: Path, name: str, command: str, rest: str = "", more: str = "") -> Path:
    folder.mkdir(exist_ok=True)
    head = f'figure: {{title: "On {name}", command: {command}, shows: "a <b> & c"{more}}}'
    (folder / f"{name}.yaml").write_text(f"{head}{MACHINE}{rest}\n")
    return folder / f"{name}.yaml"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, (command, rest) in FIGURES.items():
        write(tmp_path / "scenes", name, command, rest)
    return tmp_path / "scenes"


@pytest.fixture
def run(cam, folder):
    def call(*words: str, code: int = 0):
        done = cam("figures", *words, "--folder", str(folder), "-o", "out")
        assert done.returncode == code, done.stdout + done.stderr
        assert "Traceback" not in done.stderr
        return done

    return call


def reasons(done) -> dict[str, str]:
    return {row["figure"]: row["reason"] for row in json.loads(done.stdout)["figures"]}


def test_only_what_changed_is_computed_with_its_reason(run, folder, tmp_path):
    assert reasons(run("--json")) == dict.fromkeys(FIGURES, "new")
    path = folder / "1.1.yaml"
    path.write_text(path.read_text().replace("On", "About") + "# said\nbasins: {refine: 1}\n")
    done = run("--json")
    assert reasons(done) == dict.fromkeys(FIGURES, "unchanged")
    assert list(reasons(done)) == ["1.1", "1.2a", "1.10"]
    assert all(row["seconds"] == 0.0 for row in json.loads(done.stdout)["figures"])

    changed = reasons(run("--json", "--set", "follower.restitution=0.7"))
    assert changed == {"1.1": "scene changed", "1.2a": "scene changed", "1.10": "unchanged"}

    picture, state = (tmp_path / "out" / "1.10" / name for name in ("profile.png", "figure.json"))
    picture.unlink()
    (plan,) = json.loads(run("--json", "--dry-run", "1.10").stdout)["plan"]
    assert plan["reason"] == "artefact changed"
    assert not picture.exists()
    assert reasons(run("--json", "1.10")) == {"1.10": "artefact changed"}
    assert picture.exists()
    state.write_text(state.read_text().replace('"program": "', '"program": "0'))
    assert reasons(run("--json", "1.10")) == {"1.10": "program changed"}


def test_another_lift_table_is_data_changed(run, folder):
    for path in folder.iterdir():
        path.unlink()
    scene = (ROOT / "configs" / "lift-table.yaml").read_text()
    head = "figure: {title: a table, command: simulate --profile-only}\n"
    (folder / "2.yaml").write_text(head + scene)
    table = folder / "valve-lift.csv"
    shutil.copy(ROOT / "configs" / table.name, table)
    assert reasons(run("--json")) == {"2": "new"}
    assert reasons(run("--json")) == {"2": "unchanged"}
    table.write_bytes(table.read_bytes() + b"\n")
    assert reasons(run("--json")) == {"2": "data changed"}


class Page(HTMLParser):
    """Tags with their attributes, and ids."""

    def __init__(self, text: str):
        super().__init__()
        self.tags, self.open = [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in ("meta", "img", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def all(self, tag: str) -> list[dict]:
        return [attrs for name, attrs in self.tags if name == tag]


def test_the_page_is_whole_and_needs_nothing_from_elsewhere(run, tmp_path):
    run("1.1", "1.10")
    out = tmp_path / "out"
    text = (out / "index.html").read_text()
    page = Page(text)
    assert not page.open
    assert not page.all("script")
    assert "http" not in text
    pictures = page.all("img")
    assert [p["src"] for p in pictures] == ["1.1/simulate.png", "1.10/profile.png"]
    for picture in pictures:
        assert picture["alt"].endswith("opens the picture")
        assert int(picture["width"]) == 1340
        assert int(picture["height"]) > 500
    ids = {attrs["id"] for _, attrs in page.tags if "id" in attrs}
    for link in page.all("a"):
        target = link["href"]
        assert target[1:] in ids if target.startswith("#") else (out / target).is_file()
    assert text.count("Not computed yet") == 1
    assert "<dt>label</dt><dd>P(1;inf)</dd>" in text
    assert "transient: 5" in text
    assert f"cam simulate -c {tmp_path / 'scenes' / '1.10.yaml'} --profile-only" in text


def test_bytes_do_not_depend_on_threads(run, tmp_path):
    def contents():
        paths = [*(tmp_path / "out").rglob("*.csv"), *(tmp_path / "out").rglob("*.png")]
        return {path: path.read_bytes() for path in paths}

    run("1.2", "1.10", "--threads", "1")
    first = contents()
    shutil.rmtree(tmp_path / "out")
    run("1.2", "1.10", "--threads", "4")
    assert contents() == first
    assert len(first) == 6


def test_check_names_every_number_that_drifted(run, folder):
    assert "no such file" in run("--check", "1.1", code=3).stdout
    run("--update-reference", "1.1")
    assert "every number is the reference's" in run("--check", "1.1").stdout

    path = folder / "reference" / "1.1.json"
    reference = json.loads(path.read_text())
    name = "events.csv theta_deg largest"
    true = reference["regular"][name]
    reference["regular"][name] = true + 0.5
    path.write_text(json.dumps(reference))
    said = run("--check", "1.1", code=3).stdout
    assert f"1.1: {name}: reference {true + 0.5!r}, found {true!r}, off by -0.5" in said
    assert "1 numbers drifted in 1 figure" in said
    assert "portability" not in said


@pytest.mark.parametrize("text", ["{", "[1, 2]", '{"regular": {}}'])
def test_a_reference_that_is_none_is_a_fault(run, folder, text):
    run("1.10")
    (folder / "reference").mkdir()
    (folder / "reference" / "1.10.json").write_text(text)
    with pytest.raises(SceneError, match="--update-reference"):
        check(figures(folder)[-1], folder.parent / "out")


def test_a_last_bit_of_a_chaotic_motion_is_a_broken_portability(run, folder):
    run("--update-reference", "1.2a")
    path = folder / "reference" / "1.2a.json"
    reference = json.loads(path.read_text())
    assert reference["chaotic"]["impacts.csv rows"] > 10
    name = "impacts.csv theta_deg median"
    true = reference["chaotic"][name]
    reference["chaotic"][name] = true * (1.0 + 2e-16)
    path.write_text(json.dumps(reference))
    said = run("--check", "1.2a", code=3).stdout
    assert f"1.2a: {name} (chaotic): reference {reference['chaotic'][name]!r}" in said
    assert "portability broke: only chaotic motions and last bits differ" in said


def test_another_restitution_drifts_and_says_that_the_scene_did(run):
    run("--update-reference", "1.2a", "1.10")
    done = run("--check", "--json", "1", "--set", "follower.restitution=0.79", code=2)
    assert "expected one of 1.1, 1.2a, 1.10" in done.stderr
    words = ("--check", "--json", "1.2", "1.10", "--set", "follower.restitution=0.79")
    found = json.loads(run(*words, code=3).stdout)
    assert {drift["figure"] for drift in found["drifts"]} == {"1.2a"}
    assert found["drifts"][0]["name"] == "hash of the scene"
    assert not any(drift["portability"] for drift in found["drifts"])


def test_an_interrupted_run_keeps_finished_figures(run, folder, tmp_path):
    write(folder, "1.3", "sweep", "run: {transient: 100000}")
    words = ["figures", "--folder", str(folder), "-o", "out", "--threads", "2"]
    process = subprocess.Popen(
        [sys.executable, "-m", "camcli", *words],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    until = time.monotonic() + 60
    done = tmp_path / "out" / "1.10" / "figure.json"
    while not done.exists() and time.monotonic() < until:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130, said
    assert "interrupted" in said
    assert not (tmp_path / "out" / "1.3" / "figure.json").exists()
    assert "Not computed yet" in (tmp_path / "out" / "index.html").read_text()
    plan = json.loads(run("--json", "--dry-run").stdout)["plan"]
    assert [row["figure"] for row in plan if row["reason"] == "new"] == ["1.3"]


def test_a_figure_that_fails_leaves_the_others(run, folder):
    write(folder, "1.3", "simulate", "run: {start: {q: 0.05}}")
    done = run("1.3", "1.10", code=2)
    assert "1.3: " in done.stderr
    assert "below the cam" in done.stderr
    assert reasons(run("--json", "1.10")) == {"1.10": "unchanged"}


def test_faults_of_all_scenes_at_once(run, folder):
    write(folder, "2.1", "swep")
    write(folder, "2.2", "sweep --frobnicate")
    write(folder, "2.3", "sweep -o elsewhere")
    write(folder, "2.4", "sweep", more=", colour: red")
    write(folder, "2.5", "''")
    (folder / "2.6.yaml").write_text(MACHINE)
    write(folder, "2.7", '"sweep \'"')
    write(folder, "2.8", "figures")
    said = run(code=2).stderr.splitlines()
    told = {"2.1": "swep", "2.2": "--frobnicate", "2.3": "--out", "2.4": "colour",
            "2.5": "no command", "2.6": "no such section", "2.7": "quotation",
            "2.8": "figures"}  # fmt: skip
    assert len(said) == len(told)
    for (name, words), line in zip(told.items(), said, strict=True):
        assert f"{name}.yaml" in line
        assert words in line


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--check", "--update-reference"), "--check"),
        (("--update-reference", "--set", "run.rpm=3"), "--set"),
        (("--threads", "0"), "--threads"),
        (("--rpm", "3"), "--rpm"),
        (("--folder", "absent"), "absent"),
        (("7.7",), "7.7"),
    ],
)
def test_faults_of_the_command_line(cam, folder, words, told):
    given = () if "--folder" in words else ("--folder", str(folder))
    done = cam("figures", *words, *given)
    assert done.returncode == 2
    assert told in done.stderr


def test_the_chapter_is_complete_and_its_references_are_small():
    known = figures(REAL)
    assert [figure.name for figure in known] == NAMES
    assert [figure.name for figure in chosen(known, ["3.6", "3.10"])] == [*NAMES[6:12], "3.10"]
    assert all(figure.shows and figure.title for figure in known)
    references = list((REAL / "reference").iterdir())
    assert sorted(path.name for path in references) == sorted(f"{name}.json" for name in NAMES)
    assert sum(path.stat().st_size for path in references) < 300_000
    for figure in known:
        scene = json.loads((REAL / "reference" / f"{figure.name}.json").read_text())["scene"]
        assert scene == figure.hashes["scene"], f"{figure.name}: --update-reference"


def test_a_figure_is_a_scene_of_its_command(cam):
    for figure in figures(REAL):
        if figure.name in ("3.2a", "3.5", "3.6f", "3.7b", "3.8b", "3.14"):
            done = cam(figure.words[0], "-c", str(figure.path), "--dry-run", *figure.words[1:])
            assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_real_figures_agree_with_their_reference(cam):
    done = cam("figures", "--check", "3.2", "3.4", "3.5", "3.6f", "3.8b", "3.9a", "3.10", "3.14")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "every number is the reference's" in done.stdout
