"""Measured pieces are kept as they were, those the clock left out are not."""

from math import isnan, nan

from camcli.analysis.bench.clock import NOT_REACHED, Clock
from camcli.analysis.bench.flights import CODEC as FLIGHTS
from camcli.analysis.bench.flights import Flights
from camcli.analysis.bench.kept import one_by_one
from camcli.analysis.bench.machine import Bench
from camcli.analysis.bench.row import Outcome
from camcli.analysis.bench.scenes import CODEC as SCENES
from camcli.analysis.bench.scenes import Scene
from camcli.analysis.bench.stability import CODEC, stability
from camcli.cli.bench_runs import parts_of
from camcli.parallel import Work
from camcli.parallel.codec import pack, unpack
from camcli.parallel.journal import Journal


def run(path, pieces, found):
    """(results, pieces measured) of a run that keeps them."""
    measured, ticks = [], []

    def measure(piece):
        measured.append(piece)
        return Outcome(f"case {piece}", "this", found[piece], found[piece], 0.1 * piece)

    journal = Journal(path, "bench")
    work = Work(threads=1, journal=journal)
    results = list(one_by_one(measure, pieces, CODEC, work, lambda: ticks.append(1)))
    journal.close()
    assert len(ticks) == len(pieces)
    return results, measured


def test_only_what_was_not_reached_is_measured_again(tmp_path):
    first, _ = run(tmp_path / "j", [1, 2, 3], {1: "ok", 2: NOT_REACHED, 3: "failed"})
    again, measured = run(tmp_path / "j", [1, 2, 3], {2: "ok"})
    assert measured == [2]
    assert [again[0], again[2]] == [first[0], first[2]]
    assert again[1].status == "ok"


def test_every_kind_of_result_comes_back():
    scene = Scene("a", ("--x", "1"), "ok", 0, 0.25, None, 7, ("numpy",))
    assert SCENES.load(unpack(pack(SCENES.store(scene)))) == scene
    rows = [Flights("core", 1000, 1000, 870, 0, 0, 1.5), Flights("peer", 1000)]
    assert FLIGHTS.load(unpack(pack(FLIGHTS.store(rows)))) == rows
    assert FLIGHTS.store([Flights("core", 1000, 999)]) is None
    odd = Outcome("c", "e", "", "ok", nan)
    assert isnan(CODEC.load(unpack(pack(CODEC.store(odd)))).seconds)


def test_rows_of_a_run_that_was_stopped_are_not_run_again(tmp_path):
    bench = Bench(parts_of, lambda words: None)
    journal = Journal(tmp_path / "j", "bench")
    done = list(stability(bench, [8, 9], keeping=Work(threads=1, journal=journal)))
    again = stability(bench, [8, 9], Clock(0.0), keeping=Work(threads=1, journal=journal))
    assert list(again) == done
    journal.close()
