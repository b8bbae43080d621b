"""Valid machines at the ends of what a scene allows, through the commands: never an exit code 1.

Done, refused in words, or a status: every number here is one that a user may write.
"""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import cam_in
from tests.support.bounds import fuzz, limited

pytestmark = pytest.mark.slow

CONFIGS = Path(__file__).parents[2] / "configs"
SHORT = (
    "run.transient=8", "run.record=4", "run.impact_budget=300", "run.work_budget=100000",
    "orbits.starts=2", "basins.cells=[3,3]", "basins.budget=20",
)  # fmt: skip
COMMANDS = {
    "orbits": "--rpm {low}:{high} --points 3 --set orbits.at={rpm} --no-plot",
    "orbits --prove": "--rpm {low}:{high} --points 3 --set orbits.at={rpm} --no-plot",
    "explore": "--rpm {low}:{high} --points 2",
    "classify": "--rpm {low}:{high} --points 2 --no-plot",
    "sweep": "--rpm {low}:{high} --points 3",
    "detach": "--rpm {low}:{high} --points 3",
    "detach --tolerance follower.mass=10%": "--points 3 --no-plot --set detach.machines=4",
    "basins": "--rpm {rpm}",
}
SPEEDS = {
    "chapter": 700.0,
    "eccentric": 19.098593171027442,
    "law-smooth": 150.0,
    "law-cycloidal": 150.0,
    "bouncing-ball": 1050.0,
    "lift-table": 3300.0,
    "valve-train": 3300.0,
}


def run(folder, command, name, sets, speed=1.0):
    """The exit code and what was said."""
    rpm = SPEEDS[name] * speed
    options = COMMANDS[command].format(low=0.97 * rpm, high=1.03 * rpm, rpm=rpm)
    words = [f"--set '{text}'" for text in (*sets, *SHORT)]
    scene = CONFIGS / f"{name}.yaml"
    with limited():
        done = cam_in(folder, command, f"-c {scene}", options, *words, "-o out")
    return done.returncode, done.stderr


KNOWN = [
    # after half a natural period any rate of impact repeats, or none does
    ("orbits", "eccentric", ["follower.restitution=1"]),
    ("orbits", "eccentric", ["follower.restitution=1", "cam.lift=1"]),
    ("orbits", "eccentric", ["follower.restitution=1", "cam.lift=1e3"]),
    ("orbits", "eccentric", ["follower.restitution=1", "cam.lift=1e6"]),
    ("explore", "eccentric", ["follower.restitution=1"]),
    ("explore", "chapter", ["follower.damping=1e9"]),  # at most 0 speeds on a page
    # the window of basins.q that the machine gives itself had no width
    ("detach --tolerance follower.mass=10%", "eccentric", ["cam.lift=1e-12"]),
    ("detach --tolerance follower.mass=10%", "eccentric", ["cam.lift=1e-300", "run.rpm=1e-9"]),
    # contact is lost at 6e-291 rpm, where zeta/omega has no square
    ("sweep", "law-cycloidal", ["follower.stiffness=1e-300", "follower.damping=1e-9"]),
]


@pytest.mark.parametrize(("command", "name", "sets"), KNOWN)
def test_a_machine_that_once_ended_in_a_fault(tmp_path, command, name, sets):
    code, said = run(tmp_path, command, name, sets)
    assert code in (0, 3), said


def test_a_page_without_a_motion_is_refused_with_the_reason(cam):
    done = cam("explore --set follower.stiffness=0 --points 3 -o out", code=2)
    assert "no motion at any speed (the follower left the cam and nothing brings it back)" in (
        done.stderr
    )
    assert "give the follower a spring, gravity or a preload" in done.stderr


BASINS = [
    ("chapter", ["follower.restitution=0", "follower.damping=1e9"]),
    ("chapter", ["follower.stiffness=0"]),
    ("eccentric", ["follower.restitution=1"]),
    ("eccentric", ["cam.lift=5", "follower.restitution=0"]),
    ("bouncing-ball", ["follower.damping=1e4"]),
    ("law-smooth", ["follower.preload=1e5", "follower.damping=0"]),
    ("valve-train", ["follower.stiffness=0", "follower.gravity=9.81"]),
]


@pytest.mark.parametrize(("name", "sets"), BASINS)
def test_basins_of_extreme_machines(tmp_path, name, sets):
    """Some only: with a restitution of nearly 1 nine cells take a hundred million impacts."""
    code, said = run(tmp_path, "basins", name, sets)
    assert code in (0, 3), said


EXTREMES = {
    "follower.restitution": ["0", "1", "0.999999999999", "1e-16", "0.999999"],
    "follower.stiffness": ["0", "1e-300", "1e-9", "1e9"],
    "follower.damping": ["0", "1e-9", "{critical}", "{just_above}", "1e4", "1e9"],
    "follower.gravity": ["0", "9.81", "-9.81", "1e6"],
    "follower.preload": ["0", "-100", "1e5"],
}


@st.composite
def machines(draw):
    """(command, scene, sets, speed as a share of the scene's)."""
    name = draw(st.sampled_from(sorted(SPEEDS)))
    keys = draw(st.lists(st.sampled_from(sorted(EXTREMES)), max_size=4, unique=True))
    chosen = {key: draw(st.sampled_from(EXTREMES[key])) for key in keys}
    if "{" in chosen.get("follower.damping", ""):
        chosen |= {"follower.mass": "1.221", "follower.stiffness": "1430.8"}
    critical = 2 * (1.221 * 1430.8) ** 0.5
    exact = {"critical": repr(critical), "just_above": repr(critical * (1 + 4e-16))}
    sets = [f"{key}={text.format(**exact)}" for key, text in chosen.items()]
    speed = draw(st.sampled_from([1.0, 1.0, 0.25, 0.5, 2.0, 1e-4, 1e3]))
    command = draw(st.sampled_from([one for one in COMMANDS if one != "basins"]))
    return command, name, sets, speed


@pytest.mark.soak
@fuzz(25)
@given(machine=machines())
def test_no_valid_machine_ends_in_a_fault(tmp_path_factory, machine):
    code, said = run(tmp_path_factory.mktemp("machine"), *machine)
    assert code in (0, 2, 3), said
    assert "internal fault" not in said
