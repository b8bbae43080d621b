"""From a lift table to a verdict, as somebody who knows engines and no bifurcations would go."""

import pytest

from tests.cams.lift_tables import Lobe, smooth, table


@pytest.fixture
def begun(cam, tmp_path):
    """A folder with a table and the scene that cam init wrote for it."""
    (tmp_path / "lobe.csv").write_text(table(Lobe(smooth), 1, decimals=3))
    assert cam("init", "lobe.csv").returncode == 0
    return tmp_path


def test_init_overwrites_nothing_and_writes_a_scene_to_fill_in(cam, begun):
    before = (begun / "lobe.yaml").read_bytes()
    again = cam("init", "lobe.csv")
    assert (again.returncode, again.stdout) == (2, "")
    assert "lobe.yaml: found a file of this name" in again.stderr
    assert cam("init", "lobe.csv", "--force").returncode == 0
    assert (begun / "lobe.yaml").read_bytes() == before
    assert cam("init").returncode == 0
    assert cam("detach", "-c", "scene.yaml", "--no-plot", "--points", "3").returncode == 0


@pytest.mark.parametrize("command", ["sweep", "detach", "orbits", "classify", "basins"])
def test_a_range_that_is_not_given_comes_from_the_machine(cam, begun, command):
    done = cam(command, "-c", "lobe.yaml", "--dry-run")
    assert done.returncode == 0, done.stderr
    words = done.stderr.partition(f"note: {command}.rpm is not given: ")[2].split()
    assert 2300 < float(words[0]) < 3500  # about the loss of contact, not another machine
    given = cam(command, "-c", "lobe.yaml", "--dry-run", "--rpm", "100:200")
    assert "is not given" not in given.stderr
    assert "is not given" not in cam(command, "--dry-run").stderr
