"""Every fault at once, each at its line and column, in words, with something to do."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from camcli.scene import load as load_module

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


def test_several_faults_at_once_with_exact_places(places):
    assert places(SEVERAL) == [
        ("2:9", "follower.mass"),
        ("3:14", "follower.stiffness"),
        ("4:12", "follower.damping"),
        ("5:12", "follower.gravity"),
        ("6:3", "follower.prelod"),
        ("8:32", "cam.base_radius"),
        ("9:44", "cam.nose_radius"),
        ("9:77", "cam.offset"),
        ("11:8", "run.rpm"),
        ("12:10", "run.start"),
        ("13:14", "run.transient"),
        ("14:3", "run.transient"),
        ("15:11", "run.record"),
        ("16:22", "run.chatter_tolerance"),
        ("18:1", "simulate"),
        ("20:16", "sweep.rpm.start"),
        ("20:24", "sweep.rpm.num"),
        ("20:33", "sweep.rpm.stop"),
        ("21:14", "sweep.direction"),
        ("22:23", "sweep.sections.1"),
        ("23:1", "rpm"),
    ]


def test_every_fault_says_what_was_found_what_is_expected_and_what_to_do(faults):
    for fault in faults(SEVERAL):
        assert fault.found
        assert fault.expected.startswith("expected ")
        assert fault.cure
        assert re.search(r"scene\.yaml:\d+:\d+: \S+: .*, expected .*, .+", str(fault))


@pytest.mark.parametrize(
    ("line", "found", "expected", "cure"),
    [
        ("run: {rpm: '7e2'}", "'7e2'", "a number from 1e-09 to 1000000000", "remove the quotes"),
        ("run: {rpm: 0}", "0", "a number from 1e-09", "speed of the cam, turns per minute"),
        ("run: {rpm: -5}", "-5", "a number from 1e-09", "in this range"),
        ("run: {rpm: 1e999}", "1e999", "a number from", "finite"),
        ("run: {rpm: nan}", "nan", "a number from", "finite"),
        ("run: {rpm: true}", "true", "a number", "neither numbers nor text"),
        ("run: {rpm: [700]}", "a list", "a number", "a single value"),
        ("run: {rpm: {a: 1}}", "a map", "a number", "a single value"),
        ("run: {rpm: 11:40}", "'11:40'", "a number", "base 60"),
        ("run: {rpm: fast}", "'fast'", "a number", "give rpm as a number"),
        ("run: {rpm: }", "nothing", "a number", "remove the line"),
        ("run: {record: 0}", "0", "a whole number from 1 to", "turns recorded"),
        ("run: {record: 1e30}", "1e30", "a whole number from 1 to", "in this range"),
        ("run: {record: 2.5}", "2.5", "a whole number from 1 to", "round it"),
        ("run: {record: yes}", "'yes'", "a whole number", "plain text"),
        ("run: {strobe_deg: 360}", "360", "at least 0 and less than 360", "in this range"),
        ("run: {start: resting}", "'resting'", "a map with the keys q, v, theta_deg", "key: value"),
        ("run: {start: {q: 1 m}}", "'1 m'", "a number from -10", "(height of the follower, m;"),
        ("run: [rpm, 700]", "a list", "a map with the keys rpm, start", "without dashes"),
        ("run: {<<: {rpm: 3}}", "merge key", "one of rpm, start", "write the keys out"),
        ("run: {recrod: 4}", "unknown key 'recrod'", "one of rpm", "did you mean 'record'?"),
        ("run: {zzz: 4}", "unknown key 'zzz'", "one of rpm", "remove it"),
        ("num: 3\nrpm: 3", "unknown key 'rpm'", "one of follower", "run.rpm or sweep.rpm"),
        ("sweep: {direction: Up}", "'Up'", "one of fixed, up, down", "did you mean 'up'?"),
        ("sweep: {sections: impacts}", "'impacts'", "a list of", "sections: [impacts]"),
        ("sweep: {sections: []}", "an empty list", "a list of", "at least one"),
        ("sweep: {sections: {}}", "an empty map", "a list of", "as a list"),
        ("sweep: {rpm: {num: 1000000000}}", "1000000000", "1 to 10000000", "number of speeds"),
        ("sweep: {rpm: {num: 0}}", "0", "1 to 10000000", "number of speeds"),
    ],
)
def test_words_of_a_fault(faults, valid, line, found, expected, cure):
    fault = faults(valid + line + "\n")[-1]
    assert found in fault.found
    assert expected in fault.expected
    assert cure in fault.cure


@pytest.mark.parametrize(
    ("key", "bad"),
    [
        ("mass", ["0", "-1", "nan", "inf", "-inf", "'1'", "true", "1e999"]),
        ("stiffness", ["-1", "nan", "inf"]),
        ("damping", ["-1e-300", "nan", "inf"]),
        ("gravity", ["nan", "-.inf"]),
        ("preload", ["nan", "inf"]),
        ("restitution", ["-0.1", "1.0000000000000002", "nan", "inf"]),
    ],
)
def test_follower_outside_its_range(places, valid, key, bad):
    for value in bad:
        text = re.sub(rf"{key}: [\d.]+", f"{key}: {value}", valid)
        if text == valid:
            text = valid.replace("{mass", f"{{{key}: {value}, mass")
        column = text.index(f"{key}: {value}") + len(key) + 3
        assert places(text) == [(f"1:{column}", f"follower.{key}")]


def test_missing_sections_and_keys(places, valid):
    assert places("run: {rpm: 700}\n") == [("1:1", "follower"), ("1:1", "cam")]
    assert places(valid.replace("mass: 1.221, ", "")) == [("1:1", "follower.mass")]
    assert places(valid.replace("  kind: arcs\n", "")) == [("2:1", "cam.kind")]
    assert places("follower:\n" + valid[valid.index("cam:") :]) == [
        ("1:1", "follower.mass"),
        ("1:1", "follower.stiffness"),
        ("1:1", "follower.restitution"),
    ]


def test_bad_geometry_is_a_fault_at_the_cam(faults, valid):
    (fault,) = faults("# a comment\n" + valid.replace("flank_radius: 0.85", "flank_radius: 0.9"))
    assert fault.where.endswith("scene.yaml:3:1")
    assert fault.path == "cam"
    assert "flank circle" in fault.found


def test_wrong_kind_of_cam(faults, valid):
    (fault,) = faults(valid.replace("kind: arcs", "kind: arc"))
    assert (fault.path, fault.where[-4:]) == ("cam.kind", ":3:9")
    assert "arcs" in fault.expected
    assert fault.cure == "did you mean 'arcs'?"
    assert faults(valid[: valid.index("cam:")] + "cam: arcs\n")[0].path == "cam"


@pytest.mark.parametrize("text", ["", "- a\n", "7\n", "# comment\n", "~\n"])
def test_a_file_that_is_no_map_is_one_fault(faults, text):
    (fault,) = faults(text)
    assert "a map with the sections follower, cam, run" in fault.expected


def test_one_value_is_one_fault(faults, valid):
    (fault,) = faults(valid + "run: {rpm: !!float fast}\n")
    assert fault.found == "found the tag !!float"


def test_too_many_faults_are_counted(faults, valid):
    found = faults(valid + "".join(f"k{i}: 1\n" for i in range(500)))
    assert len(found) == load_module.MAX_FAULTS + 1
    assert found[-1].found == "400 further faults"


def test_keys_of_the_user_cannot_write_to_the_terminal(faults, valid):
    (fault,) = faults(valid + '"\\e[2J\\n\\u202e": 1\n')
    assert str(fault).isprintable()


TWO_KINDS = """
import sys, json
from typing import Literal
from pathlib import Path
from pydantic import BaseModel, ConfigDict, Field
import camcli.cams
class Linear(BaseModel):
    shape: Literal["linear"]
    gain: float = Field(gt=0, description="gain, m")
class Square(BaseModel):
    shape: Literal["square"]
class Toy(BaseModel):
    '''A stand-in for a second kind: a key named like it, and a union inside.'''
    model_config = ConfigDict(extra="forbid")
    kind: Literal["toy"]
    lift: float = Field(gt=0, description="lift, m")
    toy: float = Field(gt=0, description="toy, m")
    law: Linear | Square = Field({"shape": "square"}, discriminator="shape", description="law")
camcli.cams.CAMS = (camcli.cams.ArcsCam, Toy)
from camcli.scene import load_scene
from camcli.errors import SceneError
for number, cam in enumerate(json.loads(sys.argv[2])):
    path = Path(sys.argv[1]) / "s.yaml"
    path.write_text("follower: {mass: 1, stiffness: 1, restitution: 1}\\n" + cam + "\\n")
    try:
        print(type(load_scene(path).cam).__name__)
    except SceneError as error:
        print(" | ".join(f"{f.where[-4:]} {f.path} {f.expected}" for f in error.faults))
"""


def test_two_kinds_of_cam(tmp_path):
    cams = {
        "cam: {kind: toy, lift: 1, toy: 2}": "Toy",
        "cam: {kind: toy, lift: 0, toy: 2}": "2:24 cam.lift expected a number greater than 0",
        "cam: {kind: toy, lift: 1, toy: x}": "2:32 cam.toy expected a number greater than 0",
        "cam: {kind: toy, lift: '1', toy: 1}": "2:24 cam.lift expected a number greater than 0",
        "cam: {kind: toy, toy: 1}": ":2:1 cam.lift expected a number greater than 0",
        "cam: {kind: toy, lift: 1, toy: 1, x: 1}": (
            "2:35 cam.x expected one of kind, lift, toy, law"
        ),
        "cam: {kind: toy, lift: 1, toy: 1, law: {shape: linear, gain: x}}": (
            "2:62 cam.law.gain expected a number greater than 0"
        ),
        "cam: {kind: toy, lift: 1, toy: 1, law: {shape: round}}": (
            "2:48 cam.law.shape expected one of linear, square"
        ),
        "cam: {kind: toy, lift: 1, toy: 1, law: {}}": (
            "2:35 cam.law.shape expected one of linear, square"
        ),
        "cam: {lift: 1}": ":2:1 cam.kind expected one of arcs, toy",
        "cam: {kind: 3}": "2:13 cam.kind expected one of arcs, toy",
        "cam: toy": ":2:6 cam expected a map with the keys kind",
    }
    root = Path(__file__).parents[2]
    command = [sys.executable, "-c", TWO_KINDS, str(tmp_path), json.dumps(list(cams))]
    run = subprocess.run(command, capture_output=True, text=True, cwd=root, check=True)
    assert run.stdout.splitlines() == list(cams.values())
