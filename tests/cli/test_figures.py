"""cam figures: what is computed and why, the page, the comparison with the reference."""

import json
import os
import re
import shutil
import signal
import threading
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from time import sleep
from types import SimpleNamespace as Made

import pytest

import camcli
import camcli.cli.figures as figures_module
from camcli.cli.exit_codes import DONE, INTERNAL, NUMERICS, USAGE
from camcli.cli.figures import State, chosen, compared, figures_in, read, verdict
from camcli.cli.options import Request
from camcli.output.certificate_check import CheckedCertificate, check_certificate
from camcli.output.digest import Drift, caption, digest, drifts
from camcli.output.run_folder import run_folder
from tests.conftest import cam_in

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
REAL = ROOT / "configs" / "figures"
NAMES = [
    "all-orbits", "atlas", "atlas-nose", "chaos", "motion",
    "proof-doubling", "proof-lift-off", "proof-three-turns", "proof-two-impacts",
    "3.1", "3.2", "3.3", "3.4", "3.5", "3.6a", "3.6b", "3.6c",
    "3.6d", "3.6e", "3.6f", "3.7", "3.8a", "3.8b", "3.9a", "3.9b", "3.9c", "3.9d", "3.10",
    "3.11", "3.14",
]  # fmt: skip
MACHINE = """
follower: {mass: 1.221, stiffness: 1430.8, restitution: 0.8}
cam: {kind: arcs, base_radius: 0.4, flank_center: 0.45, flank_radius: 0.85,
      nose_center: 0.40393320723821, nose_radius: 0.15, top_dwell_deg: 40, offset: 0.3}
"""
NO_FAULTS = {"piece_faults": []}
RUN = "run: {rpm: 190, transient: 5, record: 2}"
SWEEP = "run: {transient: 20, record: 10}\nsweep: {rpm: {start: 700, stop: 745, num: 4}}"
FIGURES = {
    "1.1": ("simulate", RUN),
    "1.2a": ("sweep", SWEEP),
    "1.10": ("simulate", f"{RUN}\nsimulate: {{profile_only: true}}"),
}


def write(folder, name, command, rest="", more="", shows=True) -> None:
    words = ', shows: "a <b> & c"' if shows else ""
    head = f'figure: {{title: "On {name}", command: {command}{words}{more}}}'
    (folder / f"{name}.yaml").write_text(f"{head}{MACHINE}{rest}\n")


@pytest.fixture(scope="module")
def computed(tmp_path_factory):
    """A folder with scenes, their figures in out, and references of them: made once."""
    home = tmp_path_factory.mktemp("figures")
    (home / "scenes").mkdir()
    for name, (command, rest) in FIGURES.items():
        write(home / "scenes", name, command, rest)
    for more in ("", "--update-reference"):
        cam_in(home, f"figures --folder {home}/scenes -o {home}/out -q", more, code=0)
    return home


@pytest.fixture
def home(computed, tmp_path):
    """A copy of `computed` to change."""
    return shutil.copytree(computed, tmp_path / "home")


@pytest.fixture
def run(home, cam):
    """`cam figures WORDS`: what it printed."""

    def call(*words, code=0):
        return cam("figures", *words, "--folder home/scenes -o home/out", code=code)

    return call


def reasons(run, *words):
    plan = json.loads(run("--dry-run", "--json", *words).stdout)["plan"]
    return {row["figure"]: row["reason"] for row in plan}


@pytest.mark.ci
def test_only_what_changed_is_computed_with_its_reason(run, home):
    assert reasons(run) == dict.fromkeys(FIGURES, "unchanged")
    assert list(reasons(run)) == ["1.1", "1.2a", "1.10"]
    path = home / "scenes" / "1.1.yaml"
    path.write_text(path.read_text().replace("On", "About") + "# said\nbasins: {refine: 1}\n")
    assert reasons(run) == dict.fromkeys(FIGURES, "unchanged")
    changed = reasons(run, "--set", "follower.restitution=0.7")
    assert changed == {"1.1": "scene changed", "1.2a": "scene changed", "1.10": "unchanged"}

    picture, state = (home / "out" / "1.10" / name for name in ("profile.png", "figure.json"))
    picture.unlink()
    assert reasons(run, "1.10") == {"1.10": "artefact changed"}
    done = json.loads(run("--json").stdout)["figures"]
    assert [row["figure"] for row in done if row["seconds"]] == ["1.10"]
    assert picture.exists()
    state.write_text(state.read_text().replace('"program": "', '"program": "0'))
    assert reasons(run, "1.10") == {"1.10": "program changed"}


def test_a_misshapen_state_or_record_is_none_and_stops_no_other_figure(run, home):
    record, path = (home / "out" / "1.1" / name for name in ("run.json", "figure.json"))
    whole = json.loads(path.read_text())
    for text in ("{", "[1]", "{}", "\ufeff\0", json.dumps({**whole, "hashes": ["x"]})):
        path.write_text(text)
        assert read(State, path) is None
        assert reasons(run) == {"1.1": "new", "1.2a": "unchanged", "1.10": "unchanged"}
    for text in ("[" * 100_000, '{"result": {"a": [{}, 1]}, "cost": {"impacts": 1}}', "[]"):
        record.write_text(text)
        assert reasons(run)["1.10"] == "unchanged"
    for file in (record, path):
        file.unlink()
        os.mkfifo(file)
    (home / "out" / "1.2a" / "run.json").write_text("[" * 30)
    (home / "out" / "1.10" / "figure.json").write_text("[]")
    done = json.loads(run("--json", "1.10").stdout)["figures"]
    assert [row["reason"] for row in done] == ["new"]
    assert (home / "out" / "index.html").read_text().count("Not computed yet") == 1
    assert reasons(run)["1.1"] == "new"


def test_the_installed_figures_keep_their_references(cam):
    inside = Path(camcli.__file__).parent
    done = cam("figures", "--folder", str(inside), "--update-reference")
    assert (done.returncode, "installed program" in done.stderr) == (2, True)


@pytest.mark.ci
def test_another_lift_table_is_data_changed(run, home):
    for path in (home / "scenes").glob("*.yaml"):
        path.unlink()
    scene = (ROOT / "configs" / "lift-table.yaml").read_text()
    head = "figure: {title: a table, command: simulate}\nsimulate: {profile_only: true}\n"
    (home / "scenes" / "2.yaml").write_text(head + scene)
    table = home / "scenes" / "valve-lift.csv"
    shutil.copy(ROOT / "configs" / table.name, table)
    run("--quiet")
    assert reasons(run) == {"2": "unchanged"}
    table.write_bytes(table.read_bytes() + b"\n")
    assert reasons(run) == {"2": "data changed"}


def test_the_page_shows_what_was_computed(computed):
    text = (computed / "out" / "index.html").read_text()
    for name in ("1.1/simulate.png", "1.2a/sweep.png", "1.10/profile.png"):
        assert f'<img src="{name}" width="20' in text
        assert (computed / "out" / name).is_file()
    assert "<dt>label</dt><dd>P(1;inf)</dd>" in text
    assert "transient: 5" in text
    assert f"cam simulate -c {computed / 'scenes' / '1.10.yaml'}" in text
    assert "Not computed yet" not in text


def test_a_check_computes_again_and_no_byte_depends_on_threads(run, home):
    def contents():
        paths = [*(home / "out").rglob("*.csv"), *(home / "out").rglob("*.png")]
        return {path: path.read_bytes() for path in paths}

    before = contents()
    assert "every number is the reference's" in run("--check", "--threads", "1", "1.2").stdout
    assert len(before) == 9
    assert contents() == before


def test_figures_that_take_long_have_processes_of_their_own(run, home, monkeypatch):
    """No byte changes, and nothing is computed here."""

    def contents():
        paths = [*(home / "out").rglob("*.csv"), *(home / "out").rglob("*.png")]
        return {path: path.read_bytes() for path in paths}

    before = contents()
    path = home / "out" / "1.1" / "figure.json"
    last = re.sub(r'"seconds": [0-9.]+', '"seconds": 100.0', path.read_text())
    path.write_text(last)
    monkeypatch.setattr(figures_module, "compute", None)
    assert "every number is the reference's" in run("--check", "--threads", "2").stdout
    assert contents() == before


def drifted(home, name, change):
    """The drifts of a figure whose reference a function has changed."""
    path = home / "scenes" / "reference" / f"{name}.json"
    reference = json.loads(path.read_text())
    change(reference)
    path.write_text(json.dumps(reference))
    (figure,) = chosen(figures_in(home / "scenes"), [name])
    return compared(figure, state_of(home, name))


def state_of(home, name):
    return read(State, home / "out" / name / "figure.json")


def test_every_number_that_drifted_is_named(home, run):
    name = "events.csv theta_deg largest"

    def move(reference):
        reference["regular"][name] += 0.5

    (drift,) = drifted(home, "1.1", move)
    assert (drift.name, drift.by, drift.portability) == (name, -0.5, False)
    said = run("--check", "1.1", code=3).stdout
    assert f"1.1: {name}: reference {drift.reference!r}, found {drift.found!r}, off by -0.5" in said
    assert "1 number drifted in 1 figure" in said
    assert "portability" not in said
    quiet = run("--check", "1.1", "-q", code=3)  # a script in CI is told which number it is
    assert (quiet.stdout, quiet.stderr.splitlines()[-2:]) == ("", said.splitlines()[-3:-1])


def test_a_last_bit_of_a_chaotic_motion_is_a_broken_portability(home):
    name = "impacts.csv theta_deg median"

    def nudge(reference):
        assert reference["chaotic"]["impacts.csv rows"] > 0
        reference["chaotic"][name] *= 1.0 + 2e-16

    found = drifted(home, "1.2a", nudge)
    assert [(d.name, d.group, d.portability) for d in found] == [(name, "chaotic", True)]
    assert "portability broke: only chaotic motions and last bits differ" in verdict(found)


def test_another_scene_explains_every_drift(home):
    def other(reference):
        reference["scene"] = "0" * 64
        reference["chaotic"]["impacts.csv rows"] += 1

    found = drifted(home, "1.2a", other)
    assert [d.name for d in found] == ["hash of the scene", "impacts.csv rows"]
    assert not any(d.portability for d in found)


@pytest.mark.parametrize("text", ["{", "[1, 2]", '{"regular": {}}', None])
def test_a_reference_that_is_none_is_a_drift_of_its_figure_alone(home, text):
    path = home / "scenes" / "reference" / "1.10.json"
    path.unlink()
    if text is not None:
        path.write_text(text)
    found = [d for f in figures_in(home / "scenes") for d in compared(f, state_of(home, f.name))]
    assert [(d.figure, d.name) for d in found] == [("1.10", str(path))]
    assert "--update-reference" in found[0].found
    said = verdict(found)
    if text is None:
        assert said == ("1 figure has no reference to compare with: --update-reference makes one")
        assert f"cam figures 1.10 --folder {home / 'scenes'} --update" in found[0].found
    else:
        assert "drifted" in said


@pytest.mark.parametrize(("count", "listed", "more"), [(12, 12, 0), (13, 12, 1), (40, 12, 28)])
def test_twelve_drifts_of_a_figure_are_listed(count, listed, more):
    told: list[str] = []
    drifted = [Drift("1.1", "speeds", f"x{k}", 1.0, 2.0, 1.0) for k in range(count)]
    figures_module._print_drifts(
        [*drifted, Drift("1.2", "speeds", "y", 1.0, 2.0, 1.0)], told.append
    )
    of_first, of_other = listed + (more > 0), 1
    assert len(told) == of_first + of_other + 1
    assert [line.split(":")[1].split()[0] for line in told[:listed]] == [
        f"x{k}" for k in range(listed)
    ]
    if more:
        assert told[listed] == f"1.1: and {more} more (--json has all of them)"
    assert told[of_first].startswith("1.2: y")


def test_what_a_drift_is():
    def groups(regular, solved):
        return {"regular": {"x": regular}, "chaotic": {}, "solved": {"y": solved}}

    assert list(drifts("f", groups(1.0, 2.0), groups(1.0, 2.0 + 1e-8))) == []
    found = list(drifts("f", groups(1.0, 2.0), groups(1.0 + 1e-12, "inf")))
    assert [(d.name, d.portability) for d in found] == [("x", True), ("y", False)]
    assert found[1] == Drift("f", "solved", "y", 2.0, "inf")


def test_a_caption_has_the_numbers_of_the_run(run, home):
    values = {"x y": 1.25, "label": "P(1;inf)", "rows": 3}
    assert caption("{x y|.1f} of {rows}, {label}", values) == "1.2 of 3, P(1;∞)"
    with pytest.raises(KeyError, match="'z'"):
        caption("{z}", values)
    lacking = "The caption names"
    for shows, said, code in (("at {label}", "at P(1;∞)", 0), ("{no such} speed", lacking, 3)):
        write(home / "scenes", "1.1", "simulate", RUN, more=f', shows: "{shows}"', shows=False)
        done = run(code=code)
        assert (lacking in done.stderr) == (code == 3)
        assert said in (home / "out" / "index.html").read_text()


def test_large_tables_go_when_their_digest_is_made(run, home):
    folder = home / "out" / "1.2a"
    sizes = {path.name: path.stat().st_size for path in folder.glob("*.csv")}
    largest = max(sizes, key=sizes.__getitem__)
    state = state_of(home, "1.2a")
    for limit, gone in ((sizes[largest], set()), (sizes[largest] - 1, {largest})):
        (folder / "figure.json").unlink()
        figures_module._finish(folder, state, large=limit)
        assert {path.name for path in folder.glob("*.csv")} == sizes.keys() - gone
    assert reasons(run, "1.2") == {"1.2a": "unchanged"}
    run("1.2")
    assert f"also writes {largest}, too large" in (home / "out" / "index.html").read_text()


def test_a_figure_that_fails_leaves_the_others(run, home):
    write(home / "scenes", "1.3", "simulate", "run: {start: {q: 0.05}}")
    said = run("1.3", "1.10", code=2).stderr
    assert "1.3: " in said
    assert "below the cam" in said
    assert reasons(run) == {**dict.fromkeys(FIGURES, "unchanged"), "1.3": "new"}


def test_a_figure_without_memory_leaves_the_others(run, home, monkeypatch):
    from camcli.cli import figures

    def short(command, scene, *more, **how):
        if command.name == "sweep":
            raise MemoryError
        return real(command, scene, *more, **how)

    real = figures.compute
    monkeypatch.setattr(figures, "compute", short)
    said = run("--check", "--threads", "1", code=2).stderr
    assert "1.2a: cam: out of memory" in said
    assert reasons(run) == {"1.1": "unchanged", "1.2a": "new", "1.10": "unchanged"}


@pytest.mark.ci
def test_an_interrupt_keeps_what_is_done(run, home, monkeypatch):
    """It comes in the second figure: the first is finished, the page is there, no third begins."""
    from camcli.cli import figures

    began = []

    def interrupted(*words, **how):
        began.append(words)
        if len(began) == 2:
            os.kill(os.getpid(), signal.SIGINT)
            sleep(1.0)  # the main thread has it first
            raise KeyboardInterrupt
        return real(*words, **how)

    real = figures.compute
    monkeypatch.setattr(figures, "compute", interrupted)
    changed = "--set", "follower.damping=1"
    (home / "out" / "index.html").unlink()
    run("--threads", "1", *changed, code=130)
    assert list(reasons(run, *changed).values()).count("unchanged") == 1
    assert (home / "out" / "index.html").exists()
    assert len(began) == 2
    for thread in threading.enumerate():  # a process of its own would be gone with them
        if thread.name.startswith("ThreadPoolExecutor"):
            thread.join(10.0)
    run(*changed, code=0)
    assert set(reasons(run, *changed).values()) == {"unchanged"}


def test_a_digest_is_the_same_where_the_pieces_were_on_disk(home, tmp_path):
    scene = camcli.load_scene(home / "scenes" / "1.2a.yaml")
    with run_folder(tmp_path / "kept", {"command": "sweep"}) as folder:
        result = camcli.sweep(scene, work=replace(folder.work, in_memory=-1))
        assert digest(result.tables, result.summary) == state_of(home, "1.2a").digest


def test_faults_of_all_scenes_at_once(run, home):
    write(home / "scenes", "2.1", "swep")
    write(home / "scenes", "2.2", "sweep --frobnicate")
    write(home / "scenes", "2.3", "sweep -o elsewhere")
    write(home / "scenes", "2.4", "sweep", more=", colour: red")
    write(home / "scenes", "2.5", "''")
    (home / "scenes" / "2.6.yaml").write_text(MACHINE)
    write(home / "scenes", "2.7", '"sweep \'"')
    write(home / "scenes", "2.8", "figures")
    said = run(code=2).stderr.splitlines()
    told = {"2.1": "swep", "2.2": "--frobnicate", "2.3": "expected sweep alone", "2.4": "colour",
            "2.5": "no command", "2.6": "no such section", "2.7": "found options",
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
        (("7.7",), "7.7"),
        (("1",), "expected one of 1.1, 1.2a, 1.10"),
    ],
)
def test_faults_of_the_command_line(run, words, told):
    assert told in run(*words, code=2).stderr


def test_the_example_is_complete_and_its_references_are_small():
    known = figures_in(REAL)
    assert [figure.name for figure in known] == NAMES
    parts = [name for name in NAMES if name.startswith("3.6")]
    assert [figure.name for figure in chosen(known, ["3.6", "3.10"])] == [*parts, "3.10"]
    assert all(figure.scene.figure.shows for figure in known)
    references = list((REAL / "reference").iterdir())
    assert sorted(path.name for path in references) == sorted(f"{name}.json" for name in NAMES)
    assert sum(path.stat().st_size for path in references) < 300_000
    for figure in known:
        scene = json.loads(figure.reference_path.read_text())["scene"]
        assert scene == figure.hashes["scene"], f"{figure.name}: --update-reference"


CORNER_IMPACT = "bifurcations.csv 1 P(1;1) corner-impact b nonsmooth-fold"
CORNER_HITS = (
    124.998297, 122.699318, 121.685872, 121.106981, 120.735577, 120.481041, 120.299126, 120.165355,
)  # fmt: skip
INDEPENDENT = {  # recomputed in closed form or with 40 digits, to the digits that are written
    "3.7": {  # at 358.5 rpm, the second of three speeds
        "attractors.csv 1 P(1;2) #2 q_m": 0.546,
        "attractors.csv 1 P(1;2) #2 v_m_per_s": 32.48,
    },
    "3.8b": {
        "detach.csv first_detachment A2 rpm": 114.979326744,
        "detach.csv fills A2 rpm": 134.872968058,
        "detach.csv accumulation_at_corner c rpm": 119.712,
        **{f"corner_hits.csv {n} c rpm": rpm for n, rpm in enumerate(CORNER_HITS, 1)},
    },
    "3.10": {
        f"{CORNER_IMPACT} rpm": 673.234445003812,
        f"{CORNER_IMPACT} trace_left": 1.6418699,
        f"{CORNER_IMPACT} trace_right": 1.3714214,
        f"{CORNER_IMPACT} det_left": 0.64,
        "bifurcations.csv 1 P(1;1) period-doubling rpm": 739.319780216,
    },
    "3.14": {
        f"bifurcations.csv 2 P(2;1:1) corner-impact c border-period-doubling {name}": value
        for name, value in (
            ("rpm", 739.3779296493),
            ("trace_left", 1.3816246),
            ("trace_right", -4.0910731),
            ("det_left", 0.4096),
        )
    },
}


def test_references_hold_the_numbers_of_independent_computations():
    for name, values in INDEPENDENT.items():
        solved = json.loads((REAL / "reference" / f"{name}.json").read_text())["solved"]
        for key, value in values.items():
            digits = len(repr(value).partition(".")[2])
            assert abs(solved[key] - value) < 0.6 * 10.0**-digits, key


def test_real_figures_agree_with_their_reference(cam):
    done = cam("figures --check 3.5 -o out --folder", str(REAL), code=0)
    assert "every number is the reference's" in done.stdout


def test_captions_are_made_of_the_numbers_of_the_run():
    """No number with a decimal point is typed, and every label named is one of the run."""
    for figure in figures_in(REAL):
        reference = json.loads(figure.reference_path.read_text())
        values = {**reference["regular"], **reference["chaotic"], **reference["solved"]}
        about = figure.scene.figure
        typed = re.sub(r"\{[^{}]+\}", "", about.shows)
        assert not re.search(r"\d\.\d", typed), figure.name
        said, texts = caption(about.shows, values), [*values, *map(str, values.values())]
        assert "{" not in said
        for label in re.findall(r"P\(\d+;[^)]*\)", typed):
            assert any(label in text for text in texts), (figure.name, label)
        assert set(about.printed) <= set(values)
        for name in re.findall(r"\{([^{}|]+)", about.shows):
            if isinstance(values[name], float):
                assert caption(about.shows, {**values, name: 2.0 * values[name] + 1.0}) != said


def test_all_figures_have_the_width_and_the_forms_asked_for(tmp_path):
    (tmp_path / "scenes").mkdir()
    write(tmp_path / "scenes", "1.1", *FIGURES["1.1"])
    words = f"figures --folder {tmp_path}/scenes -o {tmp_path}/out -q --width 3.5in --format pdf"
    cam_in(tmp_path, words, code=0)
    made = tmp_path / "out" / "1.1"
    assert {path.suffix for path in made.glob("simulate.*")} == {".png", ".pdf"}
    wide = int.from_bytes((made / "simulate.png").read_bytes()[16:20], "big")
    assert wide == pytest.approx(3.5 * 300, abs=1)
    assert "<figure>" in (tmp_path / "out" / "index.html").read_text()
    fault = cam_in(tmp_path, words.replace("3.5in", "wide"), code=2)
    assert "--width" in str(fault)


@pytest.mark.ci
def test_a_certificate_is_checked_by_itself_and_one_that_is_not_confirmed_is_told(
    cam, tmp_path, monkeypatch
):
    """Its size and statements stand on the page; one that is refused ends in 3."""
    (tmp_path / "scenes").mkdir()
    orbits = "orbits: {at: 700, all: {impacts: 1, turns: 1}}\nplot: {panels: [cover]}"
    write(tmp_path / "scenes", "1.1", "orbits", orbits)
    cam("figures --folder scenes -o out -q", code=0)
    path = tmp_path / "out" / "1.1" / "proof.json"
    state = json.loads((path.parent / "figure.json").read_text())["certificate"]
    assert (state["confirmed"], state["bytes"]) == (True, path.stat().st_size)
    count = len(json.loads(path.read_text())["statements"])
    assert state["lines"][-1] == f"{count} of {count} statements are confirmed"
    shown = (tmp_path / "out" / "index.html").read_text()
    assert '<a href="1.1/proof.json" download>proof.json</a>' in shown
    assert f"<li>{state['lines'][0]}</li>" in shown

    (tmp_path / "changed").mkdir()
    changed = path.read_text().replace('"label": "P(1;1)"', '"label": "P(1;2)"')
    (tmp_path / "changed" / "proof.json").write_text(changed)
    again = check_certificate(tmp_path / "changed")
    assert not again.confirmed
    monkeypatch.setattr(figures_module, "check_certificate", lambda folder: again)
    done = cam("figures --folder scenes -o out -q --check", code=3)
    assert "1.1: its certificate is not confirmed: not confirmed: P(1;2), stable" in done.stderr
    assert check_certificate(tmp_path) is None
    said = cam("figures --folder scenes -o out", code=3).stdout  # also where it is not made anew
    assert "0 of 1 figure" in said


@pytest.mark.parametrize(("code", "ends"), [(0, 3), (1, 1), (3, 3)])
def test_a_fault_is_worse_than_a_certificate_that_is_not_confirmed(
    home, tmp_path, monkeypatch, code, ends
):
    """The figure is not whole then, and is computed again the next time."""
    refused = CheckedCertificate(confirmed=False, bytes=1, seconds=0.1, lines=["no"])
    instead = {
        "check_before": lambda *_, **__: None,
        "open_folder": lambda *_: nullcontext(),
        "compute": lambda *_, **__: (Made(tables={}, complete=True), {"result": {}, **NO_FAULTS}),
        "check_certificate": lambda _: refused,
        "exit_code": lambda *_: code,
        "digest": lambda *_: {},
    }
    for name, call in instead.items():
        monkeypatch.setattr(figures_module, name, call)
    state = figures_module._drawn(figures_in(home / "scenes")[0], Request(out=tmp_path))
    assert state.exit == ends
    assert state.certificate is refused


@pytest.mark.parametrize("code", [DONE, NUMERICS, INTERNAL, USAGE])
def test_a_figure_is_finished_where_its_run_is_whole(tmp_path, monkeypatch, code):
    """A run with a row that could not be computed is whole; one with a fault is not."""
    finished = []
    state = State(hashes={}, exit=code, notes=[])
    monkeypatch.setattr(figures_module, "_drawn", lambda figure, request: state)
    monkeypatch.setattr(figures_module, "_finish", lambda folder, done: finished.append(done.exit))
    request = Made(folder=lambda command: tmp_path / command)
    done = figures_module._computed(Made(command="sweep", hashes={}), request)
    assert done.exit == code
    assert finished == ([code] if code in (DONE, NUMERICS) else [])
