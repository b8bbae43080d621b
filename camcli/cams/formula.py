"""A cam as a certificate has it: the numbers of its closed formula (`camcli.check` knows these)."""

from collections.abc import Sequence
from typing import Any

from flint import arb

from camcli.cams.balls import precision
from camcli.cams.compile import DIGITS, Shape
from camcli.cams.decimals import decimal, exact, exactly
from camcli.cams.law import LawCam, SccaLaw, written


def formula_of(shape: Any) -> dict[str, Any] | None:
    """The numbers of a cam's closed formula, or the polynomials of one that was fitted.

    None for a cam with lash, whose seat is not among them.
    """
    if getattr(shape, "lash", None) is not None:
        return None
    kind = getattr(shape, "kind", "")
    if kind == "arcs":
        names = (
            "base_radius",
            "flank_center",
            "nose_center",
            "nose_radius",
            "top_dwell_deg",
            "offset",
        )
        return _numbers(shape, kind, names)
    if kind == "eccentric":
        return _numbers(shape, kind, ("base", "lift"))
    if kind == "oscillator":
        free = ("mass", "stiffness", "amplitude", "frequency", "clearance")
        return {"damping": exact(shape.follower_damping), **_numbers(shape, kind, free)}
    if isinstance(shape, LawCam):
        degrees = {
            "start_deg": shape.rise.start_deg,
            "rise_deg": shape.rise.length_deg,
            "top_dwell_deg": shape.top_dwell_deg,
            "fall_deg": shape.fall.length_deg,
        }
        laws = {"rise_law": _law(shape.rise.law), "fall_law": _law(shape.fall.law)}
        as_written = {key: decimal(written(x)) for key, x in degrees.items()}
        return {**_numbers(shape, kind, ("base", "lift")), **laws, **as_written}
    return _pieces(shape)


def _numbers(shape: Any, kind: str, names: Sequence[str]) -> dict[str, Any]:
    """A cam's numbers by name."""
    return {"kind": kind, **{name: exact(getattr(shape, name)) for name in names}}


def _law(law: str | SccaLaw) -> Any:
    """The name of a law, or its widths of sine and cosine."""
    if not isinstance(law, SccaLaw):
        return law
    b = written(law.scca.b)
    return {"b": decimal(b), "d": decimal(min(written(law.scca.d), 1 - b))}


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
    pieces = []
    for part in parts:
        first, last = (round(float(x / (2 * arb.pi()) * count)) for x in (part.start, part.end))
        if not part.pieces:
            level = {"center": "0", "coefficients": [exactly(arb(part.level))]}
            pieces.append({"first": first, "last": last, **level})
        for i, piece in enumerate(part.pieces):
            numbers = [exact(x) for x in piece.coefficients]
            while len(numbers) > 1 and numbers[-1] == "0":
                numbers.pop()
            at = {"first": first + i, "last": first + i + 1, "center": exact(piece.center)}
            pieces.append({**at, "coefficients": numbers})
    return {"kind": "pieces", "count": count, "pieces": pieces}
