"""What a run.json, or the key of a run's pieces, says of the run: enough to do it again."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, StringConstraints, ValidationError

from camcli.errors import Fault, SceneError, shown
from camcli.scene import Scene, load_scene

MOST_BYTES = 64 << 20  # of a run.json
ARTEFACT = StringConstraints(pattern=r"^[a-zA-Z0-9_-]{1,64}\.[a-z]{1,8}$")


class Options(BaseModel):
    """What the command line alone decides; all else stands in the scene."""

    model_config = ConfigDict(extra="forbid")

    plot: bool = True
    profile_only: bool = False
    base_radius: float | None = None
    prove: bool = False
    animate: bool = False
    report: bool = False
    with_basins: bool = False
    with_map: bool = False
    source: str = ""

    def arguments(self) -> dict[str, Any]:
        """Arguments of the API function."""
        return self.model_dump(exclude={"plot"}, exclude_unset=True)


class Record(BaseModel):
    """A run; the rest of a run.json is not read."""

    command: Literal["simulate", "sweep", "detach", "orbits", "basins", "classify", "explore"]
    scene: dict[str, Any]
    options: Options = Options()
    artefacts: dict[Annotated[str, ARTEFACT], str] = {}
    program_sha256: str = ""

    def load(self, folder: Path | None, beside: Path) -> Scene:
        """Its scene, files that it names in a folder of the user's, else `beside` the record.

        Only there the user has allowed to look. Raises SceneError.
        """
        cam = self.scene.get("cam")
        outside = isinstance(cam, dict) and cam.get("allow_outside") is True
        allowed = {"cam.allow_outside": True} if folder is not None and outside else {}
        try:
            return load_scene(self.scene, allowed, folder=folder or beside)
        except SceneError as error:
            faults = [
                replace(fault, cure="say with --folder where it is")
                if fault.path == "cam.allow_outside" or "no such file" in fault.found
                else fault
                for fault in error.faults
            ]
            raise SceneError(*faults) from None


def record_of(text: str | bytes, path: Path) -> Record:
    """The record; raises SceneError where the text is none."""
    try:
        return Record.model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        said = ": ".join([*(shown(str(key)) for key in first["loc"]), first["msg"]])
        raise _refusal(path, f"cannot be read ({said})") from None


def read_record(path: Path) -> Record:
    """The record in a file; raises SceneError where it is none of artefacts, or a giant."""
    try:
        if not path.is_file():
            path.stat()  # says what is wrong where there is nothing
            raise _refusal(path, "cannot be read (no file)")
        with open(path, "rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise _refusal(path, f"cannot be read ({error.strerror})") from None
    if len(data) > MOST_BYTES:
        raise _refusal(path, "cannot be read (too large)")
    record = record_of(data, path)
    if not record.artefacts:
        raise _refusal(path, "found no artefacts in it")
    return record


def _refusal(path: Path, found: str) -> SceneError:
    return SceneError(Fault("FILE", str(path), found, "expected the run.json of a run", ""))
