"""The site of the guide is built without a warning: no link, page or picture is missing."""

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mkdocstrings")
ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_the_site_is_built_without_a_warning(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "-q", "-d", str(tmp_path)],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert 'href="reference/library/"' in (tmp_path / "index.html").read_text()
    assert "camcli.simulate" in (tmp_path / "reference/library/index.html").read_text()
    assert "682.25" in (tmp_path / "tutorial/first-steps/index.html").read_text()
