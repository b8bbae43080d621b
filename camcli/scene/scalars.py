"""Plain YAML scalars read as a person means them, and what is odd about those that are not.

YAML 1.1 reads `1:30` as 90, `010` as 8, `on` as true and `1e-3` as text. Here `1e-3` is a
number and the others stay text, so that validation can say what is wrong with them.
"""

from __future__ import annotations

import re

Scalar = None | bool | int | float | str

_INTEGER = re.compile(r"[+-]?(?:0|[1-9][0-9]*)")
_FLOAT = re.compile(
    r"[+-]?(?:(?:[0-9]+\.[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|[0-9]+[eE][+-]?[0-9]+)"
)
_NOT_FINITE = re.compile(r"[+-]?\.?(?:nan|inf|infinity)", re.IGNORECASE)
_WORDS = {"": None, "~": None, "null": None, "true": True, "false": False}
_LONGEST_INTEGER = 18  # digits; above, no field takes it and int() of 10^5 digits is slow

_ODDITIES = (
    (r"[+-]?\d+(:\d+)+(\.\d*)?", "base 60 is not read, write a decimal number"),
    (r"[+-]?0[xobXOB][0-9a-fA-F_]+", "write the number in decimal"),
    (r"[+-]?0\d+", "write the number without leading zeros (it could mean octal)"),
    (r"[+-]?[\d.]+(_[\d.]+)+", "leave out the underscores"),
    (r"[+-]?\d+(,\d+)+", "write a decimal point, and no separators between thousands"),
    (r"[+-]?[\d.]+[dD][+-]?\d+", "write the exponent with e"),
    (r"[−–]\s*[\d.]+.*", "write the minus sign as an ASCII -"),
    (r"[+-]?[\d.]+([eE][+-]?\d+)?\s*[^\W\d].*", "write the number without its unit"),
    (r"[+-]?[\d.]+\s*[-+*/^].*", "write the value out, expressions are not evaluated"),
    (r"(?i:on|off|yes|no|y|n)", "this word is plain text here, not a switch"),
)


def resolve(text: str) -> Scalar:
    """Value of an unquoted scalar: null, true or false, a number, or the text itself."""
    if len(text) <= 5 and text.lower() in _WORDS:
        return _WORDS[text.lower()]
    if _INTEGER.fullmatch(text):
        return int(text) if len(text) <= _LONGEST_INTEGER else float(text)
    if _FLOAT.fullmatch(text):
        return float(text)
    if _NOT_FINITE.fullmatch(text):
        return float(text.replace(".", ""))
    return text


def oddity(text: str) -> str:
    """What to do about a text that stands where a number is expected ('' when unknown)."""
    if not isinstance(resolve(text), str):
        return "remove the quotes" if text else "give a value"
    for pattern, cure in _ODDITIES:
        if len(text) <= 100 and re.fullmatch(pattern, text.strip()):
            return cure
    return ""
