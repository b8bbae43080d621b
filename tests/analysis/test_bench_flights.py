"""Random flights against brute force, as `cam bench precision --flights` counts them."""

import numpy as np
import pytest

from camcli.analysis.bench import dense, flights
from camcli.analysis.bench.clock import Clock
from camcli.analysis.bench.machine import Bench, reference
from camcli.analysis.bench.peers.lifts import lift_of
from camcli.cli.bench_runs import parts_of
from tests.kernel.helpers import ORACLE_CAM


@pytest.fixture(scope="module")
def bench():
    return Bench(parts_of, lambda words: None)


def untimed(rows):
    """Rows of flights without their times."""
    return [{k: v for k, v in vars(row).items() if k != "seconds"} for row in rows]


def test_ours_misses_nothing_and_invents_nothing(bench):
    done = []
    flown = list(flights.flights(bench, flights.blocks(60), on_block=lambda: done.append(1)))
    ours, *peers = flights.totals(flown)
    assert (ours.asked, ours.flights, len(done)) == (60, 60, 1)
    assert ours.missed == ours.invented == 0
    assert ours.compared > 40
    assert [row.compared for row in peers] == [ours.compared] * 2


def test_blocks_are_whole_but_for_the_last():
    assert flights.blocks(0) == []
    assert flights.blocks(200) == [flights.Block(0, 200)]
    sizes = [(b.number, b.count) for b in flights.blocks(2 * flights.BLOCK + 5)]
    assert sizes == [(0, flights.BLOCK), (1, flights.BLOCK), (2, 5)]
    assert all(b.compiled for b in flights.blocks(flights.COMPILE_FROM))


def test_a_flight_is_the_same_however_many_are_asked_for(bench, monkeypatch):
    def drawn(number, count):
        seen = []
        ours = flights.ours
        with monkeypatch.context() as patch:
            patch.setattr(flights, "ours", lambda lift, f: seen.append(f) or ours(lift, f))
            flights.fly_block(flights.Block(number, count), bench, Clock())
        return [(f.rpm, f.theta_deg, f.gap, f.u) for f in seen]

    assert drawn(3, 9)[:4] == drawn(3, 4)
    assert drawn(3, 4) != drawn(4, 4)


def test_the_peers_fly_the_first_blocks_only(bench):
    first = flights.fly_block(flights.Block(flights.BLOCKS_OF_PEERS - 1, 5), bench, Clock())
    last = flights.fly_block(flights.Block(flights.BLOCKS_OF_PEERS, 5), bench, Clock())
    assert [row.flights for row in first] == [5, 5, 5]
    assert [row.flights for row in last] == [5, 0, 0]
    total = flights.totals([first, last])
    assert [(row.asked, row.flights) for row in total] == [(10, 10), (10, 5), (10, 5)]
    assert untimed(flights.totals([first])) == untimed(first)


def test_a_block_ends_with_the_clock(bench):
    rows = flights.fly_block(flights.Block(0, 5), bench, Clock(0.0))
    assert [(row.asked, row.flights) for row in rows] == [(5, 0)] * 3


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
