"""The options every command shares, declared once."""

import inspect
import os
import re
from collections import Counter
from collections.abc import Callable, Collection
from contextlib import ExitStack, redirect_stdout
from dataclasses import dataclass, fields
from functools import cache
from math import isfinite
from pathlib import Path
from textwrap import fill
from typing import Any

import typer
from typer.core import TyperCommand
from typer.models import OptionInfo

from camcli.cli.help import parts_of
from camcli.errors import Fault, SceneError, is_given, shown
from camcli.quantities import PAPER

MOST_THREADS = 4096
Values = dict[str, tuple[Any, str]]  # scene path -> (value, option it came from)


def given(section: str, option: str = "", /, **values: Any) -> Values:
    """The keys of a section whose options were given: neither None nor a flag left out.

    An option bears the name of its key, where it is not named.
    """
    return {
        f"{section}.{key}": (value, option or f"--{key.replace('_', '-')}")
        for key, value in values.items()
        if is_given(value)
    }


def option(words: str, metavar: str | None = None, *names: str, **more: Any) -> Any:
    """An option that takes a value; without names it bears that of its parameter."""
    return typer.Option(None, *names, help=words, metavar=metavar, **more)


def argument(
    words: str,
    metavar: str,
    default: Any = None,
    complete: Callable[[str], list[str]] | None = None,
) -> Any:
    """A word without an option's name; complete: what a shell may make of the word's beginning."""
    return typer.Argument(default, help=words, metavar=metavar, autocompletion=complete)


def flag(words: str, *names: str) -> Any:
    """An option that takes no value."""
    return typer.Option(False, *names, help=words)


def _folder(text: str) -> Path:
    """The folder of -o; an empty name is refused."""
    if not text:
        raise typer.BadParameter("found '', expected the name of a folder, e.g. -o .")
    return Path(text)


def numbers(text: str | None, option: str, form: str, example: str) -> list[float] | None:
    """The numbers of an option's text; None where it was not given.

    form: how it should look, such as `two numbers LO:HI` or `KEY=LO:HI`: as many numbers, apart by
    its comma or colon, behind an = if it has one. example: for the fault of another text.
    """
    if text is None:
        return None
    from camcli.scene import scalar

    separator = "," if "," in form else ":"
    words = text.rpartition("=")[2].split(separator)
    found = []
    for word in words:
        value = scalar(word.strip())
        if isinstance(value, bool) or not isinstance(value, int | float):
            continue
        if isfinite(value):
            found.append(float(value))
    expected_count = 1 + form.count(separator)
    is_in_form = len(found) == len(words) == expected_count and ("=" in form) == ("=" in text)
    if not is_in_form:
        fault = Fault(option, "", f"found '{shown(text)}'", f"expected {form}", f"e.g. {example}")
        raise SceneError(fault)
    return found


def refuse_idle(*faults: tuple[object, str, str, str]) -> None:
    """Raise SceneError for options that mean nothing together.

    Each is (whether it was given so, its name, without or with what, what to do): for instance
    `(seed and not starts, "--seed", "without --starts", "add --starts N")`.
    """
    idle = [
        Fault(name, "", f"found it {beside}", "it means nothing there", cure)
        for was_given_so, name, beside, cure in faults
        if was_given_so
    ]
    if idle:
        raise SceneError(*idle)


@dataclass(frozen=True)
class Request:
    """What the user asked for with the shared options."""

    config: Path | None = option(
        "Scene (YAML), - for stdin. Default: the example's.", "FILE", "-c", "--config"
    )
    sets: list[str] | None = option("path.to.key=value, as YAML. Repeatable.", "KEY=VALUE", "--set")
    rpm: str | None = option("Speed X or range LO:HI, rpm; 6000crank: of a crank.", "RPM")
    points: str | None = option("Points of a range; samples per turn in simulate.", "N[,M]")
    out: Path | None = option(
        "Folder for the artefacts. Default: out/COMMAND.", "DIR", "-o", "--out", parser=_folder
    )
    no_plot: bool = flag("Draw nothing.")
    formats: str | None = option("Of pictures: png, pdf, svg.", "A,B", "--format")
    width: str | None = option("Of pictures, e.g. 85mm or 3.3in.", "LENGTH")
    height: str | None = option("The same.", "LENGTH")
    font: str | None = option("Of pictures, by name.")
    style: str | None = option("A matplotlib style: name or file.")
    no_title: bool = flag("No title, no notes in it.")
    panels: str | None = option("Panels drawn, by name.", "A,B")
    json: bool = flag("One JSON object on stdout.")
    verbose: bool = flag("Print the theory too.", "--verbose", "-v")
    quiet: bool = flag("Say nothing but faults.", "--quiet", "-q")
    threads: int | None = option("Threads; never changes a result. Default: all processors.")
    dry_run: bool = flag("Validate, print the plan and its cost; write nothing.")

    def __post_init__(self) -> None:
        """Put the default where an option was not given: typer's description of it stands there."""
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, OptionInfo):  # not given
                object.__setattr__(self, field.name, value.default)

    def picture_values(self) -> Values:
        """What the options of pictures set in the scene's section `plot`."""
        values = given(
            "plot",
            width=_millimetres(self.width, "width"),
            height=_millimetres(self.height, "height"),
            font=self.font,
            style=self.style,
            panels=_names(self.panels),
        )
        if self.no_title:
            values["plot.title"] = (False, "--no-title")
        return values | given("plot", "--format", formats=_names(self.formats))

    def folder(self, command: str) -> Path:
        """Where the artefacts go."""
        return self.out if self.out is not None else Path("out") / command


SCENE = ("config", "sets", "rpm", "points")
PICTURES = "Pictures (cam guide paper-figure)"
DRAWING = ("formats", "width", "height", "font", "style", "no_title", "panels")

GROUPS = {  # of the options in the help; others are the command's own
    "Scene and run": (
        *SCENE, "out", "json", "verbose", "quiet", "threads", "dry_run", "shard", "cluster",
    ),
    PICTURES: ("no_plot", *DRAWING),
}  # fmt: skip


def _names(text: str | None) -> list[str] | None:
    """The names between commas; None where the option was not given."""
    return None if text is None else [name.strip() for name in text.split(",")]


def _millimetres(text: str | None, name: str) -> float | None:
    """A length such as `3.3in` in mm; name: of the option that gave it, for the fault."""
    if text is None:
        return None
    match = re.fullmatch(rf"\s*(\d+\.?\d*)\s*(|{'|'.join(PAPER)})\s*", text)
    if match is None:
        expected = f"expected a number and one of {', '.join(PAPER)}"
        raise SceneError(Fault(f"--{name}", "", f"found '{text}'", expected, "e.g. 85mm"))
    return float(match[1]) * PAPER[match[2] or "mm"]


VARY = option("A number of the scene to vary, as in --set.", "KEY=LO:HI")
SHARD = option("Only part I of N; cam merge joins them.", "I/N")
CLUSTER = option("Dask scheduler HOST:PORT, or local.", "ADDRESS")


class _Command(TyperCommand):
    """A command with short help, whose options are given once."""

    def format_help_text(self, ctx: Any, formatter: Any) -> None:
        """The sentence, the examples and the files; the guide has the rest."""
        help_text = parts_of(self.help or "")
        write = formatter.write
        sentence = f"{help_text.sentence} More: cam guide {self.name}."
        write(f"\n{_indented(sentence, formatter.width)}\n")
        for heading, lines in (("Examples", help_text.examples), ("Files", help_text.files)):
            if lines:
                write(f"\n{heading}:\n" + "".join(f"  {line}\n" for line in lines))

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """The options in groups, by what they are about; options of pictures are only named."""
        groups: dict[str, list[Any]] = {heading: [] for heading in ("Options", *GROUPS)}
        for parameter in self.get_params(ctx):
            headings = [heading for heading, names in GROUPS.items() if parameter.name in names]
            groups[headings[0] if headings else "Options"].append(parameter)
        for heading, parameters in groups.items():
            rows = []  # (option, what it does)
            for parameter in parameters:
                row = parameter.get_help_record(ctx)
                if row is not None and "--help" not in row[0]:
                    rows.append(row)
            if heading == PICTURES and rows:
                options = ", ".join(option for option, _ in rows)
                formatter.write(f"\n{heading}:\n{_indented(options, formatter.width)}\n")
            elif rows:
                with formatter.section(heading):
                    formatter.write_dl(rows)

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Refuse an option that takes one value and is given twice: only the last would count."""
        _, _, given = self.make_parser(ctx).parse_args(args=[*args])
        # the parser lists a parameter as often as it was given
        parameters: list[Any] = [each for each in given if each.param_type_name == "option"]
        times = Counter(parameter for parameter in parameters if not parameter.is_flag)
        faults = [
            _repeated(parameter.opts[0], count)
            for parameter, count in times.items()
            if count > 1 and not parameter.multiple
        ]
        if faults:
            raise SceneError(*faults)
        return super().parse_args(ctx, args)


def _indented(text: str, width: int) -> str:
    """Text in lines of a width, two columns in."""
    return fill(text, width, initial_indent="  ", subsequent_indent="  ")


def _repeated(name: str, times: int) -> Fault:
    """What is said of an option that takes one value and was given more often."""
    found = "found it twice" if times == 2 else f"found it {times} times"
    if name == "-c":
        cure = "give one scene, and what differs with --set"
        return Fault(name, "", found, "expected one scene", cure)
    return Fault(name, "", found, "expected it once", "leave all but one of them out")


def register(app: typer.Typer, run: Callable[..., int], without: Collection[str] = ()) -> None:
    """Make `run(request, own options ...) -> exit code` a command of the same name.

    Its docstring is the help text. `without` names shared options that mean nothing to it.
    """
    _, *own = _parameters(run)  # without the request
    shared = [parameter for parameter in _parameters(Request) if parameter.name not in without]
    parameters = [*shared, *own]

    def call(**values: Any) -> None:
        """Run the command with the options given, and end with its exit code."""
        request = Request(**{parameter.name: values.pop(parameter.name) for parameter in shared})
        threads = request.threads
        if threads is not None and not 1 <= threads <= MOST_THREADS:
            found = f"found {threads}"
            expected = f"expected 1 or more, at most {MOST_THREADS}"
            raise SceneError(Fault("--threads", "", found, expected, "leave it out for all"))
        with ExitStack() as stack:
            if request.quiet and not request.json:
                nowhere = stack.enter_context(open(os.devnull, "w"))
                stack.enter_context(redirect_stdout(nowhere))
            raise typer.Exit(run(request, **values))

    call.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    call.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    app.command(run.__name__, cls=_Command, help=run.__doc__)(call)


@cache
def _parameters(function: Callable) -> list[inspect.Parameter]:
    """The parameters with their annotations evaluated, to be given by name.

    An option without a name of its own bears that of its parameter.
    """
    by_name = []
    for parameter in inspect.signature(function, eval_str=True).parameters.values():
        option_info = parameter.default
        if isinstance(option_info, OptionInfo) and not option_info.param_decls:
            name = parameter.name.strip("_").replace("_", "-")
            option_info.param_decls = (f"--{name}",)
        by_name.append(parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY))
    return by_name
