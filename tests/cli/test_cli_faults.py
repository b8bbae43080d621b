"""What a user gets for a mistake: one message per fault, the exit code, never a traceback."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

QUICK = ("--no-plot", "--set", "run.transient=1", "--set", "run.record=2")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("sweep", "--rpm", "abc"), "abc"),
        (("sweep", "--rpm", "1:2:3"), "1:2:3"),
        (("simulate", "--rpm", "600:700"), "cam sweep"),
        (("simulate", "--rpm", "nan"), "nan"),
        (("simulate", "--set", "run.rpmm=3"), "rpm"),
        (("simulate", "--set", "run.rpm"), "="),
        (("simulate", "--threads", "0"), "--threads"),
        (("sweep", "--points", "0"), "--points"),
        (("simulate", "-c", "absent.yaml"), "absent.yaml"),
        (("simulate", "--set", "run.start.q=0.05"), "0.05 m below the cam"),
        (("simulate", "--set", "follower.mass=5e-324"), "1e-15"),
        (("simulate", "--set", "cam.nose_center=0.2"), "do not touch"),
        (("simulate", "--set", "cam.flank_radius=0.851"), "0.001 m"),
        (("sweep", "--points", "10000000", "--set", "run.record=1000000000"), "GB"),
        (("simulate", "--frobnicate"), "--frobnicate"),
        (("frobnicate",), "frobnicate"),
    ],
)
def test_fault_is_named_with_exit_code_2(cam, words, said):
    done = cam(*words)
    assert done.returncode == 2, done.stderr
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""


def test_every_fault_of_a_file_at_once_with_line_and_column(cam, tmp_path):
    (tmp_path / "bad.yaml").write_text(
        "follower: {mass: -1, stiffness: abc, restitution: 2}\n"
        "cam: {kind: arcs, base_radius: 0.4}\n"
        "run:\n  rpm: 0\n"
    )
    done = cam("simulate", "-c", "bad.yaml")
    assert done.returncode == 2
    lines = done.stderr.splitlines()
    assert len(lines) >= 5
    assert any(line.startswith("bad.yaml:1:18: follower.mass: ") for line in lines)
    assert any(line.startswith("bad.yaml:4:8: run.rpm: ") for line in lines)


def test_target_that_is_a_file(cam, tmp_path):
    (tmp_path / "taken").write_text("keep me")
    done = cam("simulate", *QUICK, "-o", "taken")
    assert done.returncode == 2
    assert "file where the folder should be" in done.stderr
    assert (tmp_path / "taken").read_text() == "keep me"


def test_numerical_trouble_keeps_the_rows_and_exits_3(cam, tmp_path):
    words = ("follower.stiffness=0", "run.start.q=1", "run.start.v=1")
    sets = [word for pair in zip(["--set"] * 3, words, strict=True) for word in pair]
    done = cam("sweep", "--rpm", "100:200", "--points", "2", *QUICK, *sets)
    assert done.returncode == 3
    assert "no-return" in done.stderr
    text = (tmp_path / "out/sweep/speeds.csv").read_text()
    assert text.count("no-return") == 2


def test_impact_budget_keeps_what_was_found(cam, tmp_path):
    done = cam(
        "simulate", *QUICK, "--rpm", "190", "--set", "run.impact_budget=5", "--set",
        "run.transient=0",
    )  # fmt: skip
    assert done.returncode == 3
    assert "impact-budget" in done.stderr
    record = json.loads((tmp_path / "out/simulate/run.json").read_text())
    assert record["result"]["status"] == "impact-budget"
    assert (tmp_path / "out/simulate/events.csv").read_text().count("impact") >= 5


def test_warning_where_nothing_dissipates(cam):
    done = cam("simulate", *QUICK, "--set", "follower.restitution=1")
    assert "nothing dissipates" in done.stderr


@pytest.mark.parametrize("command", ["simulate", "sweep"])
def test_warning_of_absurd_height(cam, command):
    done = cam(command, "--no-plot", "--rpm", "1e6")
    assert done.returncode == 0
    assert "times the cam's lift" in done.stderr


def test_interrupt_says_so_and_leaves_the_old_artefacts(cam_process, tmp_path):
    cam_process("sweep", "--rpm", "700", *QUICK)
    before = (tmp_path / "out/sweep/speeds.csv").read_bytes()
    process = subprocess.Popen(
        [sys.executable, "-m", "camcli", "sweep", "--points", "100001", "--no-plot"],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=60)[1]
    assert process.returncode == 130
    assert "interrupted" in said
    assert (tmp_path / "out/sweep/speeds.csv").read_bytes() == before
