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
from camcli.errors import Fault, SceneError, plural, shown
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
    readable = _is_a_scene(document)
    if not readable:
        document.data = {}  # the command line is checked all the same
    findings = [*document.findings, *_override(document, overrides, {})]
    paths_of_set = {str(text).partition("=")[0].strip() for text in overrides}
    replaced_by_options = paths_of_set & set(options or {})
    if readable and replaced_by_options and not findings:
        findings += _faults_at(replaced_by_options, document, home)
    findings += _override(document, (), options or {}, len(overrides))
    if readable:
        # A cam that names a file finds it beside the scene; elsewhere the user alone allows.
        permitted = not OUTSIDE.isdisjoint(paths_of_set | set(options or {}))
        context = {"folder": home, "permitted": permitted, "command": command}
        try:
            scene = Scene.model_validate(document.data, strict=True, context=context)
        except ValidationError as error:
            from camcli.scene.faults import findings as translated

            findings += translated(document, error)
        else:
            if not findings:
                return scene
    raise _error(findings)


def _is_a_scene(document: Document) -> bool:
    """Whether a document holds a map; where it is something else, a finding says so.

    Raises SceneError for the run.json of a run.
    """
    if document.data is None and document.findings:
        return False
    if not isinstance(document.data, dict):
        document.findings.append(_no_map(document))
        return False
    if "scene_sha256" in document.data:
        found = "found the run.json of a run"
        cure = "give it to cam rerun, or copy its `scene`"
        raise SceneError(Fault(document.place(()).value.name, "", found, "expected a scene", cure))
    return True


def _faults_at(paths: set[str], document: Document, folder: Path) -> list[Finding]:
    """The faults of the scene at these dotted paths; folder: where its files are.

    They are looked for before an option replaces, and so hides, what --set has put there.
    """
    from camcli.scene.faults import findings as translated

    context = {"folder": folder, "permitted": True, "command": ""}
    try:
        Scene.model_validate(document.data, strict=True, context=context)
    except ValidationError as error:
        return [found for found in translated(document, error) if ".".join(found.path) in paths]
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
        """The fault of this text; cure: what to do about it."""
        return SceneError(Fault(option, "", f"found '{shown(text)}'", _SPEED, cure))

    parts = [part.strip() for part in text.split(":")]
    if re.fullmatch(r"[\d.]+\s*(-|\.\.|,|to)\s*[\d.]+", text):
        raise refused("write a range with a colon, as 660:760")
    if len(parts) > 2:
        raise refused("give the number of speeds with --points")
    last_with_shaft = of_a_shaft(parts[-1])  # (number, shaft), None without a shaft
    speeds: list[WrittenSpeed] = []
    for part in parts:
        with_shaft = of_a_shaft(part)
        if with_shaft is None and last_with_shaft is not None:
            _, shaft = last_with_shaft
            with_shaft = of_a_shaft(f"{part} {shaft}")
        if with_shaft is None:
            value = scalar(part)
            shaft = ""
        else:
            value, shaft = with_shaft
        if isinstance(value, bool) or not isinstance(value, int | float):
            is_word = part != "" and not isinstance(value, str)  # true or null: no quotes are there
            cure = "" if is_word else oddity(part)
            raise refused(cure or "write it as 700, 660:760 or 6000crank")
        if shaft and last_with_shaft is None:
            raise refused(f"write {shaft} behind the second end, or behind both")
        rpm_of_cam = value * SHAFTS[shaft] if shaft else value
        if not SLOWEST <= rpm_of_cam <= FASTEST:
            raise refused("give a speed in this range")
        speeds.append(f"{float(value)!r} {CRANK}" if shaft == CRANK else float(value))
    return speeds[0] if len(speeds) == 1 else (speeds[0], speeds[1])


def _read(file: Path) -> Document:
    """A scene file with its places; `-` is stdin. What cannot be read becomes a finding."""
    name = "stdin" if str(file) == "-" else shown(str(file), 500)
    try:
        if name == "stdin":
            data = _stdin()
        else:
            cure = "check the name, or leave out -c for the default scene"
            data = read_bytes(file, name, MAX_BYTES, "expected a YAML file", cure)
        text = decoded(data, name)
    except SceneError as error:
        document = Document(Mark(0, name))
        document.findings += [
            Finding(Mark(0, fault.where), (), fault.found, fault.expected, fault.cure)
            for fault in error.faults
        ]
        return document
    return parse(text, name)


def _stdin() -> bytes:
    """The bytes of a scene from stdin; raises SceneError where that is closed or has too many."""
    if sys.stdin is None:
        cure = "pipe one into it, or name a file"
        raise SceneError(Fault("stdin", "", "found it closed", "expected a scene", cure))
    data = sys.stdin.buffer.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:  # its beginning alone would be another scene
        size = f"{MAX_BYTES // 1000} kB"
        found = f"found more than {size}"
        expected = f"expected at most {size}"
        raise SceneError(Fault("stdin", "", found, expected, "is this the right file?"))
    return data


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
    """(dotted path, document of the value) of every override and then of every option.

    ranked: how many were put before these; each has a mark with a rank of its own, which sorts it
    behind them.
    """
    if isinstance(overrides, Mapping):
        for rank, (path, value) in enumerate(overrides.items(), 1):
            yield str(path), document_of(value, Mark(rank, "overrides"))
    else:
        for rank, text in enumerate(overrides, 1):
            yield _text_of_set(text, rank)
    for rank, (path, (value, name)) in enumerate(options.items(), ranked + len(overrides) + 1):
        document = document_of(value, Mark(rank, name))
        if isinstance(value, str) and _has_odd_bytes(value):
            found = f"found '{shown(value)}', no UTF-8 text"
            expected = "expected a name in UTF-8"
            document.findings = [Finding(Mark(rank, name), (), found, expected, "rename the file")]
        yield path, document


def _text_of_set(text: str, rank: int) -> tuple[str, Document]:
    """(dotted path, document of the value) of a text of --set; the path is empty where it is odd.

    The document then has a finding that says why.
    """
    name = f"--set {shown(text)}"
    path, equals, value = text.partition("=")
    document = parse(value, name, rank, numbered=False)
    if _has_odd_bytes(text):
        found = "found bytes that are no UTF-8 text"
        document.findings = [Finding(Mark(rank, name), (), found, _FORM, "type it again")]
        return "", document
    if not equals:
        cure = "write the key, an = and the value without blanks between"
        document.findings = [Finding(Mark(rank, name), (), "found no '='", _FORM, cure)]
        return "", document
    return path, document


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
    kind_before = document.value(("cam", "kind"))
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
            findings += [found._replace(path=path + found.path) for found in value.findings]
    if document.value(("cam", "kind")) != kind_before:
        _drop_keys_of_another_cam(document)
    return findings


def _drop_keys_of_another_cam(document: Document) -> None:
    """Leave out of the cam what its kind has no key for, unless an override has put it there."""
    kind = document.value(("cam", "kind"))
    cam = document.value(("cam",))
    for model in CAMS:
        kinds_of_model = get_args(model.model_fields["kind"].annotation)  # of its Literal
        if kind in kinds_of_model:
            known = {}
            for key, value in cam.items():
                is_of_override = document.place(("cam", key)).key.rank > 0
                if key in model.model_fields or is_of_override:
                    known[key] = value
            document.data = {**document.data, "cam": known}


def _error(findings: Iterable[Finding]) -> SceneError:
    """All faults in order, one per place and path."""
    first_at: dict[tuple, Finding] = {}
    for finding in findings:
        first_at.setdefault((finding.mark, finding.path), finding)
    ordered = sorted(first_at.values(), key=lambda finding: finding.mark)
    faults = [finding.fault() for finding in ordered[:MAX_FAULTS]]
    if len(ordered) > MAX_FAULTS:
        more = plural(len(ordered) - MAX_FAULTS, "further fault")
        faults.append(Fault(ordered[0].mark.name, "", more, "", "correct these first"))
    return SceneError(*faults)
