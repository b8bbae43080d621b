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
    made: dict[str, Callable[[BinaryIO], Any]] = {"proof.json": partial(_write_proof, certificate)}
    if checker:
        made["check.py"] = _write_checker
    return made


def _write_proof(certificate: dict[str, Any], file: BinaryIO) -> None:
    """Write proof.json, one statement a line."""
    statements = [json.dumps(one) for one in certificate["statements"]]
    rest = {key: value for key, value in certificate.items() if key != "statements"}
    text = json.dumps(rest, indent=1)[:-2] + ',\n "statements": [\n' + ",\n".join(statements)
    file.write(f"{text}\n ]\n}}\n".encode())


def _write_checker(file: BinaryIO) -> None:
    """Write a copy of camcli/check.py, which runs without camcli."""
    file.write(files("camcli").joinpath("check.py").read_bytes())
