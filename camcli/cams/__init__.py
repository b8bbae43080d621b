"""Cam kinds: one file per kind, registered in `AnyCam`.

A kind is a pydantic model with a literal `kind`, geometry checks that raise ValueError, and
`parts()`: the smooth parts of one turn, in balls of as many digits as are in use. Everything else
is done from those parts.
"""

from typing import get_args

from camcli.cams.arcs import ArcsCam
from camcli.cams.eccentric import EccentricCam
from camcli.cams.law import LawCam
from camcli.cams.lift_table import TableCam
from camcli.cams.oscillator import OscillatorCam

AnyCam = ArcsCam | LawCam | EccentricCam | TableCam | OscillatorCam
CAMS = get_args(AnyCam)


def cam_name(cam: AnyCam) -> str:
    """What a cam is called beside others: its file, its law or its kind.

    Examples
    --------
    >>> from camcli.cams import EccentricCam, cam_name
    >>> cam_name(EccentricCam(kind="eccentric", base=0.0, lift=0.02))
    'eccentric'
    """
    if isinstance(cam, TableCam):
        return cam.file
    law = cam.rise.law if isinstance(cam, LawCam) else None
    return law if isinstance(law, str) else cam.kind
