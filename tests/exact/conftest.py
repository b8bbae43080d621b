"""What the tests of certificates share: the checker's verdict on a file."""

import json

import pytest
from flint import ctx
from mpmath import mp

from camcli import check


@pytest.fixture
def checked(tmp_path, capsys):
    """(exit code, what is printed) of the checker for the content of a file."""

    def run(content) -> tuple[int, str]:
        file = tmp_path / "changed.json"
        file.write_text(content if isinstance(content, str) else json.dumps(content))
        code = check.main([str(file)])
        printed = capsys.readouterr()
        return code, printed.out + printed.err

    return run


@pytest.fixture
def bits():
    """The digits of the checker, and of mpmath."""
    before = ctx.prec
    ctx.prec = check.BITS
    with mp.workdps(60):
        yield
    ctx.prec = before
