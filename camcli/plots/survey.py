"""What the picture of a sweep must know of all speeds before it is drawn, and the pixels after.

Each is one pass over the speeds: they may come from a disk, and be more than memory holds.
"""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from camcli.analysis.sweep import Speed, status_name
from camcli.errors import OK
from camcli.plots.batches import Batches
from camcli.plots.density import Cloud, Pixels


@dataclass(frozen=True)
class Survey:
    """Speeds in their own order, what their points come to; None for what was not recorded."""

    rpm: np.ndarray
    status: np.ndarray
    impacts: Cloud | None
    strobe: Cloud | None

    @classmethod
    def of(cls, speeds: Sequence[Speed]) -> Survey:
        """Pass over all speeds once."""
        rpm, status = array("d"), array("q")
        clouds = Cloud.empty(len(speeds)), Cloud.empty(len(speeds))
        batches = [Batches(cloud.take) for cloud in clouds]
        seen = [False, False]
        for owner, speed in enumerate(speeds):
            rpm.append(speed.rpm)
            status.append(speed.status)
            for k, section in enumerate((speed.impacts, speed.strobe)):
                if section is not None:
                    seen[k] = True
                    batches[k].add(owner, section[1])
        for batch in batches:
            batch.flush()
        found = [cloud if some else None for cloud, some in zip(clouds, seen, strict=True)]
        return cls(np.array(rpm), np.array(status, dtype=np.int64), *found)

    @property
    def troubled(self) -> np.ndarray:
        """Speeds (rpm) whose status is not ok, ascending."""
        return np.sort(self.rpm[self.status != OK])

    def troubles(self) -> Counter[str]:
        """How many speeds have each status that is not ok."""
        codes, counts = np.unique(self.status[self.status != OK], return_counts=True)
        return Counter(dict(zip(map(status_name, codes.tolist()), counts.tolist(), strict=True)))


def count(speeds: Sequence[Speed], pictures: Sequence[tuple[Pixels, bool]]) -> None:
    """Pass over all speeds once and count their points; True: a picture of impacts, else strobe."""
    impacts, strobe = ([one for one, kind in pictures if kind == want] for want in (True, False))
    first, second = Batches(partial(_take_all, impacts)), Batches(partial(_take_all, strobe))
    for owner, speed in enumerate(speeds):
        if impacts and speed.impacts is not None:
            first.add(owner, speed.impacts[1])
        if strobe and speed.strobe is not None:
            second.add(owner, speed.strobe[1])
    first.flush()
    second.flush()


def _take_all(pictures: Sequence[Pixels], owner: np.ndarray, values: np.ndarray) -> None:
    for pixels in pictures:
        pixels.take(owner, values)
