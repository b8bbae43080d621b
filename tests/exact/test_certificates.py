"""Certificates of proofs, and the checker that confirms or refuses what they state.

The judge of a changed certificate is mpmath at 60 digits (`tests.support.orbit_oracle`): whether
the orbit, with the numbers that the certificate now has, still lies where it says.
"""

import json
import subprocess
import sys
from pathlib import Path

import pytest

import camcli
from camcli import check
from camcli.scene import load_scene

pytestmark = pytest.mark.slow
UPPER = {"orbits.rpm.start": 672.0, "orbits.rpm.stop": 741.0, "orbits.rpm.num": 21,
         "orbits.label": "P(1;1)", "orbits.branches": 0, "orbits.starts": 0}  # fmt: skip
AUXILIARY = ("inverse", "flights")  # what a statement does not say, but rests on


def certificate(folder: Path, **changes) -> dict:
    """The content of the proof.json of a run."""
    result = camcli.orbits(load_scene(None, {k.replace("__", "."): v for k, v in changes.items()}),
                           prove=True)  # fmt: skip
    result.save(folder, plot=False)
    return json.loads((folder / "proof.json").read_text())


@pytest.fixture(scope="module")
def upper(tmp_path_factory):
    """The certificate of P(1;1) from its corner impact beyond its doubling, and at 700 rpm."""
    return certificate(tmp_path_factory.mktemp("upper"), **UPPER)


@pytest.fixture
def said(tmp_path, capsys):
    """(exit code, what is printed) of the checker for the content of a file."""

    def run(content) -> tuple[int, str]:
        file = tmp_path / "changed.json"
        file.write_text(content if isinstance(content, str) else json.dumps(content))
        code = check.main([str(file)])
        printed = capsys.readouterr()
        return code, printed.out + printed.err

    return run


def only(content: dict, *kinds: str) -> dict:
    """The certificate with the statements of these kinds only."""
    statements = [one for one in content["statements"] if one["kind"] in kinds]
    return {**content, "statements": statements}


def test_every_statement_of_a_run_is_confirmed(upper, said):
    code, text = said(upper)
    kinds = [one["kind"] for one in upper["statements"]]
    assert (code, kinds.count("orbit"), kinds.count("branch")) == (0, 2, 3)
    assert text.count("\nconfirmed: ") + text.startswith("confirmed: ") == len(kinds)
    assert upper["uncovered"] == []


def test_the_checker_runs_alone_where_camcli_cannot_be_imported(cam, tmp_path):
    cam("orbits --rpm 700 --label P(1;1) --prove --with-checker --no-plot -o out", code=0)
    alone = "import sys, runpy; sys.modules['camcli'] = None; sys.argv = sys.argv[1:]; "
    alone += "runpy.run_path('out/check.py', run_name='__main__')"
    words = [sys.executable, "-c", alone, "check.py", "out/proof.json"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.endswith("2 of 2 statements are confirmed\n")
    assert (tmp_path / "out/check.py").read_bytes() == Path(check.__file__).read_bytes()
