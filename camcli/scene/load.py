"""A scene from its source and what overrides it: valid as a whole, or every fault at once."""

import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

from pydantic import ValidationError

from camcli.cams import CAMS
from camcli.cams.files import decoded, read_bytes
from camcli.cams.oscillator import OscillatorCam
from camcli.errors import Fault, SceneError, shown
from camcli.quantities import SHAFTS
from camcli.scene.document import (
    MAX_DEPTH,
    Document,
    Finding,
    Mark,
    document_of,
    oddity,
    parse,
    scalar,
)
from camcli.scene.schema import FASTEST, SLOWEST, VARYING, Scene
from camcli.scene.speeds import CRANK, of_a_shaft

MAX_BYTES = 256_000  # a scene is a few kB
MAX_FAULTS = 100  # a file with more is not a scene; the last fault then says how many

OUTSIDE = {"cam", "cam.allow_outside"}  # what of the command line may allow other files

WrittenSpeed = float | str  # rpm of the cam, or a text such as `6000 crank`

_FORM = "expected path.to.key=value"
_SPEED = f"expected a speed from {SLOWEST:g} to {FASTEST:g} turns per minute, or a range LO:HI"


def load_scene(
    source: str | os.PathLike | Mapping[str, Any] | None = None,
    overrides: Mapping[str, Any] | Sequence[str] = (),
    options: Mapping[str, tuple[Any, str]] | None = None,
    *,
    folder: str | os.PathLike = "",
    command: str = "",
) -> Scene:
    """Read, override and validate a scene.

    Parameters
    ----------
    source
        Path of a YAML file, the same as a dict, or None for the scene shipped with the package.
        `configs/NAME.yaml` is the example shipped of that name where no such file is here.
    overrides
        Values by dotted path, `{"run.rpm": 700}`; or texts of `--set`, `["run.rpm=700"]`, whose
        values are read as YAML. A later one beats an earlier one, and all beat the source.
    options
        Values of the command line's options by dotted path, as (value, name of the option). They
        beat the overrides.
    folder
        Where a lift table that a dict names is looked for; beside the file for a path.
    command
        What the scene is for, where that is known: a fault then names only panels that it draws.

    Raises
    ------
    SceneError
        With every fault, those of the source first, each with its place and what to do.

    Examples
    --------
    >>> import camcli
    >>> scene = camcli.load_scene(None, {"run.rpm": 700})
    >>> scene.run.rpm
    700.0
    >>> scene.cam.kind
    'arcs'
    """
    if isinstance(source, Mapping):
        document = document_of(source, Mark(0, "scene"))
        home = Path(folder)
    else:
        file = default_scene_path() if source is None else here_or_shipped(Path(source))
        document = _read(file)
        home = file.parent
    read = bool(not document.findings or document.data is not None)
    if read and not isinstance(document.data, dict):
        document.findings.append(_no_map(document))
        read = False
    if not read:
        document.data = {}  # the command line is checked all the same
    if read and "scene_sha256" in document.data:
        found, cure = "found the run.json of a run", "give it to cam rerun, or copy its `scene`"
        raise SceneError(Fault(document.place(()).value.name, "", found, "expected a scene", cure))
    findings = [*document.findings, *_override(document, overrides, {})]
    hidden = set(options or {}) & {str(text).partition("=")[0].strip() for text in overrides}
    if read and hidden and not findings:
        findings += _faults_at(hidden, document, {"folder": home, "permitted": True})
    findings += _override(document, (), options or {}, len(overrides))
    if read:
        try:
            # A cam that names a file finds it beside the scene; elsewhere the user alone allows.
            names = {str(text).partition("=")[0].strip() for text in (*overrides, *(options or ()))}
            permitted = not names.isdisjoint(OUTSIDE)
            context = {"folder": home, "permitted": permitted, "command": command}
            scene = Scene.model_validate(document.data, strict=True, context=context)
        except ValidationError as error:
            from camcli.scene.faults import findings as translated

            findings += translated(document, error)
        else:
            if not findings:
                return scene
    raise _error(findings)


def _faults_at(paths: set[str], document: Document, context: dict[str, Any]) -> list[Finding]:
    """The faults of the scene at these dotted paths.

    They are looked for before an option replaces, and so hides, what --set has put there.
    """
    from camcli.scene.faults import findings as translated

    try:
        Scene.model_validate(document.data, strict=True, context={**context, "command": ""})
    except ValidationError as error:
        found = translated(document, error)
        return [item for item in found if ".".join(map(str, item.path)) in paths]
    return []


def default_scene_path() -> Path:
    """The default scene, the cam-follower example: in the package (wheel) or beside (checkout)."""
    package = Path(__file__).resolve().parents[1]
    inside = package / "configs" / "chapter.yaml"
    return inside if inside.is_file() else package.parent / "configs" / "chapter.yaml"


def here_or_shipped(path: Path) -> Path:
    """The path; one of configs/ that is not in the working folder is the example shipped.

    So the commands of the guide run from an installed program too, outside a checkout.
    """
    if path.parts[:1] != ("configs",) or os.path.lexists(path):
        return path
    shipped = default_scene_path().parent.joinpath(*path.parts[1:])
    return shipped if os.path.isfile(shipped) else path


def resolved(scene: Scene) -> dict[str, Any]:
    """The full scene, defaults included, as plain values that JSON can hold.

    Of an oscillator the follower's constants and the speeds are left out: they follow from its cam.
    """
    values = scene.model_dump(mode="json")
    if isinstance(scene.cam, OscillatorCam):
        values["follower"] = {"restitution": scene.follower.restitution}
        values["spring"] = None
        del values["run"]["rpm"]
        for name in (*VARYING, "detach"):
            values[name]["rpm"] = {"num": values[name]["rpm"]["num"]}
    return values


def scene_hash(scene: Scene) -> str:
    """SHA-256 of the full scene: the same on every machine, order and notation do not matter."""
    import hashlib
    import json

    text = json.dumps(resolved(scene), sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def parse_rpm(text: str, option: str = "--rpm") -> WrittenSpeed | tuple[WrittenSpeed, WrittenSpeed]:
    """A speed `X` or a range `LO:HI` (either order), in turns per minute of the cam.

    One of the crank stays a text, `6000 crank`, which the scene reads. A shaft that stands behind
    the range alone, `5000:6000 crank`, is that of both ends.
    """

    def refused(cure: str) -> SceneError:
        return SceneError(Fault(option, "", f"found '{shown(text)}'", _SPEED, cure))

    parts = [part.strip() for part in text.split(":")]
    if re.fullmatch(r"[\d.]+\s*(-|\.\.|,|to)\s*[\d.]+", text):
        raise refused("write a range with a colon, as 660:760")
    if len(parts) > 2:
        raise refused("give the number of speeds with --points")
    last = of_a_shaft(parts[-1])
    speeds: list[WrittenSpeed] = []
    for part in parts:
        written = of_a_shaft(part)
        if written is None and last is not None:
            _, shaft = last
            written = of_a_shaft(f"{part} {shaft}")
        value = scalar(part) if written is None else written[0]
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise refused(oddity(part) or "write it as 700, 660:760 or 6000crank")
        if written is not None and last is None:
            raise refused(f"write {written[1]} behind the second end, or behind both")
        rpm = value if written is None else value * SHAFTS[written[1]]
        if not SLOWEST <= rpm <= FASTEST:
            raise refused("give a speed in this range")
        is_of_crank = written is not None and written[1] == CRANK
        speeds.append(f"{float(value)!r} {CRANK}" if is_of_crank else float(value))
    return speeds[0] if len(speeds) == 1 else (speeds[0], speeds[1])


def _read(file: Path) -> Document:
    """A scene file with its places; `-` is stdin. What cannot be read becomes a finding."""
    name = shown(str(file), 500)
    cure = "check the name, or leave out -c for the default scene"
    try:
        if name == "-" and sys.stdin is None:
            cure = "pipe one into it, or name a file"
            raise SceneError(Fault("stdin", "", "found it closed", "expected a scene", cure))
        if name == "-":
            name = "stdin"
            data = sys.stdin.buffer.read(MAX_BYTES + 1)
            if len(data) > MAX_BYTES:  # its beginning alone would be another scene
                size = f"{MAX_BYTES // 1000} kB"
                cure = "is this the right file?"
                found, expected = f"found more than {size}", f"expected at most {size}"
                raise SceneError(Fault(name, "", found, expected, cure))
        else:
            data = read_bytes(file, name, MAX_BYTES, "expected a YAML file", cure)
        text = decoded(data, name)
    except SceneError as error:
        document = Document(Mark(0, name))
        document.findings += [
            Finding(Mark(0, f.where), (), f.found, f.expected, f.cure) for f in error.faults
        ]
        return document
    return parse(text, name)


def _no_map(document: Document) -> Finding:
    """The finding for a file whose content is not a map of sections."""
    kind = "list" if isinstance(document.data, list) else "single value"
    found = "found nothing in this file" if document.data is None else f"found a {kind}"
    expected = f"expected a map with the sections {', '.join(Scene.model_fields)}"
    return Finding(document.place(()).value, (), found, expected, "start from follower: and cam:")


def _overriding(
    overrides: Mapping[str, Any] | Sequence[str],
    options: Mapping[str, tuple[Any, str]],
    ranked: int,
) -> Iterator[tuple[str, Document]]:
    """(dotted path, value) of every override and then every option, with its own mark."""
    if isinstance(overrides, Mapping):
        for rank, (path, value) in enumerate(overrides.items(), 1):
            yield str(path), document_of(value, Mark(rank, "overrides"))
    else:
        for rank, text in enumerate(overrides, 1):
            name = f"--set {shown(text)}"
            path, equals, value = text.partition("=")
            document = parse(value, name, rank, numbered=False)
            odd = _has_odd_bytes(text)
            if odd or not equals:
                cure = "write the key, an = and the value without blanks between"
                found = "found bytes that are no UTF-8 text" if odd else "found no '='"
                cure = "type it again" if odd else cure
                document.findings = [Finding(Mark(rank, name), (), found, _FORM, cure)]
                path = ""
            yield path, document
    for rank, (path, (value, name)) in enumerate(options.items(), ranked + len(overrides) + 1):
        document = document_of(value, Mark(rank, name))
        if isinstance(value, str) and _has_odd_bytes(value):
            found, expected = f"found '{shown(value)}', no UTF-8 text", "expected a name in UTF-8"
            document.findings = [Finding(Mark(rank, name), (), found, expected, "rename the file")]
        yield path, document


def _has_odd_bytes(text: str) -> bool:
    """Whether a text of the command line holds bytes that are no UTF-8."""
    return any("\ud800" <= character <= "\udfff" for character in text)


def _override(
    document: Document,
    overrides: Mapping[str, Any] | Sequence[str],
    options: Mapping[str, tuple[Any, str]],
    ranked: int = 0,
) -> list[Finding]:
    """Put every override where it belongs; the faults of those that cannot be read.

    ranked: so many were put before these. Where overrides change `cam.kind`, keys of the source
    that the new kind lacks fall away.
    """
    findings: list[Finding] = []
    before = document.value(("cam", "kind"))
    for dotted_path, value in _overriding(overrides, options, ranked):
        path = tuple(key.strip() for key in dotted_path.split("."))
        if path == ("",) and value.findings:
            findings += value.findings
        elif "" in path or len(path) > MAX_DEPTH:
            found = f"found the path '{shown(dotted_path)}'"
            mark = value.place(()).value
            findings.append(Finding(mark, (), found, _FORM, "name a key as in run.rpm"))
        else:
            if not value.findings:
                document.put(path, value)
            findings += [item._replace(path=path + item.path) for item in value.findings]
    kind = document.value(("cam", "kind"))
    cam = document.value(("cam",))
    for model in CAMS:
        if kind != before and kind in get_args(model.model_fields["kind"].annotation):
            known = {
                key: value
                for key, value in cam.items()
                if key in model.model_fields or document.place(("cam", key)).key.rank > 0
            }
            document.data = {**document.data, "cam": known}
    return findings


def _error(findings: Iterable[Finding]) -> SceneError:
    """All faults in order, one per place and path."""
    first: dict[tuple, Finding] = {}
    for item in findings:
        first.setdefault((item.mark, item.path), item)
    ordered = sorted(first.values(), key=lambda item: item.mark)
    faults = [item.fault() for item in ordered[:MAX_FAULTS]]
    if len(ordered) > MAX_FAULTS:
        more = f"{len(ordered) - MAX_FAULTS} further faults"
        faults.append(Fault(ordered[0].mark.name, "", more, "", "correct these first"))
    return SceneError(*faults)
