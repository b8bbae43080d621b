"""The files of a run that proves: proof.json, and its checker beside it."""

import json
from collections.abc import Callable
from functools import partial
from importlib.resources import files
from typing import Any, BinaryIO


def proof_files(
    certificate: dict[str, Any] | None, checker: bool = False
) -> dict[str, Callable[[BinaryIO], Any]]:
    """Functions that write proof.json and, where it is asked for, its checker beside it."""
    if certificate is None:
        return {}
    writers: dict[str, Callable[[BinaryIO], Any]] = {
        "proof.json": partial(_write_proof, certificate)
    }
    if checker:
        writers["check.py"] = _write_checker
    return writers


def _write_proof(certificate: dict[str, Any], file: BinaryIO) -> None:
    """Write proof.json, one statement a line: they come last, behind all other entries."""
    others = {key: value for key, value in certificate.items() if key != "statements"}
    beginning = json.dumps(others, indent=1).removesuffix("\n}")
    lines = ",\n".join(json.dumps(statement) for statement in certificate["statements"])
    file.write(f'{beginning},\n "statements": [\n{lines}\n ]\n}}\n'.encode())


def _write_checker(file: BinaryIO) -> None:
    """Write a copy of camcli/check.py, which runs without camcli."""
    file.write(files("camcli").joinpath("check.py").read_bytes())
