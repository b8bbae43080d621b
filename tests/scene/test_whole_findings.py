"""What is said of a scene that cannot be read or used, word by word, a case for each cause."""

from __future__ import annotations

import pytest

from camcli.errors import SceneError
from camcli.scene import load_scene
from tests.cli.test_whole_faults import LAW, STOP

FOLLOWER = "follower: {mass: 1.0, stiffness: 1000.0, restitution: 0.5}\n"
CAM = "cam: {kind: eccentric, base: 0.1, lift: 0.02}\n"
SECTIONS = (
    "follower, cam, spring, contact, run, plot, simulate, sweep, detach, orbits, classify, basins, "
    "explore, bench, figure"
)
RUN = (
    "rpm, start, crank, transient, record, patience, strobe_deg, chatter_tolerance, impact_budget, "
    "work_budget"
)


def said_of(*scene) -> list[str]:
    with pytest.raises(SceneError) as refused:
        load_scene(*scene)
    return [str(fault) for fault in refused.value.faults]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("follower: !odd {mass: 1.0, stiffness: 1.0, restitution: 0.5}\n" + CAM,
         "1:11: follower: found the tag !odd, expected a value without a tag, remove it"),
        (FOLLOWER + CAM + "? [1, 2]\n: 3\n",
         "3:3: found a map or list as a key, expected a word, write 'key: value' with a plain key"),
        (FOLLOWER + FOLLOWER + CAM,
         "2:1: follower: found key 'follower' on lines 1 and 2, expected each key once, keep one "
         "of the two"),
        ("a: \x07\n",
         "1:4: found the control character 0x07, expected text, is this a binary file?"),
        ("follower:\n\tmass: 1\n", "2:1: found a tab, expected YAML, indent with spaces"),
        (FOLLOWER + CAM + "---\n" + FOLLOWER,
         "3:1: found a second document, expected YAML, remove this '---' and what follows"),
        ("follower: *one\n",
         "1:11: found an alias (*) without its anchor (&), expected YAML, put the anchor before "
         "it"),
        ("follower: mass: 1\n",
         "1:15: found a second ':', expected YAML, put the text in quotes, or start a new line"),
        ("follower: 'mass\n", "2:1: a quote is not closed, expected YAML, close it"),
        ('follower: "\\q"\n',
         "1:12: a quoted text is not readable, expected YAML, check its quotes and escapes"),
        ("follower: [1, 2\n",
         "2:1: a bracket is not closed, or a comma is missing, expected YAML, close it"),
        ("follower:\n  mass: 1\n stiffness: 2\n",
         "3:2: the indentation does not fit the lines above, expected YAML, align the keys"),
        ("follower: @1\n",
         "1:11: a word begins with a character of YAML's own, expected YAML, put it in quotes"),
        ("[" * 40 + "]" * 40,
         "1:34: found maps and lists nested deeper than 32 levels, expected YAML, is this the "
         "right file?"),
        ("", f"1:1: found nothing in this file, expected a map with the sections {SECTIONS}, start "
             "from follower: and cam:"),
        ("- 1\n", f"1:1: found a list, expected a map with the sections {SECTIONS}, start from "
                  "follower: and cam:"),
        ("1\n", f"1:1: found a single value, expected a map with the sections {SECTIONS}, start "
                "from follower: and cam:"),
        (FOLLOWER + CAM + "<<: {a: 1}\n",
         f"3:1: <<: found a merge key '<<', expected one of {SECTIONS}, write the keys out, "
         "merging is not read"),
    ],
)  # fmt: skip
def test_a_text_that_is_no_scene(tmp_path, text, said):
    file = tmp_path / "scene.yaml"
    file.write_text(text)
    assert said_of(file) == [f"{file}:{said}"]


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"\xff\xfea\x00", ":1:1: found UTF-16 text, expected UTF-8 text, save the file as UTF-8"),
        (b"follower: \xff\n",
         ":1:11: found byte 0xff, expected UTF-8 text, save the file as UTF-8"),
        (None, ": no such file, expected a YAML file, check the name, or leave out -c for the "
               "default scene"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_text(tmp_path, data, said):
    file = tmp_path / "scene.yaml"
    if data is not None:
        file.write_bytes(data)
    assert said_of(file) == [f"{file}{said}"]


@pytest.mark.parametrize(
    ("value", "cure"),
    [
        ("1:30", "base 60 is not read, write a decimal number"),
        ("0x1F", "write the number in decimal"),
        ("012", "write the number without leading zeros (it could mean octal)"),
        ("1_000", "leave out the underscores"),
        ("1,5", "write a decimal point, and no separators between thousands"),
        ("1d3", "write the exponent with e"),
        ("−3", "write the minus sign as an ASCII -"),
        ("3 kg", "write the number without its unit"),
        ("2*3", "write the value out, expressions are not evaluated"),
        ("3 crank", "only a speed may be the crank's, written as 6000 crank"),
        ("some", "give mass as a number"),
        ("'3'", "remove the quotes"),
        ("''", "give a value"),
    ],
)
def test_a_number_written_as_none_is(tmp_path, value, cure):
    file = tmp_path / "scene.yaml"
    file.write_text(f"follower:\n  mass: {value}\n  stiffness: 9.0\n  restitution: 0.5\n{CAM}")
    bare = value.strip("'")
    assert said_of(file) == [
        f"{file}:2:9: follower.mass: found '{bare}', expected a number, {cure} (mass of the "
        "follower, kg)"
    ]


@pytest.mark.parametrize(
    ("value", "found", "expected", "cure"),
    [
        (".inf", ".inf", "a finite number", "give mass a finite number"),
        ("true", "true", "a number", "true and false are neither numbers nor text here"),
        ("[1, 2]", "a list of 2 values", "a number", "give mass a single value"),
        ("[]", "an empty list", "a number", "give mass a single value"),
        ("{a: 1}", "a map", "a number", "give mass a single value"),
        ("null", "null", "a number", "give mass a value, or remove the line"),
        ("0", "0", "a number of at least 1e-15", "change mass"),
    ],
)
def test_another_thing_than_a_number(tmp_path, value, found, expected, cure):
    file = tmp_path / "scene.yaml"
    file.write_text(f"follower:\n  mass: {value}\n  stiffness: 9.0\n  restitution: 0.5\n{CAM}")
    assert said_of(file) == [
        f"{file}:2:9: follower.mass: found {found}, expected {expected}, {cure} (mass of the "
        "follower, kg)"
    ]


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("run.rpm=700:800",
         "run.rpm: found '700:800', expected a number, a range of speeds stands in sweep.rpm; give "
         "rpm a single value (speed of the cam, turns per minute)"),
        ("run.rpm={start: 1, stop: 2}",
         "run.rpm: found a map, expected a number, a range of speeds stands in sweep.rpm; give rpm "
         "a single value (speed of the cam, turns per minute)"),
        ("run.transient=1.5",
         "run.transient: found 1.5, expected a whole number, round it (turns before recording)"),
        ("run.record=0",
         "run.record: found 0, expected a number of at least 1, change record (turns recorded)"),
        ("run.rpm", "found no '=', expected path.to.key=value, write the key, an = and the value "
                    "without blanks between"),
        ("=3", "found the path '', expected path.to.key=value, name a key as in run.rpm"),
        ("a..b=3", "found the path 'a..b', expected path.to.key=value, name a key as in run.rpm"),
        ("run=3", f"run: found 3, expected a map with the keys {RUN}, write 'key: value' lines "
                  "below run (one simulation)"),
        ("sweep.rpm=700",
         "sweep.rpm: found 700, expected a map with the keys start, stop, num, write one speed as "
         "rpm: {start: 700, stop: 700} (range of speeds)"),
        ("basins.cells=30",
         "basins.cells: found 30, expected a list, write cells along both sides: [30, 30] (cells "
         "along q and v)"),
        ("cam.kind=eccentrc",
         "cam.kind: found 'eccentrc', expected one of arcs, law, eccentric, table, oscillator, did "
         "you mean 'eccentric'?"),
        ("cam.kind=zzz",
         "cam.kind: found 'zzz', expected one of arcs, law, eccentric, table, oscillator, choose "
         "one of these"),
        ("run.rmp=3",
         f"run.rmp: found the unknown key 'rmp', expected one of {RUN}, did you mean 'rpm'?"),
        ("mass=3",
         f"mass: found the unknown key 'mass', expected one of {SECTIONS}, did you mean "
         "follower.mass or spring.mass?"),
        ("follower.restitution=1.5",
         "follower.restitution: found 1.5, expected a number of at most 1, change restitution "
         "(coefficient of restitution, 0..1)"),
        ("basins.q=[1, 1]",
         "basins.q: found [1, 1], expected [low, high], two different ends, give a window of some "
         "width"),
        ("sweep.tables=nz",
         "sweep.tables: found 'nz', expected one of csv, npz, none, did you mean 'npz'? (form of "
         "the sections' tables: text, binary columns, or left out)"),
    ],
)  # fmt: skip
def test_an_override_that_is_refused(tmp_path, override, said):
    file = tmp_path / "scene.yaml"
    file.write_text(FOLLOWER + CAM)
    assert said_of(file, [override]) == [f"--set {override}: {said}"]


FREE = {"follower": {"mass": 1.0, "restitution": 0.5}, "cam": LAW["cam"]}  # its spring by loads
OF_AN_OSCILLATOR = "write it under cam; a range is --vary cam.frequency=LO:HI"
TIMELESS = f"expected none: its speed is its frequency, {OF_AN_OSCILLATOR}"
UNDER_CAM = (
    "beside an oscillator, expected every constant of an oscillator, and its frequency, under "
    f"cam, {OF_AN_OSCILLATOR}"
)
NO_SEAT = (
    "beside an oscillator, expected neither lash nor seat: its stop is where its clearance puts "
    "it, leave it out"
)


@pytest.mark.parametrize(
    ("scene", "values", "said"),
    [
        (LAW, {"spring.in_follower": True},
         "spring: found in_follower without mass, expected the mass of the spring, give "
         "spring.mass in kg, or leave in_follower out"),
        ({**LAW, "spring": {"rate": 5.0, "preload": 3.0}}, {},
         "spring: found follower.stiffness beside loads of the spring, expected one of them, leave "
         "one out"),
        ({**FREE, "spring": {"rate": 5.0}}, {},
         "spring: found rate, expected two of rate, preload, seat_load, nose_load, leave out, or "
         "add, the others"),
        ({**FREE, "spring": {"seat_load": 50.0, "nose_load": 30.0}}, {},
         "spring: found seat_load 50 N and nose_load 30 N, expected a spring that presses harder "
         "at 0.11 m than at 0.1 m, check both loads"),
        ({**FREE, "cam": {**LAW["cam"], "base": 0.0},
          "spring": {"seat_load": 50.0, "preload": 30.0}}, {},
         "spring: found preload 30 N and seat_load 50 N, expected a spring that presses harder at "
         "0.01 m than at 0 m, both are at q = 0 here, give another"),
        (LAW, {"contact.face": "knife", "contact.follower_radius": 0.01},
         "contact: found face: knife with follower_radius 0.01, expected no radius: only a roller "
         "has one, leave one of them out"),
        (LAW, {"contact.face": "flat", "contact.follower_radius": 0.01},
         "contact: found face: flat with follower_radius 0.01, expected no radius: only a roller "
         "has one, leave one of them out"),
        (LAW, {"contact.face": "knife", "contact.width": 0.01},
         "contact: found face: knife with width 0.01, expected no width: a Hertz pressure needs a "
         "roller or a flat face, leave one of them out"),
        (LAW, {"contact.base_radius": 0.1},
         "contact: found neither face nor width, expected what runs on the lobe, or the width of "
         "the contact line, give face: knife, roller or flat, or width in m"),
        (LAW, {"orbits.checker": True},
         "orbits: found checker: true without prove, expected a proof that it can check, write "
         "prove: true, or leave checker out"),
        (LAW, {"orbits.all.impacts": 2, "orbits.all.turns": 1, "orbits.label": "P(1;1)"},
         "orbits: found label beside all, expected all orbits at one speed, or some and their "
         "branches, leave out label, or all"),
        (LAW, {"classify.starts": 1000, "classify.rpm": {"start": 9, "stop": 20, "num": 100_000}},
         "classify: found 100000 speeds x 1001 starts, 100100000 motions, expected at most "
         "10000000, ask for fewer speeds or starts"),
        (LAW, {"figure.title": "a", "figure.command": "sweep --rpm 3"},
         "figure.command: found options in 'sweep --rpm 3', expected sweep alone, write them into "
         "the scene: each option of a command is a key of its section"),
        (LAW, {"figure.title": "a", "figure.command": " "},
         "figure.command: found no command, expected the name of a command of cam, name one"),
        (LAW, {"simulate.animate": True, "simulate.profile_only": True},
         "simulate.animate: found it with profile_only, it means nothing there, leave one of them "
         "out"),
        (LAW, {"plot.formats": ["png", "png"]},
         "plot.formats: found the same name twice: 'png', expected each name once, keep one of the "
         "two"),
        (STOP, {"cam.lash": 0.1}, f"cam.lash: found lash {NO_SEAT}"),
        (STOP, {"follower.seat_restitution": 0.1},
         f"follower.seat_restitution: found seat_restitution {NO_SEAT}"),
        (STOP, {"follower.mass": 2.0}, f"follower: found mass {UNDER_CAM}"),
        (STOP, {"run.rpm": 2.0}, f"run: found rpm {UNDER_CAM}"),
        (STOP, {"sweep.rpm.start": 2.0, "sweep.rpm.stop": 3.0},
         f"sweep.rpm: found a range of speeds for an oscillator, {TIMELESS}"),
        (STOP, {"basins.rpm.start": 2.0, "basins.rpm.stop": 2.0},
         f"basins.rpm: found 2.0 rpm for an oscillator, {TIMELESS}"),
        (STOP, {"orbits.at": 2.0}, f"orbits.at: found 2.0 rpm for an oscillator, {TIMELESS}"),
        (STOP, {"sweep.vary": [{"key": "follower.mass", "start": 1.0, "stop": 2.0}]},
         "sweep.vary: found follower.mass beside an oscillator, expected a number of its cam, or "
         f"follower.restitution, {OF_AN_OSCILLATOR}"),
        (LAW, {"follower.seat_restitution": 0.1},
         "follower.seat_restitution: found 0.1 without cam.lash, expected it beside cam.lash: a "
         "follower without lash has no seat, add cam.lash, or leave it out"),
        (LAW, {"cam.lash": 0.0},
         "cam.lash: found 0.0, and a cam that stays nowhere on its base circle, expected a lash "
         "above 0, or a dwell on the base circle, which is the seat, leave it out: without lash "
         "the follower rests on its cam"),
        (LAW, {"cam.lash": 0.01},
         "cam.lash: found 0.01, and a cam that lifts 0.01 m, expected less than the lift: the "
         "follower would never leave its seat, give it in m, at the follower (behind a rocker: at "
         "the valve)"),
        # the arcs of the default scene, by hand: 0.85 - (0.45 + 0.2); 9 - 0.85; 0.7 - 0.4501;
        # 8.55 - 0.7
        (None, {"cam.base_radius": 0.2},
         "cam: the flank circle misses the base circle by 0.2 m: flank_radius must equal "
         "flank_center + base_radius, change the values of cam"),
        (None, {"cam.nose_radius": 9.0},
         "cam: nose_radius is 8.15 m too large: it must be smaller than flank_radius, change the "
         "values of cam"),
        (None, {"cam.nose_center": 0.0001},
         "cam: flank and nose circle do not touch, they miss by 0.2499 m: flank_center + "
         "nose_center must exceed flank_radius - nose_radius, change the values of cam"),
        (None, {"cam.nose_center": 9.0},
         "cam: flank and nose circle do not touch, they overlap by 7.85 m: |flank_center - "
         "nose_center| must be below flank_radius - nose_radius, change the values of cam"),
    ],
)  # fmt: skip
def test_numbers_that_make_no_machine(scene, values, said):
    (fault,) = said_of(scene, values)
    assert fault.endswith(said)
    place = fault.removesuffix(said)
    assert place in ("overrides: ", "scene: ") or place.endswith("chapter.yaml:15:1: ")
