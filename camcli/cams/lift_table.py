"""`kind: table`: a measured lift, an angle and a lift in each row of a text file.

    c(theta) = base + rocker_ratio * lift(angle),    theta = zero_deg +- angle

Everything about the file stands in the scene; nothing about it is guessed. The lift is smoothed
only as far as the rounding of its digits demands, and what is left of the error of c_thetatheta is
estimated (`lift_fit`).
"""

from __future__ import annotations

import hashlib
import os
from decimal import Decimal
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, ValidationInfo, model_validator

from camcli.cams import decimals
from camcli.cams.compile import Part
from camcli.cams.decimals import Numbers
from camcli.cams.files import read_bytes, refused
from camcli.cams.lift_fit import Accuracy, Errors, Fit, Smoother, noise, piece
from camcli.cams.lift_reading import Reading, Turn, read_turn

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Column = Annotated[int, Field(strict=True, ge=1)] | Annotated[str, Field(min_length=1)]
UNITS = {"m": 1.0, "mm": 1e-3, "inch": 0.0254}
MAX_BYTES = 10_000_000
EXPECTED = "expected a table of angles and lifts"
CHUNK = 8  # pieces of a stretch: its bounds are tighter than those of a whole flank


class TableCam(BaseModel):
    """A measured lift table in a text file beside the scene."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    kind: Literal["table"]
    file: Annotated[str, Field(min_length=1, max_length=1000)] = Field(
        description="text file of the table, from the scene's folder"
    )
    header: Annotated[bool, Field(strict=True)] = Field(
        description="whether its first line names the columns"
    )
    angle_column: Column = Field(description="column of the angle: number from 1, or name")
    lift_column: Column = Field(description="column of the lift: number from 1, or name")
    angle: Literal["cam", "crank"] = Field(
        description="degrees of the cam, or of a crank that turns twice as fast"
    )
    lift: Literal["m", "mm", "inch", "fraction"] = Field(
        description="unit of the lift; fraction: of max_lift"
    )
    max_lift: Annotated[Number, Field(gt=0, le=1e6)] | None = Field(
        None, description="lift where the table says 1, m; only with lift: fraction"
    )
    rocker_ratio: Annotated[Number, Field(gt=0, le=1e3)] = Field(
        1.0, description="lift of the follower per lift in the table"
    )
    zero_deg: Annotated[Number, Field(ge=-1e6, le=1e6)] = Field(
        description="angle of the cam where the table's angle is zero, deg"
    )
    direction: Literal["same", "reversed"] = Field(
        description="whether theta grows or falls with the table's angle"
    )
    base: Annotated[Number, Field(ge=-1e6, le=1e6)] = Field(description="c at zero lift, m")
    base_radius: Annotated[Number, Field(gt=0, le=1e6)] | None = Field(
        None, description="radius of the base circle, m; only the radius of curvature needs it"
    )
    smoothing: Annotated[Number, Field(ge=0, le=1e6)] | None = Field(
        None, description="rms deviation of the cam from the table, m; null: as its rounding asks"
    )
    allow_outside: Annotated[bool, Field(strict=True)] = Field(
        False, description="allow a file outside the scene's folder"
    )
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")] | None = Field(
        None, description="SHA-256 the file must have; null: any"
    )
    _turn: Turn = PrivateAttr()
    _outside: str = PrivateAttr("")

    @model_validator(mode="after")
    def _readable(self, info: ValidationInfo) -> TableCam:
        if (self.lift == "fraction") != (self.max_lift is not None):
            raise ValueError("lift: fraction and max_lift belong together: give both, or neither")
        folder = Path((info.context or {}).get("folder", Path()))
        name = str(folder / self.file)
        self._inside(folder, name)
        cure = "check the name; it is looked for beside the scene"
        data = read_bytes(folder / self.file, name, MAX_BYTES, EXPECTED, cure, "file")
        digest = hashlib.sha256(data).hexdigest()
        if self.sha256 not in (None, digest):
            found = f"found a file with the SHA-256 {digest}"
            cure = "this is not the file the scene was made for; remove sha256 to use it"
            raise refused(name, "sha256", found, f"expected {self.sha256}", cure)
        object.__setattr__(self, "sha256", digest)  # the scene's hash depends on the file's bytes
        self._turn = read_turn(data, name, self._reading())
        return self

    def _inside(self, folder: Path, name: str) -> None:
        """Refuse a file outside the scene's folder unless the scene allows it."""
        try:
            home, place = os.path.realpath(folder), os.path.realpath(folder / self.file)
            inside = os.path.commonpath([home, place]) == home
        except ValueError:  # a name no file can have
            inside = True
        if not inside and not self.allow_outside:
            found = "found a file outside the scene's folder"
            cure = "copy it beside the scene, or write allow_outside: true"
            raise refused(name, "file", found, "expected a file beside the scene", cure)
        self._outside = "" if inside else place

    def _reading(self) -> Reading:
        unit = self.max_lift if self.max_lift is not None else UNITS[self.lift]
        return Reading(
            angle_column=self.angle_column,
            lift_column=self.lift_column,
            header=self.header,
            lift_unit=unit * self.rocker_ratio,
            angle_unit=Decimal("0.5") if self.angle == "crank" else Decimal(1),
            zero_deg=self.zero_deg,
            reversed=self.direction == "reversed",
        )

    @cached_property
    def _fitted(self) -> tuple[Smoother, Fit, float]:
        smoother, sigma = Smoother(self._turn), noise(self._turn)
        if self.smoothing is None:
            return smoother, smoother.balanced(sigma), sigma
        return smoother, smoother.with_rms(self.smoothing), sigma

    @cached_property
    def errors(self) -> Errors:
        """What the fit may have changed."""
        return Errors(*self._fitted)

    @cached_property
    def accuracy(self) -> Accuracy:
        """Rounding found, residuals, and the bound on c_thetatheta."""
        return self.errors.accuracy()

    @property
    def outside(self) -> str:
        """The file's real path where it is not in the scene's folder, else ''."""
        return self._outside

    @property
    def measured(self) -> Turn:
        """The table laid on one turn of the cam; lift above the base."""
        return self._turn

    def parts(self, numbers: Numbers = decimals) -> list[Part]:
        """Dwells, and between them the spline in chunks of equal pieces."""
        smoother, fit, _ = self._fitted
        moving = set(smoother.moving)
        parts, i = [], 0
        while i < smoother.count:
            j = i
            while j < smoother.count and (j in moving) == (i in moving):
                j += 1
            parts += self._chunks(fit.coefficients, i, j, i in moving, numbers)
            i = j
        return parts

    def _chunks(self, coefficients, low: int, high: int, moves: bool, numbers) -> list[Part]:
        count = len(coefficients)

        def phase(i: int) -> Any:
            return 2 * numbers.pi() * i / count

        if not moves:
            level = numbers.number(self.base) + numbers.number(coefficients[low])
            return [Part(phase(low), phase(high), None, level)]
        chunks = []
        for a in range(low, high, CHUNK):
            b = min(a + CHUNK, high)
            pieces = tuple(piece(coefficients, i, self.base) for i in range(a, b))
            chunks.append(Part(phase(a), phase(b), None, pieces=pieces))
        return chunks
