"""Helpers do what this process would do, end with it, and are not missed where they fail."""

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from threading import Thread
from time import monotonic, sleep

import pytest

from camcli.analysis.after_rest import followed
from camcli.parallel.helpers import Helper, HelperFailedError, Helpers, Turns
from camcli.parallel.threads import thread_count
from tests.conftest import some_in_ci
from tests.support.kernel_runs import machine

ROOT = Path(__file__).parents[2]

LONG = 20.0  # s that a process may take to start or to end, on a busy machine


def square_and_process(x):
    sleep(0.01)
    return x * x, os.getpid()


def asked_by(turns, threads, calls=8, function=square_and_process):
    """What each of so many threads gets, and the processes that worked."""
    found = [[] for _ in range(threads)]

    def ask(own):
        for x in range(calls):
            own.append(turns.call(function, x))

    running = [Thread(target=ask, args=(own,)) for own in found]
    for thread in running:
        thread.start()
    for thread in running:
        thread.join()
    answers = [[square for square, _ in own] for own in found]
    return answers, {process for own in found for _, process in own}


@pytest.fixture
def turns():
    """Two helpers, asked for at once where two threads ask."""
    turns = Turns(most=2, enough=0.0)
    yield turns
    for helper in turns.helpers:
        helper.end()


def ready(turns, count=2):
    asked_by(turns, 2, calls=2)
    end = monotonic() + LONG
    while len(turns.helpers) < count and monotonic() < end:
        sleep(0.01)
    assert len(turns.helpers) == count
    return {helper.process.pid for helper in turns.helpers}


def test_there_is_a_helper_for_each_processor_unless_it_is_said_otherwise():
    assert Turns().most == thread_count(None) >= 1
    assert Turns(most=3).most == 3


def test_helpers_do_it_all_once_they_are_ready(turns):
    expected = [[x * x for x in range(8)]] * 2
    helpers = ready(turns)
    answers, processes = asked_by(turns, 2)
    assert answers == expected
    assert processes == helpers
    assert os.getpid() not in processes


def test_one_thread_has_no_helpers(turns):
    answers, processes = asked_by(turns, 1)
    assert answers == [[x * x for x in range(8)]]
    assert processes == {os.getpid()}
    assert not turns._asked_for


def test_little_work_starts_none():
    turns = Turns(most=2, enough=10.0)
    assert asked_by(turns, 2)[1] == {os.getpid()}
    assert not turns._asked_for


def test_helpers_that_are_killed_are_not_missed(turns):
    for process in ready(turns):
        os.kill(process, signal.SIGTERM)
    answers, processes = asked_by(turns, 3)
    assert answers == [[x * x for x in range(8)]] * 3
    assert processes == {os.getpid()}


def divided(x):
    return 1 / x, os.getpid()


def test_an_error_is_raised_here(turns):
    ready(turns)
    with pytest.raises(ZeroDivisionError):
        turns.call(divided, 0)
    assert turns.call(divided, 1) == (1.0, os.getpid())


def test_what_cannot_be_sent_is_computed_here(turns):
    ready(turns)
    assert turns.call(lambda x: x + 1, 1) == 2


def test_an_interrupt_from_the_keyboard_leaves_a_helper_alone():
    helper = Helper()
    try:
        helper.wait_until_ready()
        os.kill(helper.process.pid, signal.SIGINT)
        assert helper.call(square_and_process, 3) == (9, helper.process.pid)
    finally:
        helper.end()
    with pytest.raises(HelperFailedError):
        helper.call(square_and_process, 3)


@pytest.mark.parametrize("text", ["Bonjour, this is a site\n", "Tea?", "c\no\n."])
def test_what_python_prints_when_it_starts_is_no_answer(tmp_path, monkeypatch, text):
    """A letter of it may mean, of a pickle, that so many bytes follow."""
    (tmp_path / "sitecustomize.py").write_text(f"print({text!r}, end='', flush=True)\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    helper = Helper()
    try:
        helper.wait_until_ready()
        assert helper.call(square_and_process, 3) == (9, helper.process.pid)
    finally:
        helper.end()


def kept_until_the_end(folder):
    """Begin something that is cleaned up when the process ends, and be busy."""
    with tempfile.TemporaryDirectory(dir=folder):
        (Path(folder) / "begun").touch()
        sleep(60.0)


@pytest.mark.parametrize("parent", some_in_ci(["ends it", "is gone"], {"ends it"}))
def test_what_a_helper_has_for_now_goes_with_it(tmp_path, parent):
    code = (
        "import sys, time; from pathlib import Path; from threading import Thread\n"
        "from tests.parallel.test_helpers import kept_until_the_end\n"
        "from camcli.parallel.helpers import Helper\n"
        "folder = Path(sys.argv[1]); h = Helper(); h.wait_until_ready()\n"
        "Thread(target=h.call, args=(kept_until_the_end, str(folder)), daemon=True).start()\n"
        "while not (folder / 'begun').exists(): time.sleep(0.01)\n"
        "print(h.process.pid, flush=True)\n"
        + ("h.end()" if parent == "ends it" else "import os; os._exit(0)")
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path)], cwd=ROOT, text=True, capture_output=True,
        timeout=60.0,
    )  # fmt: skip
    pid = int(done.stdout)
    for _ in range(300):
        if not Path(f"/proc/{pid}").exists():
            break
        sleep(0.02)
    assert [path.name for path in tmp_path.iterdir()] == ["begun"], done.stderr


def printing(x):
    print("no answer")
    return x


def test_what_is_printed_is_no_answer():
    helper = Helper()
    helper.wait_until_ready()
    assert [helper.call(printing, x) for x in range(3)] == [0, 1, 2]
    helper.end()


def test_a_helper_ends_with_the_process_that_asks():
    code = (
        "import os; from camcli.parallel.helpers import Helper; h = Helper(); h.wait_until_ready();"
        "print(h.process.pid, flush=True); os._exit(0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    end = monotonic() + LONG
    while is_alive(int(done.stdout)) and monotonic() < end:
        sleep(0.01)
    assert not is_alive(int(done.stdout))


def is_alive(process):
    try:
        with open(f"/proc/{process}/stat") as file:
            return file.read().split(")")[1].split()[0] != "Z"
    except OSError:
        return False


def test_a_helper_at_work_ends_soon_after_the_process_that_asks():
    code = (
        "import os, time; from threading import Thread; from camcli.parallel.helpers import Helper;"
        "h = Helper(); h.wait_until_ready();"
        "Thread(target=h.call, args=(time.sleep, 60.0)).start();"
        "time.sleep(0.2); print(h.process.pid, flush=True); os._exit(0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    end = monotonic() + LONG
    while is_alive(int(done.stdout)) and monotonic() < end:
        sleep(0.01)
    assert not is_alive(int(done.stdout))


def test_long_calls_have_a_process_each_until_one_fails():
    """What it failed in is done here and raised here, and so is what it would have done later."""
    helpers = Helpers(2)
    answers, processes = asked_by(helpers, 2)
    assert answers == [[x * x for x in range(8)]] * 2
    assert processes == {helper.process.pid for helper in helpers._started}
    with pytest.raises(ZeroDivisionError):
        helpers.call(divided, 0)
    answers, processes = asked_by(helpers, 2)
    assert answers == [[x * x for x in range(8)]] * 2
    assert os.getpid() in processes
    assert len(processes) == 2
    helpers.end()
    with pytest.raises(HelperFailedError):
        helpers.call(square_and_process, 3)
    assert not any(is_alive(helper.process.pid) for helper in helpers._started)


def test_calls_at_work_end_with_their_helpers():
    helpers = Helpers(1)
    assert helpers.call(square_and_process, 3)[0] == 9
    failed = []

    def ask():
        with pytest.raises(HelperFailedError):
            helpers.call(sleep, 60.0)
        failed.append(True)

    asking = Thread(target=ask)
    asking.start()
    sleep(0.1)
    helpers.end()
    asking.join(LONG)
    assert failed == [True]


def test_a_motion_after_a_rest_is_the_same_there():
    one = machine(0.0)
    args = one.shape, one.follower, one.strobe, 358.0, 2.621124501166232, False, False
    helper = Helper()
    helper.wait_until_ready()
    assert helper.call(followed, *args) == followed(*args)
    helper.end()
