"""What tests of the checker make by hand: balls of mpmath's numbers, formulas and cams."""

from __future__ import annotations

import ast
from fractions import Fraction
from types import SimpleNamespace as Made

from flint import arb
from mpmath import mp, mpf

from camcli import check

NEAR = arb("1e-60")


def ball(x) -> arb:
    """A number of mpmath as a ball."""
    return arb(mp.nstr(mpf(x), 80))


def near(found, expected) -> bool:
    """Whether a ball is a number but for roundings."""
    return bool(abs(found - ball(expected)) < NEAR) and bool(arb(found.rad()) < NEAR)


def refusal(ask, *asked) -> str:
    """Why a part of the checker refuses, or nothing."""
    try:
        ask(*asked)
    except check.RefusedError as why:
        return str(why)
    return ""


def expression(text: str):
    return Fraction(text) if check.NUMBER.fullmatch(text) else ast.parse(text, mode="eval").body


def source(*rows: dict, numbers=None, formulas=(), seat_restitution=None):
    """The entry of a cam: rows with the end and what is not the usual of each stretch."""
    usual = {"center": "0", "polynomial": ["1"], "wave": [], "circle": [], "seat": False}
    stretches = []
    for row in rows:
        values = {**usual, **row}
        stretches.append(Made(
            seat=values["seat"], end=expression(values["end"]),
            center=expression(values["center"]),
            **{key: [expression(x) for x in values[key]]
               for key in ("polynomial", "wave", "circle")},
        ))  # fmt: skip
    return Made(
        kind="law", numbers=numbers or {}, stretches=stretches, seat_restitution=seat_restitution,
        formulas=[Made(name=name, formula=expression(text)) for name, text in formulas],
    )  # fmt: skip
