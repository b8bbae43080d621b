"""cam figures"""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import asdict
from pathlib import Path
from time import perf_counter

from camcli.cli.exit_codes import DONE, NUMERICS, note
from camcli.cli.figures_check import REST, Drift, check, reference_path, update, verdict
from camcli.cli.figures_plan import (
    CHECK,
    UNCHANGED,
    Figure,
    chosen,
    default_folder,
    figures,
    reason,
    state_of,
)
from camcli.cli.figures_run import KEEP, Done, compute
from camcli.cli.options import Request
from camcli.cli.progress import bar
from camcli.cli.report import table
from camcli.errors import Fault, SceneError
from camcli.output.gallery import Picture, page
from camcli.output.run_folder import run_folder

NAME = "figures"


def run(request: Request) -> int:
    """Compute the figures that changed, write the page, compare if asked; the exit code."""
    _refuse(request)
    folder = request.extra["folder"] or default_folder()
    known = figures(folder, request.sets)
    asked = chosen(known, request.extra["names"] or ())
    out = request.folder(NAME)
    why = {f.name: CHECK if request.extra["check"] else reason(f, out / f.name) for f in asked}
    if request.dry_run:
        _show_plan(request, asked, why, out)
        return DONE
    with run_folder(out) as store:
        began = perf_counter()
        wanted = sorted(
            (f for f in asked if why[f.name] != UNCHANGED), key=lambda f: -_cost(f, out)
        )
        try:
            done = _compute(request, wanted, why, out)
        finally:
            pictures = [_picture(figure, out) for figure in known]
            store.write_text("index.html", page(pictures))
            store.commit()
        whole = [f for f in asked if state_of(out / f.name) is not None]
        if request.extra["update_reference"] and len(whole) == len(asked):
            size = update(asked, known, out)
            note(
                f"{reference_path(asked[0]).parent}/: references of {len(asked)} figures, {size} B"
            )
        drifts = [d for f in whole for d in check(f, out)] if request.extra["check"] else []
        _show(request, asked, why, done, drifts, out, perf_counter() - began)
        codes = {(state_of(out / f.name) or {}).get("exit", DONE) for f in whole}
        codes |= {d.code for d in done} | ({NUMERICS} if drifts else set())
        return max(codes - set(KEEP), default=max(codes, default=DONE))


def _refuse(request: Request) -> None:
    """Raise SceneError for options that contradict each other."""
    threads = request.threads
    if threads is not None and threads < 1:
        found, cure = f"found {threads}", "leave it out for all"
        raise SceneError(Fault("--threads", "", found, "expected 1 or more", cure))
    if request.extra["check"] and request.extra["update_reference"]:
        found = "found --check and --update-reference"
        cure = "a reference just written always agrees"
        raise SceneError(Fault("--check", "", found, "expected one of them", cure))
    if request.extra["update_reference"] and request.sets:
        cure = "change the scenes instead"
        fault = Fault("--update-reference", "", "found --set", "expected the scenes alone", cure)
        raise SceneError(fault)


def _cost(figure: Figure, out: Path) -> float:
    """Seconds it took last time, here or where the reference was made; unknown ones come first."""
    for read in (lambda: state_of(out / figure.name), lambda: _json(reference_path(figure))):
        seconds = (read() or {}).get("seconds")
        if isinstance(seconds, int | float):
            return float(seconds)
    return 1e9


def _json(path: Path) -> dict:
    try:
        found = json.loads(path.read_text())
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _compute(request: Request, wanted: Sequence[Figure], why, out: Path) -> list[Done]:
    """Compute, with one bar; where nobody watches, a line for each figure."""
    with nullcontext() if request.quiet else bar("figures", len(wanted)) as tick:

        def on_done(done: Done) -> None:
            if tick is not None:
                tick()
            elif not request.quiet:
                end = "" if done.code == DONE else f", exit code {done.code}"
                note(f"{done.name}: {why[done.name]}, {done.seconds:.1f} s{end}")

        done = compute(wanted, out, request.sets, request.threads, on_done)
    for each in done:
        if each.code != DONE:
            for line in each.notes or [f"exit code {each.code}"]:
                note(f"{each.name}: {line}")
    return done


def _picture(figure: Figure, out: Path) -> Picture:
    folder = out / figure.name
    state = state_of(folder) or {}
    return Picture(
        name=figure.name,
        title=figure.title,
        shows=figure.shows,
        command=figure.shown_command,
        scene=figure.text,
        folder=folder,
        files=state.get("files", {}),
        seconds=state.get("seconds"),
        notes=state.get("notes", []),
        record=_json(folder / "run.json") if state else {},
    )


def _show_plan(request: Request, asked: Sequence[Figure], why, out: Path) -> None:
    costs = {f.name: _cost(f, out) for f in asked}
    seconds = {name: None if cost == 1e9 else cost for name, cost in costs.items()}
    if request.json:
        rows = [
            {"figure": f.name, "reason": why[f.name], "seconds": seconds[f.name],
             "command": f.shown_command}
            for f in asked
        ]  # fmt: skip
        print(json.dumps({"command": NAME, "plan": rows}, indent=2))
        return
    rows = [
        [f.name, why[f.name], "" if seconds[f.name] is None else f"{seconds[f.name]:.1f}",
         f.shown_command]
        for f in asked
    ]  # fmt: skip
    table("cam figures, planned", ["figure", "reason", "seconds last time", "command"], rows)


def _show(request, asked, why, done: list[Done], drifts: list[Drift], out, seconds) -> None:
    spent = {each.name: each for each in done}
    if request.json:
        rows = [
            {"figure": f.name, "title": f.title, "reason": why[f.name],
             "seconds": spent[f.name].seconds if f.name in spent else 0.0,
             "exit": spent[f.name].code if f.name in spent else DONE}
            for f in asked
        ]  # fmt: skip
        text = {"command": NAME, "figures": rows, "seconds": seconds}
        if request.extra["check"]:
            text |= {"verdict": verdict(drifts), "drifts": [asdict(drift) for drift in drifts]}
        print(json.dumps(text, indent=2))
        return
    rows = [
        [f.name, f.title, why[f.name], f"{spent[f.name].seconds:.1f}" if f.name in spent else "-"]
        for f in asked
    ]
    table(f"{len(asked)} figures", ["figure", "shows", "reason", "seconds"], rows)
    for figure in asked:
        mine = [drift for drift in drifts if drift.figure == figure.name]
        for drift in mine[:REST]:
            print(drift)
        if len(mine) > REST:
            print(f"{figure.name}: and {len(mine) - REST} more (--json has all of them)")
    if request.extra["check"]:
        print(verdict(drifts))
    print(f"{out}/index.html: {len(done)} of {len(asked)} figures computed in {seconds:.3g} s")
