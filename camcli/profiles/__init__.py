"""Cam kinds: one file per kind, registered in `CAMS`.

A kind is a pydantic model with a literal `kind`, geometry checks that raise ValueError, and
`parts()`: the smooth parts of one turn. Everything else is done from those parts.
"""

from camcli.profiles.arcs import ArcsCam
from camcli.profiles.eccentric import EccentricCam
from camcli.profiles.law import LawCam
from camcli.profiles.lift_table import TableCam

CAMS = (ArcsCam, LawCam, EccentricCam, TableCam)
