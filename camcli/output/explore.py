"""explore.html: one page with the data of the motions in it, which needs no other file.

`explore.html` beside this file is the page without the data: its style and its script.
"""

import json
from base64 import b64encode
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

import numpy as np

from camcli.output.run_record import plain
from camcli.plots import style

COLOURS = {
    "flight": style.FLIGHT, "sticking": style.STICKING, "impact": style.IMPACT,
    "chatter": style.CHATTER, "detachment": style.DETACHMENT, "trouble": style.TROUBLE,
    "cam": style.CAM, "body": style.CAM_BODY, "guide": style.GUIDE, "force": style.FORCES[2],
    **{f"period{k}": colour for k, colour in enumerate(style.PERIODS, 1)},
    "longer": style.LONGER, "aperiodic": style.APERIODIC,
}  # fmt: skip


def page(data: Mapping[str, Any]) -> str:
    """The page that shows the data: plain values, and NumPy arrays of numbers or flags."""
    template = (files("camcli.output") / "explore.html").read_text(encoding="utf-8")
    colours = " ".join(f"--{name}: {colour};" for name, colour in COLOURS.items())
    text = json.dumps(plain(data), separators=(",", ":"), allow_nan=False, default=_packed)
    return template.replace("/*COLOURS*/", colours).replace(
        "/*DATA*/", text.replace("<", "\\u003c")
    )


def _packed(array: np.ndarray) -> dict[str, str]:
    """An array as base64 of float32 or uint8."""
    kind = "f4" if array.dtype.kind == "f" else "u1"
    return {kind: b64encode(array.astype(f"<{kind}").tobytes()).decode()}
