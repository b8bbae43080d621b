"""Pictures of the bench from points and rows made by hand."""

from io import BytesIO
from math import nan

import pytest

from camcli.analysis.bench.precision import FAILED, GIVEN_UP, MISSED, OK, OVER, Measured
from camcli.analysis.bench.stability import Outcome
from camcli.output.pictures import write_png
from camcli.plots.bench import draw_precision, draw_stability


def point(method, setting, seconds, error, status=OK):
    return Measured("p3", method, setting, seconds, error, 8, 20, 0, 0, nan, nan, status)


POINTS = [
    point("core", "chatter 1e-13", 1e-5, 0.0),
    point("core", "chatter 1e-03", 1e-5, 1e-5, OVER),
    point("rk45", "tol 1e-03", 1e-2, 1e-3, MISSED),
    point("rk45", "tol 1e-03 max_step 1/16 turn", 1e-1, 1e-6, GIVEN_UP),
    point("heyoka", "tol 1e-13", nan, nan, "not-installed"),
]
OUTCOMES = [
    Outcome("1: a, b", 'six "or" seven', "6", OK, 0.001),
    Outcome("2: c", "six", "a very long story " * 20, FAILED, 2.0),
]


@pytest.mark.parametrize(
    ("draw", "rows"),
    [(draw_precision, POINTS), (draw_precision, POINTS[-1:]), (draw_stability, OUTCOMES)],
)
def test_pictures_have_the_same_bytes_twice(draw, rows):
    files = BytesIO(), BytesIO()
    for file in files:
        write_png(draw(rows), file)
    assert files[0].getvalue() == files[1].getvalue()
    assert files[0].getvalue().startswith(b"\x89PNG")
