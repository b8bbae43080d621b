"""Unquoted scalars are read as a person means them; odd ones stay text with a cure."""

import math

import pytest

from camcli.scene.scalars import oddity, resolve


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("", None),
        ("~", None),
        ("null", None),
        ("Null", None),
        ("true", True),
        ("TRUE", True),
        ("False", False),
        ("0", 0),
        ("-0", 0),
        ("+5", 5),
        ("700", 700),
        ("1e-3", 1e-3),
        ("1.e-9", 1e-9),
        ("1.0E+3", 1e3),
        (".5", 0.5),
        ("5.", 5.0),
        ("-1.5", -1.5),
        ("1234567890123456789", 1234567890123456789.0),
        ("1e999", math.inf),
        ("inf", math.inf),
        ("-.inf", -math.inf),
        ("+.INF", math.inf),
    ],
)
def test_scalar_with_a_meaning(text, value):
    found = resolve(text)
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize("text", ["nan", ".nan", ".NaN", "-nan"])
def test_nan_is_a_float_that_validation_refuses(text):
    assert math.isnan(resolve(text))


@pytest.mark.parametrize(
    ("text", "cure"),
    [
        ("1:30", "base 60"),
        ("660:760", "base 60"),
        ("010", "leading zeros"),
        ("0x1F", "decimal"),
        ("0b1", "decimal"),
        ("1_000", "underscores"),
        ("1,5", "decimal point"),
        ("1d-3", "with e"),
        ("700 rpm", "unit"),
        ("1.2kg", "unit"),
        ("1/3", "expressions"),
        ("−5", "ASCII"),
        ("on", "plain text"),
        ("Off", "plain text"),
        ("yes", "plain text"),
        ("no", "plain text"),
        ("something else", ""),
        (".", ""),
        ("e5", ""),
        ("١", ""),
    ],
)
def test_odd_scalar_stays_text(text, cure):
    assert resolve(text) == text
    assert cure in oddity(text)
    assert bool(cure) == bool(oddity(text))


def test_quoted_number_is_told_to_lose_its_quotes():
    assert oddity("1e-3") == "remove the quotes"


def test_a_hundred_thousand_digits_cost_nothing():
    assert resolve("1" * 100_000) == math.inf
    assert resolve("0." + "1" * 100_000) == pytest.approx(1 / 9)
