"""The guide and README: what they show runs, prints what they say, and names what is there."""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import camcli
from camcli.api.validation import chosen
from camcli.cli.app import COMMANDS
from camcli.cli.guide import SUBJECTS, guide
from camcli.cli.reference import notebook, written
from camcli.guide import FOLDER, pages
from camcli.scene import json_schema
from camcli.words.orbits import CURVE_ENDS
from tests.conftest import cam_in
from tests.support import validation

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
PATHS = {"README": README, **{topic: page.path for topic, page in pages().items()}}
REFERENCE = (*COMMANDS, "scene", "statuses", "exit-codes")
PROSE = [topic for topic in PATHS if topic not in REFERENCE]
BLOCK = re.compile(r"(?:<!-- ([^>]*) -->\n)?```(\w+)\n(.*?)```", re.DOTALL)
WHOLE = bool({"CAMCLI_NO_SKIPS", "CAMCLI_SOAK"} & os.environ.keys())
LOOP = re.compile(r"(for|if) ")  # the first word of a block that is one command of the shell
IN_CI = (  # some seconds each
    "first-steps", "spring", "two-parameters", "paper-figure", "impact-oscillator", "study",
    "proofs", "lash", "cam-sheet", "long-runs",
)  # fmt: skip
LONG = "long"  # blocks that the soak runs: figures and other tests compute the same
DRAWS = re.compile(r"--(animate|format|panels|report|width)\b")  # options that ask for a picture


@cache
def reference() -> dict[str, str]:
    """The pages that are written from the program's tables; not while tests are collected."""
    return written()


def blocks(topic: str) -> list[tuple[str, str, str]]:
    """(remark, language, text) of each block of a page."""
    return BLOCK.findall(PATHS[topic].read_text(encoding="utf-8"))


def runs(topic: str) -> bool:
    return any(language in ("sh", "python") for _, language, _ in blocks(topic))


def flat(text: str) -> str:
    """Text without the frames of tables, in single blanks."""
    return " ".join(re.sub(r"[│┃┏┓┗┛━┳┻┡┩╇─┴└┘]", " ", text).split())


def run_shell(text: str, folder: Path, with_pictures: bool) -> str:
    """What a block of shell prints; commands of cam run in this process where they can.

    with_pictures: also of commands that draw them without being asked.
    """
    printed = ""
    for line in text.replace("\\\n", " ").splitlines() if not LOOP.match(text) else [text]:
        words = re.sub(r"\$CONFIGS", str(ROOT / "configs"), line.partition("  #")[0])
        words = re.sub(r"(?<= )configs/", f"{ROOT}/configs/", words)
        if not words.strip() or "pip install" in words:
            continue
        if words.startswith("cam ") and not re.search(r"[|>;$&]", words):
            name, *options = words.removeprefix("cam ").split(" ", 1)
            draws = with_pictures or DRAWS.search(words) or "--no-plot" not in reference()[name]
            done = cam_in(folder, name, *options, "" if draws else "--no-plot", code=0)
        else:
            path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
            done = subprocess.run(
                ["sh", "-e", "-c", words], cwd=folder, env={**os.environ, "PATH": path},
                capture_output=True, text=True, check=True,
            )  # fmt: skip
        printed += done.stdout
    return printed


def run_python(text: str, folder: Path, names: dict, capsys) -> str:
    with contextlib.chdir(folder):
        exec(compile(text, "block", "exec"), names)
    return capsys.readouterr().out


def _cases() -> list:
    """Each page that has blocks to run: without its long blocks and most pictures, and whole."""
    cases = []
    for topic in filter(runs, PROSE):
        in_ci = [pytest.mark.ci] if topic in IN_CI else []
        cases.append(pytest.param(topic, False, id=topic, marks=in_ci))
        cases.append(pytest.param(topic, True, id=f"{topic}, whole", marks=pytest.mark.soak))
    return cases


@pytest.mark.slow
@pytest.mark.parametrize(("topic", "whole"), _cases())
def test_every_block_runs_and_prints_what_the_page_says(
    topic, whole, tmp_path, capsys, monkeypatch
):
    monkeypatch.setenv("COLUMNS", "100")
    names: dict = {}
    printed = ""
    for remark, language, text in blocks(topic):
        if remark.startswith("not run") or (remark == LONG and not whole):
            continue
        if language == "sh":
            printed = run_shell(text, tmp_path, with_pictures=whole)
        elif language == "python":
            printed = run_python(text, tmp_path, names, capsys)
        elif language == "text" and printed:
            said = flat(printed)
            for line in text.splitlines():
                assert flat(line) in said, said


@pytest.mark.parametrize("topic", REFERENCE)
def test_the_reference_is_what_the_program_says(topic):
    """`python -m camcli.cli.reference` writes it anew."""
    assert set(reference()) == set(REFERENCE)
    assert PATHS[topic].read_text(encoding="utf-8") == reference()[topic]


@pytest.mark.slow
def test_the_page_of_validation_is_what_the_commands_compute():
    """`python tests/support/validation.py` writes it anew; CI computes all of it."""
    text = validation.PAGE.read_text(encoding="utf-8")
    if WHOLE:
        assert text == validation.page()
        return
    for problem in chosen(quick=True):
        assert validation.table(problem) in text


def test_the_notebook_is_the_page_in_cells():
    """`python -m camcli.cli.reference` writes it anew; the blocks of the page are run above."""
    assert (FOLDER / "how-to" / "notebook.ipynb").read_text(encoding="utf-8") == notebook()


def known_names() -> set[str]:
    """Options, keys of the scene and of run.json, columns and files, as the reference has them.

    The keys of run.json are compared with those of runs in test_run_json.py.
    """
    text = "\n".join([*reference().values(), PATHS["run-json"].read_text(encoding="utf-8")])
    options = set(re.findall(r"--[a-z][\w-]+", text))
    keys = set(re.findall(r"\b[a-z]+\.[a-z_]+(?=`)", reference()["scene"]))
    columns = set(re.findall(r"\b[a-z]\w*_\w+", text))
    files = set(re.findall(r"[\w*]+\.(?:csv|png|json|html|pdf|npz|gif|mp4)", text))
    return options | keys | columns | files


@cache
def defined_functions() -> set[str]:
    sources = (path.read_text(encoding="utf-8") for path in (ROOT / "camcli").rglob("*.py"))
    return {name for text in sources for name in re.findall(r"^ *def (\w+)", text, re.MULTILINE)}


@pytest.mark.parametrize("topic", PROSE)
def test_a_page_names_only_what_is_there(topic):
    text = PATHS[topic].read_text(encoding="utf-8")
    quoted = set(re.findall(r"`([^`\n]+)`", re.sub(r"```.*?```", "", text, flags=re.DOTALL)))
    known, sections = known_names(), json_schema()["properties"]
    for name in sorted(quoted):
        if re.fullmatch(r"(camcli|configs|tests)/[\w./-]*", name):
            assert (ROOT / name).exists(), name
        elif match := re.fullmatch(r"(--[a-z][\w-]+).*", name):
            assert match[1] in known, name
        elif match := re.fullmatch(r"([a-z]+)\.([a-z_]+)", name):
            if match[1] in sections:
                assert name in known, name
        elif match := re.fullmatch(r"cam ([a-z]+)( .*)?", name):
            assert match[1] in COMMANDS, name
        elif re.fullmatch(r"[a-z]+_[a-z_]+", name):
            assert name in known | set(dir(camcli)) | defined_functions(), name
    for target in re.findall(r"\]\(([^)#]+)\)", text):
        if not target.startswith("http"):
            assert (PATHS[topic].parent / target).exists(), target


def test_commands_in_blocks_have_the_options_that_they_give():
    """Whatever is not run, too: a command that the parser does not know would be refused."""
    for topic in PROSE:
        for _, language, text in blocks(topic):
            lines = text.replace("\\\n", " ").splitlines() if language == "sh" else []
            for line in lines:
                words = shlex.split(line, comments=True)
                if words[:1] == ["cam"] and words[1] in COMMANDS:
                    options = {w.partition("=")[0] for w in words if w.startswith("--")}
                    page = reference()[words[1]]
                    assert all(f"{option}" in page for option in options), line


def test_readme_is_short_and_begins_with_a_picture():
    text = README.read_text(encoding="utf-8")
    lines = text.splitlines()
    assert len(lines) <= 150
    assert len(text.encode()) <= 10_000
    assert next(n for n, line in enumerate(lines) if "![" in line) < 12


def test_the_index_and_the_site_lead_to_every_page():
    index = (FOLDER / "index.md").read_text(encoding="utf-8")
    site = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    for page in pages().values():
        name = page.path.relative_to(FOLDER).as_posix()
        assert f"]({name})" in index, name
        assert f"- {name}\n" in site or f"[{name}]\n" in site, name
    assert "(camcli/guide/index.md)" in README.read_text(encoding="utf-8")


def test_the_guide_is_listed_and_shown(tmp_path):
    listed = cam_in(tmp_path, "guide", code=0).stdout
    assert all(f"cam guide {topic} " in listed for topic in pages())
    assert cam_in(tmp_path, "guide sweep", code=0).stdout == reference()["sweep"]
    section = cam_in(tmp_path, "guide chaos", code=0).stdout
    assert section.startswith("## Chaos\n")
    assert "cam orbits --chaos --rpm 745" in section
    assert section.endswith("The whole page: cam guide proofs\n")
    wrong = cam_in(tmp_path, "guide swep")
    assert wrong.returncode == 2
    assert "did you mean sweep?" in wrong.stderr


def test_a_subject_leads_to_the_page_that_tells_of_it(capsys):
    assert SUBJECTS == {
        "force": "spring", "hertz": "spring", "seat": "lash", "seating": "lash", "surge": "spring",
        "tolerance": "detach", "valve": "lash",
    }  # fmt: skip
    for subject, topic in SUBJECTS.items():
        assert subject not in pages()
        assert guide(None, subject) == 0
        text = capsys.readouterr().out
        assert text == pages()[topic].text()
        assert subject in text.lower()


@pytest.mark.parametrize("command", COMMANDS)
def test_help_is_short_and_fits_a_terminal(command, tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    lines = cam_in(tmp_path, command, "--help", code=0).stdout.splitlines()
    assert len(lines) <= 45
    assert max(map(len, lines)) <= 80
    assert f"cam guide {command}." in " ".join(" ".join(lines).split())


def test_pages_begin_with_their_title_and_pictures_are_there():
    for page in pages().values():
        assert page.text().startswith(f"# {page.title}\n"), page.path
        for name in re.findall(r"!\[[^]]*\]\(([^)]+)\)", page.text()):
            assert (page.path.parent / name).is_file(), name


def test_the_page_of_orbits_lists_what_ends_a_curve():
    """In the words of the table that the program speaks from."""
    page = " ".join(PATHS["orbits"].read_text(encoding="utf-8").split())
    for words in CURVE_ENDS.values():
        assert f"; {words};" in page
