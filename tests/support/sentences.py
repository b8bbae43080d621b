"""Text in source code that reads like a sentence, and where it may stand."""

import ast
import re
from collections.abc import Iterator

# three words in a row, a value in braces counts as one
SENTENCE = re.compile(r"(?:(?:a|[A-Za-z][a-z'-]+|{})[,:;]? ){2}(?:a|[A-Za-z][a-z'-]+|{})")
WORD = re.compile(r"[A-Za-z]{2}")  # values alone are no sentence
# what makes a fault of its arguments, or names a piece of work where it fails
TOLD_BY = {"Fault", "SceneError", "piece", "attempt"}
# what says of its arguments what a column or a table is
DESCRIBED_BY = {"Quantity", "Head", "_replace"}
Function = ast.FunctionDef | ast.AsyncFunctionDef


def sentences(source: str) -> Iterator[tuple[int, str]]:
    """(line, text) of each string of a module that reads like a sentence.

    Values in it are written {}. Left out are docstrings, what a __repr__ says to programmers, what
    describes a column or a table, and what belongs to a fault or names a piece: what is raised, the
    arguments of TOLD_BY and of functions that hand theirs on to it, and what is assigned to a name
    in these arguments.
    """
    tree = ast.parse(source)
    functions = [node for node in ast.walk(tree) if isinstance(node, Function)]
    left_out = set(_docstrings(tree))
    told_by = TOLD_BY | DESCRIBED_BY | {one.name for one in functions if _hands_on(one)}
    for function in functions:
        if function.name == "__repr__":
            left_out |= set(ast.walk(function))
        left_out |= _told(function, told_by)
    left_out |= {node for one in ast.walk(tree) if _tells(one, told_by) for node in ast.walk(one)}
    left_out |= _described(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            left_out |= {part for part in node.values if isinstance(part, ast.Constant)}
    for node in ast.walk(tree):
        text = _text(node)
        if node not in left_out and any(WORD.search(part) for part in SENTENCE.findall(text)):
            yield node.lineno, text


def _text(node: ast.AST) -> str:
    """The text of a string or an f-string; of anything else none."""
    if isinstance(node, ast.JoinedStr):
        parts = (one.value if isinstance(one, ast.Constant) else "{}" for one in node.values)
        return "".join(map(str, parts))
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""


def _docstrings(tree: ast.Module) -> Iterator[ast.AST]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | Function) and ast.get_docstring(node):
            yield node.body[0].value


def _tells(node: ast.AST, told_by: set[str]) -> bool:
    """Whether a node raises, or calls one of these functions."""
    if isinstance(node, ast.Call):
        return getattr(node.func, "id", getattr(node.func, "attr", "")) in told_by
    return isinstance(node, ast.Raise)


def _hands_on(function: Function) -> bool:
    """Whether a function makes a fault, or the name of a piece, of a text it is given."""
    arguments = [*function.args.args, *function.args.kwonlyargs]
    texts = {
        one.arg
        for one in arguments
        if isinstance(one.annotation, ast.Name) and one.annotation.id == "str"
    }
    return any(
        isinstance(node, ast.Name) and node.id in texts
        for one in ast.walk(function)
        if _tells(one, TOLD_BY)
        for node in ast.walk(one)
    )


def _told(function: Function, told_by: set[str]) -> set[ast.AST]:
    """What a function raises or hands on, with what it assigns to the names therein."""
    told = {node for one in ast.walk(function) if _tells(one, told_by) for node in ast.walk(one)}
    assigned = [node for node in ast.walk(function) if isinstance(node, ast.Assign | ast.AugAssign)]
    size = -1
    while size < len(told):
        size = len(told)
        names = {node.id for node in told if isinstance(node, ast.Name)}
        for one in assigned:
            targets = one.targets if isinstance(one, ast.Assign) else [one.target]
            if names & {n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name)}:
                told |= set(ast.walk(one))
    return told


def _described(tree: ast.Module) -> set[ast.AST]:
    """Statements of a module that describe columns, with what they name."""
    described = [one for one in tree.body if any(_tells(n, DESCRIBED_BY) for n in ast.walk(one))]
    names = {n.id for one in described for n in ast.walk(one) if isinstance(n, ast.Name)}
    for one in tree.body:
        targets = one.targets if isinstance(one, ast.Assign) else []
        if names & {target.id for target in targets if isinstance(target, ast.Name)}:
            described.append(one)
    return {node for one in described if isinstance(one, ast.Assign) for node in ast.walk(one)}
