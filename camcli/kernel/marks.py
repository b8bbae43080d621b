"""Marks that make a function part of the kernel; it stays plain Python until it is compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

F = TypeVar("F", bound=Callable)

FUNCTIONS: list[Callable] = []  # of the whole kernel, in the order of their definition
OUTLINED: set[Callable] = set()
ENTRIES: dict[str, Callable] = {}


def inlined(function: F) -> F:
    """A function of the kernel that is compiled into its callers."""
    FUNCTIONS.append(function)
    return function


def outlined(function: F) -> F:
    """A function on a rarely taken path: compiled as a call."""
    OUTLINED.add(function)
    return inlined(function)


def entry(function: F) -> F:
    """A function that Python calls; only these have a compiled copy of their own on disk."""
    ENTRIES[function.__name__] = function
    return inlined(function)
