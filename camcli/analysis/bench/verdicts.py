"""What the points of the precision part say, case by case."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan

from camcli.analysis.bench.precision import OK, Measured

EXACT = 1e-9  # turns: the error at which times are compared


@dataclass(frozen=True)
class Verdict:
    """Of one case: our tightest setting, the fastest peer to reach EXACT, the most exact one."""

    case: str
    ours: Measured
    fastest: Measured | None
    best: Measured | None

    @property
    def ratio(self) -> float | None:
        """Time of the fastest peer that is exact enough, over ours."""
        return None if self.fastest is None else self.fastest.seconds / self.ours.seconds


def verdicts(found: Sequence[Measured]) -> list[Verdict]:
    """One for each case that ours was measured in, in order; nan seconds: it was not."""
    told = []
    for case in dict.fromkeys(m.case for m in found):
        here = [m for m in found if m.case == case]
        ours = [m for m in here if m.ours and not isnan(m.seconds)]
        peers = [m for m in here if not m.ours and m.status == OK]
        if ours:
            exact = [m for m in peers if m.error <= EXACT]
            fastest = min(exact, key=lambda m: m.seconds, default=None)
            best = min(peers, key=lambda m: m.error, default=None)
            told.append(Verdict(case, ours[-1], fastest, best))
    return told
