"""What a scene does not need is not imported."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from camcli.cli.report import RICH_SETTINGS
from camcli.output.drawing_process import import_what_draws

ROOT = Path(__file__).parents[2]
CAM = str(Path(sys.executable).parent / "cam")

PROBE = (
    "import sys, camcli.cli.exit_codes as panel; from camcli.cli.app import app\n"
    "panel.guarded(lambda: app({words!r}, standalone_mode=False))\n"
    "print(*sys.modules, file=sys.stderr)"
)
HEAVY = ("numba", "scipy", "matplotlib")
OF_ORBITS = ("camcli.analysis.orbits.study", "camcli.analysis.orbits.atlas", "camcli.words.detach")
SHORT = "--no-plot --set run.transient=10 --set run.record=3"


@pytest.mark.parametrize(
    ("line", "absent"),
    [
        ("--help", (*HEAVY, "numpy", "flint", "pydantic", "yaml", "rich")),
        (f"simulate --rpm 190 {SHORT}", HEAVY),
        ("simulate --profile-only --no-plot", HEAVY),
        (f"classify --rpm 190 {SHORT} --set run.record=100", ("camcli.exact",)),
        ("sweep --no-plot --points 21", ("matplotlib", "rich", "numpy.ma", *OF_ORBITS)),
    ],
)
def test_what_is_not_needed_is_not_imported(tmp_path, line, absent):
    often = 2 if "--points 21" in line else 1  # the first one may have to compile the kernel
    for _ in range(often):
        done = subprocess.run(
            [sys.executable, "-c", PROBE.format(words=line.split())],
            cwd=tmp_path, capture_output=True, text=True, check=True,
            env={name: value for name, value in os.environ.items() if name not in RICH_SETTINGS},
        )  # fmt: skip
    assert set(done.stderr.splitlines()[-1].split()) & set(absent) == set()


@pytest.mark.parametrize("line", ["--help", "guide"])
def test_help_is_shown_without_what_runs(tmp_path, line):
    """As the installed command is called, from its beginning to its end."""
    code = (
        "import atexit, sys; from camcli.__main__ import main\n"
        "atexit.register(lambda: print(*sys.modules, file=sys.stderr))\n"
        f"sys.argv = ['cam', *{line.split()!r}]; main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    absent = ("camcli.parallel", "camcli.output", "numpy", *HEAVY)
    assert set(done.stderr.splitlines()[-1].split()).isdisjoint(absent)


def test_classes_of_matplotlib_are_documented_again_once_what_draws_is_there(tmp_path, monkeypatch):
    """In a command itself they are not: it shows no documentation of them."""
    (tmp_path / "drawing_with_a_class.py").write_text(
        "from matplotlib.lines import Line2D\nclass Line(Line2D): pass\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    import_what_draws("drawing_with_a_class")
    line = sys.modules["drawing_with_a_class"].Line
    assert "markeredgecolor" not in line.set.__doc__
    assert "markeredgecolor" in type("Other", (line,), {}).set.__doc__


@pytest.mark.parametrize(
    ("typed", "told"),
    [
        ("cam swe", "sweep"), ("cam sweep --ly", "--lyapunov"), ("cam detach --to", "--tolerance"),
        ("cam guide stu", "study"),
    ],
)  # fmt: skip
def test_a_shell_completes_commands_their_options_and_topics(typed, told):
    words = typed.split(" ")
    env = {**os.environ, "COMP_WORDS": typed, "COMP_CWORD": str(len(words) - 1)}
    env |= {"_CAM_COMPLETE": "complete_bash"}
    done = subprocess.run([CAM], env=env, capture_output=True, text=True, check=True)
    assert done.stdout.split() == [told]


def test_an_older_python_is_told_which_one_is_needed(monkeypatch):
    from camcli.__main__ import OLDEST, main

    needed = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["requires-python"]
    assert needed == f">={OLDEST[0]}.{OLDEST[1]}"
    monkeypatch.setattr("sys.version_info", (3, 10, 13))
    with pytest.raises(SystemExit, match=r"found Python 3\.10, expected 3\.11"):
        main()


@pytest.mark.ci
def test_a_home_that_may_not_be_written_is_not_told_of_by_matplotlib(tmp_path):
    """-q says nothing but faults, in a container without a home too."""
    home = {key: os.environ[key] for key in os.environ if key not in ("MPLCONFIGDIR", "HOME")}
    command = [sys.executable, "-m", "camcli", "simulate", "--profile-only", "-q"]
    done = subprocess.run(
        command, cwd=tmp_path, env={**home, "HOME": os.devnull}, capture_output=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")
