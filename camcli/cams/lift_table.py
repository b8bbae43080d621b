"""`kind: table`: a measured lift, an angle and a lift in each row of a text file.

    c(theta) = base + lift_scale * rocker_ratio * lift(angle),    theta = zero_deg +- angle

of a table measured at the lobe; one measured at the valve is that of the follower as it is, and
rocker_ratio only says how much less the lobe lifts.

Everything about the file stands in the scene; nothing about it is guessed. The lift is smoothed
only as far as the rounding of its digits demands, and what is left of the error of c_thetatheta is
estimated (`lift_fit`).
"""

from __future__ import annotations

import hashlib
import os
from dataclasses import replace
from functools import cached_property, lru_cache
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from flint import arb
from pydantic import Field, PrivateAttr, ValidationInfo, model_validator

from camcli.cams.compile import Part, build
from camcli.cams.files import read_bytes, refused
from camcli.cams.lash import LashedCam
from camcli.errors import SceneError
from camcli.quantities import LENGTHS

if TYPE_CHECKING:
    import numpy as np

    from camcli.cams.lift_fit import Accuracy, Errors
    from camcli.cams.lift_reading import Turn
    from camcli.kernel.cam_table import Cam

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Column = Annotated[int, Field(strict=True, ge=1)] | Annotated[str, Field(min_length=1)]
Flag = Annotated[bool, Field(strict=True)]
MAX_BYTES = 10_000_000
CHUNK = 8  # pieces of a stretch: its bounds are tighter than those of a whole flank
REMEMBERED = 8  # fits

if TYPE_CHECKING:
    LiftUnit = str
else:
    LiftUnit = Literal[(*LENGTHS, "fraction")]


class TableCam(LashedCam):
    """A measured lift table in a text file beside the scene.

    Examples
    --------
    A scene reads the file; `configs/lift-table.yaml` is shipped with one.

    >>> import camcli
    >>> cam = camcli.load_scene("configs/lift-table.yaml").cam
    >>> cam.file
    'valve-lift.csv'
    >>> cam.lift, cam.angle
    ('inch', 'crank')
    """

    kind: Literal["table"]
    file: Annotated[str, Field(min_length=1, max_length=1000)] = Field(
        description="text file of the table, from the scene's folder"
    )
    header: Flag | Annotated[int, Field(strict=True, ge=0, le=100)] = Field(
        description="whether its first line names the columns, or how many lines do"
    )
    skip_lines: Annotated[int, Field(strict=True, ge=0, le=100_000)] = Field(
        0, description="lines of the file before the header"
    )
    decimal: Literal["point", "comma"] = Field(
        "point", description="what separates the decimals of a number"
    )
    angle_column: Column = Field(description="column of the angle: number from 1, or name")
    lift_column: Column = Field(description="column of the lift: number from 1, or name")
    angle: Literal["cam", "crank"] = Field(
        description="degrees of the cam, or of a crank that turns twice as fast"
    )
    lift: LiftUnit = Field(description="unit of the lift; thou: 0.001 inch; fraction: of max_lift")
    subtract: Annotated[Number, Field(ge=-1e6, le=1e6)] = Field(
        0.0, description="number of the table at zero lift: of radii that of the base circle"
    )
    max_lift: Annotated[Number, Field(gt=0, le=1e6)] | None = Field(
        None, description="lift where the table says 1, m; only with lift: fraction"
    )
    lift_scale: Annotated[Number, Field(gt=0, le=1e3)] = Field(
        1.0, description="factor on every lift of the table, to vary it; 1: as measured"
    )
    mirrored: Flag = Field(
        False,
        description="whether the table is one flank, from the base circle to the nose or back, and "
        "the other flank its mirror image",
    )
    rocker_ratio: Annotated[Number, Field(gt=0, le=1e3)] = Field(
        1.0, description="lift of the follower, a valve, per lift of the lobe; 1: no rocker"
    )
    measured_at: Literal["lobe", "valve"] = Field(
        "lobe", description="on which side of a rocker the table was measured"
    )
    zero_deg: Annotated[Number, Field(ge=-1e6, le=1e6)] = Field(
        description="angle of the cam where the table's angle is zero, deg"
    )
    direction: Literal["same", "reversed"] = Field(
        description="whether theta grows or falls with the table's angle"
    )
    base: Annotated[Number, Field(ge=-1e6, le=1e6)] = Field(description="c at zero lift, m")
    base_radius: Annotated[Number, Field(gt=0, le=1e6)] | None = Field(
        None, description="radius of the base circle, m; only the shape of the lobe needs it"
    )
    smoothing: Annotated[Number, Field(ge=0, le=1e6)] | None = Field(
        None, description="rms deviation of the cam from the table, m; null: as its rounding asks"
    )
    allow_outside: Flag = Field(
        False, description="allow a file outside the scene's folder; on the command line only"
    )
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")] | None = Field(
        None, description="SHA-256 the file must have; null: any"
    )
    _turn: Turn = PrivateAttr()
    _outside: str = PrivateAttr("")
    _folder: Path = PrivateAttr(Path())

    @model_validator(mode="after")
    def _readable(self, info: ValidationInfo) -> TableCam:
        """Read the file beside the scene, check its digest, and keep the turn that it holds.

        The context of the validation says in which folder the scene is, and whether a file outside
        it is permitted. Raises SceneError; what a file outside the scene's folder holds is not
        shown.
        """
        if (self.lift == "fraction") != (self.max_lift is not None):
            raise ValueError("lift: fraction and max_lift belong together: give both, or neither")
        context = info.context or {}
        self._folder = context.get("folder", Path())
        self._check_place(bool(context.get("permitted")))
        path = self._folder / self.file
        name = str(path)
        expected = "expected a table of angles and lifts"
        cure = "check the name; it is looked for beside the scene"
        data = read_bytes(path, name, MAX_BYTES, expected, cure, "file")
        digest = hashlib.sha256(data).hexdigest()
        if self.sha256 not in (None, digest):
            found = f"found a file with the SHA-256 {digest}"
            cure = "this is not the file the scene was made for; remove sha256 to use it"
            raise refused(name, "sha256", found, f"expected {self.sha256}", cure)
        object.__setattr__(self, "sha256", digest)  # the scene's hash depends on the file's bytes
        from camcli.cams.lift_reading import read_turn

        try:
            self._turn = read_turn(data, name, self)
        except SceneError as error:  # what a file of somebody else holds is not shown
            if not self._outside:
                raise
            found = "found what is no lift table (not shown: it lies outside the scene's folder)"
            first = replace(error.faults[0], found=found, expected="", cure="")
            raise SceneError(first) from None
        return self

    def _check_place(self, permitted: bool) -> None:
        """Find out whether the file lies outside the scene's folder, where it must be permitted.

        permitted: whether the command line allows a file outside; the scene alone cannot. Raises
        SceneError.
        """
        name = str(self._folder / self.file)
        try:
            home = os.path.realpath(self._folder)
            place = os.path.realpath(self._folder / self.file)
            self._outside = "" if os.path.commonpath([home, place]) == home else place
        except ValueError:  # a name no file can have
            pass
        if self._outside and not self.allow_outside:
            found = "found a file outside the scene's folder"
            cure = "copy it beside the scene, or add --set cam.allow_outside=true"
            raise refused(name, "file", found, "expected a file beside the scene", cure)
        if self.allow_outside and not permitted:
            found = "found true in the scene itself"
            expected = "expected it on the command line"
            cure = "remove it, and add --set cam.allow_outside=true"
            raise refused(name, "allow_outside", found, expected, cure)

    @cached_property
    def errors(self) -> Errors:
        """The fit, and bounds on what it may have changed; remembered for equal tables."""
        return _fitted(self)

    @cached_property
    def accuracy(self) -> Accuracy:
        """Rounding found, residuals, and the bound on c_thetatheta."""
        return self.errors.accuracy

    @cached_property
    def least_lift(self) -> float:
        """The least lift above the base circle that the table tells from none, m.

        It is its last digit, or three standard deviations of its rows where they scatter more.
        """
        from camcli.cams.lift_fit import ERRORS

        return max(self.measured.quantum, ERRORS * self.errors.noise)

    @property
    def metres(self) -> float:
        """Lift of the follower, m, where the table has a lift of 1."""
        behind = self.rocker_ratio if self.measured_at == "lobe" else 1.0
        return (self.max_lift or LENGTHS[self.lift]) * behind * self.lift_scale

    @cached_property
    def rougher(self) -> tuple[TableCam, Cam]:
        """(the table with a rougher fit of its rows, that cam compiled)."""
        other = self.model_copy()
        other.__dict__["errors"] = self.errors.rougher  # in the place of its cached property
        return other, build(other)

    def with_lifts(self, lifts: np.ndarray) -> TableCam:
        """The table fitted, with the same smoothing lengths, to other lifts of its rows.

        lifts: m above the base, one for each row of `measured`, which stays that of the file.
        """
        from camcli.cams.lift_fit import Errors, Smoother

        other = self.model_copy()
        for cached in ("errors", "accuracy", "least_lift", "rougher"):  # all that the fit decides
            other.__dict__.pop(cached, None)
        rows = replace(self.measured, lift=lifts)
        other.__dict__["errors"] = Errors(Smoother(rows), self.errors.given)
        return other

    @property
    def outside(self) -> str:
        """The file's real path where it is not in the scene's folder, else ''."""
        return self._outside

    @property
    def folder(self) -> Path:
        """The scene's, where the file is looked for."""
        return self._folder

    @property
    def measured(self) -> Turn:
        """The table laid on one turn of the cam; lift above the base."""
        return self._turn

    @property
    def base_level(self) -> arb:
        """c on the base circle, m."""
        return arb(self.base)

    def lobe(self) -> list[Part]:
        """Dwells, and between them the spline in chunks of equal pieces.

        The spline has a polynomial for each interval between knots. An interval moves unless all
        its coefficients are held at the level of a dwell.
        """
        smoother = self.errors.smoother
        moving = set(smoother.moving.tolist())
        parts = []
        for moves, group in groupby(range(smoother.count), moving.__contains__):
            intervals = list(group)  # side by side, all of them moving or all in a dwell
            size = CHUNK if moves else len(intervals)
            chunks = [intervals[k : k + size] for k in range(0, len(intervals), size)]
            parts += [self._part_of(chunk, moves) for chunk in chunks]
        return parts

    def _part_of(self, intervals: list[int], moves: bool) -> Part:
        """The part of the cam on intervals of the spline side by side: its pieces, or a dwell."""
        from camcli.cams.lift_fit import piece

        count = self.errors.smoother.count
        coefficients = self.errors.coefficients
        low = 2 * arb.pi() * intervals[0] / count
        high = 2 * arb.pi() * (intervals[-1] + 1) / count
        if moves:
            pieces = tuple(piece(coefficients, i, self.base) for i in intervals)
            return Part(low, high, None, pieces=pieces)
        level = arb(self.base) + float(coefficients[intervals[0]])
        return Part(low, high, None, level)


@lru_cache(maxsize=REMEMBERED)
def _fitted(table: TableCam) -> Errors:
    """The fit of a table; its fields, with the digest of the file, tell it from others."""
    from camcli.cams.lift_fit import Errors, Smoother, scatter

    smoother = Smoother(table.measured)
    rms = table.smoothing
    if rms is not None:
        return Errors(smoother, smoother.with_rms(rms))
    return Errors(smoother, smoother.balanced(scatter(table.measured)))
