"""The rules of the house: lint, format, import contracts, what README promises."""

import ast
import contextlib
import subprocess
import sys
from pathlib import Path

import grimp
import pytest

from tests.support.mutants import mutants
from tests.support.sentences import sentences

ROOT = Path(__file__).parents[1]
BIN = Path(sys.executable).parent


def run(*words: str) -> subprocess.CompletedProcess:
    return subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    "words",
    [
        ("ruff", "check", "."),
        ("ruff", "format", "--check", "."),
        ("lint-imports", "--no-cache"),
        pytest.param(("mypy",), marks=pytest.mark.slow),
    ],
    ids=["ruff check", "ruff format", "import contracts", "types"],
)
def test_tool_finds_nothing(words):
    done = run(str(BIN / words[0]), *words[1:])
    assert done.returncode == 0, done.stdout + done.stderr


def test_no_modules_import_each_other_in_a_circle():
    """Also where one of them does so within a function, at its first call."""
    graph = grimp.build_graph("camcli", exclude_type_checking_imports=True)
    imports = {name: graph.find_modules_directly_imported_by(name) for name in graph.modules}
    with contextlib.suppress(StopIteration):
        while True:  # a module that imports none of those left is in no circle
            alone = next(name for name, others in imports.items() if not others & imports.keys())
            del imports[alone]
    assert sorted(imports) == []


READING = {  # functions of the analyses that look at a value, and run nothing
    "case", "impacts_of", "multipliers", "period_of", "status_name",
}  # fmt: skip


def test_a_picture_takes_values_of_the_analyses_and_computes_nothing():
    """Classes and constants, and the few functions that only read; contracts hold the rest."""
    taken = set()
    for path in (ROOT / "camcli" / "plots").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            module = getattr(node, "module", None) or ""
            if module.startswith("camcli.analysis"):
                taken |= {name.name for name in node.names}
    assert {name for name in taken if name[0].islower()} == READING


NO_RESULTS = {  # files whose sentences are not about a result
    "api/__init__.py": "the line of help of each command",
    "analysis/bench/stability.py": "cells of stability.csv, a table of tests",
    "api/validation/oscillators.py": "cells of validation.csv: sources, places, quantities",
    "api/validation/balls.py": "the same",
    "api/validation/cams.py": "the same",
    "analysis/bench/precision.py": "the settings of an integrator, cells of precision.csv",
}


@pytest.mark.parametrize("package", ["analysis", "exact", "api"])
def test_sentences_on_results_are_made_in_words(package):
    """Analyses and the API return values; `camcli/words` says them. Faults stay where they are."""
    root = ROOT / "camcli"
    found = {
        str(path.relative_to(root)): list(sentences(path.read_text()))
        for path in sorted((root / package).rglob("*.py"))
    }
    assert {name: lines for name, lines in found.items() if lines and name not in NO_RESULTS} == {}
    known = {name for name in NO_RESULTS if name.startswith(f"{package}/")}
    assert all(found[name] for name in known)  # a file that has none any more leaves the list


@pytest.mark.parametrize(
    ("source", "texts"),
    [
        ('x = "contact is lost here"', ["contact is lost here"]),
        ('def f(v):\n    return f"lands at {v} m/s"', ["lands at {} m/s"]),
        ('def f():\n    """The speed of it."""\n    return "A", "two words", "a-name"', []),
        ('def f(q):\n    raise ValueError(f"found {q} below the cam")', []),
        ('def f():\n    found = "found no such file"\n    g(Fault(found))', []),
        ('def f():\n    found = "found no such file"\n    g(found)', ["found no such file"]),
        ('def f(cure: str):\n    raise Fault(cure)\nf("look at it again")', []),
        ('def f(cure: str):\n    print(cure)\nf("look at it again")', ["look at it again"]),
        ('A = "side of the event"\nB = [Quantity(A, "what is measured")]', []),
        (
            'A = "side of the event"\nB = [f(A, "what is measured")]',
            ["side of the event", "what is measured"],
        ),
        ('piece("the motion at 7 rpm", f)\nx = "{}, {}: {}"', []),
    ],
)
def test_what_reads_like_a_sentence(source, texts):
    assert [text for _, text in sentences(source)] == texts


IN_SI = ("analysis", "exact", "parallel", "kernel", "system.py")  # rad, m/s, N


@pytest.mark.parametrize("place", IN_SI)
def test_names_in_deg_and_rpm_are_left_to_those_who_read_and_show(place):
    """Phases are in rad there. A machine's speed has the bare name rpm: its double is the datum."""
    root = ROOT / "camcli" / place
    files = [root] if root.is_file() else sorted(root.rglob("*.py"))
    assert files
    named = {str(path.relative_to(ROOT)): in_shown_units(path.read_text()) for path in files}
    assert {path: names for path, names in named.items() if names} == {}


def products_with_a_condition(source: str) -> list[str]:
    """Products of something with a comparison or a negation, where an `if` would say it."""
    products = [
        node
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult)
    ]
    return [
        ast.unparse(node) for node in products if any(map(is_condition, (node.left, node.right)))
    ]


def is_condition(node: ast.expr) -> bool:
    if isinstance(node, ast.BoolOp):  # `x or 1.0` is a number
        return all(is_condition(value) for value in node.values)
    negation = isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not)
    return negation or isinstance(node, ast.Compare)


def test_nothing_is_multiplied_by_a_condition():
    found = {
        str(path.relative_to(ROOT)): products_with_a_condition(path.read_text())
        for path in (ROOT / "camcli").rglob("*.py")
    }
    assert {path: products for path, products in found.items() if products} == {}


def test_a_product_with_a_condition_is_seen():
    source = "a = b * (c > 0)\nd = ['s'] * (not e)\nf = g * (h or 1.0)\ni = j * (k > 0 and not l)"
    expected = ["b * (c > 0)", "['s'] * (not e)", "j * (k > 0 and (not l))"]
    assert products_with_a_condition(source) == expected


def in_shown_units(source: str) -> list[str]:
    """Names of variables, arguments, attributes and functions that end in _deg or _rpm."""
    names = [
        getattr(node, part)
        for node in ast.walk(ast.parse(source))
        for part in ("id", "attr", "arg", "name")
        if isinstance(getattr(node, part, None), str)
    ]
    return sorted({name for name in names if name.endswith(("_deg", "_rpm"))})


def test_a_name_in_deg_is_seen_wherever_it_stands():
    source = "def a_deg(b_deg, *, c=1):\n    d_deg = b_deg.e_deg\n    f(g_rpm=d_deg, h_n=2)"
    assert in_shown_units(source) == ["a_deg", "b_deg", "d_deg", "e_deg", "g_rpm"]


PATCHED = {  # constants of the package that a test replaces, and why no case does instead
    "LOADER": "an installation whose PyYAML has no compiled parser",
    "MOST": "a machine that is too slow, or fast enough, for the time that a plan may take",
    "ENOUGH": "the same: plans whose numbers a test does not look at",
    "MOST_STEPS_BETWEEN": "the kernel in plain Python is a hundred times slower",
    "CONVERGED": "Newton's method one step at a time, which no run asks for",
    "FOLDER": "a guide whose headings are alike, which that of the package has none of",
    "HALF_ULP": "heights that are wrong by more than rounding, of which there are none",
    "PROBLEMS": "published numbers that are not reproduced, and problems that raise",
    "ROWS": "an extreme case that fails, of which there are none",
    "STUDIES": "a study of a second, where the real ones take minutes",
}


def patched_constants(source: str) -> set[str]:
    """Names in capitals that a call of `setattr` replaces."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "setattr":
            texts = [word.value for word in node.args[:2] if isinstance(word, ast.Constant)]
            names = [text.rpartition(".")[2] for text in texts if isinstance(text, str)]
            found |= {name for name in names if name.isupper() and name[0] != "_"}
    return found


def test_tests_replace_hardly_any_constants():
    """A case that meets a limit, or an argument, says more; what is left has a reason."""
    found = set()
    for path in (ROOT / "tests").rglob("*.py"):
        found |= patched_constants(path.read_text())
    assert found == PATCHED.keys()


def test_a_constant_that_is_replaced_is_seen():
    source = 'm.setattr(a, "B", 1)\np.setattr("c.d.E_F", 2)\nm.setattr(a, "g", 3)'
    assert patched_constants(source) == {"B", "E_F"}


def test_ci_runs_the_command_of_the_readme():
    command = "python3 -m venv .venv && .venv/bin/pip install -q -e '.[test]' && .venv/bin/pytest"
    assert command in (ROOT / "README.md").read_text()
    assert command in (ROOT / ".ci" / "run").read_text()


def test_default_scene_is_the_chapter_and_complete():
    from camcli.scene import Scene, default_scene_path, load_scene, resolved

    assert default_scene_path().read_text() == (ROOT / "configs" / "chapter.yaml").read_text()
    assert set(resolved(load_scene(None))) == set(Scene.model_fields)


def test_schema_beside_the_configs_is_current():
    import json

    from camcli.scene import json_schema

    assert json.loads((ROOT / "configs" / "schema.json").read_text()) == json_schema()


def test_every_recorded_change_of_meaning_has_its_line():
    assert len(mutants("")) > 40
