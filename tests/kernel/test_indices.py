"""Compiled, the kernel does not count from the end of a column, so it must not be asked to."""

from __future__ import annotations

from pathlib import Path

import pytest

from camcli.kernel import backend
from camcli.kernel.forms import PLAIN, Kernel
from camcli.kernel.marks import ENTRIES
from camcli.kernel.self_check import CASES, case_of

CONFIGS = Path(__file__).parents[2] / "configs"
SHORT = (
    "--set run.transient=3 --set run.record=6 --set run.patience=0 --points 20 --no-plot --quiet"
)


class Column(list):
    """A column of which an index from its end is a fault."""

    def __getitem__(self, n):
        assert isinstance(n, slice) or n >= 0
        return super().__getitem__(n)

    def __setitem__(self, n, value):
        assert isinstance(n, slice) or n >= 0
        super().__setitem__(n, value)


class Strict(Kernel):
    """Plain Python on such columns and tables."""

    def numbers(self, values, kind=float):
        return Column(super().numbers(values, kind))

    def zeros(self, count, kind=float):
        return Column(super().zeros(count, kind))

    def table(self, kind, rows):
        return Column(super().table(kind, rows))

    def copies(self, kind, row, count):
        return Column(super().copies(kind, row, count))

    def room(self, kind, count):
        return Column(super().room(kind, count))


STRICT = Strict(**{name: getattr(PLAIN, name) for name in Kernel.__dataclass_fields__})


@pytest.mark.parametrize("name", CASES)
def test_no_entry_counts_from_the_end(name):
    ENTRIES[name](*case_of(name, STRICT))


@pytest.mark.parametrize("scene", sorted(CONFIGS.glob("*.yaml")), ids=lambda path: path.stem)
def test_no_shipped_machine_makes_it_do_so(cam, monkeypatch, scene):
    monkeypatch.setattr(backend, "current", lambda: STRICT)
    monkeypatch.setattr(backend, "for_work", lambda *_: STRICT)
    monkeypatch.setattr(backend, "may_compile", lambda: False)
    done = cam(f"simulate -c {scene} {SHORT} -o out")
    assert done.returncode in (0, 3), done.stderr
    assert "internal fault" not in done.stderr
