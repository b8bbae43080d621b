"""Pieces on a Dask cluster: the same bytes, workers that die, schedulers that are not there."""

import importlib.util
import json
import os
import signal
import socket
import subprocess
import sys
import time

import pytest

from tests.parallel.long_runs import (
    DYING,
    at_work,
    begin,
    but_record,
    command,
    ended,
    files,
    gone,
    of_folder,
    run,
)

if importlib.util.find_spec("distributed") is None:
    pytest.skip("needs the package distributed", allow_module_level=True)

TURNS = ("--set", "run.transient=60", "--set", "run.record=40", "--no-plot")
SWEEP = ("sweep", "--rpm", "660:760", "--points", "41", *TURNS)
BASINS = ("basins", "--cells", "70", "--no-plot")
IMPATIENT = (
    "import camcli.parallel.dask_cluster as c; c.PATIENCE = 2.0; from camcli.cli.app import main"
)
QUIET = {"DASK_DISTRIBUTED__WORKER__DAEMON": "False"}
SLOW = f"""
import sys, time
sys.path.insert(0, {str(DYING.parents[2])!r})
from camcli.analysis.sweep import _Task
def slow(task, rpm, call=_Task.__call__):
    time.sleep(0.1)
    return call(task, rpm)
_Task.__call__ = slow
"""
OTHER = """
import camcli.output.program
def program_hash():
    return "another"
program_hash.__module__ = "camcli.output.program"
camcli.output.program.program_hash = program_hash
"""


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


class Crew:
    """A scheduler and workers, each a process of its own."""

    def __init__(self, folder):
        self.folder, self.processes, self.workers = folder, [], []
        self.address = f"127.0.0.1:{free_port()}"
        (folder / "slow.py").write_text(SLOW)
        port = self.address.partition(":")[2]
        words = ("--host", "127.0.0.1", "--port", port, "--no-dashboard")
        self.scheduler = self.start("dask_scheduler", *words)

    def start(self, module: str, *words: str) -> subprocess.Popen:
        path = [sys.executable, "-m", f"distributed.cli.{module}", *words]
        log = open(self.folder / "cluster.log", "a")  # noqa: SIM115 - as long as the process
        env = {**os.environ, **QUIET, "PYTHONUNBUFFERED": "1"}
        process = subprocess.Popen(path, cwd=self.folder, stdout=log, stderr=log, env=env)
        self.processes.append(process)
        return process

    def work(self, *words: str) -> subprocess.Popen:
        common = ("--no-nanny", "--nthreads", "1", "--no-dashboard", "--memory-limit", "0")
        place = ("--local-directory", str(self.folder))
        worker = self.start("dask_worker", self.address, *common, *place, *words)
        self.workers.append(worker)
        return worker

    def end(self) -> None:
        for process in reversed(self.processes):
            process.kill()
            process.wait()


@pytest.fixture
def crew(tmp_path_factory):
    made = Crew(tmp_path_factory.mktemp("crew"))
    yield made
    made.end()


def clean(said: str) -> None:
    """Nothing of distributed's own on the user's screen."""
    for word in ("Traceback", "distributed.", "Warning", "internal fault", "tornado", "Error:"):
        assert word not in said, said


def whole(tmp_path, words) -> dict[str, bytes]:
    """What the same command makes with threads."""
    folder = tmp_path.with_name(f"{tmp_path.name}-{words[0]}")
    assert run(command(*words, "-o", str(folder)), tmp_path)[0] == 0
    return but_record(files(folder))


@pytest.mark.parametrize("words", [SWEEP, BASINS], ids=["sweep", "basins"])
def test_processes_of_this_machine(tmp_path, words):
    local = (*words, "--cluster", "local", "--threads", "2", "-o", str(tmp_path / "out"))
    code, said = run(command(*local), tmp_path)
    assert code == 0, said
    assert said == ""
    assert but_record(files(tmp_path / "out")) == whole(tmp_path, words)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out"]
    options = json.loads((tmp_path / "out/run.json").read_text())["options"]
    assert not {"cluster", "shard"} & set(options)


def test_workers_elsewhere_and_one_that_dies(tmp_path, crew):
    expected = whole(tmp_path, SWEEP)
    for _ in range(2):
        crew.work("--preload", "slow.py")
    words = (*SWEEP, "--cluster", crew.address, "-o", "out")
    process = begin(command(*words), tmp_path)
    assert at_work(tmp_path / "out")
    crew.workers[0].kill()
    code, said = ended(process)
    assert code == 0, said
    clean(said)
    assert but_record(files(tmp_path / "out")) == expected
    code, said = run(command(*BASINS, "--cluster", crew.address, "-o", "cells"), tmp_path)
    assert code == 0, said
    assert but_record(files(tmp_path / "cells")) == whole(tmp_path, BASINS)


def test_all_workers_die_then_an_interrupt_then_the_scheduler(tmp_path, crew):
    expected = whole(tmp_path, SWEEP)
    words = (*SWEEP, "--cluster", crew.address, "-o", "out")

    crew.work("--preload", "slow.py")
    impatient = [sys.executable, "-c", f"{IMPATIENT}; main()", *words]
    process = begin(impatient, tmp_path)
    assert at_work(tmp_path / "out")
    crew.workers[-1].kill()
    code, said = ended(process)
    assert (code, "found no worker for 2 s" in said) == (2, True), said
    clean(said)

    crew.work("--preload", "slow.py")
    process = begin(command(*words), tmp_path)
    assert at_work(tmp_path / "out", 6)
    process.send_signal(signal.SIGINT)
    code, said = ended(process)
    assert (code, "pieces are on disk" in said, "going on" in said) == (130, True, True), said
    clean(said)

    process = begin(command(*words), tmp_path)
    assert at_work(tmp_path / "out", 8)
    crew.scheduler.kill()
    code, said = ended(process)
    assert (code, "lost the scheduler" in said) == (2, True), said
    clean(said)
    assert files(tmp_path / "out") == {}

    code, said = run(command(*words[:-4], "-o", "out"), tmp_path)
    assert (code, "going on" in said) == (0, True)
    assert but_record(files(tmp_path / "out")) == expected


@pytest.mark.parametrize("address", [None, "", "::::", "nonsense", "http://x"])
def test_no_scheduler_is_said_soon(tmp_path, address):
    address = f"127.0.0.1:{free_port()}" if address is None else address
    began = time.monotonic()
    code, said = run(command(*SWEEP, "--cluster", address, "-o", "out"), tmp_path)
    assert time.monotonic() - began < 30
    assert (code, "--cluster: found no scheduler" in said) == (2, True), said
    clean(said)
    assert list((tmp_path / "out").iterdir()) == []


def test_an_interrupt_of_local_processes_leaves_none(tmp_path):
    words = (*SWEEP[:4], "4001", *TURNS, "--cluster", "local", "-o", str(tmp_path / "out"))
    process = begin(command(*words), tmp_path, start_new_session=True)
    assert at_work(tmp_path / "out")
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    code, said = ended(process)
    assert code == 130, said
    clean(said)
    assert gone(tmp_path)
    assert of_group(process.pid) == set()


def of_group(group: int) -> set[int]:
    """Processes of a group that are alive ten seconds later."""
    until = time.monotonic() + 10
    while True:
        out = subprocess.run(["ps", "-eo", "pid,pgid,stat"], capture_output=True, text=True)
        rows = [line.split() for line in out.stdout.splitlines()[1:]]
        left = {int(pid) for pid, pgid, stat in rows if int(pgid) == group and stat[0] != "Z"}
        if not left or time.monotonic() > until:
            return left
        time.sleep(0.1)


def test_a_worker_of_another_version_is_refused(tmp_path, crew):
    (crew.folder / "slow.py").write_text(OTHER)
    crew.work("--preload", "slow.py")
    code, said = run(command(*SWEEP, "--cluster", crew.address, "-o", "out"), tmp_path)
    assert (code, "another version of this program" in said) == (2, True), said
    clean(said)


def test_without_the_package(tmp_path):
    code = "import sys; sys.modules['distributed'] = None; from camcli.cli.app import main; main()"
    words = [sys.executable, "-c", code, *SWEEP, "--cluster", "local"]
    code, said = run(words, tmp_path)
    assert (code, "pip install 'camcli[cluster]'" in said) == (2, True), said
    assert of_folder(tmp_path) == set()
