"""What a certificate needs of a proof: its equations, its boxes, its events."""

from __future__ import annotations

from dataclasses import dataclass

from camcli.analysis.orbits.locate import Located
from camcli.exact.shooting import Box, Shooting


@dataclass(frozen=True)
class Evidence:
    """The boxes in which an orbit, an event or a branch was proved, in so many bits.

    joints: of a branch, boxes of single orbits: one before the first box, one that each box shares
    with the next, one behind the last. ends: the event that was proved, or those at both ends of a
    branch, None where an end is none. axes: of a stable orbit, the ellipse [[a, b], [c, d]] about
    each of its impacts in which it certainly attracts.
    """

    bits: int
    shooting: Shooting
    boxes: tuple[Box, ...]
    joints: tuple[Box, ...] = ()
    ends: tuple[Located | None, ...] = ()
    axes: tuple[tuple[float, float, float, float], ...] = ()
