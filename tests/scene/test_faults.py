"""Every fault at once, each at its line and column, in words, with something to do."""

import re

import pytest

from camcli.errors import SceneError
from camcli.scene import load_scene

SEVERAL = """\
follower:
  mass: "1.2"
  stiffness: -3
  damping: 010
  gravity: .nan
  prelod: 0
  restitution: 1e-3
cam: {kind: arcs, base_radius: 0.4 m, flank_center: 0.45, flank_radius: 0.85,
      nose_center: 0.4039332, nose_radius: true, top_dwell_deg: 40, offset: .inf}
run:
  rpm: 660:760
  start: [1, 2]
  transient: 600.5
  transient: 3
  record: on
  chatter_tolerance: 1e-2
simulate:
- samples: 3
sweep:
  rpm: {start: 0, num: 0, stop: null}
  direction: upp
  sections: [impacts, strob]
rpm: 700
"""
PLACES = """
2:9 follower.mass           3:14 follower.stiffness   4:12 follower.damping  5:12 follower.gravity
6:3 follower.prelod         8:32 cam.base_radius      9:44 cam.nose_radius   9:77 cam.offset
11:8 run.rpm                12:10 run.start           13:14 run.transient    14:3 run.transient
15:11 run.record            16:22 run.chatter_tolerance                      18:1 simulate
20:16 sweep.rpm.start       20:24 sweep.rpm.num       20:33 sweep.rpm.stop   21:14 sweep.direction
22:23 sweep.sections.1      23:1 rpm
"""


def test_several_faults_at_once_with_exact_places_each_in_three_parts(faults, places):
    assert places(SEVERAL) == list(zip(PLACES.split()[::2], PLACES.split()[1::2], strict=True))
    for fault in faults(SEVERAL):
        assert re.search(r"scene\.yaml:\d+:\d+: \S+: (found|no) .*, expected .*, .+", str(fault))


@pytest.mark.parametrize(
    ("line", "found", "expected", "cure"),
    [
        ("run: {rpm: '7e2'}", "'7e2'", "a number", "remove the quotes"),
        ("run: {rpm: 0}", "0", "at least 1e-09", "change rpm (speed of the cam, turns per minute)"),
        ("run: {rpm: 1e999}", "1e999", "a finite number", "finite"),
        ("run: {rpm: true}", "true", "a number", "neither numbers nor text"),
        ("run: {rpm: [700]}", "a list", "a number", "a single value"),
        ("run: {rpm: {start: 660}}", "a map", "a number", "a range of speeds stands in sweep.rpm"),
        ("run: {rpm: 11:40}", "'11:40'", "a number", "a range of speeds stands in sweep.rpm"),
        ("run: {rpm: fast}", "'fast'", "a number", "give rpm as a number"),
        ("run: {rpm: }", "nothing", "a number", "remove the line"),
        ("run: {record: 0}", "0", "a number of at least 1", "turns recorded"),
        ("run: {record: 2.5}", "2.5", "a whole number", "round it"),
        ("run: {record: yes}", "'yes'", "a whole number", "give record as a number"),
        ("run: {strobe_deg: 360}", "360", "less than 360", "change strobe_deg"),
        ("run: {start: {q: 1 m}}", "'1 m'", "a number", "unit (height, m;"),
        ("run: [rpm, 700]", "a list", "a map with the keys rpm, start", "'key: value' lines"),
        ("run: {<<: {rpm: 3}}", "merge key", "one of rpm, start", "write the keys out"),
        ("run: {recrod: 4}", "unknown key 'recrod'", "one of rpm", "did you mean 'record'?"),
        ("run: {zzz: 4}", "unknown key 'zzz'", "one of rpm", "remove it"),
        ("num: 3\nrpm: 3", "unknown key 'rpm'", "one of follower", "run.rpm or sweep.rpm"),
        ("sweep: {direction: Up}", "'Up'", "one of fixed, up, down", "did you mean 'up'?"),
        ("sweep: {sections: impacts}", "'impacts'", "a list", "sections as a list: [impacts]"),
        ("sweep: {sections: []}", "an empty list", "at least 1", "sections recorded"),
        ("basins: {rpm: 358.5}", "358.5", "a map", "rpm: {start: 358.5, stop: 358.5}"),
        ("basins: {cells: 60}", "60", "a list", "[60, 60]"),
        ("sweep: {sections: {}}", "an empty map", "a list", "as a list"),
        ("sweep: {sections: [strobe, strobe]}", "twice: 'strobe'", "once", "keep one"),
        ("sweep: {lyapunov: 1}", "1", "true or false", "largest exponent"),
        ("orbits: {curve_range: []}", "an empty list", "2 values", "range of curve_in"),
        ("basins: {q: [1]}", "a list of 1 value", "2 values", "position"),
        ("basins: {q: [1, 2, 3]}", "a list of 3 values", "at most 2", "position"),
        ("figure: {command: sweep}", "no key 'title'", "what the figure shows", "add 'title: ...'"),
        ("figure: {title: '', command: sweep}", "''", "at least 1 char", "change title"),
    ],
)
def test_words_of_a_fault(faults, valid, line, found, expected, cure):
    fault = faults(valid + line + "\n")[-1]
    assert found in fault.found
    assert expected in fault.expected
    assert cure in fault.cure


def test_the_cam_s_own_checks_and_kinds(faults, valid):
    (fault,) = faults("# a comment\n" + valid.replace("flank_radius: 0.85", "flank_radius: 0.9"))
    assert (fault.where[-14:], fault.path) == ("scene.yaml:3:1", "cam")
    assert "flank circle" in fault.found
    (fault,) = faults(valid.replace("kind: arcs", "kind: arc"))
    assert (fault.path, fault.where[-4:]) == ("cam.kind", ":3:9")
    assert fault.expected == "expected one of arcs, law, eccentric, table, oscillator"
    assert fault.cure.startswith("did you mean 'arcs'?")
    assert faults(valid[: valid.index("cam:")] + "cam: arcs\n")[0].path == "cam"


@pytest.mark.parametrize(
    ("law", "path", "expected"),
    [
        ("3-4-6", "cam.rise.law", "one of harmonic, cycloidal, 3-4-5"),
        ("{scca: {b: 1, c: x, d: 0}}", "cam.rise.law.scca.c", "a number"),
        ("{scca: {b: 1, c: 1, d: 0}}", "cam.rise.law.scca", ""),
        ("{scca: {b: 1, c: 0}}", "cam.rise.law.scca.d", "share with a cosine"),
        ("{sca: {}}", "cam.rise.law.sca", "one of scca"),
        ("{scca: {b: 1, c: 0, d: 0, e: 0}}", "cam.rise.law.scca.e", "one of b, c, d"),
    ],
)
def test_a_union_inside_a_kind_names_no_members(faults, valid, law, path, expected):
    cam = f"cam: {{kind: law, base: 0, lift: 1, fall: {{length_deg: 90, law: 3-4-5}}, rise: {{start_deg: 0, length_deg: 90, law: {law}}}}}\n"  # noqa: E501
    fault = faults(valid[: valid.index("cam:")] + cam)[0]
    assert fault.path == path
    assert expected in fault.expected


def test_a_law_is_one_of_the_words_or_a_map(faults, valid):
    rise = "{start_deg: 0, length_deg: 90, law: 3-4-6}"
    fall = "{length_deg: 90, law: 3-4-5}"
    cam = f"cam: {{kind: law, base: 0, lift: 1, rise: {rise}, fall: {fall}}}\n"
    (fault,) = faults(valid[: valid.index("cam:")] + cam)
    assert (fault.path, fault.found) == ("cam.rise.law", "found '3-4-6'")
    assert fault.expected == (
        "expected one of harmonic, cycloidal, 3-4-5, 4-5-6-7, modified-trapezoid, modified-sine, "
        "constant-acceleration, constant-velocity or a map with the keys scca"
    )
    assert fault.cure.startswith("did you mean '3-4-5'? (law of motion: a name, or {scca: ")


def test_too_many_faults_are_counted(faults, valid):
    found = faults(valid + "".join(f"k{i}: 1\n" for i in range(500)))
    assert len(found) == 101
    assert found[-1].found == "400 further faults"


def test_no_fault_follows_from_another_and_hints_are_limited(places, faults, valid):
    assert places(valid + "sweep: {sections: [strob]}") == [("11:20", "sweep.sections.0")]
    unknown = ", ".join(f"recor{i}: 1" for i in range(60))
    cures = [fault.cure for fault in faults(valid + f"run: {{{unknown}}}")]
    assert cures == ["did you mean 'record'?"] * 50 + ["remove it"] * 10


@pytest.mark.parametrize(
    ("follower", "run", "told"),
    [
        ({}, {"mas": 700}, ["follower.mass", "run.mas"]),  # another section's key is none of its
        ({"mas": 1.0}, {}, ["follower.mas"]),
    ],
)
def test_a_missing_key_is_told_unless_it_is_misspelt_in_its_own_section(follower, run, told):
    cam = {"kind": "eccentric", "base": 0.1, "lift": 0.02}
    scene = {"follower": {"stiffness": 1.0, "restitution": 0.5, **follower}, "cam": cam, "run": run}
    with pytest.raises(SceneError) as raised:
        load_scene(scene)
    assert sorted(fault.path for fault in raised.value.faults) == told
