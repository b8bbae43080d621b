"""What a lift table says of itself as a cam: its parts, its unit, its fits, where its file is."""

from __future__ import annotations

import os
from types import SimpleNamespace as Stub

import numpy as np
import pytest
from flint import arb

from camcli.cams import lift_fit, lift_table
from camcli.cams.balls import precision
from camcli.cams.compile import DIGITS
from camcli.cams.lift_table import TableCam
from camcli.errors import SceneError

COUNT = 40


def test_the_parts_of_a_table_are_dwells_and_chunks_of_eight_pieces():
    """Intervals 3 to 21 and 32 to 37 move; a dwell is one part, however long it is."""
    rng = np.random.default_rng(3)
    coefficients = rng.uniform(0.001, 0.01, COUNT)
    moving = np.array([*range(3, 22), *range(32, 38)])
    errors = Stub(smoother=Stub(moving=moving, count=COUNT), coefficients=coefficients)
    table = Stub(errors=errors, base=0.25)
    table._part_of = lambda intervals, moves: TableCam._part_of(table, intervals, moves)
    with precision(DIGITS):
        parts = TableCam.lobe(table)
        edges = [float(part.start / arb.pi() * 20) for part in parts]
        ends = [float(part.end / arb.pi() * 20) for part in parts]
        levels = [part.level - arb(0.25) for part in parts if not part.pieces]
    assert edges == pytest.approx([0, 3, 11, 19, 22, 32, 38])
    assert ends == pytest.approx([3, 11, 19, 22, 32, 38, 40])
    assert [len(part.pieces) for part in parts] == [0, 8, 8, 3, 0, 6, 0]
    assert [part.lift for part in parts] == [None] * 7
    assert [float(level) for level in levels] == coefficients[[0, 22, 38]].tolist()
    told = [piece for part in parts for piece in part.pieces]
    assert told == [lift_fit.piece(coefficients, int(i), 0.25) for i in moving]


@pytest.mark.parametrize(
    ("keys", "metres"),
    [
        ({"lift": "inch"}, 0.0254 * 1.5 * 1.25),
        ({"lift": "inch", "measured_at": "valve"}, 0.0254 * 1.25),
        ({"lift": "fraction", "max_lift": 0.008}, 0.008 * 1.5 * 1.25),
        ({"lift": "fraction", "max_lift": 0.008, "measured_at": "valve"}, 0.008 * 1.25),
    ],
)
def test_a_lift_of_one_in_a_table_is_so_many_metres_at_the_follower(keys, metres):
    usual = {"rocker_ratio": 1.5, "measured_at": "lobe", "max_lift": None, "lift_scale": 1.25}
    assert TableCam.metres.fget(Stub(**{**usual, **keys})) == pytest.approx(metres, rel=1e-15)


def test_the_least_lift_is_a_last_digit_or_three_deviations():
    for quantum, noise, least in ((1e-6, 3e-7, 1e-6), (1e-6, 5e-7, 1.5e-6)):
        table = Stub(measured=Stub(quantum=quantum), errors=Stub(noise=noise))
        assert TableCam.least_lift.func(table) == pytest.approx(least)


def test_a_rougher_table_and_one_of_other_lifts_have_fits_of_their_own(monkeypatch):
    """Nothing of the fit is remembered that another one decides."""
    monkeypatch.setattr(lift_table, "build", lambda shape: ("built", shape))
    monkeypatch.setattr(lift_fit, "Smoother", lambda rows: ("smoother", rows))
    monkeypatch.setattr(lift_fit, "Errors", lambda smoother, given: ("errors", smoother, given))
    remembered = dict.fromkeys(("errors", "accuracy", "least_lift", "rougher"), "old")

    def table() -> Stub:
        measured = lift_fit.Turn(np.arange(3.0), np.zeros(3), np.arange(3), 1e-6, 1.0, [])
        errors = Stub(rougher="rougher", given="lengths")
        return Stub(errors=errors, measured=measured, model_copy=lambda: Stub(**remembered, a=1))

    other, built = TableCam.rougher.func(table())
    assert other.errors == "rougher"
    assert built == ("built", other)
    lifts = np.array([1.0, 2.0, 4.0])
    other = TableCam.with_lifts(table(), lifts)
    assert set(vars(other)) == {"errors", "a"}
    kind, (_, rows), given = other.errors
    assert (kind, given) == ("errors", "lengths")
    assert rows.lift is lifts
    assert rows.quantum == 1e-6


@pytest.mark.parametrize(
    ("smoothing", "length"), [(None, "balanced at noise"), (0.0, "rms 0.0"), (2e-6, "rms 2e-06")]
)
def test_a_fit_is_as_smooth_as_its_rounding_asks_or_as_is_told(monkeypatch, smoothing, length):
    smoother = Stub(with_rms=lambda rms: f"rms {rms}", balanced=lambda at: f"balanced at {at}")
    monkeypatch.setattr(lift_fit, "Smoother", lambda rows: smoother if rows == "rows" else None)
    monkeypatch.setattr(lift_fit, "Errors", lambda smoother, given: (smoother, given))
    monkeypatch.setattr(lift_fit, "scatter", lambda rows: "noise" if rows == "rows" else None)
    table = Stub(measured="rows", smoothing=smoothing)
    assert lift_table._fitted.__wrapped__(table) == (smoother, length)


def place_of(folder, file, allowed=False, permitted=False) -> str:
    """Where a file outside the folder is, or the key that is refused."""
    table = Stub(_folder=folder, file=file, allow_outside=allowed, _outside="")
    try:
        TableCam._check_place(table, permitted)
    except SceneError as error:
        return f"{error.faults[0].path}: {error.faults[0].found}"
    return table._outside


def test_a_file_outside_the_folder_is_allowed_on_the_command_line_alone(tmp_path):
    """The name of a folder may begin with that of another one; links are followed."""
    home, beside = tmp_path / "home", tmp_path / "home2"
    home.mkdir()
    beside.mkdir()
    (tmp_path / "door").symlink_to(home)
    outside = os.path.realpath(beside / "x.csv")
    refused = "file: found a file outside the scene's folder"
    alone = "allow_outside: found true in the scene itself"
    for folder in (home, tmp_path / "door"):
        assert place_of(folder, "x.csv") == ""
        assert place_of(folder, str(home / "x.csv")) == ""
        assert place_of(folder, "a\0b.csv") == ""
        for file in ("../home2/x.csv", outside):
            assert place_of(folder, file) == refused
            assert place_of(folder, file, permitted=True) == refused
            assert place_of(folder, file, allowed=True) == alone
            assert place_of(folder, file, allowed=True, permitted=True) == outside
        assert place_of(folder, "x.csv", allowed=True) == alone
        assert place_of(folder, "x.csv", allowed=True, permitted=True) == ""
