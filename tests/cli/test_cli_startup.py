"""What a scene does not need is not imported."""

import subprocess
import sys

HEAVY = ("numba", "scipy", "matplotlib", "numpy", "pydantic", "yaml", "rich")
PROBE = (
    "import sys, camcli.cli.exit_codes as panel; from camcli.cli.app import app\n"
    "panel.guarded(lambda: app({words!r}, standalone_mode=False))\n"
    "print(sorted(m for m in {heavy!r} if m in sys.modules), file=sys.stderr)"
)


def imported(tmp_path, *words: str) -> set[str]:
    done = subprocess.run(
        [sys.executable, "-c", PROBE.format(words=list(words), heavy=HEAVY)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    return set(eval(done.stderr.splitlines()[-1]))


def test_help_imports_nothing_heavy(tmp_path):
    assert imported(tmp_path, "--help") == set()


def test_small_simulation_needs_no_compiler_and_no_plotting(tmp_path):
    found = imported(tmp_path, "simulate", "--rpm", "190", "--set", "run.transient=10", "--set",
                     "run.record=3", "--no-plot")  # fmt: skip
    assert found.isdisjoint({"numba", "scipy", "matplotlib"})


def test_large_sweep_without_picture_draws_nothing(tmp_path):
    assert "matplotlib" not in imported(tmp_path, "sweep", "--no-plot", "--points", "21")
