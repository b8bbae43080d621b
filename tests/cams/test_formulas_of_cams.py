"""The formulas that a certificate has of a cam, evaluated as Python, against its table.

Formulas and table are made by different code: the text of a polynomial, a wave or a circle is
evaluated here with the numbers of the cam, and c is compared in every stretch of it.
"""

import math
from itertools import pairwise
from types import SimpleNamespace

import pytest
from flint import arb

from camcli import load_scene
from camcli.cams.balls import UndecidedError, precision
from camcli.cams.compile import DIGITS, Part, Piece, build
from camcli.cams.formula import ERROR_OF_EDGES, formula_of
from camcli.cams.law import _below, _larger, _smaller, degrees, within_turn
from camcli.cams.varied import ScaledTable, can_vary, constants_of, name_in_formula, with_number
from camcli.kernel.cam_table import TERMS, TURN, lift_at, stretch_at

SPRING = {"mass": 1.2, "stiffness": 1430.8, "restitution": 0.8}
ARCS = {
    "kind": "arcs", "base_radius": 0.4, "flank_center": 0.45, "flank_radius": 0.85,
    "nose_center": 0.4, "nose_radius": 0.15, "top_dwell_deg": 40.0, "offset": 0.07,
}  # fmt: skip
OSCILLATOR = {
    "kind": "oscillator", "mass": 1.7, "stiffness": 1.3, "amplitude": 1.1, "frequency": 0.9,
    "clearance": 0.3,
}  # fmt: skip


def law(rise, fall, start=100.0, dwell=23.0, lengths=(71.0, 83.0), **more):
    return {
        "kind": "law", "base": 0.013, "lift": 0.011, "top_dwell_deg": dwell,
        "rise": {"law": rise, "start_deg": start, "length_deg": lengths[0]},
        "fall": {"law": fall, "length_deg": lengths[1]}, **more,
    }  # fmt: skip


def widths(b, c, d):
    return {"scca": {"b": b, "c": c, "d": d}}


CAMS = {
    "arcs": ARCS,
    "arcs-lash": {**ARCS, "lash": 0.02},
    "arcs-no-clearance": {**ARCS, "lash": 0.0},
    "eccentric": {"kind": "eccentric", "base": 0.1, "lift": 0.3},
    "eccentric-lash": {"kind": "eccentric", "base": 0.1, "lift": 0.3, "lash": 0.04},
    "damping": {**OSCILLATOR, "damping": 0.4},
    "damping-ratio": {**OSCILLATOR, "damping_ratio": 0.2},
    "polynomials": law("3-4-5", "4-5-6-7"),
    "through-zero": law("cycloidal", "constant-velocity", 300.0),
    "through-zero-in-the-fall": law("harmonic", "modified-trapezoid", -130.0),
    "from-zero": law("modified-sine", "constant-acceleration", 0.0, 0.0),
    "widths": law(widths(0.2, 0.3, 0.5), widths(0.4, 0.0, 0.6), lash=0.0015),
    "half-a-sine": law(widths(0.5, 0.2, 0.3), "harmonic"),
    "more-than-one": law(widths(0.3, 0.0, 0.7 + 4e-10), "harmonic"),
    "whole-turn": law("cycloidal", "3-4-5", 20.0, 0.0, (100.1, 259.9 + 2e-10)),
    "lash-through-zero": law("modified-sine", "3-4-5", 310.0, lash=0.002),
    "no-clearance": law("cycloidal", "cycloidal", lash=0.0),
}


def cam_of(section):
    follower = {"restitution": 0.8} if section["kind"] == "oscillator" else SPRING
    return load_scene({"follower": follower, "cam": section, "run": {}}).cam


class Formulas:
    """The stretches of a cam as a certificate has it, as functions of doubles."""

    def __init__(self, told: dict):
        self.names = {"pi": math.pi, "sqrt": math.sqrt, "atan2": math.atan2}
        for name, text in told["numbers"].items():
            self.names[name] = float(text.partition(" +/- ")[0])
        for one in told["formulas"]:
            self.names[one["name"]] = self.value(one["formula"])
        self.ends = [self.value(one["end"]) for one in told["stretches"]]
        self.stretches = told["stretches"]

    def value(self, text: str) -> float:
        return float(eval(text, {"__builtins__": {}}, self.names))

    def lift(self, k: int, theta: float) -> float:
        stretch = self.stretches[k]
        x = theta - self.value(stretch["center"])
        total = sum(self.value(a) * x**n for n, a in enumerate(stretch["polynomial"]))
        if stretch["wave"]:
            cosine, sine, rate = map(self.value, stretch["wave"])
            total += cosine * math.cos(rate * x) + sine * math.sin(rate * x)
        if stretch["circle"]:
            kappa, rho = map(self.value, stretch["circle"])
            total += kappa * math.cos(x) + math.sqrt(rho**2 - (kappa * math.sin(x)) ** 2)
        return total


def check(shape, seat_restitution=None) -> dict:
    """The formulas of a cam, which are those of its table in every stretch."""
    told = formula_of(shape, seat_restitution)
    formulas, table = Formulas(told), build(shape)
    size = table.top - min(stretch.c_min for stretch in table.stretches)
    assert formulas.ends == sorted(formulas.ends)
    assert formulas.ends[-1] == pytest.approx(TURN, rel=1e-15)
    for k, (start, end) in enumerate(pairwise([0.0, *formulas.ends])):
        assert end - start > 1e-10
        for share in (0.02, 0.3, 0.5, 0.77, 0.98):
            theta = start + share * (end - start)
            i = stretch_at(table, theta)
            c = lift_at(table, i, theta)[0]
            assert formulas.lift(k, theta) == pytest.approx(c, abs=2e-13 * size), (k, share)
            assert formulas.stretches[k]["seat"] == bool(table.stretches[i].seat)
    return told


@pytest.mark.parametrize("name", CAMS)
def test_the_formulas_of_a_cam_are_its_table(name):
    shape = cam_of(CAMS[name])
    lash = getattr(shape, "lash", None)
    told = check(shape, 0.0625)
    assert told["kind"] == CAMS[name]["kind"]
    assert told["seat_restitution"] == (None if lash is None else "0.0625")
    assert formula_of(shape)["seat_restitution"] is None
    keys = [key for key in told["numbers"] if not key.startswith("edge")]
    for key in keys:
        value = shape.follower_damping if key == "damping" else getattr(shape, key)
        assert float(told["numbers"][key]) == value
    edges = [text for key, text in told["numbers"].items() if key.startswith("edge")]
    assert len(edges) == (2 if lash else 0)
    for text in edges:  # as many digits as the error promises
        digits, error = text.split(" +/- ")
        assert error == ERROR_OF_EDGES
        assert len(digits.partition(".")[2]) >= 66


def test_fitted_pieces_are_told_one_by_one():
    """A dwell of two eighths, five pieces and a dwell of one; a piece may have few powers."""
    coefficients = ((0.2, 0.5, -0.3, 0.0, 0.7), (0.1,), (0.4, 0.0, 0.9), (0.0,), (0.3, -0.8))
    with precision(DIGITS):
        eighth = arb.pi() / 4
        centers = [float(eighth * (2 * k + 5) / 2) for k in range(5)]
        pieces = tuple(
            Piece(center, float(eighth / 2), told + (0.0,) * (TERMS - len(told)))
            for center, told in zip(centers, coefficients, strict=True)
        )
        parts = [
            Part(arb(0), 2 * eighth, None, arb(0.625)),
            Part(2 * eighth, 7 * eighth, None, pieces=pieces),
            Part(7 * eighth, 8 * eighth, None, arb(0.875)),
        ]
    shape = SimpleNamespace(parts=lambda: parts)
    told = check(shape)
    assert (told["kind"], told["numbers"], told["formulas"]) == ("pieces", {}, [])
    assert [one["end"] for one in told["stretches"]] == [f"2*pi*{k}/8" for k in range(2, 9)]
    lengths = [len(one["polynomial"]) for one in told["stretches"]]
    assert lengths == [1, 5, 1, 3, 1, 2, 1]
    assert formula_of(SimpleNamespace(lash=0.1, as_drawn=lambda: shape)) is None
    parts[1] = Part(2 * eighth, 7 * eighth, lambda theta: theta)
    with pytest.raises(ValueError, match="without a formula"):
        formula_of(shape)


@pytest.mark.parametrize(
    ("kind", "more", "known"),
    [
        ("arcs", {}, {
            "base_radius", "flank_center", "nose_center", "nose_radius", "top_dwell_deg", "offset",
        }),
        ("eccentric", {}, {"base", "lift"}),
        ("law", {}, {"base", "lift"}),
        ("table", {}, set()),
        ("arcs", {"lash": 0.0}, set()),
    ],
)  # fmt: skip
def test_a_certificate_varies_the_numbers_of_its_formulas(kind, more, known):
    shape = SimpleNamespace(kind=kind, **more)
    every = ("base_radius", "flank_center", "flank_radius", "nose_center", "nose_radius", "base",
             "top_dwell_deg", "offset", "lift", "lash", "frequency", "lift_scale")  # fmt: skip
    for name in every:
        wanted = (f"cam.{name}", set()) if name in known else None
        assert name_in_formula(shape, f"cam.{name}") == wanted


@pytest.mark.parametrize("ratio", [None, 0.0, 0.2])
def test_the_constants_of_an_oscillator_follow_from_its_numbers_in_a_certificate(ratio):
    """With a damping ratio the damping would vary with mass and stiffness."""
    shape = SimpleNamespace(kind="oscillator", damping_ratio=ratio)
    own = ("mass", "stiffness", "damping", "amplitude", "frequency", "clearance")
    for name in own:
        constants = {"rpm", name} if name in own[:3] else {"rpm"}
        wanted = (f"cam.{name}", constants)
        if ratio is not None and name in ("mass", "stiffness"):
            wanted = None
        assert name_in_formula(shape, f"cam.{name}") == wanted
    assert name_in_formula(shape, "cam.damping_ratio") is None


def test_the_speed_of_an_oscillator_has_the_digits_of_its_frequency():
    shape = cam_of({**OSCILLATOR, "damping": 0.4})
    with precision(DIGITS):
        varied = with_number(shape, "cam.frequency", arb(1) / 3)
        (rpm,) = constants_of(varied).values()
        assert abs(rpm - 10 / arb.pi()) < 1e-40
        varied = with_number(shape, "cam.damping", arb(1) / 7)
        assert set(constants_of(varied)) == {"damping", "rpm"}
        assert abs(constants_of(varied)["damping"] * 7 - 1) < 1e-40


@pytest.mark.parametrize("kind", ["arcs", "eccentric", "law"])
def test_the_height_of_a_seat_without_clearance_does_not_vary(kind):
    height = ("base", "base_radius", "offset", "lash")
    others = ("lift", "flank_center", "flank_radius", "nose_radius", "rise.start_deg")
    for name in (*height, *others):
        for lash in (None, 0.0, 0.1):
            shape = SimpleNamespace(kind=kind, lash=lash)
            assert can_vary(shape, f"cam.{name}") == (lash != 0.0 or name in others)


@pytest.mark.parametrize(
    ("changes", "factors"),
    [
        ({}, {"lift_scale": 1.5}),
        ({"max_lift": 0.03}, {"lift_scale": 1.5, "max_lift": 0.03}),
        ({"measured_at": "lobe"}, {"lift_scale": 1.5, "rocker_ratio": 1.0}),
        ({"measured_at": "lobe", "rocker_ratio": 1.7}, {"lift_scale": 1.5, "rocker_ratio": 1.7}),
        ({"rocker_ratio": 1.7}, {"lift_scale": 1.5}),
    ],
)
def test_the_numbers_of_a_table_to_which_its_lift_is_proportional(changes, factors):
    table = SimpleNamespace(
        **{"kind": "table", "lash": None, "base": 0.25, "lift_scale": 1.5, "max_lift": None,
           "measured_at": "valve", "rocker_ratio": 1.0, **changes}
    )  # fmt: skip
    for key in ("lift_scale", "max_lift", "rocker_ratio", "zero_deg", "smoothing"):
        assert can_vary(table, f"cam.{key}") == (key in factors)
    with precision(DIGITS):
        for key, home in factors.items():
            scaled = with_number(table, f"cam.{key}", arb("0.9"))
            assert isinstance(scaled, ScaledTable)
            assert abs(scaled.factor * arb(home) - arb("0.9")) < 1e-40
            assert scaled.base == arb(0.25)
            assert abs(scaled._moved(arb(2)) - (arb("0.25") + scaled.factor * arb("1.75"))) < 1e-40
        moved = with_number(table, "cam.base", arb("0.7"))
        assert (moved.factor, moved.table) == (1, table)
        assert abs(moved._moved(arb("0.3")) - arb("0.75")) < 1e-40


def test_an_angle_is_laid_within_the_turn():
    for angle, within in ((370.5, 10.5), (-10.25, 349.75), (0.0, 0.0), (360.0, 0.0), (725.0, 5.0)):
        assert float(within_turn(arb(angle))) == within
        shifted = within_turn(arb(angle + 0.125) + arb(0, 1e-20))
        assert shifted.overlaps(arb(within + 0.125))


def test_the_smaller_of_two_angles_is_known_also_where_they_are_equal():
    for two, three in ((degrees(2.0), degrees(3.0)), (arb(2), arb(3)), (arb(2), degrees(3.0))):
        assert _below(two, three)
        assert not _below(three, two)
        assert not _below(two, two)
        for angles in ((two, three), (three, two)):
            assert (_smaller(*angles), _larger(*angles)) == (two, three)
    with pytest.raises(UndecidedError):
        _below(arb(2), arb(2) + arb(0, 1e-9))
