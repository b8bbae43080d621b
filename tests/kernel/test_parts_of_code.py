"""What keeps, finds and calls machine code, part by part, without any that is compiled."""

from __future__ import annotations

import builtins
import errno
import os
import stat
import sys
import time
from collections import namedtuple
from ctypes import CFUNCTYPE, c_int32, c_int64, c_void_p, cast, string_at
from pathlib import Path
from struct import calcsize, unpack
from types import SimpleNamespace as Made

import numpy as np
import pytest

from camcli import errors
from camcli.errors import SceneError
from camcli.kernel import code_cache, compiled, machine_code
from camcli.kernel.cam_table import Cam
from camcli.kernel.code_cache import ABANDONED, CODE, MARK, UNUSED
from camcli.kernel.compiled import CodeSource
from camcli.kernel.forms import PLAIN, as_list, row_of, rows_of
from camcli.kernel.machine_code import MachineCode, flatten, form_of
from camcli.kernel.self_check import ARRAYS, _cam, case_of
from camcli.kernel.variational import Growth, Pair

posix = pytest.mark.skipif(os.name == "nt", reason="there are no such files or owners")


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "camcli" / "kernel-0"
    code_cache.make_folder(place)
    return place


# -- the folder of code


def test_the_name_of_the_folder_changes_with_each_source(monkeypatch, tmp_path):
    """With its content and with its name; the package's exceptions are one of them."""
    sources = tmp_path / "kernel"
    sources.mkdir()
    for name in ("a.py", "b.py"):
        (sources / name).write_text(name)
    (tmp_path / "errors.py").write_text("errors")
    monkeypatch.setattr(code_cache, "__file__", str(sources / "a.py"))
    monkeypatch.setattr(errors, "__file__", str(tmp_path / "errors.py"))
    name_of = code_cache.source_hash.__wrapped__
    found = [name_of()]
    (sources / "notes.txt").write_text("no source")
    assert name_of() == found[0]
    for change in (
        lambda: (sources / "b.py").write_text("other"),
        lambda: (tmp_path / "errors.py").write_text("other"),
        lambda: (sources / "b.py").rename(sources / "c.py"),
        lambda: (sources / "d.py").write_text(""),
    ):
        change()
        found.append(name_of())
    assert len(set(found)) == len(found)
    assert {len(name) for name in found} == {16}


def test_the_folder_is_in_the_cache_of_the_user_or_nowhere(monkeypatch):
    monkeypatch.setattr(code_cache, "source_hash", lambda: "0123")
    monkeypatch.setenv("XDG_CACHE_HOME", "/else/where")
    assert code_cache.cache_dir() == Path("/else/where/camcli/kernel-0123")
    for unset in ("", None):
        if unset is None:
            monkeypatch.delenv("XDG_CACHE_HOME")
        else:
            monkeypatch.setenv("XDG_CACHE_HOME", unset)
        monkeypatch.setattr(os.path, "expanduser", lambda path: path.replace("~", "/home/me"))
        assert code_cache.cache_dir() == Path("/home/me/.cache/camcli/kernel-0123")
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)  # nobody has a home
    assert code_cache.cache_dir() == Path(os.devnull) / "camcli/kernel-0123"


def test_code_is_of_these_libraries_this_python_and_this_processor(monkeypatch):
    """Each of them changes the key; the last part of Python's version does not."""
    import llvmlite.binding as llvm

    key = code_cache.machine_key.__wrapped__
    found = [key()]
    for module, name, value in (
        (code_cache, "version", lambda package: f"{package} 1"),
        (code_cache, "version", lambda package: f"{package} {len(package)}"),
        (sys, "version_info", (3, 99, 0)),
        (sys, "version_info", (99, *sys.version_info[1:])),
        (sys, "implementation", Made(name="other")),
        (llvm, "get_process_triple", lambda: "other"),
        (llvm, "get_host_cpu_name", lambda: "other"),
        (llvm, "get_host_cpu_features", lambda: "other"),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(module, name, value)
            found.append(key())
    assert len(set(found)) == len(found)
    with monkeypatch.context() as patch:
        patch.setattr(sys, "version_info", (*sys.version_info[:2], 99))
        assert key() == found[0]


@posix
def test_what_is_plain(folder, monkeypatch):
    """A file or a folder of this user or the administrator, and what has gone."""
    (folder / "file").touch()
    (folder / "folder").mkdir()
    (folder / "link").symlink_to("file")
    os.mkfifo(folder / "pipe")
    found = {name: code_cache.is_plain(folder / name) for name in
             ("file", "folder", "link", "pipe", "gone")}  # fmt: skip
    assert found == {"file": True, "folder": True, "link": False, "pipe": False, "gone": True}
    me = 1000
    monkeypatch.setattr(os, "geteuid", lambda: me)
    for owner, plain in ((me, True), (0, True), (me + 1, False)):
        status = os.stat_result((stat.S_IFREG | 0o666, 1, 1, 1, owner, 0, 0, 0, 0, 0))
        monkeypatch.setattr(os, "lstat", lambda path, status=status: status)
        assert code_cache.is_plain(folder) == plain


@posix
def test_what_nobody_uses_any_more_goes_when_code_is_kept(folder):
    """Code, marks and folders after a month, anything else after a minute; empty folders too."""
    beside = folder.with_name("kernel-1")
    lonely = folder.with_name("kernel-2")
    for place in (beside, lonely):
        code_cache.make_folder(place)
    ages = {
        folder / f"a{CODE}": (UNUSED - 60.0, True), folder / f"b{CODE}": (UNUSED + 60.0, False),
        folder / f"a{MARK}": (UNUSED - 60.0, True), beside / f"b{MARK}": (UNUSED + 60.0, False),
        beside / "a.0123": (ABANDONED - 30.0, True), beside / "b.0123": (ABANDONED + 30.0, False),
        lonely / f"a{CODE}": (UNUSED + 60.0, False),
    }  # fmt: skip
    folders = {
        folder / "numba-a": (UNUSED - 60.0, True),
        folder / "numba-b": (UNUSED + 60.0, False),
    }
    for path in ages:
        path.touch()
    for path in folders:
        path.mkdir()
        (path / "code").touch()
    ages |= folders
    now = time.time()
    for path, (age, _) in ages.items():
        os.utime(path, (now - age, now - age))
    kept = folder / f"c{CODE}"
    code_cache.keep_code(kept, b"code")
    assert {path: path.exists() for path in ages} == {
        path: stays for path, (_, stays) in ages.items()
    }
    assert not lonely.exists()
    assert beside.exists()
    os.utime(kept, (now - UNUSED, now - UNUSED))
    assert code_cache.read_code(kept) == b"code"
    assert abs(kept.stat().st_mtime - now) < 60.0  # it was used just now


@posix
def test_a_link_is_discarded_and_not_what_it_leads_to(folder):
    (folder / "folder").mkdir()
    (folder / "folder" / "file").touch()
    (folder / "link").symlink_to("folder")
    code_cache.discard(folder / "link")
    assert sorted(path.name for path in folder.iterdir()) == ["folder"]
    assert (folder / "folder" / "file").exists()
    code_cache.discard(folder / "folder")
    code_cache.discard(folder / "gone")
    assert not list(folder.iterdir())


@posix
@pytest.mark.parametrize(("why", "is_dead"), [
    (errno.ELOOP, True), (errno.ENXIO, True), (errno.EMLINK, True), (errno.ENOENT, False),
    (errno.EACCES, False),
])  # fmt: skip
def test_a_mark_that_cannot_be_opened_is_of_the_dead_where_it_is_no_file(
    folder, monkeypatch, why, is_dead
):
    (folder / f"code.0{MARK}").touch()

    def refused(*given):
        raise OSError(why, "no")

    monkeypatch.setattr(os, "open", refused)
    assert bool(code_cache.deaths(folder, "code")) == is_dead


@posix
@pytest.mark.parametrize("age", [0.0, 2.0 * ABANDONED])
def test_where_a_disk_has_no_locks_the_age_of_a_mark_decides_too(folder, monkeypatch, age):
    mark = folder / f"code.0{MARK}"
    mark.touch()
    (folder / f"code2.0{MARK}").touch()
    assert code_cache.deaths(folder, "code") == [mark]  # nobody holds its lock
    os.utime(mark, (time.time() - age, time.time() - age))

    def refused(*given):
        raise OSError(errno.ENOLCK, "no locks")

    monkeypatch.setattr(code_cache.fcntl, "flock", refused)
    assert code_cache.deaths(folder, "code") == ([mark] if age else [])
    folder.chmod(0o777)
    assert code_cache.deaths(folder, "code") == []  # anybody may have written it


# -- where code comes from


@pytest.mark.parametrize(("value", "fits"), [
    (None, True), ("1", True), (" 4 ", True), ("0", False), ("-2", False), ("+0", False),
    ("many", True),  # numba says what it thinks of it
])  # fmt: skip
def test_numba_is_asked_for_one_thread_at_least(monkeypatch, value, fits):
    if value is None:
        monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
    else:
        monkeypatch.setenv("NUMBA_NUM_THREADS", value)
    monkeypatch.setitem(sys.modules, "numba", Made())
    if fits:
        compiled.import_numba()
    else:
        with pytest.raises(SceneError, match="expected a whole number above 0"):
            compiled.import_numba()


@pytest.mark.parametrize(("error", "raised"), [
    (ImportError("no module"), SceneError), (ValueError("no number"), SceneError),
    (MemoryError(), MemoryError), (ImportError("failed to map segment of x"), ImportError),
    (RuntimeError("can't start new thread"), RuntimeError),
])  # fmt: skip
def test_a_numba_that_is_broken_is_told_from_a_shortage(monkeypatch, error, raised):
    real = builtins.__import__

    def fails(name, *given, **more):
        if name == "numba":
            raise error
        return real(name, *given, **more)

    monkeypatch.setattr(builtins, "__import__", fails)
    with pytest.raises(raised) as found:
        compiled.import_numba()
    assert type(found.value) is raised


@pytest.mark.parametrize(("error", "raised"), [
    (MemoryError(), True), (OSError(), True), (AttributeError(), False), (TypeError(), False),
])  # fmt: skip
def test_a_failure_to_compile_is_told_from_a_shortage(monkeypatch, error, raised):
    def fails(entry, args):
        raise error

    monkeypatch.setitem(sys.modules, "camcli.kernel.compiler", Made(machine_code=fails))
    entry = Made(name="fill_flows", args=())
    if raised:
        with pytest.raises(type(error)):
            compiled._made_by_us(entry)
    else:
        assert compiled._made_by_us(entry) is None


def test_the_kinds_of_arguments_are_those_of_their_numbers_and_of_their_columns():
    of = compiled._types
    column, other = np.zeros(3), np.zeros(3, int)
    assert of((1.0, column)) == of((2.5, np.zeros(7)))
    for args in ((1, column), (1.0, other), (1.0, column, column), (1.0,), (1.0, 1.0)):
        assert of(args) != of((1.0, column))


@posix
def test_a_folder_is_made_safe_for_numba(folder):
    place = folder / "numba-0"
    assert compiled._prepare_for_numba(place)
    (place / "sub").mkdir()
    (place / "sub" / "code.nbi").touch()
    os.mkfifo(place / "sub" / "pipe")
    (place / "link").symlink_to("sub")
    assert compiled._prepare_for_numba(place)
    place.chmod(0o770)
    os.utime(place, (0, 0))
    assert compiled._prepare_for_numba(place)
    assert stat.S_IMODE(place.stat().st_mode) == 0o700
    assert time.time() - place.stat().st_mtime < 60.0
    found = sorted(path.name for path in place.rglob("*"))
    assert found == ["code.nbi", "sub"]
    folder.chmod(0o777)
    assert not compiled._prepare_for_numba(place)
    assert not compiled._prepare_for_numba(folder / "numba-1")


def test_numba_has_kept_an_entry_where_its_index_is_a_file(folder):
    (folder / "sub").mkdir()
    entry = Made(name="fill_flows")
    for name in ("x.fill_flows-1.nbc", "x.fill-1.nbi", "x.fill_flows2-1.nbi"):
        (folder / "sub" / name).touch()
    (folder / "x.fill_flows-1.nbi").touch()
    (folder / "sub" / "y.fill_flows-1.nbi").mkdir()
    assert not compiled._is_kept_by_numba(folder, entry)
    (folder / "sub" / "x.fill_flows-1.nbi").touch()
    assert compiled._is_kept_by_numba(folder, entry)


@posix
@pytest.mark.parametrize("make", [
    lambda path: path.symlink_to("nowhere"), lambda path: path.mkdir(mode=0o700),
    lambda path: path.touch(),
])  # fmt: skip
def test_a_folder_that_is_not_ours_is_told(tmp_path, make):
    """Also a link that leads nowhere; nothing is read from there or kept."""
    place = tmp_path / "kernel-0"
    make(place)
    news = []
    source = CodeSource(place, news.append)
    source._kept = lambda entry: len
    args = case_of("fill_flows")
    assert source.code("fill_flows", args) is len
    expected = [] if place.is_dir() else [code_cache.News.NOT_OURS]
    assert news == expected


# -- how code is called


def test_arguments_become_the_numbers_that_numba_takes():
    row = namedtuple("Row", "a b")
    column, ints = np.array([1.0, 2.0, 3.0]), np.array([5], np.int64)
    rows = ARRAYS.table(Pair, [Pair(), Pair()])
    numbers, kinds = [], []
    flatten((1.5, row(2, (3.25,)), column, ints, rows, np.zeros(0)), numbers, kinds)
    addresses = [each.__array_interface__["data"][0] for each in (column, ints, rows)]
    width = 7 * 8  # of a `Pair`
    assert numbers == [
        1.5, 2, 3.25,
        0, 0, 3, 8, addresses[0], 3, 8,
        0, 0, 1, 8, addresses[1], 1, 8,
        0, 0, 2, width, addresses[2], 2, width,
        0, 0, 0, 8, 0, 0, 8,
    ]  # fmt: skip
    assert kinds == [np.float64, np.int64, rows.dtype, np.float64]
    assert form_of(numbers[:4]) == "=dqdq"
    assert calcsize(form_of([1, 1.0, 1])) == 24
    for wrong in (np.zeros((2, 2)), np.zeros(6)[::2], np.zeros(3)):
        wrong.flags.writeable = wrong.ndim != 1 or wrong.size != 3 or not wrong.flags.contiguous
        with pytest.raises(TypeError, match="contiguous"):
            flatten((wrong,), [], [])


def call_of(monkeypatch, cam, *args) -> tuple[MachineCode, list]:
    """A call for arguments like these, and the numbers that each call has passed."""
    numbers, kinds, passed = [], [], []
    flatten((cam, *args), numbers, kinds)

    def function(returned, exception, packed):
        size = calcsize(form_of(numbers))
        passed.append(unpack(form_of(numbers), string_at(packed, size)))
        c_int64.from_address(returned).value = len(passed)
        return 0

    callback = CFUNCTYPE(c_int32, c_void_p, c_void_p, c_void_p)(function)
    address = cast(callback, c_void_p).value
    engine = Made(
        add_object_file=list, finalize_object=lambda: None, callback=callback,
        get_function_address=lambda symbol: address if symbol else 0,
    )  # fmt: skip
    for name, value in (
        ("initialize_native_target", lambda: None), ("parse_assembly", lambda text: None),
        ("Target", Made(from_triple=lambda triple: Made(create_target_machine=lambda: None))),
        ("initialize_native_asmprinter", lambda: None),
        ("create_mcjit_compiler", lambda *given: engine),
        ("ObjectFileRef", Made(from_data=lambda code: code)),
    ):  # fmt: skip
        monkeypatch.setattr(machine_code.llvm, name, value)
    with pytest.raises(ValueError, match="no function"):
        MachineCode("entry", "", b"", numbers, kinds)
    return MachineCode("entry", "symbol", b"", numbers, kinds), passed


def test_each_call_passes_its_own_arguments(monkeypatch):
    """What was flattened is kept for the same cam and column only; other kinds are a fault."""
    cams = [(1.0, np.zeros(2)), (2.0, np.zeros(2))]
    columns = [np.zeros(3), np.zeros(3)]
    call, passed = call_of(monkeypatch, cams[0], columns[0])
    order = [(0, 0), (0, 0), (1, 0), (1, 1), (0, 1), (0, 0), (1, 0)]
    for n, (i, j) in enumerate(order, 1):
        assert call(cams[i], columns[j]) == n
    for (i, j), numbers in zip(order, passed, strict=True):
        expected = []
        flatten((cams[i], columns[j]), expected, [])
        assert list(numbers) == expected
    for wrong in (np.zeros(3, int), np.zeros(3, [("a", float)])):
        with pytest.raises(TypeError, match="other columns"):
            call(cams[0], wrong)
    for more in ((columns[0], 1.0), (columns[0], columns[1])):
        with pytest.raises(TypeError, match="compiled for other"):
            call(cams[1], *more)
    assert len(passed) == len(order)


def test_a_number_is_passed_anew_in_each_call(monkeypatch):
    cam = (1.0,)
    column = np.zeros(1)
    call, passed = call_of(monkeypatch, cam, column, 1.0)
    for number in (1.0, 2.0):
        call(cam, column, number)
    assert [numbers[-1] for numbers in passed] == [1.0, 2.0]
    with pytest.raises(TypeError, match="other arguments"):
        call(cam, column, "1.0")
    with pytest.raises(TypeError, match="other arguments"):
        call(cam, column)


# -- tables in both forms


@pytest.mark.parametrize("kernel", [PLAIN, ARRAYS], ids=["plain", "arrays"])
def test_tables_and_columns_in_both_forms(kernel):
    """Rows are each their own, and kinds are those that are asked for."""
    for kind in (float, int):
        for column in (kernel.numbers([1, 2], kind), kernel.numbers((1, 2), kind),
                       kernel.zeros(2, kind)):  # fmt: skip
            assert len(column) == 2
            dtype = np.float64 if kind is float else np.int64
            assert kernel is PLAIN or column.dtype == dtype
    assert [type(x) for x in PLAIN.numbers((1, 2))] == [float, float]
    assert as_list(kernel.numbers([1.5, 2.5])) == [1.5, 2.5]
    for rows in (kernel.copies(Pair, Pair(qq=3.0), 2), kernel.table(Pair, (Pair(qq=3.0),) * 1),
                 kernel.table(Pair, [Pair(qq=3.0), Pair(qq=3.0)])):  # fmt: skip
        rows[0].qq = 5.0
        assert [row.qq for row in rows] == [5.0, 3.0][: len(rows)]
        taken, all_taken = row_of(Pair, rows[0]), rows_of(Pair, rows)
        rows[0].qq = 7.0
        assert taken == all_taken[0] == Pair(qq=5.0)
    room = kernel.room(Growth, 2)
    room[0].area_twos = 4
    assert [room[1].area_twos, room[0].area_twos] == [0, 4]
    for log in (kernel.log(3), kernel.unwritten_log(3)):
        assert log.capacity == 3
        assert {len(column) for column in log if not isinstance(column, int)} == {3}
        assert kernel is PLAIN or [column.dtype.kind for column in log[:5]] == list("iifff")
        assert len({id(column) for column in log[:5]}) == 5
    strobe = kernel.strobe(4)
    assert strobe.rows == 4
    strobe.q[0] = strobe.impacts[0] = 1
    assert strobe.w[0] == strobe.chatter[0] == 0


def test_a_column_is_the_given_one_where_it_may_be_written():
    given, values = np.zeros(2), [1.0, 2.0]
    assert ARRAYS.numbers(given) is given
    assert PLAIN.numbers(values) is values
    given.flags.writeable = False
    column = ARRAYS.numbers(given)
    column[0] = 1.0
    assert given[0] == 0.0


def test_the_flows_of_a_cam_have_a_row_for_every_two_stretches():
    cam: Cam = ARRAYS.cam(_cam(PLAIN))
    assert isinstance(cam.pieces, np.ndarray)
    asked = []
    kernel = Made(room=lambda kind, count: asked.append(count) or "flows",
                  fill_flows=lambda *given: asked.append(given))  # fmt: skip
    assert type(PLAIN).stretch_flows(kernel, cam, "constants") == "flows"
    assert asked == [len(cam.stretches) ** 2, (cam, "constants", "flows")]
