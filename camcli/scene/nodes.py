"""Input with the place of each value and key: what validation errors are traced back through.

Nodes are not changed once built; aliases share them, and `replaced` copies along its path.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from camcli.scene.places import Mark, Path
from camcli.scene.scalars import Scalar


@dataclass(slots=True)
class Node:
    """A value with its mark. Scalars keep the text they were written as, maps their keys' marks.

    `size` counts the nodes and keys with aliases expanded, `height` the levels below.
    """

    mark: Mark
    value: Scalar | dict[str, Node] | list[Node]
    text: str | None = None
    keys: dict[str, Mark] = field(default_factory=dict)
    size: int = 1
    height: int = 0

    def child(self, key: str | int) -> Node | None:
        if isinstance(self.value, dict):
            return self.value.get(key)
        if isinstance(self.value, list) and isinstance(key, int) and 0 <= key < len(self.value):
            return self.value[key]
        return None


def plain(node: Node) -> object:
    """The value alone. Recursive: the depth was limited when the nodes were built."""
    if isinstance(node.value, dict):
        return {key: plain(child) for key, child in node.value.items()}
    if isinstance(node.value, list):
        return [plain(child) for child in node.value]
    return node.value


def node_of(value: object, mark: Mark) -> Node:
    """Node of a Python value, as options give it; all of it stands at one mark."""
    if isinstance(value, Mapping):
        children = {str(key): node_of(child, mark) for key, child in value.items()}
        return Node(mark, children, keys=dict.fromkeys(children, mark))
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        return Node(mark, [node_of(child, mark) for child in value])
    return Node(mark, value)


def at(root: Node, path: Path) -> tuple[Node, Mark]:
    """The deepest node on the path and the mark of its key."""
    node, key_mark = root, Mark(root.mark.source, 1, 1)
    for key in path:
        child = node.child(key)
        if child is None:
            break
        key_mark = node.keys.get(key, child.mark)
        node = child
    return node, key_mark


def replaced(root: Node, path: tuple[str, ...], value: Node) -> Node:
    """Copy of the nodes with the value at a path; missing sections on the way are created.

    A scalar that stands in the way gives way: validation then names what belongs there.
    """
    if not path:
        return value
    key = path[0]
    if isinstance(root.value, list) and key.isdecimal() and root.child(int(key)):
        children = list(root.value)
        children[int(key)] = replaced(children[int(key)], path[1:], value)
        return replace(root, value=children)
    if not isinstance(root.value, dict):
        root = Node(value.mark, {})
    child = root.value.get(key) or Node(value.mark, None)
    keys = {**root.keys, key: value.mark if len(path) == 1 else root.keys.get(key, value.mark)}
    return replace(root, value={**root.value, key: replaced(child, path[1:], value)}, keys=keys)
