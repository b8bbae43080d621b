"""Random flights against brute force, as `cam bench precision --flights` counts them."""

import numpy as np
import pytest

from camcli.analysis.bench import dense, flights
from camcli.analysis.bench.machine import Bench, reference
from camcli.analysis.bench.peers.lifts import lift_of
from camcli.cli.bench_runs import parts_of
from tests.kernel.helpers import ORACLE_CAM


@pytest.fixture(scope="module")
def bench():
    return Bench(parts_of, lambda words: None)


def test_ours_misses_nothing_and_invents_nothing(bench):
    done = []
    ours, *peers = flights.flights(bench, 60, 3, lambda: done.append(1))
    assert (ours.flights, len(done)) == (60, 60)
    assert ours.missed == ours.invented == 0
    assert ours.compared > 40
    assert [row.compared for row in peers] == [ours.compared] * 2


def test_a_contact_elsewhere_is_missed_or_invented(bench):
    section = reference("stability")["cam"]
    lift, rng = lift_of(section), np.random.default_rng(5)
    while True:
        f = flights.random_flight(rng, bench.cam(section))
        found, flight = flights.ours(lift, f)
        if found is not None and flights.verdict(lift, f, found, flight)[0] == "right":
            break
    outcomes = [flights.verdict(lift, f, x, flight)[0] for x in (None, found + 0.1, found - 0.01)]
    assert outcomes == ["missed", "missed", "invented"]


def test_the_dense_lift_is_the_oracles():
    lift = lift_of(reference("stability")["cam"])
    theta = np.linspace(-7.0, 14.0, 300)
    c, slope = dense.lift_at(lift, theta)
    exact = [ORACLE_CAM.laws(x % (2 * np.pi)) for x in theta]
    assert c == pytest.approx([float(e[0]) for e in exact], abs=1e-14)
    assert slope == pytest.approx([float(e[1]) for e in exact], abs=1e-13)
