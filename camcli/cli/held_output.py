"""stdout that cannot fail in the middle of a run: held back until the artefacts are in place."""

from __future__ import annotations

import os
import sys
from io import BytesIO, TextIOWrapper
from typing import TextIO


class Held(TextIOWrapper):
    """Text for a stdout that nobody watches; its encoding decides how tables are drawn."""

    def __init__(self, real: TextIO):
        self.bytes = BytesIO()
        super().__init__(self.bytes, encoding=real.encoding, errors=real.errors)
        self.real = real

    def release(self) -> None:
        """Write what was held back; raises OSError, and what is left is then dropped."""
        self.flush()
        held = self.bytes.getvalue()
        self.bytes.seek(0)
        self.bytes.truncate()
        try:
            self.real.buffer.write(held)
            self.real.flush()
        except OSError:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.real.fileno())
            os.close(nowhere)
            raise


def hold_output() -> None:
    """Hold stdout back unless a person watches; a closed one takes everything and shows nothing."""
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115 - for the rest of the process
    elif not sys.stdout.isatty():
        sys.stdout = Held(sys.stdout)
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115


def release_output() -> None:
    """Let stdout go; raises OSError."""
    if isinstance(sys.stdout, Held):
        sys.stdout.release()
    else:
        sys.stdout.flush()
