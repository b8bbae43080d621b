"""The library as a script uses it: beside other code, twice, in threads, and like the command."""

import doctest
import io
import pickle
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from io import BytesIO
from math import pi
from multiprocessing import get_context

import numpy as np
import pytest

import camcli
import camcli.cams
from camcli.api.command import command_of

TURNS = {"run.transient": 30, "run.record": 20, "run.patience": 0}
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
    assert set(record["artefacts"]) <= set(command_of(command).artefacts)  # looked for before a run
    for name, table in result.tables.items():
        assert f"{name}.csv" in record["artefacts"]
        assert all(len(table[column]) == table.rows for column in table.columns)


def test_columns_are_arrays_of_the_numbers_in_the_file(tmp_path):
    result = camcli.sweep(scene("sweep"))
    result.save(tmp_path, plot=False)
    read = np.genfromtxt(tmp_path / "impacts.csv", delimiter=",", names=True)
    table = result.tables["impacts"]
    assert set(dict(table)) == set(table.columns) == set(table)
    for column in table.columns:
        np.testing.assert_array_equal(table[column], read[column])
    assert result.tables["speeds"]["label"].dtype.kind == "U"
    with pytest.raises(KeyError, match="'theta'; there are rpm, period, theta_deg"):
        table["theta"]
    with pytest.raises(KeyError, match="no table 'speed'; there are impacts, strobe, speeds"):
        result.tables["speed"]
    with pytest.raises(KeyError, match="no picture 'map'; there are sweep"):
        camcli.plot(result, "map")


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
    with pytest.raises(camcli.SceneError, match=r"2 panels and 1 axes.*name fewer panels"):
        camcli.plot(result, axes=first, panels=["phase", "gap"])
    assert second.lines


def test_a_bad_scene_is_one_error_with_every_fault():
    with pytest.raises(camcli.SceneError) as caught:
        camcli.load_scene(None, {"run.rpm": -1.0, "follower.mass": 0.0, "run.rmp": 3})
    assert {"run.rpm", "follower.mass", "run.rmp"} <= {f.path for f in caught.value.faults}


@pytest.mark.ci
@pytest.mark.slow
def test_two_threads_beside_code_of_ones_own(tmp_path):
    """Sweeps, classifies, plots and saves twice at once; numba and pyplot stay as they were."""
    import sys

    import matplotlib as mpl
    import matplotlib.pyplot as plt
    import numba

    plt.switch_backend("agg")
    before = dict(mpl.rcParams), numba.config.CACHE_DIR, sys.modules["scipy"]
    open_before = plt.get_fignums()
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
    assert plt.get_fignums() == [*open_before, figure.number]
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


CAMS = {kind.__name__: kind for kind in camcli.cams.CAMS}
SLOW = {"orbits": pytest.mark.ci}  # a proof of chaos
PUBLIC = {name: getattr(camcli, name) for name in camcli.__all__ if name != "__version__"} | CAMS


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=SLOW.get(name, ())) for name in (*PUBLIC, "cam_name")]
)
def test_everything_public_has_examples_that_are_true(name):
    """What stands under `Examples` in the docstring is run as it stands there."""
    thing = PUBLIC.get(name, camcli.cams.cam_name)
    assert "Examples\n" in thing.__doc__
    (examples,) = doctest.DocTestFinder(recurse=False).find(thing, name, globs={})
    assert examples.examples
    said = io.StringIO()
    ran = doctest.DocTestRunner().run(examples, out=said.write)
    assert ran.failed == 0, said.getvalue()


VARY = [{"key": "follower.mass", "start": 1.2, "stop": 1.3, "num": 2}]
PICKLED = {
    "simulate": {}, "sweep": {}, "detach": {}, "orbits": {}, "basins": {}, "classify": {},
    "sweep, a map": {"sweep.vary": [{"key": "rpm", "start": 690, "stop": 700, "num": 2}, *VARY]},
    "sweep of another number": {"sweep.vary": VARY},
    "classify, explained": {"classify.explain": True},
    "simulate, animated": {"animate": True},
    "simulate, its cam": {"profile_only": True},
    "detach, with a report": {"report": True},
    "orbits, proved": {"prove": True},
    "explore": {"sweep.rpm.num": 2, "with_basins": True},
}  # fmt: skip


@pytest.mark.parametrize("name", PICKLED)
def test_a_result_comes_back_from_a_pickle_as_it_was(name):
    command = name.partition(",")[0].split()[0]
    small = TURNS | SMALL.get(command, SMALL["basins"] | SMALL["orbits"])
    asked = {key: value for key, value in PICKLED[name].items() if "." in key}
    options = {key: value for key, value in PICKLED[name].items() if "." not in key}
    result = getattr(camcli, command)(camcli.load_scene(None, small | asked), **options)
    same = pickle.loads(pickle.dumps(result))
    assert tables_of(same) == tables_of(result)
    assert (same.summary, same.notes, same.cost) == (result.summary, result.notes, result.cost)
    assert same.pictures.keys() == result.pictures.keys()
    assert same.files.keys() == result.files.keys()
    if command == "explore":
        pages = [one.files["explore.html"] for one in (result, same)]
        written = [BytesIO(), BytesIO()]
        for write, file in zip(pages, written, strict=True):
            write(file)
        assert written[0].getvalue() == written[1].getvalue()


def tables_of(result) -> dict[str, str]:
    return {name: "".join(table.csv()) for name, table in result.tables.items()}


def test_a_page_is_saved_without_pictures_into_a_new_folder(tmp_path):
    camcli.explore(camcli.load_scene(None, TURNS | SMALL["orbits"] | {"sweep.rpm.num": 2})).save(
        tmp_path / "new", plot=False
    )
    assert sorted(files(tmp_path / "new")) == ["explore.html"]


@pytest.mark.ci
def test_a_process_pool_returns_results_and_tables():
    spawn = get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as pool:
        result = pool.submit(camcli.sweep, scene("sweep")).result()
        table = pool.submit(pickle.loads, pickle.dumps(result.tables["speeds"])).result()
    here = camcli.sweep(scene("sweep"))
    for name, own in here.tables.items():
        assert list(result.tables[name].csv()) == list(own.csv())
    assert list(table.csv()) == list(here.tables["speeds"].csv())
    figures = [camcli.plot(one) for one in (result, here)]
    assert len(figures[0].axes) == len(figures[1].axes) > 0


def test_a_notebook_shows_verdict_picture_and_the_beginnings_of_tables():
    result = camcli.simulate(camcli.load_scene(None, {"run.rpm": 700.0, "run.record": 20}))
    page = result._repr_html_()
    assert f"<p>{result.verdict[0]}</p>" in page
    assert page.count("<img") == 1
    for name in result.tables:  # each is folded away
        assert f"<details><summary>{name}</summary><table><caption>{name}: " in page
    table = result.tables["events"]
    assert f"<caption>events: {table.rows} rows</caption>" in page
    shown = table._repr_html_()
    assert [f"<th>{name}</th>" in shown for name in table] == [True] * len(table)
    assert f"<td>{table['theta_deg'][7]:.6g}</td>" in shown
    assert shown.count("<tr>") == 9
    assert len(repr(result)) < 80


def test_a_cam_is_compiled_once_whatever_is_asked_of_it(monkeypatch):
    """For each strobe, and -0.0 is another number than 0.0; each has the table of its own cam."""
    built = []

    def counted(shape, strobe=0.0):
        built.append(shape)
        return real(shape, strobe)

    real = camcli.system.build
    monkeypatch.setattr("camcli.system.build", counted)
    own = TURNS | {"cam": {"kind": "eccentric", "base": 0.1, "lift": 0.0712345}}
    for values in ({}, {"follower.mass": 2.0}, {"run.rpm": 200.0}):
        scene = camcli.load_scene(None, own | values)
        assert camcli.simulate(scene).system.follower.mass == scene.follower.mass
        camcli.simulate(scene, profile_only=True)
    assert len(built) == 1
    table = camcli.simulate(camcli.load_scene(None, own | {"run.strobe_deg": 90})).system.cam
    assert len(built) == 2
    assert table == real(built[1], pi / 2.0)
    for base, text in ((0.0, "0x0.0p+0"), (-0.0, "-0x0.0p+0")):
        result = camcli.simulate(camcli.load_scene(None, own | {"cam.base": base}))
        assert result.system.shape.base.hex() == text
