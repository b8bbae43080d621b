"""Words come from values; what fails while they are said, or drawn, costs no file."""

import json
import pickle
import re
from dataclasses import replace
from decimal import Context, Decimal
from math import inf
from types import SimpleNamespace

import pytest

import camcli
from camcli.analysis.labels import Label, from_plain, period_of, to_plain
from camcli.api.explore_page import kind_of
from camcli.cli.report import table
from camcli.plots import style
from camcli.quantities import PARAMETERS
from camcli.words import in_print
from camcli.words.labels import motion
from camcli.words.sweep import shown_cam
from tests.conftest import rows

LONG = Label((inf, *[1.0] * 121))  # as of a search after a rest, of more turns than a user may ask
SHORT = "--no-plot --set run.transient=5 --set run.record=5"


@pytest.mark.parametrize(
    ("label", "turns", "words"),
    [
        (LONG, 122, "rests in 1 of 122 turns"),
        (Label((inf,)), 1, "bounces to rest every turn"),
        (Label((3.0, 3.0, 2.0)), 3, "8 impacts in 3 turns"),
        (Label((1.0,)), 1, "1 impact every turn"),
        ("contact", 1, "stays on the cam"),
        ("aperiodic", 0, "never repeats"),
        ("undecided", 0, "not known"),
    ],
)
def test_a_label_keeps_its_values_wherever_it_goes(label, turns, words):
    stored = json.loads(json.dumps(to_plain(label)))
    for same in (label, from_plain(stored), pickle.loads(pickle.dumps(label))):
        assert (same, motion(same), period_of(same)) == (label, words, turns)
        assert style.label_colour(same) == style.label_colour(label)


@pytest.mark.parametrize("digits", [1, 2, 3, 6])
@pytest.mark.parametrize(
    "number",
    [0.0, 0.00123456, 0.9996, 9.996, 87.65, 999.6, 123456.7, 8.76e9, -0.00004567, -98765.4],
)
def test_a_number_in_a_sentence_has_so_many_digits_and_no_power_of_ten(number, digits):
    wanted = Context(prec=digits).create_decimal(Decimal(number))
    said = in_print.written_out(number, digits)
    assert Decimal(said) == wanted
    assert "e" not in said


NAMES = {  # of what is varied: what it is called and its unit, as they stand in a picture
    "rpm": ("cam speed", "rpm"),
    "follower.mass": ("mass", "kg"),
    "follower.stiffness": ("stiffness", "N/m"),
    "follower.damping": ("damping", "N s/m"),
    "follower.gravity": ("gravity", "m/s²"),
    "follower.preload": ("preload", "N"),
    "follower.restitution": ("coefficient of restitution", ""),
    "follower.seat_restitution": ("restitution on the seat", ""),
    "cam.lift": ("lift of the cam", "m"),
}


def test_what_is_varied_has_its_name_and_unit():
    assert {key.removeprefix("follower.") for key in NAMES} == {*PARAMETERS, "cam.lift"}
    for key, (name, unit) in NAMES.items():
        assert in_print.name_and_unit(key) == (name, unit)
        if key != "rpm":
            assert in_print.valued(key, "7", 120.0) == f"{name} 7 {unit}".rstrip() + " at 120 rpm"
    assert in_print.valued("rpm", "7") == "7 rpm"
    driven = in_print.valued("follower.mass", "7", 30.0, "oscillator")
    assert driven == "mass 7 kg at frequency 3.141592654 rad/s"
    assert in_print.valued("cam.frequency", "2 to 6", 120.0) == (
        "circular frequency of the force 2 to 6 rad/s"
    )


def test_the_cam_drawn_is_named_where_one_of_its_numbers_varies():
    cam = SimpleNamespace(frequency=2.5, harmonics=[1.0])
    assert shown_cam("rpm", cam) == shown_cam("follower.mass", cam) == ""
    assert shown_cam("cam.frequency", cam) == "cam at circular frequency of the force 2.5 rad/s"
    assert shown_cam("cam.harmonics.0", cam) == "cam of the scene"


@pytest.mark.parametrize(
    ("label", "kind"),
    [
        (Label((inf,)), (0, "with rests", "rests")),
        (Label((3.0, 3.0, 2.0)), (3, "period 3", "period3")),
        (LONG, (0, "with rests", "rests")),
        (Label((1.0,) * 5), (5, "period 5", "longer")),
        ("contact", (1, "contact", "contact")),
        ("aperiodic", (0, "aperiodic", "aperiodic")),
        ("undecided", (0, "undecided", "undecided")),
    ],
)
def test_a_map_tells_a_motion_by_its_period_or_that_it_rests(label, kind):
    assert kind_of(label) == kind


@pytest.fixture
def no_parser(monkeypatch):
    """Nothing may read a label back from its text."""

    def parse(text):
        raise AssertionError(f"{text} was parsed")

    monkeypatch.setattr(Label, "parse", parse)


@pytest.mark.usefixtures("no_parser")
@pytest.mark.parametrize(
    "line",
    [
        "simulate --rpm 190", "sweep --rpm 150:745 --points 4", "detach --points 3",
        "sweep --rpm 150:745 --vary follower.restitution=0.7:0.8 --points 2,2",
        "orbits --rpm 700", "basins --rpm 700 --cells 4,4", "classify --rpm 190:700 --points 2",
        "explore --rpm 190:700 --points 2",
    ],
)  # fmt: skip
def test_no_command_parses_a_label(cam, line):
    drawing = "" if line.startswith("explore") else "--no-plot"
    cam(line, drawing, "--set run.transient=5 --set run.record=5 --set orbits.starts=2", code=0)


@pytest.mark.usefixtures("no_parser")
def test_a_sweep_that_goes_on_from_disk_has_labels_with_values(cam, tmp_path, monkeypatch):
    """Of pieces on disk the words are the same."""
    line = f"sweep --rpm 150:745 --points 4 {SHORT}"
    whole = cam(line, "-o whole", code=0).stdout.partition("whole")[0]
    parts = [cam(line, f"--shard {k}/2 -o parts", code=0) for k in (1, 2)]
    assert parts[0].stdout == ""
    assert cam("merge parts", code=0).stdout.partition("parts")[0] == whole
    same = [(tmp_path / name / "speeds.csv").read_bytes() for name in ("whole", "parts")]
    assert same[0] == same[1]


def test_a_cycle_of_more_turns_than_a_user_may_ask_for_is_told(cam, tmp_path, request):
    scene = f"-c {request.config.rootpath}/configs/law-smooth.yaml"
    done = cam("classify", scene, "--rpm 700 --vary cam.rise.length_deg=0.5:0.5 --points 1", code=0)
    assert "rests in 1 of 122 turns" in done.stdout
    assert rows(tmp_path / "out/classify/classify.csv")[0]["label"].startswith("P(122;inf:1:1")


@pytest.mark.parametrize(
    "line",
    [
        "sweep --rpm 341:347 --points 3 --set run.record=60",
        "classify --rpm 341:347 --points 3",
        "sweep --vary follower.restitution=0.55:0.61 --rpm 350 --points 3 --set run.record=60",
    ],
)
def test_a_table_of_long_labels_fits_eighty_columns(cam, monkeypatch, line):
    """Each row has one line, in which the label alone is cut."""
    monkeypatch.setenv("COLUMNS", "80")
    lines = cam(line, "--no-plot", code=0).stdout.splitlines()
    first = next(k for k, text in enumerate(lines) if text.startswith("label ")) + 2
    rests = [text for text in lines if re.match(r"P\(\d+;inf:", text)]
    assert rests
    assert rests == [text for text in lines[first : first + 3] if text.startswith("P(")]
    for text in rests:
        assert len(text) <= 80
        assert re.fullmatch(r"P\(\d+;inf:[\d:]*… +rests in \d+ of \d+ turns( +[^ …]+){4}", text)


def broken(*_args, **_options):
    raise ZeroDivisionError("nobody foresaw this")


def record_of(folder):
    return json.loads((folder / "run.json").read_text())


@pytest.mark.parametrize(
    ("words", "name"),
    [("labels.motion", "the words on the screen"), ("verdict.verdict", "verdict")],
)
def test_words_that_fail_cost_the_exit_code_alone(cam, tmp_path, monkeypatch, words, name):
    line = f"sweep --rpm 150:745 --points 3 {SHORT}"
    cam(line, "-o whole", code=0)
    monkeypatch.setattr(f"camcli.words.{words}", broken)
    done = cam(line, "-o out", code=1)
    first, second = done.stderr.splitlines()[-2:]
    assert first.startswith(f"fault: {name}: ZeroDivisionError: nobody foresaw this (camcli/")
    assert "this is a fault of camcli" in second
    assert "out/run.json" in second
    assert "Traceback" not in done.stderr + done.stdout
    names = sorted(path.name for path in (tmp_path / "whole").iterdir())
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == names
    for file in set(names) - {"run.json"}:
        assert (tmp_path / "out" / file).read_bytes() == (tmp_path / "whole" / file).read_bytes()
    (fault,) = record_of(tmp_path / "out")["piece_faults"]
    assert fault["pieces"] == [name]
    assert "Traceback" in fault["traceback"]
    assert record_of(tmp_path / "whole")["piece_faults"] == []
    cam(line, "--json -o json", code=int(name == "verdict"))  # a record takes no other words


def test_a_picture_that_fails_costs_itself_alone(cam, tmp_path, monkeypatch):
    line = "sweep --rpm 150:745 --points 3 --set run.transient=5 --set run.record=5"
    cam(line, "-o out", code=0)
    before = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    monkeypatch.setattr("camcli.plots.sweep.draw_sweep", broken)
    done = cam(line, "-o out", code=1)
    assert "fault: sweep.png: ZeroDivisionError: nobody foresaw this" in done.stderr
    assert "150" in done.stdout  # the words are said all the same
    after = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    assert before.keys() - after.keys() == {"sweep.png"}  # that of the run before is gone
    assert all(after[name] == before[name] for name in after if name != "run.json")
    assert record_of(tmp_path / "out")["piece_faults"][0]["pieces"] == ["sweep.png"]


def test_a_picture_that_the_scene_is_to_blame_for_costs_no_table(cam, tmp_path, monkeypatch):
    from camcli.errors import Fault, SceneError

    def refused(*_args):
        raise SceneError(Fault("my.mplstyle:3", "plot.style", "found no LaTeX", "", ""))

    monkeypatch.setattr("camcli.plots.sweep.draw_sweep", refused)
    done = cam("sweep --rpm 150:745 --points 3 --set run.record=5", code=2)
    assert "my.mplstyle:3: plot.style: found no LaTeX" in done.stderr
    assert {"impacts.csv", "strobe.csv", "speeds.csv", "run.json"} == {
        path.name for path in (tmp_path / "out/sweep").iterdir()
    }


def test_a_table_or_a_summary_that_fails_costs_itself_alone(cam, tmp_path, monkeypatch):
    monkeypatch.setattr("camcli.api.sweep.speed_row", broken)
    done = cam("sweep --rpm 150:745 --points 3", SHORT, code=1)
    assert "fault: speeds.csv" in done.stderr
    names = {path.name for path in (tmp_path / "out/sweep").iterdir()}
    assert names == {"impacts.csv", "strobe.csv", "run.json"}


def test_a_range_of_two_numbers_stays_on_one_line_of_a_narrow_screen(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "80")
    heads = ["cam (rpm)", "crank (rpm)", "loft (mm)", "lands (m/s)", "at (deg)", "at lift (mm)"]
    row = ["3309", "6617", "0.0404", "1.38", "58.09", "0", "2", "0 to 910.3"]
    table("forces", [*heads, "bounces", "force (N)"], [row, [*row[:-1], ""]])
    told = capsys.readouterr().out
    assert "0 to 910.3\n" in told
    assert max(map(len, told.splitlines())) <= 80


def test_the_mass_of_an_oscillator_stays_at_its_stop():
    assert motion("contact", "oscillator") == "stays at the stop"


def test_a_summary_that_is_no_json_is_a_fault_of_the_record(tmp_path):
    quick = camcli.load_scene(None, {"run.transient": 0, "run.record": 2})
    found = replace(camcli.simulate(quick), summary={"what": object()})
    found.save(tmp_path, plot=False)
    record = json.loads((tmp_path / "run.json").read_text())
    assert record["result"] is None
    assert [one["pieces"] for one in record["piece_faults"]] == [["the summary"]]
    assert record["artefacts"].keys() == {"events.csv", "trajectory.csv"}
