"""The picture of the bench from points made by hand."""

from math import nan

import pytest

from camcli.analysis.bench.precision import GIVEN_UP, MISSED, OK, OVER, Measured
from camcli.plots.bench import draw_precision
from tests.output.pictures import pixels, words


def point(method, setting, seconds, error, status=OK):
    return Measured("p3", method, setting, seconds, error, 8, 20, 0, 0, nan, nan, status)


POINTS = [
    point("core", "chatter 1e-13", 1e-5, 0.0),
    point("core", "chatter 1e-03", 1e-5, 1e-5, OVER),
    point("rk45", "tol 1e-03", 1e-2, 1e-3, MISSED),
    point("rk45", "tol 1e-03 max_step 1/16 turn", 1e-1, 1e-6, GIVEN_UP),
    point("heyoka", "tol 1e-13", nan, nan, "not-installed"),
]


@pytest.mark.parametrize("rows", [POINTS, POINTS[-1:]])
def test_the_picture_names_what_is_in_it(rows):
    assert pixels(draw_precision(rows)).min() < 100
    said = words(draw_precision(rows))
    assert ("camcli" in said) == ("missed or invented impacts" in said) == (len(rows) > 1)
