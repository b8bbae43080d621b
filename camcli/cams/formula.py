"""A cam as a certificate has it: its numbers, and the formulas of its stretches.

A stretch ends at the angle `end`, where the next one begins, and with x = theta - center it is
sum a_j x^j + A cos k x + B sin k x + kappa cos x + sqrt(rho^2 - kappa^2 sin^2 x), with a_j in
`polynomial`, (A, B, k) in `wave` and (kappa, rho) in `circle`. All of these are formulas, as text,
of the numbers of the cam, of pi and of formulas before them; so a checker needs to know no cam.
"""

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from flint import arb

from camcli.cams.balls import precision
from camcli.cams.compile import DIGITS, Part, Shape
from camcli.cams.decimals import exact, exactly
from camcli.cams.lash import LashedCam
from camcli.cams.law import POLYNOMIALS, SCCA, TURN, LawCam, SccaLaw, written

DIGITS_OF_EDGES = 80  # of the angles at which a cam passes its seat
ERROR_OF_EDGES = "1e-66"  # rad, more than their rounding
SAME_EDGE = 1e-30  # rad: so near to an end of a part of the cam they are that end
ARCS = {
    "rho1": "base_radius + flank_center",  # of the flank circle
    "x2": "((rho1 - nose_radius)*(rho1 - nose_radius) - flank_center*flank_center"
    " - nose_center*nose_center)/(2*flank_center)",  # of the nose circle's centre
    "y2": "sqrt(nose_center*nose_center - x2*x2)",
    "scale": "rho1/(rho1 - nose_radius)",  # the circles touch on the line through their centres
    "top": "pi - pi*top_dwell_deg/360",
    "b": "top - atan2(y2, x2)",
    "c": "b + atan2(y2*scale, (x2 + flank_center)*scale - flank_center)",
    "low": "base_radius - offset",
    "high": "nose_center + nose_radius - offset",
}
OSCILLATOR = {
    "spring": "stiffness - mass*frequency*frequency",
    "damper": "damping*frequency",
    "share": "amplitude/(spring*spring + damper*damper)",
}


def formula_of(shape: Any, seat_restitution: float | None = None) -> dict[str, Any] | None:
    """The formulas of a cam, or the polynomials of one that was fitted.

    None for one that was fitted and has lash: its polynomials are cut, and rounded anew, where they
    pass the seat. seat_restitution: that of the seat, None where it is that of the cam.
    """
    if getattr(shape, "lash", None) is None:
        return _as_drawn(shape)
    drawn = _as_drawn(shape.as_drawn())
    return None if drawn["kind"] == "pieces" else _seated(shape, drawn, seat_restitution)


def _seated(
    shape: LashedCam, drawn: dict[str, Any], seat_restitution: float | None
) -> dict[str, Any] | None:
    """The formulas of a cam with lash, from those of the cam as it is drawn.

    Its stretches are of two kinds: the lobe is the drawn cam less the lash, the seat is at the
    height of the base circle. The angle at which the cam passes its seat has no formula: it becomes
    one of the cam's numbers, with a bound of its error. seat_restitution: None where it is that of
    the cam. Returns None where the lobe has other stretches than there are formulas.
    """
    with precision(DIGITS_OF_EDGES):
        lobe = [part for part in shape.lobe() if part.end > part.start]
        if len(lobe) != len(drawn["stretches"]):
            return None
        formulas = list(zip(lobe, drawn["stretches"], strict=True))
        numbers = {**drawn["numbers"], "lash": exact(shape.lash or 0.0)}
        base_circle = "low" if drawn["kind"] == "arcs" else "base"
        stretches = []
        for part in shape.parts():
            end = _end_of(part, formulas)
            if end is None:
                end = f"edge{len(numbers)}"
                middle = part.end.mid().str(DIGITS_OF_EDGES - 10, radius=False)
                numbers[end] = f"{middle} +/- {ERROR_OF_EDGES}"
            if part.seat:
                stretches.append({**_stretch(end, [base_circle]), "seat": True})
                continue
            formula = _formula_around(part, formulas)
            level, *slopes = formula["polynomial"]
            lowered = [f"{level} - lash", *slopes]
            stretches.append({**formula, "end": end, "polynomial": lowered})
    restitution = None if seat_restitution is None else exact(seat_restitution)
    return {
        **drawn,
        "numbers": numbers,
        "stretches": stretches,
        "seat_restitution": restitution,
    }


def _end_of(part: Part, formulas: Sequence[tuple[Part, dict[str, Any]]]) -> str | None:
    """The formula of the angle at which a part ends; None where it is not an end of the lobe's."""
    for drawn, formula in formulas:
        if abs(drawn.end - part.end) < SAME_EDGE:
            return formula["end"]
    return None


def _formula_around(part: Part, formulas: Sequence[tuple[Part, dict[str, Any]]]) -> dict[str, Any]:
    """The formula of the part of the lobe in which the middle of a part lies."""
    middle = (part.start + part.end) / 2
    return next(formula for drawn, formula in formulas if drawn.end > middle)


def _as_drawn(shape: Any) -> dict[str, Any]:
    """The formulas of a cam without lash."""
    kind = getattr(shape, "kind", "")
    if kind == "arcs":
        return _arcs(shape)
    if kind == "eccentric":
        round_one = _stretch("2*pi", ["base + lift/2"], wave=("-lift/2", "0", "1"))
        return _cam(kind, _numbers(shape, ("base", "lift")), {}, [round_one])
    if kind == "oscillator":
        names = ("mass", "stiffness", "amplitude", "frequency", "clearance")
        numbers = {"damping": exact(shape.follower_damping), **_numbers(shape, names)}
        steady = _stretch("2*pi", ["-clearance"], wave=("share*spring", "share*damper", "1"))
        return _cam(kind, numbers, OSCILLATOR, [steady])
    return _law(shape) if isinstance(shape, LawCam) else _pieces(shape)


def _cam(
    kind: str, numbers: dict[str, str], formulas: dict[str, str], stretches: list[dict[str, Any]]
) -> dict[str, Any]:
    """A cam as a certificate has it."""
    named = [{"name": name, "formula": formula} for name, formula in formulas.items()]
    return {"kind": kind, "numbers": numbers, "formulas": named, "stretches": stretches,
            "seat_restitution": None}  # fmt: skip


def _stretch(
    end: str,
    polynomial: Sequence[str],
    center: str = "0",
    wave: Sequence[str] = (),
    circle: Sequence[str] = (),
) -> dict[str, Any]:
    """A stretch by its formulas."""
    return {"end": end, "center": center, "polynomial": list(polynomial), "wave": list(wave),
            "circle": list(circle), "seat": False}  # fmt: skip


def _numbers(shape: Any, names: Sequence[str]) -> dict[str, str]:
    """A cam's numbers by name."""
    return {name: exact(getattr(shape, name)) for name in names}


def _arcs(shape: Any) -> dict[str, Any]:
    """Base circle, flank, nose, top dwell, and back: the circles are tangent to one another."""
    names = ("base_radius", "flank_center", "nose_center", "nose_radius", "top_dwell_deg", "offset")
    flank, nose = ("-flank_center", "rho1"), ("nose_center", "nose_radius")
    stretches = [
        _stretch("b", ["low"]),
        _stretch("c", ["-offset"], "b", circle=flank),
        _stretch("top", ["-offset"], "top", circle=nose),
        _stretch("2*pi - top", ["high"]),
        _stretch("2*pi - c", ["-offset"], "2*pi - top", circle=nose),
        _stretch("2*pi - b", ["-offset"], "2*pi - b", circle=flank),
        _stretch("2*pi", ["low"]),
    ]
    return _cam("arcs", _numbers(shape, names), ARCS, stretches)


class Zone(NamedTuple):
    """A part of a law s(x), 0 <= x <= 1, or of the turn, deg: as a stretch is, about its center."""

    start: Fraction
    end: Fraction
    center: Fraction
    polynomial: Sequence[str]
    wave: Sequence[str] = ()


def _law(shape: LawCam) -> dict[str, Any]:
    """Base dwell, rise, top dwell and fall; what goes beyond the turn begins the turn."""
    start = written(shape.rise.start_deg) % TURN
    top = start + written(shape.rise.length_deg)
    fall = top + written(shape.top_dwell_deg)
    end = min(fall + written(shape.fall.length_deg), start + TURN)
    formulas: dict[str, str] = {}
    arcs = [
        *_motion("rise", shape.rise.law, start, top, ("base", "lift"), formulas),
        Zone(top, fall, top, ["base + lift"]),
        *_motion("fall", shape.fall.law, fall, end, ("base + lift", "-lift"), formulas),
        Zone(end, start + TURN, end, ["base"]),
    ]
    turned = [one._replace(start=one.start - turn, end=one.end - turn, center=one.center - turn)
              for one in arcs for turn in (0, TURN)]  # fmt: skip
    within = [one for one in turned if one.start < TURN and one.end > 0 and one.start < one.end]
    stretches = [
        _stretch(_rad(min(one.end, Fraction(TURN))), one.polynomial, _rad(one.center), one.wave)
        for one in sorted(within, key=lambda one: one.start)
    ]
    return _cam("law", _numbers(shape, ("base", "lift")), formulas, stretches)


def _motion(
    name: str,
    law: str | SccaLaw,
    start: Fraction,
    end: Fraction,
    levels: tuple[str, str],
    formulas: dict[str, str],
) -> list[Zone]:
    """The parts of c = low + step s(x) from start to end, deg; levels: low and step.

    Its length in rad, and what its law needs, are put among the formulas.
    """
    low, step = levels
    length = end - start
    formulas[name] = _rad(length)
    if isinstance(law, str) and law in POLYNOMIALS:
        terms = POLYNOMIALS[law]
        zones = [Zone(Fraction(0), Fraction(1), Fraction(0),
                      [str(terms.get(j, 0)) for j in range(max(terms) + 1)])]  # fmt: skip
    elif isinstance(law, str):
        sine, cosine = SCCA[law]
        zones = _scca(name, Fraction(sine), Fraction(cosine), formulas)
    else:
        b = written(law.scca.b)
        zones = _scca(name, b, min(written(law.scca.d), 1 - b), formulas)
    arcs = []
    for zone in zones:
        polynomial = [f"({step})*({a})/({'*'.join([name] * j)})" if j else f"{low} + ({step})*({a})"
                      for j, a in enumerate(zone.polynomial)]  # fmt: skip
        wave = [f"({step})*({zone.wave[0]})", f"({step})*({zone.wave[1]})",
                f"({zone.wave[2]})/{name}"] if zone.wave else []  # fmt: skip
        begin, to, center = (start + length * x for x in zone[:3])
        arcs.append(Zone(begin, to, center, polynomial, wave))
    return arcs


def _scca(name: str, b: Fraction, d: Fraction, formulas: dict[str, str]) -> list[Zone]:
    """The zones of a law whose acceleration is a sine over b/2, constant, a cosine over d, and so
    back: up to a factor sin(pi x/b), 1, and cos(pi y/d), y = x - (1 - d)/2.

    Put among the formulas, each with the name of the motion before it: `sine` = b/pi, `cosine` =
    d/pi, and height and rate where it begins to be constant and where it ends, from the integrals;
    `most`, twice what s(1/2) would be, by which all is divided.
    """
    half = Fraction(1, 2)
    whole = Fraction(1)
    if b == d == half:  # one sine throughout
        return [Zone(0 * half, whole, 0 * half, ["0", "1"], ["0", "-1/(2*pi)", "2*pi"])]
    sine, cosine, height, turn, turning, most = (
        f"{name}_{part}" for part in ("sine", "cosine", "height", "turn", "turning", "most")
    )
    constant = _over((1 - b - d) / 2)
    formulas[sine] = f"{_over(b)}/pi"
    formulas[cosine] = f"{_over(d)}/pi"
    formulas[height] = f"{sine}*{_over(b)}/2 - {sine}*{sine}"
    formulas[turn] = f"{height} + {sine}*{constant} + {constant}*{constant}/2"
    formulas[turning] = f"{sine} + {constant}"
    formulas[most] = f"2*({turn} + {cosine}*{cosine} + {turning}*{_over(d)}/2)"
    first = Zone(0 * half, b / 2, 0 * half, ["0", f"{sine}/{most}"],
                 ["0", f"-{sine}*{sine}/{most}", f"1/{sine}"])  # fmt: skip
    second = Zone(b / 2, (1 - d) / 2, b / 2,
                  [f"{height}/{most}", f"{sine}/{most}", f"1/(2*{most})"])  # fmt: skip
    third = Zone((1 - d) / 2, (1 + d) / 2, (1 - d) / 2,
                 [f"({turn} + {cosine}*{cosine})/{most}", f"{turning}/{most}"],
                 [f"-{cosine}*{cosine}/{most}", "0", f"1/{cosine}"])  # fmt: skip
    zones = [first, second, third, _mirrored(second), _mirrored(first)]
    return [zone for zone in zones if zone.start < zone.end]


def _mirrored(zone: Zone) -> Zone:
    """The zone of 1 - s(1 - x)."""
    terms = [f"-({a})" if j % 2 == 0 else a for j, a in enumerate(zone.polynomial)]
    terms[0] = f"1 - ({zone.polynomial[0]})"
    wave = [f"-({zone.wave[0]})", *zone.wave[1:]] if zone.wave else []
    return Zone(1 - zone.end, 1 - zone.start, 1 - zone.center, terms, wave)


def _over(x: Fraction) -> str:
    """A fraction as a formula."""
    return f"({x.numerator}/{x.denominator})"


def _rad(degrees: Fraction) -> str:
    """An angle as a formula, rad."""
    return f"pi*{_over(degrees / 180)}"


def _pieces(shape: Shape) -> dict[str, Any]:
    """The polynomials of a cam on equal parts of the turn, and its dwells."""
    with precision(DIGITS):
        parts = shape.parts()
    if any(part.lift is not None and not part.pieces for part in parts):
        raise ValueError("a cam without a formula that a certificate knows")
    count = max(
        round(float(2 * arb.pi() * max(1, len(part.pieces)) / (part.end - part.start)))
        for part in parts
    )
    stretches = []
    for part in parts:
        edges = [round(float(x / (2 * arb.pi()) * count)) for x in (part.start, part.end)]
        if not part.pieces:
            stretches.append(_stretch(f"2*pi*{edges[1]}/{count}", [exactly(arb(part.level))]))
        for i, piece in enumerate(part.pieces):
            terms = [exact(x) for x in piece.coefficients]
            while len(terms) > 1 and terms[-1] == "0":
                terms.pop()
            end = f"2*pi*{edges[0] + i + 1}/{count}"
            stretches.append(_stretch(end, terms, exact(piece.center)))
    return _cam("pieces", {}, {}, stretches)
