"""Small changes of a program's meaning, made in its text where its syntax tree says.

`changes_of` lists those that one line of a module allows: a comparison that takes in its limit,
another operator, a constant a little larger, an element left out, two arguments swapped, a word of
a sentence dropped, a statement that is not done. Left alone is what has no meaning for a result:
docstrings, hints of types, decorators, imports, `__all__`, `__repr__`.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

COMPARED = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
}  # fmt: skip
OPERATED = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Mod: ast.Mult,
    ast.FloorDiv: ast.Mult,
}  # fmt: skip
FUNCTIONS = {
    "min": "max", "max": "min", "any": "all", "all": "any", "floor": "ceil", "ceil": "floor",
    "sin": "cos", "cos": "sin", "degrees": "radians", "radians": "degrees",
}  # fmt: skip
ATTRIBUTES = {
    "min": "max", "max": "min", "any": "all", "all": "any", "low": "high", "high": "low",
    "lower": "upper", "upper": "lower", "lowest": "highest", "highest": "lowest", "first": "last",
    "last": "first", "left": "right", "right": "left", "start": "stop", "stop": "start",
    "argmin": "argmax", "argmax": "argmin",
}  # fmt: skip
WORD = re.compile(r"(?<![\w/.\-{%])[A-Za-z]{3,}(?![\w/.\-}=(])")
DIGITS = re.compile(r"\.(\d+)([efg%])")
OPERATIONS = (ast.BinOp, ast.BoolOp, ast.Compare, ast.UnaryOp, ast.IfExp)
LEFT_ALONE = (ast.Import, ast.ImportFrom, ast.Pass, ast.Global, ast.Nonlocal)
DROPPED = (ast.Expr, ast.AugAssign, ast.Continue, ast.Break)
PARTS = (ast.ExceptHandler, ast.match_case)
WITHOUT_RESULT = ("model_config", "__all__", "__slots__")


@dataclass(frozen=True)
class Change:
    """One change: `old`, which begins at a character of the text, becomes `new`."""

    line: int
    last_line: int
    begin: int
    old: str
    new: str
    kind: str
    function: str | None  # None: done when the module is imported
    names: tuple[str, ...] = ()  # what an assignment at import gives a value to

    def made_in(self, text: str) -> str:
        """The text with the change."""
        return text[: self.begin] + self.new + text[self.begin + len(self.old) :]


def changes_of(text: str) -> dict[int, list[Change]]:
    """The changes that each line of a module allows, by the line on which they begin."""
    found: dict[int, list[Change]] = {}
    for change in _Finder(text).in_block(ast.parse(text).body):
        found.setdefault(change.line, []).append(change)
    return found


def changes_meaning(change: Change, text: str) -> bool:
    """Whether the changed module can be read and is another one."""
    try:
        return ast.dump(ast.parse(change.made_in(text))) != ast.dump(ast.parse(text))
    except (SyntaxError, ValueError):
        return False


class _Finder:
    """Walks a module and makes each change."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.lines = text.splitlines()
        self.starts = [0]
        for line in text.splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(line))
        self.function: str | None = None
        self.names: tuple[str, ...] = ()

    def in_block(self, block: list[ast.stmt]) -> Iterator[Change]:
        """All changes of some statements."""
        for statement in block:
            if isinstance(statement, LEFT_ALONE) or _is_text(statement):
                continue
            if isinstance(statement, ast.FunctionDef):
                yield from self._in_function(statement)
            elif isinstance(statement, ast.ClassDef):
                yield from self.in_block(statement.body)
            else:
                yield from self._in_statement(statement)

    def _in_function(self, function: ast.FunctionDef) -> Iterator[Change]:
        if function.name == "__repr__":
            return
        outer = self.function
        self.names = (function.name,)
        for defaults in (function.args.defaults, function.args.kw_defaults):
            yield from self._in_field(defaults)
        self.function = outer or function.name
        yield from self.in_block(function.body)
        self.function = outer

    def _in_statement(self, statement: ast.stmt) -> Iterator[Change]:
        if isinstance(statement, ast.If) and "TYPE_CHECKING" in ast.dump(statement.test):
            return
        names = _given(statement)
        if set(names) & set(WITHOUT_RESULT):
            return
        if self.function is not None and isinstance(statement, DROPPED):
            yield self._change(statement, "pass", "statement dropped")
        if self.function is not None and isinstance(statement, ast.If):
            yield self._change(statement.test, "False", "branch never taken")
        for field, value in ast.iter_fields(statement):
            if not isinstance(statement, (ast.For, ast.If, ast.While, ast.With, ast.Try)):
                self.names = names
            if field == "annotation":
                for call in (node for node in ast.walk(value) if isinstance(node, ast.Call)):
                    yield from self._inside(call, None)
            elif isinstance(value, list) and value and isinstance(value[0], ast.stmt):
                yield from self.in_block(value)
            elif isinstance(value, list) and value and isinstance(value[0], PARTS):
                for part in value:
                    yield from self.in_block(part.body)
            elif field not in ("target", "targets"):
                yield from self._in_field(value)

    def _in_field(self, value: object) -> Iterator[Change]:
        """The changes in the expressions of a field of a node."""
        for part in value if isinstance(value, list) else [value]:
            if isinstance(part, ast.withitem):
                part = part.context_expr
            if isinstance(part, ast.expr):
                yield from self._in_expression(part, None)

    def _in_expression(self, node: ast.expr, string: ast.JoinedStr | None) -> Iterator[Change]:
        """The changes of an expression and of what is in it; string: the f-string around it."""
        if isinstance(node, ast.JoinedStr) and string is None:
            string = node
        for kind, new in _others(node):
            if string is None:
                text = ast.unparse(new)
                yield self._change(node, f"({text})" if isinstance(new, OPERATIONS) else text, kind)
            else:
                yield from self._in_string(string, node, new, kind)
        yield from self._inside(node, string)

    def _inside(self, node: ast.AST, string: ast.JoinedStr | None) -> Iterator[Change]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.expr):
                yield from self._in_expression(child, string)
            elif isinstance(child, (ast.keyword, ast.comprehension)):
                yield from self._inside(child, string)

    def _in_string(
        self, string: ast.JoinedStr, node: ast.expr, new: ast.expr, kind: str
    ) -> Iterator[Change]:
        """A node replaced within an f-string, which is written anew."""
        for owner in ast.walk(string):
            for field, value in ast.iter_fields(owner):
                if value is node:
                    setattr(owner, field, new)
                    text = _written(string)
                    setattr(owner, field, node)
                elif isinstance(value, list) and any(part is node for part in value):
                    setattr(owner, field, [new if part is node else part for part in value])
                    text = _written(string)
                    setattr(owner, field, value)
                else:
                    continue
                if text is not None:
                    yield self._change(string, text, kind)
                return

    def _change(self, node: ast.expr | ast.stmt, new: str, kind: str) -> Change:
        begin = self._place(node.lineno, node.col_offset)
        end = self._place(node.end_lineno, node.end_col_offset)
        return Change(
            node.lineno, node.end_lineno, begin, self.text[begin:end], new, kind, self.function,
            () if self.function else self.names,
        )  # fmt: skip

    def _place(self, line: int, column: int) -> int:
        """A character of the text; the tree counts bytes of a line."""
        return self.starts[line - 1] + len(self.lines[line - 1].encode()[:column].decode())


def _is_text(statement: ast.stmt) -> bool:
    """Whether a statement is a docstring."""
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


def _given(statement: ast.stmt) -> tuple[str, ...]:
    """The names to which a statement gives a value."""
    targets = getattr(statement, "targets", [getattr(statement, "target", None)])
    return tuple(
        node.id for target in targets if target is not None for node in ast.walk(target)
        if isinstance(node, ast.Name)
    )  # fmt: skip


def _written(string: ast.JoinedStr) -> str | None:
    """The source of an f-string; None for one that cannot be written on one line."""
    try:
        return ast.unparse(string)
    except ValueError:
        return None


def _others(node: ast.expr) -> Iterator[tuple[str, ast.expr]]:
    """What may stand in the place of an expression, each with the kind of the change."""
    for kind, ways in WAYS.items():
        if isinstance(node, kind):
            yield from ways(node)


def _other_comparisons(node: ast.Compare) -> Iterator[tuple[str, ast.expr]]:
    """Each sign of a comparison replaced by its neighbour."""
    for k, sign in enumerate(node.ops):
        if type(sign) in COMPARED:
            signs = [*node.ops[:k], COMPARED[type(sign)](), *node.ops[k + 1 :]]
            yield "comparison", ast.Compare(node.left, signs, node.comparators)


def _other_conditions(node: ast.BoolOp) -> Iterator[tuple[str, ast.expr]]:
    """`or` for `and`, or one of the conditions left out."""
    other = ast.Or() if isinstance(node.op, ast.And) else ast.And()
    yield "and, or", ast.BoolOp(other, node.values)
    for k in range(len(node.values)):
        rest = node.values[:k] + node.values[k + 1 :]
        yield "condition dropped", rest[0] if len(rest) == 1 else ast.BoolOp(node.op, rest)


def _without_sign(node: ast.UnaryOp) -> Iterator[tuple[str, ast.expr]]:
    """No minus, no `not`."""
    if isinstance(node.op, (ast.Not, ast.USub)):
        yield "sign or not", node.operand


def _other_alternative(node: ast.IfExp) -> Iterator[tuple[str, ast.expr]]:
    """The two alternatives of a conditional expression swapped."""
    yield "alternatives swapped", ast.IfExp(node.test, node.orelse, node.body)


def _fewer_elements(node: ast.List) -> Iterator[tuple[str, ast.expr]]:
    """One element of a list left out."""
    if isinstance(node.ctx, ast.Load) and len(node.elts) > 1:
        for k in range(len(node.elts)):
            yield "element dropped", ast.List(node.elts[:k] + node.elts[k + 1 :], ast.Load())


def _fewer_entries(node: ast.Dict) -> Iterator[tuple[str, ast.expr]]:
    """One entry of a dictionary left out."""
    for k in range(len(node.keys)):
        keys, values = node.keys[:k] + node.keys[k + 1 :], node.values[:k] + node.values[k + 1 :]
        yield "entry dropped", ast.Dict(keys, values)


def _other_operations(node: ast.BinOp) -> Iterator[tuple[str, ast.expr]]:
    """Another sign of arithmetic; of sentences or lists that are joined, one alone."""
    joined = (ast.JoinedStr, ast.List, ast.Tuple, ast.ListComp)
    words = any(
        isinstance(side, joined) or (isinstance(side, ast.Constant) and isinstance(side.value, str))
        for side in (node.left, node.right)
    )
    if type(node.op) in OPERATED and not words:
        yield "operator", ast.BinOp(node.left, OPERATED[type(node.op)](), node.right)
    if isinstance(node.op, (ast.Add, ast.Sub)):
        yield "addend dropped", node.left


def _other_constants(node: ast.Constant) -> Iterator[tuple[str, ast.expr]]:
    """Another truth value, a number a little larger, a sentence without one of its words."""
    value = node.value
    if isinstance(value, bool):
        yield "truth value", ast.Constant(not value)
    elif isinstance(value, int):
        yield "number", ast.Constant(value + 1)
        if value > 0:
            yield "number", ast.Constant(value - 1)
    elif isinstance(value, float):
        yield "number", ast.Constant(1.1 * value if value else 1.0)
    elif isinstance(value, str) and " " in value:
        for word in WORD.finditer(value):
            yield "word dropped", ast.Constant(value[: word.start()] + value[word.end() :].lstrip())
    if isinstance(value, str):
        for digits in DIGITS.finditer(value):
            fewer = str(int(digits[1]) - 1) if int(digits[1]) > 1 else str(int(digits[1]) + 1)
            yield "digits", ast.Constant(value[: digits.start(1)] + fewer + value[digits.end(1) :])


def _other_name(node: ast.Name) -> Iterator[tuple[str, ast.expr]]:
    """The opposite of a function: the largest for the smallest."""
    if node.id in FUNCTIONS:
        yield "opposite", ast.Name(FUNCTIONS[node.id], ast.Load())


def _other_attribute(node: ast.Attribute) -> Iterator[tuple[str, ast.expr]]:
    """The opposite of an attribute: the last for the first."""
    if isinstance(node.ctx, ast.Load) and node.attr in ATTRIBUTES:
        yield "opposite", ast.Attribute(node.value, ATTRIBUTES[node.attr], ast.Load())


def _other_arguments(node: ast.Call) -> Iterator[tuple[str, ast.expr]]:
    """A call with two arguments swapped, or without one that is given by name."""
    for k in range(len(node.args) - 1):
        a, b = node.args[k : k + 2]
        if isinstance(a, (ast.Name, ast.Attribute, ast.Constant)) and type(a) is type(b):
            swapped = [*node.args[:k], b, a, *node.args[k + 2 :]]
            yield "arguments swapped", ast.Call(node.func, swapped, node.keywords)
    for k, keyword in enumerate(node.keywords):
        if keyword.arg is not None:
            rest = node.keywords[:k] + node.keywords[k + 1 :]
            yield "argument dropped", ast.Call(node.func, node.args, rest)


WAYS: dict[type[ast.expr], Callable[..., Iterator[tuple[str, ast.expr]]]] = {
    ast.Compare: _other_comparisons,
    ast.BoolOp: _other_conditions,
    ast.UnaryOp: _without_sign,
    ast.BinOp: _other_operations,
    ast.IfExp: _other_alternative,
    ast.Constant: _other_constants,
    ast.Name: _other_name,
    ast.Attribute: _other_attribute,
    ast.List: _fewer_elements,
    ast.Dict: _fewer_entries,
    ast.Call: _other_arguments,
}
