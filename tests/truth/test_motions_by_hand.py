"""What `camcli.simulate` asks, and what it makes of motions and cams that are made by hand."""

from __future__ import annotations

from io import BytesIO
from math import degrees, radians
from types import SimpleNamespace as Made

import pytest

from camcli.analysis.integrate import Cost
from camcli.analysis.labels import Label
from camcli.api import simulate
from camcli.errors import Status
from camcli.output.tables import Table


def stubs(monkeypatch, module, **answers):
    """Replace functions of a module by ones that give their arguments, or an answer."""
    for name, answer in answers.items():
        of = answer if callable(answer) else (lambda *given, answer=answer, **more: answer)
        monkeypatch.setattr(module, name, of)


@pytest.mark.parametrize(
    ("animate", "rows", "status", "files", "notes"),
    [
        (True, 2, Status.OK, ["a film"], ["high", "rounded", "ended"]),
        (True, 0, Status.OK, [], ["high", "rounded", "ended"]),  # nothing is there to be shown
        (False, 2, Status.NO_RETURN, [], ["high", "rounded", "ended", "trouble"]),
    ],
)
def test_the_result_of_a_motion(monkeypatch, animate, rows, status, files, notes):
    section = Made(samples=90, plot_turns=7, animate=animate, profile_only=False)
    scene = Made(simulate=section, run=Made(rpm=650.0))
    machine = Made(scene=scene, system="system", settings="settings")
    asked = {}
    found = Made(
        rpm=650.0, label=Label((1.0, 2.0)), status=status, periods=30, corners=[0.5, 1.5],
        cost=Cost(3, 4), one_of_many="of many",
        events=[(0.1, 1, 2.0, "impact", 0.3, -0.4, 0.5)],
        trajectory=[(0.1, 2.0, 0.3, 0.4, 0.5, 0.6, "flight")] * rows,
    )  # fmt: skip

    def note(name, *words):
        def of(*given):
            asked[name] = given
            return list(words)

        return of

    stubs(
        monkeypatch, simulate, machine_of=machine, throw=lambda system, rpm: ("throw", system, rpm),
        with_arguments=lambda *given, **more: asked.update(given=(given, more)),
        height_notes=note("high", "high"), rounding_notes=note("rounded", "rounded"),
        end_notes=note("ended", "ended"), drawn_by=lambda *given: given,
        trouble=note("trouble", *(["trouble"] if status != Status.OK else [])),
        _films=lambda *given: {"a film": given},
    )  # fmt: skip

    def run(*given):
        asked["run"] = given
        return found

    monkeypatch.setattr("camcli.analysis.simulate.simulate", run)
    result = simulate.simulate("scene", base_radius=0.02, animate=animate)
    assert asked["given"] == (
        ("scene", "simulate"), {"profile_only": False, "base_radius": 0.02, "animate": animate}
    )  # fmt: skip
    assert asked["run"] == ("system", 650.0, "settings", 90)
    assert (asked["high"], asked["rounded"]) == ((("throw", "system", 650.0),), ("of many",))
    assert (asked["ended"], asked["trouble"]) == ((found,), (status,))
    assert result.summary == {
        "rpm": 650.0, "label": found.label, "status": status.text, "periods": 30, "events": 1,
        "corners_deg": [degrees(0.5), degrees(1.5)],
    }  # fmt: skip
    assert list(result.notes) == notes
    assert (result.complete, result.cost) == (status == Status.OK, Cost(3, 4))
    assert result.files == ({"a film": (machine, found)} if files else {})
    assert result.pictures["simulate"] == ("simulate.draw_simulation", found, "system", 7)
    trajectory, events = result.tables["trajectory"], result.tables["events"]
    assert list(trajectory) == [
        "t_s", "theta_deg", "q_m", "v_m_per_s", "c_m", "c_dot_m_per_s", "contact"
    ]  # fmt: skip
    assert [len(trajectory["t_s"]), events["event"].tolist()] == [rows, ["impact"]]
    assert [events[name].tolist() for name in ("period", "u_minus_m_per_s")] == [[1], [-0.4]]


def test_a_film_shows_the_last_turns_on_the_base_circle_of_the_cam(monkeypatch):
    written = []
    monkeypatch.setattr("camcli.output.pictures.animation_kinds", lambda: ["gif", "mp4"])
    monkeypatch.setattr(
        "camcli.output.pictures.write_animation", lambda *given: written.append(given)
    )
    monkeypatch.setattr("camcli.plots.simulate.draw_frames", lambda *given: given)
    monkeypatch.setattr("camcli.plots.mechanism.Outline.of_lift", lambda *given: given)
    for cam, base in ((Made(base_radius=0.02), 0.02), (Made(), None)):
        scene = Made(cam=cam, simulate=Made(plot_turns=7), run=Made(record=40))
        films = simulate._films(Made(scene=scene, system="system"), "found")
        file = BytesIO()
        films["simulate.mp4"](file)
        frames = ("found", "system", ("system", base, cam), 7)
        assert written.pop() == (frames, file, "mp4")
        assert list(films) == ["simulate.gif", "simulate.mp4"]


@pytest.mark.parametrize("lobe", [True, False])
def test_the_result_of_profiles_side_by_side(monkeypatch, lobe):
    """Each cam has a table of its own machine; the lobe, notes and summary are of the first."""
    own, other, third = (
        Made(system=Made(name=name, rocker_ratio=ratio))
        for name, ratio in (("own", 1.25), ("other", 1.5), ("third", 1.75))
    )
    own.scene = Made(run=Made(rpm=650.0), cam="cam", simulate=None)
    touch = Made(theta=radians(10.0), place=(0.25, 0.5), direction=radians(20.0))
    outline = Made(touches=[touch]) if lobe else None
    cams = [
        Made(machine=machine, base_radius=base)
        for machine, base in ((own, 0.02), (other, 0.03), (third, 0.04))
    ]
    ran = []

    def profile_of(cam, scene, runner):
        ran.append((cam.base_radius, scene, runner))
        return Made(machine=cam.machine, profile=Made(lobe=outline, of=cam.base_radius))

    stubs(
        monkeypatch, simulate, _cams_side_by_side=cams, _profile_of=profile_of,
        _runner=lambda scene, base: f"runner on {base}",
        _profile_names=lambda profile: ["theta_deg", "c_m"],
        _profile_rows=lambda profile, system, rpm: iter([(profile.of, f"{system.name} {rpm}")]),
        undercut_notes=lambda profile, system: ["undercut", system.name],
        lobe_notes=lambda lobe, units: ["lobe", units], units_of=lambda system: system.name,
        _profile_summary=lambda profile, ratio, cam: {"of": [profile.of, ratio, cam]},
        _draw_profiles=lambda profiles: [one.profile.of for one in profiles],
    )  # fmt: skip
    result = simulate._profile(own)
    assert ran == [(0.02, own.scene, "runner on 0.02"), (0.03, own.scene, None),
                   (0.04, own.scene, None)]  # fmt: skip
    assert list(result.tables) == ["profile", "profile_2", "profile_3", *["outline"] * lobe]
    for name, row in (("profile", [0.02, "own 650.0"]), ("profile_2", [0.03, "other 650.0"]),
                      ("profile_3", [0.04, "third 650.0"])):  # fmt: skip
        assert [column.tolist()[0] for column in result.tables[name].values()] == row
    if lobe:
        outline = {name: column.tolist() for name, column in result.tables["outline"].items()}
        assert outline == {"theta_deg": pytest.approx([10.0]), "x_m": [0.25], "y_m": [0.5],
                           "contact_angle_deg": pytest.approx([20.0])}  # fmt: skip
    assert result.notes == (("lobe", "own") if lobe else ("undercut", "own"))
    assert result.summary == {"of": [0.02, 1.25, "cam"]}
    assert result.pictures["profile"]() == [0.02, 0.03, 0.04]
    assert (result.values.of, result.cost, result.complete) == (0.02, Cost(), True)
    assert isinstance(result.tables["profile"], Table)


@pytest.mark.parametrize("between", [None, (600.0, 700.0)])
def test_the_first_loss_of_a_measured_cam_has_its_range(monkeypatch, between):
    asked = []

    def profile(*given):
        asked.append(given)
        return Made(first=first, lobe=None)

    first = Made(rpm=650.0, low=649.0, high=651.0)
    monkeypatch.setattr("camcli.analysis.cam_profile.profile", profile)
    stubs(monkeypatch, simulate, lost_between=between,
          replace=lambda one, **more: Made(**{**vars(one), **more}))  # fmt: skip
    cam = simulate._CamBeside(Made(system="system"), 0.02)
    scene = Made(run=Made(rpm=650.0), simulate=Made(samples=90))
    machine, base, found = simulate._profile_of(cam, scene, "runner")
    assert asked == [("system", 650.0, 90, 0.02, "runner")]
    assert (machine.system, base) == ("system", 0.02)
    low, high = between or (649.0, 651.0)
    assert found.first == Made(rpm=650.0, low=low, high=high)
    first = None
    assert simulate._profile_of(cam, scene, None).profile.first is None


def test_a_cam_on_which_nothing_runs_is_drawn_by_its_lift(monkeypatch):
    """Each by its own machine, in units of the first one."""
    drawn = []
    monkeypatch.setattr("camcli.plots.cam_profile.draw_profiles", drawn.append)
    monkeypatch.setattr("camcli.plots.cam_profile.CamDrawing", lambda *given: given)
    outlines = Made(
        of_lift=lambda *given: ("lift", *given), of_lobe=lambda *given: ("lobe", *given)
    )
    monkeypatch.setattr("camcli.plots.mechanism.Outline", outlines)
    monkeypatch.setattr(simulate, "units_of", lambda system: f"units of {system.as_drawn}")
    first, second = (Made(scene=Made(cam=f"cam {n}"), system=Made(as_drawn=f"drawn {n}"))
                     for n in (1, 2))  # fmt: skip
    lobe = Made(lobe="a lobe")
    simulate._draw_profiles([simulate._CamProfile(first, 0.02, lobe),
                             simulate._CamProfile(second, 0.03, Made(lobe=None))])  # fmt: skip
    units = "units of drawn 1"
    assert drawn == [[
        (lobe, ("lobe", "drawn 1", "a lobe"), "cam 1", units),
        (Made(lobe=None), ("lift", "drawn 2", 0.03, "cam 2"), "cam 2", units),
    ]]  # fmt: skip


@pytest.mark.parametrize(
    ("face", "last"),
    [("flat", "eccentricity_m"), ("knife", "pressure_angle_deg"), ("roller", "pressure_angle_deg")],
)
def test_the_columns_of_a_profile_are_those_of_its_face(face, last):
    plain = simulate._profile_names(Made(lobe=None))
    names = simulate._profile_names(Made(lobe=Made(face=face)))
    assert names == [*plain, "lobe_radius_m", last]
    assert plain[:5] == [
        "theta_deg",
        "c_m",
        "c_theta_m_per_rad",
        "c_thetatheta_m_per_rad2",
        "force_n",
    ]
