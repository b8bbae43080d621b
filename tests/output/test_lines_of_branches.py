"""The lines of branches over the parameter: a point alone, a lost end, rims above a cloud."""

from types import SimpleNamespace as Made

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from camcli.plots.axes import mark_look
from camcli.plots.orbits import _draw_branches


def orbit(value: float, *positions: float, stable: bool = True):
    multiplier = 0.5 if stable else 2.0
    return Made(value=value, positions=positions, stable=stable, multipliers=(multiplier,) * 2)


def branch(*points, ends=("end-of-range", "end-of-range")):
    return Made(points=points, ends=ends)


BRANCHES = [
    branch(orbit(700.0, 1.0), orbit(710.0, 2.0), orbit(720.0, 4.0, stable=False),
           orbit(730.0, 8.0, stable=False), ends=("end-of-range", "lost")),
    branch(orbit(705.0, 3.0, 5.0)),
    branch(orbit(700.0, -1.0), orbit(730.0, -2.0), ends=("lost", "lost")),
]  # fmt: skip
SHADES = ["#112233", "#445566", "#778899"]


def drawn(simulated, branches=BRANCHES, proved=()):
    """The panel with branches over a cloud of points (zorder 1) and an event's line (zorder 3)."""
    axes = Figure().subplots()
    axes.plot([700.0, 730.0], [0.0, 8.0], ".", zorder=1)
    axes.axvline(715.0, zorder=3)
    steps = list(proved) or [[False] * (len(one.points) - 1) for one in branches]
    scene = Made(
        branches=branches, proved=steps, colours=SHADES[: len(branches)], simulated=simulated,
        lines=lambda of: [of(one.points) for one in branches],
    )  # fmt: skip
    _draw_branches(axes, scene, lambda point: point.positions, 0.0)
    return axes


def rims(line) -> list[tuple[float, str]]:
    """Width (points) and colour of what is drawn below a line."""
    effects = [effect._gc for effect in line.get_path_effects()]
    return [(gc["linewidth"], to_hex(gc["foreground"])) for gc in effects]


def test_the_lines_of_a_branch_change_with_its_stability_and_a_point_alone_is_a_dot():
    """Beside another point that is further from the border a step is as stable as that one."""
    axes = drawn(None)
    mine = [line for line in axes.lines[2:] if line.get_marker() == "None"]
    assert [(line.get_xdata().tolist(), line.get_ydata().tolist(), to_hex(line.get_color()))
            for line in mine] == [
        ([700.0, 710.0], [1.0, 2.0], "#112233"),
        ([710.0, 720.0, 730.0], [2.0, 4.0, 8.0], "#112233"),
        ([700.0, 730.0], [-1.0, -2.0], "#778899"),
    ]  # fmt: skip
    assert [line.get_linestyle() for line in mine] == ["-", "--", "-"]
    (dots,) = [line for line in axes.lines if line.get_marker() == "o" and
               to_hex(line.get_color()) == "#445566"]  # fmt: skip
    assert dots.get_linestyle() in ("None", "-")
    assert (list(dots.get_xdata()), list(dots.get_ydata())) == ([705.0, 705.0], [3.0, 5.0])
    assert max(line.get_zorder() for line in mine) < dots.get_zorder()
    assert dots.get_markersize() == 3.0


@pytest.mark.parametrize("simulated", [None, "motions"])
def test_what_lies_above_simulated_motions_has_a_white_rim(simulated):
    """The cloud of points and the bands of what is proved have none, nor any line without it."""
    axes = drawn(simulated, proved=[[True, True, False], [], [True]])
    above = [line for line in axes.lines if line.get_zorder() > 2.5]
    assert len(above) == 1 + 3 + 1 + 3
    for line in axes.lines:
        if line not in above or simulated is None:
            assert rims(line) == []
    of_branches = [line for line in above if to_hex(line.get_color()) in SHADES]
    assert len(of_branches) == 4
    for line in of_branches if simulated else []:
        ((width, colour),) = rims(line)
        assert colour == "#ffffff"
        assert 1.0 <= width - line.get_linewidth() <= 2.0  # half of it on either side
    bands = [artist for artist in (*axes.collections, *axes.lines, *axes.patches)
             if 1.0 < artist.get_zorder() <= 2.5]  # fmt: skip
    places = [(list(band.get_xdata()), list(band.get_ydata())) for band in bands]
    assert places == [
        ([700.0, 710.0], [1.0, 2.0]), ([710.0, 720.0], [2.0, 4.0]), ([700.0, 730.0], [-1.0, -2.0]),
    ]  # fmt: skip
    assert all(not band.get_path_effects() for band in bands)


def test_where_a_branch_is_lost_is_marked_at_each_such_end():
    """All values of the orbit have a mark, of the look of lost ends and not of an event."""
    look = mark_look("lost")
    marks = [line for line in drawn(None).lines if line.get_zorder() == 6]
    assert {line.get_marker() for line in marks} == {look["marker"]}
    assert {line.get_markersize() for line in marks} == {look["ms"]}
    places = [(list(line.get_xdata()), list(line.get_ydata())) for line in marks]
    assert places == [([730.0], [8.0]), ([700.0], [-1.0]), ([730.0], [-2.0])]
    two = branch(orbit(700.0, 1.0, 2.0), orbit(710.0, 1.5, 2.5), ends=("lost", "fold"))
    axes = drawn(None, [two])
    (mark,) = [line for line in axes.lines if line.get_zorder() == 6]
    assert np.transpose(mark.get_data()).tolist() == [[700.0, 1.0], [700.0, 2.0]]
