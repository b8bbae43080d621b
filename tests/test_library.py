"""The library as a script uses it: beside other code, twice, in threads, and like the command."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import camcli
from camcli.cli.run import ARTEFACTS

TURNS = {"run.transient": 30, "run.record": 20}
SMALL = {
    "simulate": {"run.rpm": 190.0},
    "sweep": {"sweep.rpm.num": 5},
    "detach": {"detach.rpm.num": 5},
    "orbits": {"orbits.rpm.start": 700.0, "orbits.rpm.stop": 700.0, "orbits.starts": 2},
    "basins": {"basins.rpm.start": 700.0, "basins.rpm.stop": 700.0, "basins.cells": [12, 12]},
    "classify": {"classify.rpm.num": 3},
}


def scene(command: str):
    return camcli.load_scene(None, {**TURNS, **SMALL[command]})


def files(folder) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir() if p.name != "run.json"}


@pytest.mark.slow
@pytest.mark.parametrize("command", SMALL)
def test_a_result_saves_what_the_command_writes(cam, tmp_path, command):
    result = getattr(camcli, command)(scene(command))
    drawn = command in ("simulate", "detach")
    record = result.save(tmp_path / "library", plot=drawn)
    words = [f"--set='{key}={value}'" for key, value in {**TURNS, **SMALL[command]}.items()]
    cam(command, *words, "-o command -q", "" if drawn else "--no-plot", code=0)
    assert files(tmp_path / "library") == files(tmp_path / "command")
    assert record["result"] == result.summary
    assert set(record["artefacts"]) <= set(ARTEFACTS[command].split())  # looked for before a run
    for name, table in result.tables.items():
        assert f"{name}.csv" in record["artefacts"]
        assert all(len(table[column]) == len(table) for column in table.columns)


def test_columns_are_arrays_of_the_numbers_in_the_file(tmp_path):
    result = camcli.sweep(scene("sweep"))
    result.save(tmp_path, plot=False)
    read = np.genfromtxt(tmp_path / "impacts.csv", delimiter=",", names=True)
    table = result.tables["impacts"]
    assert set(dict(table)) == set(table.columns) == set(table)
    for column in table.columns:
        np.testing.assert_array_equal(table[column], read[column])
    assert result.tables["speeds"]["label"].dtype.kind == "U"
    with pytest.raises(KeyError):
        table["theta"]


def test_progress_is_told_and_a_picture_is_a_figure():
    from matplotlib.figure import Figure

    told = []
    result = camcli.sweep(scene("sweep"), progress=lambda *what: told.append(what))
    assert told == [("speeds", n, 5) for n in range(1, 6)]
    assert isinstance(camcli.plot(result), Figure)
    with pytest.raises(KeyError):
        camcli.plot(result, "orbits")
    assert camcli.plot(result, width=85).get_figwidth() * 25.4 == pytest.approx(85.0)
    with pytest.raises(camcli.SceneError, match=r"plot\.widht"):
        camcli.plot(result, widht=85)


def test_a_picture_is_drawn_into_axes_of_ones_own():
    from matplotlib.figure import Figure

    result = camcli.simulate(scene("simulate"))
    own = Figure(figsize=(5, 2))
    first, second = own.subplots(1, 2)
    assert camcli.plot(result, axes=first, panels=["phase"]) is own
    assert first.get_xlabel() == "relative position $q - c$ (m)"
    camcli.plot(result, axes=[first, second])
    assert second.lines


def test_a_bad_scene_is_one_error_with_every_fault():
    with pytest.raises(camcli.SceneError) as caught:
        camcli.load_scene(None, {"run.rpm": -1.0, "follower.mass": 0.0, "run.rmp": 3})
    assert {"run.rpm", "follower.mass", "run.rmp"} <= {f.path for f in caught.value.faults}


@pytest.mark.slow
def test_two_threads_beside_code_of_ones_own(tmp_path):
    """Sweeps, classifies, plots and saves twice at once; numba and pyplot stay as they were."""
    import sys

    import matplotlib as mpl
    import matplotlib.pyplot as plt
    import numba

    plt.switch_backend("agg")
    before = dict(mpl.rcParams), numba.config.CACHE_DIR, sys.modules["scipy"]
    figure, axes = plt.subplots()
    axes.plot([0, 1])
    twice = numba.njit(lambda x: 2 * x)

    def study(folder, commands=("sweep", "classify")):
        for command in commands:
            result = getattr(camcli, command)(scene(command))
            camcli.plot(result)
            result.save(folder / command)
        assert twice(21) == 42
        return {name: files(folder / name) for name in commands}

    with ThreadPoolExecutor(2) as pool:
        first, second = pool.map(study, (tmp_path / "a", tmp_path / "b"))
    assert first == second
    assert study(tmp_path / "a", ["sweep"])["sweep"] == first["sweep"]  # over those once more
    assert (dict(mpl.rcParams), numba.config.CACHE_DIR, sys.modules["scipy"]) == before
    assert plt.get_fignums() == [figure.number]
    assert axes.lines[0].get_ydata().tolist() == [0, 1]
    plt.close(figure)


def test_the_api_is_what_it_says():
    assert set(camcli.__all__) <= set(dir(camcli))
    assert all(getattr(camcli, name) is not None for name in camcli.__all__)
    with pytest.raises(AttributeError):
        _ = camcli.swep
    for name in ("simulate", "sweep", "detach", "orbits", "basins", "classify", "plot"):
        text = getattr(camcli, name).__doc__
        assert all(f"{part}\n    ---" in text for part in ("Parameters", "Returns"))
