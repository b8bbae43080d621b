"""The picture of a sweep that is larger than memory: batches, passes, bytes held."""

import tracemalloc
from collections.abc import Sequence

import numpy as np
import pytest

from camcli.analysis.integrate import Cost
from camcli.analysis.sweep import Speed, Sweep
from camcli.cams.arcs import ArcsCam
from camcli.errors import Status
from camcli.plots import density
from camcli.plots.sweep import Survey, draw_sweep
from camcli.system import Follower, System
from tests.conftest import settings
from tests.output import pictures

COLUMNS = [[150.0, 151.0, 149.0], [], [np.nan], [1.0, np.inf, 359.0, 20.0, 30.0], [150.0], [7.0]]


@pytest.fixture(scope="module")
def system():
    cam = ArcsCam(
        kind="arcs",
        base_radius=0.4,
        flank_center=0.45,
        flank_radius=0.85,
        nose_center=0.40393320723821,
        nose_radius=0.15,
        top_dwell_deg=40,
        offset=0.3,
    )
    return System.build(Follower(1.221, 1430.8), cam.parts())


class Lazy(Sequence):
    """Speeds made whenever they are asked for, as from a disk; counts how often."""

    def __init__(self, make, many):
        self.make, self.many, self.made = make, many, 0

    def __len__(self):
        return self.many

    def __getitem__(self, k):
        if not 0 <= k < self.many:
            raise IndexError(k)
        self.made += 1
        return self.make(k)


def speed(rpm, phases, q, status=Status.OK):
    phases = None if phases is None else (range(len(phases)), phases, phases, phases)
    return Speed(rpm, "aperiodic", 0, status, phases, (range(len(q)), q, q, q, q), Cost())


def some(k):
    phases = np.array([140.0, 150.0 + k % 30, 190.0]) if k % 5 else np.array([1.0, 200.0, 359.0])
    return speed(
        700.0 + (7 * k) % 50,
        phases,
        [1.0, 2.0 + k % 3],
        Status.OK if k % 9 else Status.IMPACT_BUDGET,
    )


def png(speeds, system):
    return pictures.png(draw_sweep(Sweep(speeds, "fixed", Cost()), system, settings()))


def test_a_lazy_sweep_is_the_same_picture_and_read_twice(system):
    lazy = Lazy(some, 50)
    assert png(lazy, system) == png([some(k) for k in range(50)], system)
    assert lazy.made == 100


def test_speeds_out_of_order_are_the_ordered_picture(system):
    speeds = [some(k) for k in range(50)]
    assert png(speeds, system) == png(sorted(speeds, key=lambda one: one.rpm), system)


def test_the_points_are_never_all_in_memory(system):
    points = np.linspace(100.0, 300.0, 10_000)
    lazy = Lazy(lambda k: speed(700.0 + k / 10.0, points, points), 2000)
    png(Lazy(some, 5), system)
    tracemalloc.start()
    png(lazy, system)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 120e6  # a column of all points is 160 MB


@pytest.mark.parametrize("size", [1, 2, 3, 1000])
def test_the_size_of_a_batch_changes_nothing(size, monkeypatch):
    monkeypatch.setattr(density, "BATCH", size)
    cloud = density.Cloud.of(COLUMNS)
    assert cloud.count.tolist() == [3, 0, 0, 4, 1, 1]
    assert [end.tolist() for end in cloud.ends()] == [[149, 1, 150, 7], [151, 359, 150, 7]]
    columns = density.Columns.of([4.0, 5.0, 1.0, 2.0, 3.0, 6.0], 4)  # two speeds meet twice
    pixels = density.Pixels(columns, 0.0, 360.0, 12)
    density.take_all(COLUMNS, pixels.take)
    shares = pixels.shares(cloud)
    assert columns.totals(cloud).tolist() == [4, 1, 3, 1]
    assert shares[:, 0].compressed().tolist() == [0.5, 0.25, 0.25, 0.25]
    assert shares[:, 2].compressed().tolist() == pytest.approx([1 / 3, 2 / 3, 2 / 3])


def test_nothing_holds_a_column_beyond_its_turn():
    seen = []
    batch = density.Batches(lambda owner, values: seen.append((owner.tolist(), values.tolist())))
    values = np.array([1.0, 2.0])
    batch.add(3, values)
    values[:] = 0.0  # as a buffer that the next speed is decoded into
    batch.flush()
    assert seen == [([3, 3], [1.0, 2.0])]


def test_a_survey_counts_statuses_and_leaves_out_what_was_not_recorded():
    survey = Survey.of([speed(3.0, None, []), speed(1.0, None, [2.0], Status.IMPACT_BUDGET)])
    assert survey.impacts is None
    assert survey.strobe.count.tolist() == [0, 1]
    assert survey.troubles() == {"impact-budget": 1}
    assert survey.troubled.tolist() == [1.0]
