"""Pictures and tables of the bench from points and rows made by hand."""

from math import nan

from camcli.analysis.bench.flights import Flights
from camcli.analysis.bench.precision import GIVEN_UP, MISSED, OK, OVER, Measured
from camcli.analysis.bench.row import FAILED, Outcome
from camcli.analysis.bench.scenes import Scene
from camcli.output.bench import flights_csv, precision_csv, scenes_csv, stability_csv
from camcli.plots.bench_precision import draw_precision
from camcli.plots.bench_stability import draw_stability
from tests.output.pictures import png

PNG = b"\x89PNG"


def point(method, setting, seconds, error, status=OK):
    return Measured("p3", method, setting, seconds, error, 8, 20, 0, 0, 0.1, nan, nan, status)


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
    Outcome("3: d", "six", "", "not-reached", nan),
]


def drawn(draw, *what):
    first, second = (png(draw(*what)) for _ in range(2))
    assert first == second
    return first


def test_pictures_have_the_same_bytes_twice():
    assert drawn(draw_precision, POINTS, {"p3": "P(3;3:3:2)", "none": "no points"})[:4] == PNG
    assert drawn(draw_precision, POINTS[-1:], {"p3": "P(3;3:3:2)"})[:4] == PNG
    assert drawn(draw_stability, OUTCOMES)[:4] == PNG


def test_tables_have_their_columns_and_no_stray_commas():
    lines = "".join(stability_csv(OUTCOMES)).splitlines()
    assert lines[0] == "case,expected,observed,status,seconds"
    assert lines[1] == "1: a; b,six 'or' seven,6,ok,0.001"
    assert lines[3] == "3: d,six,,not-reached,"
    lines = "".join(precision_csv(POINTS)).splitlines()
    assert lines[0].startswith("case,method,setting,seconds,error,impacts,")
    assert lines[-1] == "p3,heyoka,tol 1e-13,,,8,20,0,0,0.1,,,not-installed"
    found = [
        Scene("a, b", ("x",), "ok", 0, 2.0, None, 10, ()),
        Scene("c", ("y",), "ok", 0, 3.0, 0.5, 20, ("numpy", "yaml")),
        Scene("d", ("z",), "not-reached", None, nan, None, 0, ()),
    ]
    assert "".join(scenes_csv(found)).splitlines()[1:] == [
        "a; b,ok,2.0,1.0,,10,",
        "c,ok,3.0,1.5,0.5,20,numpy yaml",
        "d,not-reached,,,,0,",
    ]
    assert "".join(flights_csv([Flights("core", 10, 9, 8)])).splitlines()[1] == (
        "core,10,9,8,0,0,0.0"
    )
