"""Corners of a cam by letter, and the smooth regions A1, A2, ... between them."""

from dataclasses import dataclass
from string import ascii_lowercase

from camcli.cams.compile import column, corners
from camcli.kernel.cam_table import TURN, Cam

SAME_PHASE = 1e-12  # rad: phases of a turn are exact to some 1e-15


@dataclass(frozen=True)
class Corner:
    """A jump of c_theta or c_thetatheta, at theta (rad), where `stretch` begins."""

    name: str
    theta: float
    stretch: int


@dataclass(frozen=True)
class Region:
    """The stretches from one corner to the next; phases in rad, start < end <= start + 2 pi.

    A boundary at 0 or at the strobe phase is no corner: the region goes on behind it. `begins` and
    `ends` name the corners, empty where the cam has none.
    """

    name: str
    start: float
    end: float
    begins: str
    ends: str
    stretches: tuple[int, ...]


def corner_list(cam: Cam) -> list[Corner]:
    """Corners in ascending phase: a, b, c, ..., beyond z by number."""
    starts = column(cam, "start")
    return [
        Corner(ascii_lowercase[k] if k < len(ascii_lowercase) else f"corner{k + 1}", starts[n], n)
        for k, n in enumerate(corners(cam))
    ]


def regions(cam: Cam) -> list[Region]:
    """The smooth regions between corners: A1 begins at the first corner, A2 at the second, ...

    The last region goes on through theta = 0 to the first corner. A cam without corners is one
    region.
    """
    corners_of_cam = corner_list(cam)
    count = len(cam.stretches)
    if not corners_of_cam:
        return [Region("A1", 0.0, TURN, "", "", tuple(range(count)))]
    next_corners = [*corners_of_cam[1:], corners_of_cam[0]]
    result = []
    for k, (begin, end) in enumerate(zip(corners_of_cam, next_corners, strict=True), 1):
        through_zero = k == len(corners_of_cam)
        end_theta = end.theta + TURN if through_zero else end.theta
        # one corner alone: its region has all stretches
        stretch_count = (end.stretch - begin.stretch - 1) % count + 1
        stretches = tuple((begin.stretch + j) % count for j in range(stretch_count))
        result.append(Region(f"A{k}", begin.theta, end_theta, begin.name, end.name, stretches))
    return result
