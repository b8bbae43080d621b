"""The attractor carried between two speeds: its box, its runs, and where they first leave it."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace as Stub

import numpy as np
import pytest

from camcli.analysis.explain import attractor, saddles
from camcli.analysis.explain.attractor import CarriedAttractor
from camcli.analysis.integrate import Cost, Settings, Start, StartError

RUNS = 40  # turns of each run


@dataclass
class Carried:
    """A machine that has a motion of given states at each speed, instead of one that runs."""

    states_at: dict[float, list]
    begun: list = field(default_factory=list)

    def orbit(self, system, rpm, settings, start=None):
        self.begun.append((rpm, settings.transient, settings.record, start))
        q, w = np.array(self.states_at[rpm]).T
        record = Stub(strobe_q=q, strobe_w=w, cost=Cost(1, 0, 0))
        return Stub(run=lambda events=True: record, as_start=lambda: f"start of {rpm}")


@pytest.fixture
def carried(monkeypatch):
    def make(near_states, far_states, transient=20):
        machine = Carried({700.0: near_states, 710.0: far_states})
        monkeypatch.setattr(attractor, "Orbit", machine.orbit)
        settings = Settings(transient, 5, 1e-9, 1000)
        return CarriedAttractor("system", settings, 700.0, 710.0, RUNS), machine

    return make


@pytest.mark.parametrize(("transient", "settle"), [(20, 1000), (1500, 1500)])
def test_an_attractor_settles_at_the_near_speed_and_is_carried_from_there(
    carried, transient, settle
):
    one, machine = carried([[0.0, 1.0]], [[1.0, 2.0]], transient)
    from_there = "start of 700.0"
    assert machine.begun == [
        (700.0, settle, 1, None), (700.0, 0, RUNS, from_there), (710.0, 0, RUNS, from_there),
    ]  # fmt: skip
    assert (one.near, one.stays, one.far, one.leaves) == (700.0, 700.0, 710.0, 710.0)
    assert one.cost == Cost(2, 0, 0)
    assert one.crowding == 1.0
    assert (one.way(690.0), one.way(703.0)) == (10.0, 3.0)


def test_the_box_has_a_margin_of_a_twentieth_of_all_states(carried):
    """The near states reach over 1 by 2; those of both ends over 10 by 4."""
    one, _ = carried([[0.0, 1.0], [1.0, 3.0]], [[-9.0, 2.0], [0.5, -1.0]])
    assert one.size == pytest.approx([10.0, 4.0])
    low, high = one.box
    assert low == pytest.approx([-0.5, 0.8])
    assert high == pytest.approx([1.5, 3.2])


@pytest.mark.parametrize(
    ("states", "outside"),
    [
        ([[0.5, 1.0]], 0),
        ([[0.0, 0.0], [1.0, 2.0]], 0),  # its edges belong to it
        ([[1.5, 1.0]], 1),
        ([[0.5, -0.5]], 1),
        ([[1.5, -0.5], [-0.5, 2.5], [0.5, 1.5]], 2),
    ],
)
def test_a_state_is_outside_where_either_of_its_numbers_is(states, outside):
    one = CarriedAttractor.__new__(CarriedAttractor)
    one.box = np.array([0.0, 0.0]), np.array([1.0, 2.0])
    assert one.outside(np.array(states)) == outside


@pytest.mark.parametrize(("near", "far", "change"), [(700.0, 701.0, 700.37), (701.0, 700.0, 700.2)])
def test_the_speed_of_the_change_is_halved_to_a_65536th(monkeypatch, near, far, change):
    one = CarriedAttractor.__new__(CarriedAttractor)
    one.stays, one.leaves = near, far
    one.run = lambda rpm: rpm
    one.has_left = lambda rpm: (rpm - change) * (far - near) > 0.0
    one.narrow()
    assert abs(one.leaves - one.stays) == pytest.approx(2.0**-16, rel=1e-9)
    assert min(one.stays, one.leaves) <= change <= max(one.stays, one.leaves)
    assert one.has_left(one.leaves)
    assert not one.has_left(one.stays)


@pytest.mark.parametrize(
    ("largest", "second", "crowding"),
    [(0.2, -0.8, 0.25), (0.8, -0.2, 1.0), (0.0, -0.8, 0.5), (-0.1, -0.8, 0.5), (0.2, 0.0, 0.5),
     (0.2, 0.1, 0.5), (np.inf, -0.8, 0.5), (None, None, 0.5)],
)  # fmt: skip
def test_the_dimension_across_the_leaves_is_of_the_exponents(
    monkeypatch, largest, second, crowding
):
    """-lambda_1/lambda_2, one at most; where they tell nothing it stays as it is."""
    one = CarriedAttractor.__new__(CarriedAttractor)
    one.system, one.crowding = "system", 0.5
    found = None if largest is None else Stub(largest=largest, second=second)
    monkeypatch.setattr(attractor, "of_record", lambda *asked: found if asked == (
        "system", 701.0, "record") else None)  # fmt: skip
    one.measure(701.0, "record")
    assert one.crowding == pytest.approx(crowding)


def test_a_motion_from_a_state_has_its_states_at_both_ends(monkeypatch):
    """After 0, 1, ..., n turns: n + 1 of them are recorded, from the strobe, none left out."""
    one = CarriedAttractor.__new__(CarriedAttractor)
    one.system, one.settings, one.cost = Stub(strobe=0.25), Settings(7, 8, 1e-9, 10), Cost()
    machine = Carried({600.0: [[0.0, 1.0], [2.0, 3.0]]})
    monkeypatch.setattr(attractor, "Orbit", machine.orbit)
    assert one.states(600.0, (0.5, 2.0), 3).tolist() == [[0.0, 1.0], [2.0, 3.0]]
    omega = 600.0 * np.pi / 30.0
    assert machine.begun == [(600.0, 0, 4, Start(0.5, pytest.approx(2.0 * omega), 0.25))]


def test_a_motion_that_begins_below_the_cam_has_no_states_outside():
    def below(rpm, x, turns):
        raise StartError("below", 0.0, 0.0)

    one = Stub(states=below, outside=len)
    assert saddles._outside(one, 700.0, (0.0, 0.0), 3) == 0
    one.states = lambda rpm, x, turns: [x] * turns
    assert saddles._outside(one, 700.0, (0.0, 0.0), 3) == 3


@pytest.mark.parametrize("size", [(1.0, 1.0), (1e-6, 1e-7), (1e-6, 1e3), (1e6, 1e5)])
def test_a_saddle_has_two_axes_of_relative_size_one_in_any_unit(monkeypatch, size):
    """It stretches (1, 0) by 3 and shrinks (1, 1) by a half, in sizes of its states."""
    size = np.array(size)
    monkeypatch.setattr(saddles, "Shooter", lambda system, rpm: Stub(
        at_value=lambda *_: Stub(turns=1), verdict=lambda root: (0, 0, 0.0)))  # fmt: skip
    orbit = Stub(root=Stub(x=[], whole=(), turns=1))
    found = Stub(admissible=True, states=[size, 0.5 * size])
    monkeypatch.setattr(saddles, "from_root", lambda *_: found)
    axes = np.array([[1.0, 1.0], [0.0, 1.0]])
    for values, is_saddle in ((np.diag([3.0, 0.5]), True), (None, False)):
        scaled = np.array([[2.0, 1.0], [0.0, 2.0]])  # one direction only
        if values is not None:
            scaled = axes @ values @ np.linalg.inv(axes)
        matrix = scaled * size[:, None] / size
        monkeypatch.setattr(saddles, "monodromy", lambda *_, matrix=matrix: matrix)
        if not is_saddle:
            with pytest.raises(saddles.LostError):
                saddles.Saddle(Stub(system=None), 700.0, orbit)
            continue
        saddle = saddles.Saddle(Stub(system=None), 700.0, orbit)
        assert saddle.mu == pytest.approx(3.0)
        along, across = (saddle.axes / size[:, None]).T
        assert abs(along) == pytest.approx([1.0, 0.0])
        assert abs(across) == pytest.approx([0.5**0.5, 0.5**0.5])
        assert (0.25 * saddle.axes[:, 0] - 0.5 * saddle.axes[:, 1]) @ saddle.to == pytest.approx(
            [0.25, -0.5]
        )
