"""What `camcli.detach` asks its study, its proofs and its report, and makes of their answers.

All of them are replaced by answers made by hand, of which each is another one.
"""

from __future__ import annotations

from contextlib import contextmanager
from io import BytesIO
from math import inf, radians
from types import SimpleNamespace as Made

import pytest

import camcli
from camcli.analysis.integrate import Cost
from camcli.api import detach
from camcli.api.command import command_of
from camcli.errors import Status
from camcli.piece_faults import PieceFault, gather


def fault(name):
    return PieceFault(name, "E", "place", "traceback")


SPRING = {"rate": 1.0, "mass": 0.05, "solid_at": 0.0175}


@pytest.fixture
def asked(monkeypatch):
    """What the parts of `detach` are asked, by their names; each gives an answer of its own."""
    given = {}

    def part(name, answer=None, fails=()):
        def of(*args, **more):
            given[name] = (args, more)
            gather(map(fault, fails))
            return answer(*args, **more) if callable(answer) else answer

        monkeypatch.setattr(detach, name, of)

    @contextmanager
    def budget_of(scene, progress):
        yield Made(status=given["budget"])

    given["budget"] = Status.OK
    found = Made(troubled=[(700.0, Status.OK)], cost=Cost(3, 4), holds=[], past=["past of found"])
    part("run", found, ["the study"])
    monkeypatch.setattr(detach, "budget_of", budget_of)
    monkeypatch.setattr(detach, "refuse_an_oscillator", lambda scene, command: None)
    monkeypatch.setattr(detach, "with_arguments", lambda scene, name, **given: scene)
    monkeypatch.setattr(detach, "machine_of", lambda scene: Made(scene=scene, held=False))
    part("_held_in_report", lambda machine: Made(
        scene=machine.scene, system=Made(has_seat=True), settings="settings"))  # fmt: skip
    completed = Made(**{**vars(found), "completed": True})
    part("_completed", lambda machine, found, rpms: (completed, {"a": 1}), ["the summary"])
    part("_tables", lambda found, seat: {})
    part("_surge_table", "surge table")
    part("_surge", "surge record")
    part("surge", "waves")
    part("tolerated", "machines")
    part("tolerances", ("table", "chances", "spread"))
    part("_proved", ({"statements": [{"low": "650.5"}]}, "proved"))
    part("_undercut", ["warning: undercut"])
    part("_notes", [])
    part("accel_errors", "accel errors")
    part("_hertz", "hertz")
    part("_working_speed", 555.0)
    part("past_motions", ["past"], ["the report"])
    part("drawn_by", lambda *args: args)
    part("proof_files", {"proof.json": "writer"})
    return given


def scene(spring=SPRING, **section):
    own = {
        "rpm": Made(start=700.0, stop=600.0, num=3), "settle": 7, "impacts": 9,
        "force_rpm": (610.0,), "hold_to": 900.0, "margin_n": 12.5, "precompression_m": 0.002,
        "tolerance": ("some",), "prove": True, "report": True,
    }  # fmt: skip
    return Made(detach=Made(**{**own, **section}), cam="cam",
                spring=None if spring is None else Made(**{**SPRING, **spring}))  # fmt: skip


def test_what_the_study_is_asked_and_what_is_told_of_it(asked):
    result = detach.detach(scene(), "progress", work="work")
    (system, rpms, settings), more = asked["run"]
    assert (system.has_seat, rpms, settings) == (True, [700.0, 650.0, 600.0], "settings")
    assert callable(more.pop("on_speed"))
    assert more == {
        "settle": 7, "impacts": 9, "force_speeds": (610.0,), "hold_speed": 900.0, "margin": 12.5,
        "precompression": 0.002, "accel_error": "accel errors", "solid": 0.0175,
        "hertz": "hertz", "working_speed": 555.0,
    }  # fmt: skip
    assert asked["accel_errors"][0] == ("cam",)
    found = result.values
    assert found.completed
    assert asked["_tables"][0] == (found, True)
    assert asked["surge"][0] == (system, 0.05)
    assert asked["_surge_table"][0] == ("waves",)
    assert asked["_surge"][0] == ("waves", found)
    assert asked["tolerances"][0] == ("machines", found, "work", "progress")
    assert asked["_proved"][0] == (system, found)
    assert asked["_notes"][0] == (found, Status.OK)
    assert dict(result.tables) == {"surge": "surge table", "tolerance": "table"}
    assert result.summary == {"status": "ok", "a": 1, "surge": "surge record",
                              "tolerance": "chances", "proved": "proved"}  # fmt: skip
    assert result.pictures["detach"] == (
        "detach.draw_detach", found, system, "waves", "spread", [650.5]
    )  # fmt: skip
    assert (result.cost, result.notes, result.complete) == (
        Cost(3, 4),
        ("warning: undercut",),
        True,
    )
    pieces = [one.piece for one in result.faults]
    assert pieces == ["the study", "the summary", "the report"]
    assert list(result.files) == ["proof.json", "report.pdf"]
    assert asked["past_motions"][0] == (system, [700.0, 650.0, 600.0], "settings", 200)
    write = result.files["report.pdf"]
    assert write.args[1:] == (system, ["past"], "waves", "spread")
    assert write.args[0].values is found


def test_a_study_that_asks_for_nothing_more(asked):
    """Without a spring's mass no surge, without a height that is solid none at all."""
    asked["budget"] = Status.WORK_BUDGET
    bare = scene({"mass": None, "solid_at": None}, tolerance=(), prove=False, report=False)
    result = detach.detach(bare)
    assert asked["run"][1]["solid"] == inf
    assert not {"surge", "_surge", "tolerances", "_proved", "past_motions"} & asked.keys()
    assert result.summary == {"status": "work-budget", "a": 1}
    assert asked["proof_files"][0] == (None,)
    assert result.pictures["detach"][3:] == (None, None, [])
    assert [one.piece for one in result.faults] == ["the study", "the summary"]
    assert detach.detach(scene(None)).pictures["detach"][3] is None
    assert asked["run"][1]["solid"] == inf


def test_a_note_of_the_study_makes_it_incomplete(asked, monkeypatch):
    monkeypatch.setattr(detach, "_notes", lambda found, status: ["no bracket"])
    result = detach.detach(scene())
    assert (result.notes, result.complete) == (("no bracket", "warning: undercut"), False)


@pytest.mark.parametrize("count", [0, 2])
def test_a_certificate_without_a_statement_is_no_file(monkeypatch, count):
    certificate = {"statements": ["s"] * count, "uncovered": ["u", "v", "w"]}
    monkeypatch.setattr(detach, "_certificate", lambda system, found: (certificate, "why"))
    monkeypatch.setattr(detach, "proved_words", lambda *given: given)
    content, entry = detach._proved("system", "found")
    assert content == (certificate if count else None)
    assert entry == {
        "statements": count, "not_proved": ["u", "v", "w"], "words": (count, ["u", "v", "w"], "why")
    }  # fmt: skip


def test_the_certificate_is_that_of_the_cam_with_its_seat(monkeypatch):
    of = "camcli.analysis.contact_loss.certificate"
    monkeypatch.setattr(f"{of}.certificate", lambda *given: given)
    monkeypatch.setattr(f"{of}.no_statement", lambda *given: given)
    monkeypatch.setattr("camcli.cams.formula.formula_of", lambda *given: given)
    system = Made(shape="shape", follower=Made(seat_restitution=0.25))
    found = Made(detachment="detachment", hits="hits")
    content, why = detach._certificate(system, found)
    cam = ("shape", 0.25)
    assert content == (system, "detachment", "hits", cam, detach.proof_name)
    assert why == (system, "detachment", cam)


# --- the report


@pytest.mark.parametrize(
    ("waves", "verdict", "sentence"),
    [
        ("waves", ["Contact holds."], True),
        (None, ["Contact holds."], False),
        ("waves", ["Surge, which is not simulated, comes first."], False),
    ],
)
def test_the_words_above_a_report(monkeypatch, waves, verdict, sentence):
    """The verdict, warnings among the notes, and that surge is not simulated."""
    written = []
    monkeypatch.setattr(
        "camcli.output.pictures.write_pages", lambda *a, **m: written.append((a, m))
    )
    monkeypatch.setattr("camcli.plots.detach.report_panels", lambda *given: given)
    monkeypatch.setattr("camcli.words.machine.report_title", lambda cam: f"report of {cam}")
    monkeypatch.setattr(detach, "_outline", lambda scene, system: "outline")
    monkeypatch.setattr(detach, "_report_pages", lambda *given: given)
    plot = Made(model_copy=lambda update: update)
    result = Made(scene=Made(cam="cam", plot=plot), values="values", verdict=verdict,
                  notes=["no bracket", "warning: it is +-2 %"])  # fmt: skip
    file = BytesIO()
    detach._write_report(result, "system", ["past"], waves, "spread", file)
    (((pages, to, form), more),) = written
    assert (to, more) == (file, {"margin": 15.0})
    assert form == {"width": 180.0, "height": 267.0, "panels": None, "title": True}
    own, title, words, panels, page = pages
    assert (own, title, page) == (result, "report of cam", form)
    assert panels == ("values", "system", "outline", ["past"], waves, "spread")
    lines = words.split("\n")
    assert lines[:2] == [*verdict, "warning: it is ±2 %"]
    assert len(lines) == 2 + sentence
    if sentence:
        assert lines[2].lower() == f"{detach.NOT_SIMULATED}.".lower()
        assert lines[2][0].isupper()


class Outline:
    """An outline that says of what it is."""

    def __init__(self, *of):
        self.of = of

    of_lift = classmethod(lambda cls, *of: cls("lift", *of))
    of_lobe = classmethod(lambda cls, *of: cls("lobe", *of))

    def with_lash_seen(self):
        return Outline("lash seen", *self.of)

    def over_lash(self, lash, lobe):
        return Outline("over", lash, lobe(), lobe(0.25), *self.of)


@pytest.fixture
def outlined(monkeypatch):
    """The outline of a report for a contact, on a seat from 90 to 270 deg or on none."""
    monkeypatch.setattr("camcli.plots.mechanism.Outline", Outline)
    monkeypatch.setattr(detach, "replace", lambda one, at_rest_deg: Outline(*one.of, at_rest_deg))
    monkeypatch.setattr(detach, "stretch_at", lambda cam, theta: f"{cam} {theta > 1.0}")

    def lobe(system, face, base, roller, places):
        assert len(places) == 1440
        first, second = places[0], places[720]
        assert first == ("drawn cam False", 0.0)
        assert second == ("drawn cam True", pytest.approx(radians(180.0)))
        return system.name, str(face), base, roller

    monkeypatch.setattr(detach, "lobe_of", lobe)

    def of(contact, base=None, seat=True, lash=0.002):
        system = Made(
            has_seat=seat, lash=lash, as_drawn=Made(name="drawn", cam="drawn cam"),
            is_seat=lambda theta: radians(80.0) < theta < radians(280.0),
        )  # fmt: skip
        cam = Made(base_radius=base)
        return system, cam, detach._outline(Made(contact=contact, cam=cam), system).of

    return of


def contact(**more):
    return Made(**{"base_radius": 0.02, "face": None, "follower_radius": None, **more})


def test_the_machine_of_a_report(outlined):
    """Under its own face; a radius alone is that of a roller; the base circle of the contact."""
    system, cam, of = outlined(None, 0.03)
    assert of == ("lash seen", "lift", system, 0.03, cam, 180.0)
    system, cam, of = outlined(contact(base_radius=None))
    assert of == ("lash seen", "lift", system, None, cam, 180.0)
    system, cam, of = outlined(None, None, seat=False)
    assert of == ("lift", system, None, cam, 0.0)
    for given, face in (
        (contact(), "flat"), (contact(follower_radius=0.004), "roller"),
        (contact(face="knife"), "knife"), (contact(face="flat", follower_radius=0.004), "flat"),
    ):  # fmt: skip
        system, _, of = outlined(given, 0.03)
        roller = given.follower_radius or 0.0
        lobe, smaller = (("drawn", face, base, roller) for base in (0.02, 0.02 - 0.25))
        assert of == ("over", 0.002, lobe, smaller, "lobe", system, lobe, 180.0)
        assert outlined(given, seat=False)[2][0] == "lobe"
    assert outlined(contact(base_radius=None), 0.03)[2][2][2] == 0.03


@pytest.mark.parametrize(
    ("room", "wanted"),
    [
        ((5, 0, 0), [(["a", "b", "c", "d", "e"], 5, True)]),
        ((2, 4, 6), [(["a", "b", "c", "d"], None, True), (["e"], 6, False)]),
        ((2, 3, 4), [(["a", "b"], None, True), (["c", "d", "e"], 4, False)]),
        ((2, 1, 2), [(["a", "b"], None, True), (["c", "d", "e"], 3, False)]),
    ],
)
def test_pages_of_a_report_have_as_many_panels_and_rows_as_there_is_room_for(
    monkeypatch, room, wanted
):
    """8, 6, 5, 4 or 3 rows; of two pages the first has the machine, the forces, what follows.

    room: rows beside all panels, panels on the first page, rows on the second.
    """
    rows_of_whole, panels_of_first, rows_of_second = room

    class Picture:
        def __init__(self, title, panels, words="", lists=()):
            self.title, self.panels, self.words, self.lists = title, panels, words, lists

        def figure(self, form):
            assert form == "form"
            rows = next((one[1] for one in self.lists if one[0] == "motions"), 0)
            if not rows:
                return Made(has_room=len(self.panels) <= panels_of_first)
            whole = len(self.panels) == 5
            return Made(has_room=rows <= (rows_of_whole if whole else rows_of_second))

    monkeypatch.setattr("camcli.plots.picture.Picture", Picture)
    monkeypatch.setattr("camcli.words.detach.on_second_page", lambda *given: f"then {given}")
    monkeypatch.setattr("camcli.words.detach.second_page", lambda title: f"{title} (2)")
    tables = "camcli.words.detach_tables"
    monkeypatch.setattr(f"{tables}.lists_of_forces", lambda result: [("forces", 0)])
    monkeypatch.setattr(f"{tables}.lists_of_motions", lambda result, most: [("motions", most)])
    monkeypatch.setattr("camcli.words.machine.machine", lambda result: ("machine", 0))
    panels = dict(zip("abcde", range(5), strict=True))
    result = Made(values=Made(past=["one"]))
    pages = detach._report_pages(result, "first", "words", panels, "form")
    for page, (names, rows, has_forces) in zip(pages, wanted, strict=True):
        assert page.panels == {name: panels[name] for name in names}
        lists = [("machine", 0), ("motions", rows), ("forces", 0)]
        assert page.lists == [
            one for one in lists if one[1] is not None and (one[0] == "motions" or has_forces)
        ]
    if len(pages) == 1:
        assert (pages[0].title, pages[0].words) == ("first", "words")
    else:
        behind = list(pages[1].panels)
        assert (pages[0].title, pages[1].title) == ("first", "first (2)")
        assert (pages[0].words, pages[1].words) == (f"words\nthen {(behind, True)}", "")


def test_a_sample_of_detach_has_no_tolerances():
    values = {"detach.rpm": {"start": 100.0, "stop": 400.0, "num": 300}, "detach.report": True,
              "detach.tolerance": [{"key": "follower.mass", "percent": 5}]}  # fmt: skip
    scene = camcli.load_scene(None, values)
    for n, speeds in ((1, 25), (4, 100), (20, 300)):
        own = command_of("detach").sample(scene, n).detach
        assert (own.rpm.num, own.tolerance, own.report) == (speeds, (), True)


def test_what_is_not_complete_is_told_in_its_order(monkeypatch):
    monkeypatch.setattr(detach, "status_notes", lambda troubled: [f"of {len(troubled)}"])
    monkeypatch.setattr(detach, "trouble", lambda status: [f"trouble {status}"])
    monkeypatch.setattr(detach, "unresolved_notes", lambda found: ["unresolved"])
    found = Made(troubled=[(700.0, "a"), (710.0, "b")])
    assert detach._notes(found, "c") == ["of 2", "trouble c", "unresolved"]
    assert detach._notes(found, "b") == ["of 2", "unresolved"]


def test_ranges_of_seating_need_no_working_speed(monkeypatch):
    """Without one nothing is told of it, and no motion is followed there."""
    monkeypatch.setattr(detach, "with_ranges", lambda found, system: (found, system))
    monkeypatch.setattr(detach, "_summary", lambda found: {"a": found})
    monkeypatch.setattr(detach, "_working_speed", lambda scene: None)
    monkeypatch.setattr(detach, "seating_ranges", lambda machine, found: [found])
    machine = Made(system=Made(has_seat=False), scene=None)
    wide = ("found", machine.system)
    study, record = detach._completed(machine, "found", [700.0])
    assert (study, record) == (wide, {"a": wide, "seating": [wide]})
