"""Pieces on a Dask cluster: the same bytes, workers that die, schedulers that are not there."""

import importlib.util
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.long_runs import at_work, begin, but_record, cam, command, ended, files, gone

if importlib.util.find_spec("distributed") is None:
    pytest.skip("needs the package distributed", allow_module_level=True)

TURNS = ("--set", "run.transient=20", "--set", "run.record=20", "--no-plot")
SWEEP = ("sweep", "--rpm", "660:760", "--points", "31", *TURNS, "--set", "run.patience=0")
BASINS = ("basins", "--cells", "12", "--no-plot")
IMPATIENT = (
    "import camcli.parallel.dask_cluster as c; c.PATIENCE = 2.0; from camcli.cli.app import main"
)
SLOW = f"""
import sys, time
sys.path.insert(0, {str(Path(__file__).parents[2])!r})
import camcli.parallel.dask_cluster as cluster
def slow(task, chunk, program, run=cluster._run):
    time.sleep(0.05 * len(chunk))
    return run(task, chunk, program)
slow.__module__, slow.__qualname__ = "camcli.parallel.dask_cluster", "_run"
cluster._run = slow
"""
OTHER = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parents[2])!r})
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


class Cluster:
    """A scheduler and workers, each a process of its own."""

    def __init__(self, folder):
        self.folder, self.processes, self.workers = folder, [], []
        self.address = f"127.0.0.1:{free_port()}"
        port = self.address.partition(":")[2]
        words = ("--host", "127.0.0.1", "--port", port, "--no-dashboard")
        self.scheduler = self.start("dask_scheduler", *words)

    def start(self, module: str, *words: str) -> subprocess.Popen:
        path = [sys.executable, "-m", f"distributed.cli.{module}", *words]
        env = {**os.environ, "DASK_DISTRIBUTED__WORKER__DAEMON": "False"}
        with open(self.folder / "cluster.log", "a") as log:
            process = subprocess.Popen(path, cwd=self.folder, stdout=log, stderr=log, env=env)
        self.processes.append(process)
        return process

    def work(self, preload: str = SLOW) -> None:
        (self.folder / "preload.py").write_text(preload)
        common = ("--no-nanny", "--nthreads", "1", "--no-dashboard", "--memory-limit", "0")
        place = ("--local-directory", str(self.folder), "--preload", "preload.py")
        self.workers.append(self.start("dask_worker", self.address, *common, *place))

    def end(self) -> None:
        for process in reversed(self.processes):
            process.kill()
            process.wait()


@pytest.fixture
def cluster(tmp_path_factory):
    made = Cluster(tmp_path_factory.mktemp("cluster"))
    yield made
    made.end()


@pytest.fixture
def whole(tmp_path_factory):
    """What the same command makes with threads."""

    def made(words):
        folder = tmp_path_factory.mktemp("whole")
        assert cam((*words, "-o", "."), folder)[0] == 0
        return but_record(files(folder))

    return made


def clean(said: str) -> None:
    """Nothing of distributed's own on the user's screen."""
    for word in ("Traceback", "distributed.", "Warning", "internal fault", "tornado", "Error:"):
        assert word not in said, said


@pytest.mark.ci
@pytest.mark.slow
@pytest.mark.parametrize(
    "words", [SWEEP, pytest.param(BASINS, marks=pytest.mark.soak)], ids=["sweep", "basins"]
)
def test_processes_of_this_machine(tmp_path, whole, words):
    local = (*words, "--cluster", "local", "--threads", "2", "-o", str(tmp_path / "out"))
    assert ended(begin(command(*local), tmp_path)) == (0, "")
    assert but_record(files(tmp_path / "out")) == whole(words)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out"]
    assert b'"cluster"' not in files(tmp_path / "out")["run.json"]


@pytest.mark.ci
@pytest.mark.slow
def test_workers_elsewhere_and_one_that_dies(tmp_path, cluster, whole):
    for _ in range(2):
        cluster.work()
    process = begin(command(*SWEEP, "--cluster", cluster.address, "-o", "out"), tmp_path)
    assert at_work(tmp_path / "out")
    cluster.workers[0].kill()
    code, said = ended(process)
    assert code == 0, said
    clean(said)
    assert but_record(files(tmp_path / "out")) == whole(SWEEP)


@pytest.mark.soak
@pytest.mark.slow
def test_all_workers_die_then_an_interrupt_then_the_scheduler(tmp_path, cluster, whole):
    words = (*SWEEP, "--cluster", cluster.address, "-o", "out")

    cluster.work()
    process = begin([sys.executable, "-c", f"{IMPATIENT}; main()", *words], tmp_path)
    assert at_work(tmp_path / "out")
    cluster.workers[-1].kill()
    code, said = ended(process)
    assert (code, "found no worker for 2 s" in said) == (2, True), said
    clean(said)

    cluster.work()
    process = begin(command(*words), tmp_path)
    assert at_work(tmp_path / "out", 6)
    process.send_signal(signal.SIGINT)
    code, said = ended(process)
    assert code == 130
    assert " on disk, the same command goes on" in said
    assert "going on" in said
    clean(said)

    process = begin(command(*words), tmp_path)
    assert at_work(tmp_path / "out", 8)
    cluster.scheduler.kill()
    code, said = ended(process)
    assert (code, "lost the scheduler" in said) == (2, True), said
    clean(said)
    assert files(tmp_path / "out") == {}

    code, said = cam((*SWEEP, "-o", "out"), tmp_path)
    assert (code, "going on" in said) == (0, True)
    assert but_record(files(tmp_path / "out")) == whole(SWEEP)


@pytest.mark.slow
@pytest.mark.parametrize("address", [pytest.param(None, marks=pytest.mark.soak), "", "nonsense"])
def test_no_scheduler_is_said_soon(tmp_path, address):
    address = f"127.0.0.1:{free_port()}" if address is None else address
    code, said = cam((*SWEEP, "--cluster", address, "-o", "out"), tmp_path)
    assert (code, "--cluster: found no scheduler" in said) == (2, True), said
    assert "expected HOST:PORT, or local, see dask scheduler" in " ".join(said.split())
    clean(said)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.ci
@pytest.mark.slow
def test_an_interrupt_of_local_processes_leaves_none(tmp_path):
    words = (*SWEEP[:4], "4001", *TURNS, "--cluster", "local", "-o", str(tmp_path / "out"))
    process = begin(command(*words), tmp_path, start_new_session=True)
    assert at_work(tmp_path / "out")
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    code, said = ended(process)
    assert code == 130, said
    clean(said)
    assert gone(str(tmp_path))
    assert gone(str(process.pid))  # its group


@pytest.mark.slow
def test_a_worker_of_another_version_is_refused(tmp_path, cluster):
    cluster.work(OTHER)
    code, said = ended(begin(command(*SWEEP, "--cluster", cluster.address, "-o", "out"), tmp_path))
    assert (code, "another version of this program" in said) == (2, True), said
    clean(said)


def test_without_the_package(tmp_path):
    def hide() -> None:
        sys.modules["distributed"] = None

    code, said = cam((*SWEEP, "--cluster", "local"), tmp_path, hide)
    assert (code, "pip install 'camcli[cluster]'" in said) == (2, True), said


@pytest.mark.ci
@pytest.mark.slow
def test_processes_that_are_killed_while_they_start_are_said(tmp_path):
    def doomed() -> None:
        import distributed

        class LocalCluster(distributed.LocalCluster):
            def __init__(self, **options):
                options["preload"] = [str(tmp_path / "kill.py")]
                super().__init__(**options)

        distributed.LocalCluster = LocalCluster

    (tmp_path / "kill.py").write_text("import os; os.kill(os.getpid(), 9)\n")
    code, said = cam((*SWEEP, "--cluster", "local", "--threads", "1"), tmp_path, doomed)
    assert (code, "processes of this machine did not start" in said) == (2, True), said
    clean(said)
