"""Signals, helper processes and the connection to a cluster, function by function."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
from collections import deque
from io import BytesIO
from types import SimpleNamespace as Made

import pytest

from camcli import interrupts
from camcli.errors import SceneError
from camcli.interrupts import CutOffError, cut_off_when, raise_if_interrupted, signals_held
from camcli.parallel import dask_cluster, helpers
from camcli.parallel.dask_cluster import DaskCluster
from camcli.parallel.helpers import READY, Helper, HelperFailedError, Helpers, Turns

# --- signals


@pytest.fixture(autouse=True)
def quiet_signals(monkeypatch):
    """No signal has come yet; what a test makes of it is forgotten."""
    for name, value in (("_came", False), ("_ending", False), ("_holding", []), ("_compiling", []),
                        ("_leftovers", set())):  # fmt: skip
        monkeypatch.setattr(interrupts, name, value)


def outcome(call, *given) -> str:
    """What a call raises; an interrupt would end the tests."""
    try:
        call(*given)
    except KeyboardInterrupt:
        return "interrupt"
    except CutOffError:
        return "cut off"
    return ""


@pytest.mark.parametrize(
    ("compiling", "holding", "ending", "ends", "raised"),
    [
        (False, False, False, False, True), (True, False, False, True, True),
        (True, True, False, False, False), (False, True, False, False, False),
        (False, False, True, False, False), (True, False, True, True, False),
    ],
)  # fmt: skip
def test_a_signal_is_noted_and_raised_unless_it_must_wait(
    monkeypatch, compiling, holding, ending, ends, raised
):
    """In the compiler nothing may be raised: the process is ended there."""
    ended = []
    monkeypatch.setattr(interrupts, "_end", lambda: ended.append(1))
    monkeypatch.setattr(interrupts, "_compiling", [None] * compiling)
    monkeypatch.setattr(interrupts, "_holding", [None] * holding)
    monkeypatch.setattr(interrupts, "_ending", ending)
    assert outcome(interrupts._handle, signal.SIGINT, None) == "interrupt" * raised
    assert (interrupts.signal_came(), len(ended)) == (True, ends)


def test_a_time_that_is_over_cuts_off_the_block_that_it_is_of(monkeypatch):
    """Also where signals are held, and after the interrupt has arrived; an interrupt is first."""
    over = {"outer": False, "inner": False}
    with cut_off_when(lambda: over["outer"]):
        with cut_off_when(lambda: over["inner"]):
            over["outer"] = True
            assert outcome(raise_if_interrupted) == ""
            over["inner"] = True
            assert outcome(raise_if_interrupted) == "cut off"
            monkeypatch.setattr(interrupts, "_came", True)
            assert outcome(raise_if_interrupted) == "interrupt"
            monkeypatch.setattr(interrupts, "_holding", [None])
            assert outcome(raise_if_interrupted) == "cut off"
        monkeypatch.setattr(interrupts, "_holding", [])
        interrupts.interrupt_arrived()
        assert outcome(raise_if_interrupted) == "cut off"
    assert outcome(raise_if_interrupted) == ""
    assert not issubclass(CutOffError, Exception)


def test_signals_wait_until_the_outermost_block_is_left(monkeypatch):
    done = []

    def held() -> None:
        with signals_held():
            monkeypatch.setattr(interrupts, "_came", True)
            with signals_held():
                raise_if_interrupted()
            done.append(len(interrupts._holding))

    def in_the_compiler() -> None:
        with interrupts.compiling(), interrupts.compiling():
            done.append(len(interrupts._compiling))
            raise ZeroDivisionError

    assert outcome(held) == "interrupt"
    with pytest.raises(ZeroDivisionError), signals_held():
        raise ZeroDivisionError
    with pytest.raises(ZeroDivisionError):
        in_the_compiler()
    assert done == [1, 2]
    assert interrupts._holding == interrupts._compiling == []


def test_the_signals_of_a_process_are_taken_over(monkeypatch):
    """One that is ignored stays so; what an earlier command left is forgotten."""
    taken, watched, pipes = [], [], []
    handlers = {signal.SIGINT: signal.SIG_IGN, signal.SIGTERM: signal.SIG_DFL}
    monkeypatch.setattr(signal, "getsignal", handlers.get)
    monkeypatch.setattr(signal, "signal", lambda *given: taken.append(given))
    monkeypatch.setattr(
        signal, "set_wakeup_fd", lambda writer, warn_on_full_buffer: pipes.append(writer)
    )
    monkeypatch.setattr(
        interrupts, "Thread", lambda **given: watched.append(given) or Made(start=lambda: None)
    )
    monkeypatch.setattr(sys, "unraisablehook", None)
    monkeypatch.setattr(interrupts, "_came", True)
    monkeypatch.setattr(interrupts, "_ending", True)
    interrupts.install()
    assert taken == [(signal.SIGTERM, interrupts._handle)]
    assert (interrupts._came, interrupts._ending) == (False, False)
    assert sys.unraisablehook is interrupts._unraisable
    (thread,), (writer,) = watched, pipes
    (reader,) = thread["args"]
    assert (thread["target"], thread["daemon"]) == (interrupts._watch, True)
    assert not os.get_blocking(writer)
    os.write(writer, b"x")
    assert os.read(reader, 1) == b"x"
    os.close(reader)
    os.close(writer)


def test_what_cannot_be_raised_is_printed_unless_it_is_an_interrupt(monkeypatch):
    printed = []
    monkeypatch.setattr(sys, "__unraisablehook__", printed.append)
    error, interrupt = Made(exc_type=KeyError), Made(exc_type=KeyboardInterrupt)
    interrupts._unraisable(error)
    interrupts._unraisable(interrupt)
    assert printed == [error]


def test_what_is_unfinished_goes_when_the_process_is_ended(tmp_path, monkeypatch):
    """Files, and folders with what is in them; not what is finished, or was left in time."""

    def leave(code):
        raise SystemExit(code)

    monkeypatch.setattr(os, "_exit", leave)
    for name in ("a", "b", "c", "d"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "1").write_text("x")
        (tmp_path / name / "2").write_text("x")
    (tmp_path / "file").write_text("x")
    interrupts.unfinished(tmp_path / "a")
    interrupts.unfinished(str(tmp_path / "b"))
    interrupts.finished(tmp_path / "b")
    interrupts.finished(tmp_path / "none")
    with interrupts.removed_if_ended(tmp_path / "c"):
        assert interrupts._leftovers == {str(tmp_path / "a"), str(tmp_path / "c")}
    with pytest.raises(ZeroDivisionError), interrupts.removed_if_ended(tmp_path / "d"):
        raise ZeroDivisionError
    interrupts.unfinished(tmp_path / "file")
    monkeypatch.setattr(sys, "stderr", None)
    with pytest.raises(SystemExit) as ended:
        interrupts._end()
    assert ended.value.code == 130
    assert sorted(path.name for path in tmp_path.iterdir()) == ["b", "c", "d"]


# --- helper processes


def helper_with(said: bytes = b"", **process) -> Helper:
    """A helper whose process has said this."""
    made = Helper.__new__(Helper)
    made.process = Made(**{"stdin": BytesIO(), "stdout": BytesIO(said), **process})
    return made


def test_a_helper_is_ready_when_it_says_so():
    """Whatever Python printed may stand before it, in the same line too."""
    ready = helper_with(b"warning\nmore " + READY + b"rest")
    ready.wait_until_ready()
    assert ready.process.stdout.read() == b"rest"
    for lost in (helper_with(b"warning\n" + READY[:-1]), helper_with()):
        with pytest.raises(HelperFailedError):
            lost.wait_until_ready()
    gone = helper_with()
    gone.process.stdout.close()
    with pytest.raises(HelperFailedError):
        gone.wait_until_ready()


def test_what_a_helper_is_asked_and_answers():
    answers = pickle.dumps((True, [7])) + pickle.dumps((False, 8)) + pickle.dumps((True, None))
    asked = helper_with(answers)
    assert asked.call(divmod, 7, 2) == [7]
    assert pickle.loads(asked.process.stdin.getvalue()) == (divmod, (7, 2))
    with pytest.raises(HelperFailedError):
        asked.answer()
    assert asked.answer() is None
    with pytest.raises(HelperFailedError):
        asked.answer()  # it has ended
    with pytest.raises(HelperFailedError):
        asked.ask(lambda: 0)  # which cannot be pickled


@pytest.mark.parametrize("in_time", [True, False])
def test_a_helper_is_ended_whatever_it_does(in_time):
    done: list = []

    def wait(*seconds):
        done.append(("wait", *seconds))
        if seconds and not in_time:
            raise subprocess.TimeoutExpired("x", 1.0)

    def fails():
        done.append("close")
        raise BrokenPipeError

    pipes = {"stdin": Made(close=fails), "stdout": BytesIO()}
    ended = helper_with(terminate=lambda: done.append("terminate"), wait=wait,
                        kill=lambda: done.append("kill"), **pipes)  # fmt: skip
    ended.end()
    killed = [] if in_time else ["kill", ("wait",)]
    assert done == ["terminate", ("wait", 1.0), *killed, "close"]
    assert pipes["stdout"].closed
    done.clear()
    ended.let_go()
    assert done == ["close"]


class Worker:
    """A helper that squares, and fails after so many calls."""

    def __init__(self, most: int = 99, ready: bool = True) -> None:
        self.most, self.ready, self.done = most, ready, []

    def wait_until_ready(self):
        self.done.append("ready")
        if not self.ready:
            raise HelperFailedError

    def call(self, function, *args):
        self.most -= 1
        if self.most < 0:
            raise HelperFailedError
        return ("there", function(*args))

    def end(self):
        self.done.append("end")


def test_helpers_do_what_they_can_and_who_asks_does_the_rest(monkeypatch):
    """A helper is waited for once; one that fails does nothing any more."""
    one, two = Worker(2), Worker(ready=False)
    started = iter([one, OSError(), two])

    def start():
        found = next(started)
        if isinstance(found, OSError):
            raise found
        return found

    monkeypatch.setattr(helpers, "Helper", start)
    made = Helpers(3)
    found = [made.call(abs, -k) for k in range(9)]  # in turns
    assert found[:4] == [("there", 0), 1, 2, ("there", 3)]
    assert found[4:] == [4, 5, 6, 7, 8]
    assert (one.done, two.done) == (["ready", "end"], ["ready", "end"])
    made.end()
    assert (one.done[2:], two.done[2:]) == (["end"], ["end"])
    with pytest.raises(HelperFailedError):
        made.call(abs, -1)
    assert made._free.qsize() == 3
    both = [Worker(), Worker()]
    started = iter(both)
    made = Helpers(2)
    assert [made.call(abs, -k) for k in range(4)] == [("there", k) for k in range(4)]
    assert [one.done for one in both] == [["ready"], ["ready"]]


def turns_of(*workers, most=2) -> Turns:
    made = Turns(most, 1.0)
    made.helpers = [*workers]
    made._free = [*workers]
    return made


def test_threads_have_their_turn_at_a_helper(monkeypatch):
    """One that fails is lost, and the next one, or at last this process, does its call."""
    gone = []
    monkeypatch.setattr(helpers.atexit, "unregister", gone.append)
    one, two = Worker(1), Worker(0)
    made = turns_of(one, two)
    assert made.call(abs, -3) == ("there", 3)
    assert (made.helpers, made._free, two.done, one.done) == ([one], [one], ["end"], [])
    assert made.call(abs, -4) == 4
    assert (made.helpers, made._free, one.done) == ([], [], ["end"])
    assert [call.__self__ for call in gone] == [two, one]

    class Interrupted(Worker):
        def call(self, function, *args):
            raise KeyboardInterrupt

    cut = Interrupted()
    made = turns_of(cut)
    with pytest.raises(KeyboardInterrupt):
        made.call(abs, -3)
    assert (made.helpers, cut.done) == ([], ["end"])
    with pytest.raises(ZeroDivisionError):
        made.call(divmod, 1, 0)
    assert not made._busy_here


@pytest.mark.parametrize(
    ("most", "spent", "others", "started"),
    [(3, 1.001, True, 3), (3, 1.0, True, 0), (3, 9.0, False, 0), (1, 9.0, True, 0)],
)
def test_helpers_are_started_once_there_is_enough_for_several_threads(
    monkeypatch, most, spent, others, started
):
    begun = []

    def thread(**given):
        return Made(start=lambda: begun.append(given))

    monkeypatch.setattr(helpers, "Thread", thread)
    made = Turns(most, 1.0)
    made._busy_here = True
    made._threads = {-7} if others else set()
    made._done_here(0.4)
    assert (begun, made._busy_here) == ([], False)
    made._done_here(spent - 0.4)
    assert len(begun) == started
    assert all(given == {"target": made._start, "daemon": True} for given in begun)
    made._done_here(9.0)
    assert len(begun) == (started if most == 1 or started or not others else most)


def test_a_helper_works_as_soon_as_it_is_ready(monkeypatch):
    registered = []
    monkeypatch.setattr(helpers.atexit, "register", registered.append)
    good, bad = Worker(), Worker(ready=False)
    found = iter([OSError(), TypeError(), bad, good])

    def start():
        one = next(found)
        if isinstance(one, Exception):
            raise one
        return one

    monkeypatch.setattr(helpers, "Helper", start)
    made = Turns(2, 1.0)
    for _ in range(4):
        made._start()
    assert (made.helpers, made._free, bad.done) == ([good], [good], ["ready", "end"])
    assert [call.__self__ for call in registered] == [good]
    assert made._take() is good
    assert (made._free, made._busy_here) == ([], False)
    alone = Turns(2, 1.0)
    assert (alone._take(), alone._busy_here) == (None, True)


class Told:
    """A condition that counts how often those who wait are told, and asks what they wait for."""

    def __init__(self) -> None:
        self.times, self.answers = 0, []

    def __enter__(self):
        return self

    def __exit__(self, *failure):
        pass

    def notify_all(self):
        self.times += 1

    def wait_for(self, has_turn):
        self.answers.append(has_turn())


def test_threads_that_wait_are_told_of_each_change(monkeypatch):
    """Of a helper that is free again, that is lost or new, and of work that is done here."""
    clock = iter([10.0, 12.5, 20.0, 20.25])
    monkeypatch.setattr(helpers, "perf_counter", lambda: next(clock))
    monkeypatch.setattr(helpers.atexit, "register", lambda call: None)
    monkeypatch.setattr(helpers, "Helper", Worker)
    made = turns_of(Worker(1))
    made.enough = 99.0
    made._change = Told()
    times = []
    for act in (lambda: made.call(abs, 1), lambda: made._lose(made._free.pop()),
                lambda: made.call(abs, 1), lambda: made.call(abs, 1), made._start):  # fmt: skip
        act()
        times.append(made._change.times)
    assert times == [1, 2, 3, 4, 5]
    assert made._spent_here == 2.75


@pytest.mark.parametrize(
    ("free", "started", "busy", "has_turn"),
    [(1, 1, False, True), (1, 2, True, True), (0, 1, False, False), (0, 1, True, False),
     (0, 0, False, True), (0, 0, True, False)],
)  # fmt: skip
def test_a_thread_has_a_turn_at_a_free_helper_or_here_where_there_is_none(
    free, started, busy, has_turn
):
    made = turns_of(*(Worker() for _ in range(started)))
    made._free, made._busy_here, made._change = made.helpers[:free], busy, Told()
    made._take()
    assert made._change.answers == [has_turn]


def test_a_helper_serves_until_nobody_asks_any_more(monkeypatch):
    """An interrupt of the keyboard is not for it; what a function prints is no answer."""
    handlers, done = {}, []
    said = BytesIO()
    calls = ((abs, (-3,)), (divmod, (1, 0)), (divmod, (7, 2)))
    asked = BytesIO(b"".join(pickle.dumps(call) for call in calls))
    with monkeypatch.context() as patch:  # pytest itself needs handles and signals
        patch.setattr(signal, "signal", handlers.__setitem__)
        patch.setattr(helpers, "Thread", lambda **given: Made(start=lambda: done.append(given)))
        patch.setattr(os, "getppid", lambda: 77)
        patch.setattr(os, "dup", lambda handle: 90 + handle)
        patch.setattr(os, "dup2", lambda *given: done.append(given))
        patch.setattr(os, "fdopen", lambda *given: done.append(given) or said)
        patch.setattr(sys, "stdin", Made(buffer=asked))
        helpers.serve()
    watch = {"target": helpers._end_with, "args": (77,), "daemon": True}
    assert done == [watch, (91, "wb"), (2, 1)]
    assert handlers[signal.SIGINT] is signal.SIG_IGN
    with pytest.raises(SystemExit):
        handlers[signal.SIGTERM](signal.SIGTERM, None)
    said.seek(0)
    assert said.readline() == READY
    answers = [pickle.load(said) for _ in calls]
    assert answers == [(True, 3), (False, None), (True, (3, 1))]
    assert said.read() == b""


def test_an_answer_says_whether_the_call_returned():
    said = BytesIO()
    helpers._answer(said, True, [7])
    helpers._answer(said, False, None)
    said.seek(0)
    assert [pickle.load(said) for _ in range(2)] == [(True, [7]), (False, None)]


def test_a_helper_ends_soon_after_who_asks_has_ended(monkeypatch):
    """With its usual end first, and a second for it."""
    parents = iter([7, 7, 1])
    done: list = []
    monkeypatch.setattr(os, "getppid", lambda: next(parents))
    monkeypatch.setattr(helpers, "sleep", lambda seconds: done.append(seconds))
    monkeypatch.setattr(os, "kill", lambda *given: done.append(given))
    monkeypatch.setattr(os, "_exit", lambda code: done.append(f"exit {code}"))
    helpers._end_with(7)
    assert done == [0.5, 0.5, (os.getpid(), signal.SIGTERM), 1.0, "exit 1"]


# --- a cluster


@pytest.fixture
def distributed(monkeypatch):
    """A package `distributed` whose scheduler is at `there`; what was asked of it."""
    asked: list = []

    class Closing(Made):
        def close(self, timeout):
            asked.append((self.name, timeout))

    def client(address, timeout):
        asked.append(("client", address, timeout))
        if address == "lost":
            raise TimeoutError
        return Closing(name="client")

    made = Made(Client=client, asked=asked, local=Closing(name="local", workers={}))
    monkeypatch.setitem(sys.modules, "distributed", made)
    monkeypatch.setattr(dask_cluster, "_silence", lambda: asked.append("silent"))
    monkeypatch.setattr(dask_cluster, "monotonic", lambda: 7.0)
    monkeypatch.setattr(dask_cluster, "thread_count", lambda threads: 10 * threads)
    monkeypatch.setattr(
        dask_cluster, "_local", lambda package, count: asked.append(count) or made.local
    )
    return made


def test_a_cluster_is_that_of_an_address_or_of_this_machine(distributed):
    cluster = DaskCluster("there", 3)
    assert distributed.asked == ["silent", ("client", "there", 8.0)]
    assert (cluster.local, cluster.program, cluster.lonely) == (None, None, 7.0)

    def program():
        return "hash"

    distributed.asked.clear()
    cluster = DaskCluster("local", 3, program)
    assert distributed.asked == ["silent", 30, ("client", distributed.local, 8.0)]
    assert (cluster.local, cluster.program) == (distributed.local, (program, "hash"))
    assert cluster.__enter__() is cluster
    with pytest.raises(SceneError) as refused:
        DaskCluster("lost")
    assert str(refused.value) == (
        "--cluster: found no scheduler at 'lost' (TimeoutError), expected HOST:PORT, or local, see "
        "dask scheduler"
    )


def test_what_was_started_for_a_cluster_that_is_lost_is_ended(distributed, monkeypatch):
    for kind in (OSError, ValueError, TypeError, TimeoutError):

        def refuse(address, timeout, kind=kind):
            raise kind

        distributed.Client = refuse
        found = rf"found no scheduler at 'local' \({kind.__name__}\)"
        with pytest.raises(SceneError, match=found):
            DaskCluster("local", 2)
        assert distributed.asked.pop() == ("local", 8.0)
    for error in (OSError("x"), RuntimeError("y"), TimeoutError("z")):

        def fails(package, count, error=error):
            raise error

        monkeypatch.setattr(dask_cluster, "_local", fails)
        with pytest.raises(SceneError) as refused:
            DaskCluster("local", 2)
        assert str(refused.value) == (
            f"--cluster: the processes of this machine did not start ({error}), ask for fewer "
            "--threads, or leave --cluster out"
        )


@pytest.mark.parametrize("failed", [False, True])
def test_after_a_failure_the_workers_of_this_machine_are_killed_at_once(
    distributed, monkeypatch, failed
):
    killed = []

    def kill(number, what):
        killed.append((number, what))
        if number == 1:
            raise ProcessLookupError
        if number is None:
            raise TypeError

    monkeypatch.setattr(os, "kill", kill)
    workers = [Made(pid=number, auto_restart=True) for number in (1, None, 3)]
    distributed.local.workers = dict(enumerate(workers))
    cluster = DaskCluster("local", 1)
    distributed.asked.clear()
    cluster.__exit__(*(KeyError, KeyError(), None) if failed else (None, None, None))
    assert killed == [(number, signal.SIGKILL) for number in (1, None, 3)] * failed
    assert {one.auto_restart for one in workers} == {not failed}
    assert distributed.asked == [("client", 8.0), ("local", 8.0)]
    elsewhere = DaskCluster("there", 1)
    distributed.asked.clear()
    elsewhere.__exit__(KeyError, KeyError(), None)
    assert distributed.asked == [("client", 8.0)]


@pytest.mark.parametrize("before", [None, "error"])
def test_processes_of_this_machine_are_started_without_warnings(monkeypatch, before):
    """Warnings are as before afterwards, also where the start fails."""
    if before is None:
        monkeypatch.delenv("PYTHONWARNINGS", raising=False)
    else:
        monkeypatch.setenv("PYTHONWARNINGS", before)
    asked = []

    def local(**given):
        asked.append((given, os.environ["PYTHONWARNINGS"]))
        if len(asked) == 2:
            raise RuntimeError
        return "cluster"

    package = Made(LocalCluster=local)
    assert dask_cluster._local(package, 3) == "cluster"
    with pytest.raises(RuntimeError):
        dask_cluster._local(package, 3)
    assert os.environ.get("PYTHONWARNINGS") == before
    given, warnings = asked[0]
    assert warnings == "ignore:resource_tracker"
    assert (given["n_workers"], given["threads_per_worker"], given["processes"]) == (3, 1, True)
    assert given["preload"] == ["camcli.parallel.dask_cluster"]


def test_chunks_that_have_come_are_those_of_a_moment(distributed):
    waits = deque([Made(done={"a"}), TimeoutError()])

    def wait(futures, seconds, return_when):
        distributed.asked.append((futures, seconds, return_when))
        found = waits.popleft()
        if isinstance(found, Exception):
            raise found
        return found

    distributed.wait = wait
    assert dask_cluster._finished({"a": 1, "b": 2}) == ["a"]
    assert dask_cluster._finished({"b": 2}) == []
    assert distributed.asked == [(["a", "b"], 2.0, "FIRST_COMPLETED"),
                                 (["b"], 2.0, "FIRST_COMPLETED")]  # fmt: skip


def test_an_interrupt_of_the_keyboard_is_not_for_a_worker(monkeypatch):
    taken = []
    monkeypatch.setattr(signal, "signal", lambda *given: taken.append(given))
    dask_cluster.dask_setup(None)
    assert taken == [(signal.SIGINT, signal.SIG_IGN)]
