"""The cost that a result tells is the work of all calls of the kernel, each counted once."""

from dataclasses import replace

import pytest

import camcli
from camcli.analysis.integrate import Cost
from camcli.kernel import backend
from camcli.kernel.forms import PLAIN, Kernel

SMALL = {"run.transient": 30, "run.record": 8}


class Counter:
    """The entries of a kernel that count work, and the sums of what each counted."""

    def __init__(self, kernel: Kernel) -> None:
        self.own = kernel
        self.of_entry: dict[str, Cost] = {}
        self.kernel = replace(
            kernel,
            follow_orbits=self.follow_orbits,
            certify_orbit=self.certify_orbit,
            settle_cells=self.settle_cells,
        )

    @property
    def total(self) -> Cost:
        return sum(self.of_entry.values(), Cost())

    def counted(self, entry, impacts, works, given):
        """What an entry of the kernel returns; impacts() and works are read before and after."""

        def so_far():
            evaluations = sum(work.evaluations for work in works)
            crossings = sum(work.crossings for work in works)
            return impacts(), evaluations, crossings

        before = so_far()
        returned = getattr(self.own, entry)(*given)
        done = Cost(*(late - early for late, early in zip(so_far(), before, strict=True)))
        self.of_entry[entry] = self.of_entry.get(entry, Cost()) + done
        return returned

    def follow_orbits(self, *given):
        _, _, _, states, works, *_ = given
        impacts = lambda: sum(state.total_impacts for state in states)  # noqa: E731
        return self.counted("follow_orbits", impacts, works, given)

    def certify_orbit(self, *given):
        return self.counted("certify_orbit", lambda: 0, given[-1], given)

    def settle_cells(self, *given):
        cells, room = given[4], given[-1]
        return self.counted("settle_cells", lambda: sum(cells.impacts), room.works, given)


CHAOS = {"start": 744.0, "stop": 746.0, "num": 2}
ONE = {"start": 700.0, "stop": 700.0, "num": 1}
RANGE = {"start": 700.0, "stop": 760.0, "num": 3}


@pytest.mark.parametrize(
    ("command", "values"),
    [
        ("simulate", {"run.rpm": 700.0}),
        ("simulate", {"run.rpm": 745.0}),
        ("simulate", {"run.rpm": 180.0}),
        ("sweep", {"sweep.rpm": CHAOS, "sweep.direction": "both"}),
        ("sweep", {"sweep.rpm": RANGE, "sweep.direction": "fixed"}),
        ("detach", {"run.rpm": 260.0, "detach.rpm": {"start": 150.0, "stop": 300.0, "num": 3}}),
        ("classify", {"classify.rpm": CHAOS}),
        ("orbits", {"orbits.rpm": RANGE}),
        ("basins", {"basins.rpm": ONE, "basins.cells": [3, 3], "basins.budget": 40,
                    "basins.boundary": True, "basins.exponents": True}),
    ],
)  # fmt: skip
def test_every_impact_is_counted_once(monkeypatch, command, values):
    """Impacts that are computed are those that are told, on a machine with damping and gravity.

    What the verdict on an orbit evaluates belongs to no motion: where orbits are not what is asked
    for, it is little and may be left out.
    """
    counted = Counter(backend.compiled() if command == "basins" else PLAIN)
    for name in ("current", "compiled", "for_newton", "for_work"):
        monkeypatch.setattr(backend, name, lambda *_: counted.kernel)
    scene = camcli.load_scene(
        "configs/chapter.yaml",
        {
            **SMALL,
            "run.patience": 500,
            "follower.damping": 0.02,
            "follower.gravity": 9.81,
            **values,
        },
    )
    work = {} if command in ("simulate", "orbits") else {"work": camcli.Work(threads=1)}
    cost = getattr(camcli, command)(scene, **work).cost
    assert cost.impacts == counted.total.impacts > 0
    verdicts = counted.of_entry.get("certify_orbit", Cost())
    for told, done, of_verdicts in list(zip(cost, counted.total, verdicts, strict=True))[1:]:
        assert done - of_verdicts <= told <= done
