"""The tree of a document, as JSON has it: paths in it, changes of it, and the library that reads it after each.

A tree is never changed in place: a change makes another one, which takes the place of the first if it is not refused.
"""

from __future__ import annotations

import copy
import json
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Literal, TypeAlias

from . import _samara
from ._errors import MissionError

Kind: TypeAlias = Literal["mission", "vehicle", "gains"]
Keys: TypeAlias = tuple[str | int, ...]

BUILT_IN = "built-in:"
# Keys that are paths of files.
_TABLES = ("rotor.blade_element.file", "rotor.table.file")
_FILES = {
    "mission": (
        *("vehicle", "gains", "px4_params", "replan.gains", "wind.turbulence.noise"),
        *(f"vehicle.{key}" for key in _TABLES),
    ),
    "vehicle": _TABLES,
    "gains": (),
}
_READER = _samara.Reader()


def plain(value: Any) -> Any:
    """What JSON has for a part of a document, for NumPy's arrays and numbers, for a path."""
    if isinstance(value, View):
        return value.document
    if isinstance(value, Mapping):
        return dict(value)
    if callable(tolist := getattr(value, "tolist", None)):
        return tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"a mission cannot hold a {type(value).__name__}: {value!r}")


def within(kind: Kind) -> tuple[Kind, ...]:
    """Keys of a document that are documents themselves, or the paths of such."""
    return ("vehicle", "gains") if kind == "mission" else ()


def keys_of(path: str) -> Keys:
    """The keys of a path such as ``tuning.cases[0].pitch_deg``."""
    if not re.fullmatch(r"[^.\[\]]+(\.[^.\[\]]+|\[\d+\])*", path):
        raise KeyError(f"a path such as `tuning.cases[0].pitch_deg` is expected, found {path!r}")
    return tuple(int(key[1:-1]) if key[0] == "[" else key for key in re.findall(r"[^.\[\]]+|\[\d+\]", path))


def path_of(keys: Keys) -> str:
    """The path of some keys."""
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in keys).removeprefix(".")


def beside(file: str, path: str) -> str:
    """The path that the document ``file`` names by ``path``, from anywhere."""
    if path.startswith(BUILT_IN):
        return path
    if file.startswith(BUILT_IN):
        inside = os.path.dirname(file[len(BUILT_IN) :])
        return BUILT_IN + os.path.normpath(os.path.join(inside, path)).replace(os.sep, "/")
    return os.path.abspath(os.path.join(os.path.dirname(file), path))


def from_anywhere(kind: Kind, document: dict[str, Any], place: Callable[[str, str], str]) -> dict[str, Any]:
    """The document with the paths in it as ``place`` has them, by key and path."""
    for key in _FILES[kind]:
        keys = keys_of(key)
        if isinstance(path := at(document, keys), str) and (placed := place(key, path)) != path:
            document = put(document, keys, placed)
    return document


def at(node: Any, keys: Keys) -> Any:
    """What a tree holds; ``None`` where there is nothing."""
    for key in keys:
        try:
            node = node[key]
        except (LookupError, TypeError):
            return None
    return node


def put(node: Any, keys: Keys, value: Any) -> Any:
    """The tree with another value, or with none for ``None``; groups that are not there are made."""
    key, rest = keys[0], keys[1:]
    if isinstance(node, list) and isinstance(key, int) and key < len(node):
        entries = [*node]
        entries[key] = put(node[key], rest, value) if rest else value
        return entries
    if (node is None or isinstance(node, dict)) and isinstance(key, str):
        group = node or {}
        value = put(group.get(key), rest, value) if rest else value
        return without(key, group) if value is None else {**group, key: value}
    raise LookupError


def without(key: str, group: dict[str, Any]) -> dict[str, Any]:
    """An object without a key."""
    return {other: value for other, value in group.items() if other != key}


class View:
    """A place in a tree, whatever is there."""

    __slots__ = ("_keys", "_tree")
    _tree: Tree
    _keys: Keys

    @property
    def _held(self) -> Any:
        """What there is, an object or a list; an empty one where there is nothing."""
        raise NotImplementedError

    @property
    def document(self) -> Any:
        """A copy of what it holds, as ``json.load`` gives it."""
        return copy.deepcopy(self._held)


class Tree:
    """What a document holds, and what it was opened from."""

    def __init__(self, kind: Kind, held: dict[str, Any], read: tuple[str, str] | None = None) -> None:
        self.kind, self.held, self.origin, self.read = kind, held, held, read
        self.open_edits = 0
        self.opened: dict[tuple[str, str], dict[str, Any]] = {}

    def another(self) -> Tree:
        """A tree of its own with the same content."""
        tree = Tree(self.kind, self.origin, self.read)
        tree.held, tree.opened = self.held, {**self.opened}
        return tree

    def within(self, keys: Keys, node: Any) -> Any:
        """A node, or the document in its place if it is the path of one."""
        kind = next((kind for kind in within(self.kind) if keys == (kind,)), None)
        if kind is None or not isinstance(node, str):
            return node
        if (kind, node) not in self.opened:
            self.opened[kind, node] = opened(kind, node)[0]
        return self.opened[kind, node]

    def at(self, keys: Keys, held: Any = None) -> Any:
        """What there is at a path; ``None`` where there is nothing."""
        node = self.held if held is None else held
        if keys:
            node = at(self.within(keys[:1], at(node, keys[:1])), keys[1:])
        return node

    def change(self, edits: Iterable[tuple[Keys, Any]]) -> None:
        """Puts values in their places, ``None`` for none there, and reads the whole; refused, nothing has changed."""
        held = self.held
        for keys, value in edits:
            if len(keys) > 1 and (outer := at(held, keys[:1])) is not (inner := self.within(keys[:1], outer)):
                held = put(held, keys[:1], inner)
            try:
                held = put(held, keys, json.loads(json.dumps(value, default=plain)))
            except LookupError:
                raise KeyError(f"<{self.kind}>: {path_of(keys)}: there is no such place") from None
        held = from_anywhere(self.kind, held, _from_here)
        if not self.open_edits:
            self.check(held)
        self.held = held

    @contextmanager
    def together(self) -> Iterator[None]:
        """Changes that are read as one at the end."""
        before = self.held
        self.open_edits += 1
        try:
            yield
            if self.open_edits == 1:
                self.check(self.held)
        except BaseException:
            self.held = before
            raise
        finally:
            self.open_edits -= 1

    def texts(self, held: dict[str, Any], written: Callable[[Any], str]) -> tuple[str, str | None, str | None]:
        """Texts of the document, and of vehicle and gains where it holds them."""
        document, inner = {**held}, dict[str, str]()
        for kind in within(self.kind):
            if isinstance(held.get(kind), dict):
                document[kind], inner[kind] = f"<{kind}>", written(held[kind])
        return written(document), inner.get("vehicle"), inner.get("gains")

    def check(self, held: dict[str, Any]) -> None:
        """Has the library read the document. ``MissionError``: it is refused."""
        try:
            read(self.kind, f"<{self.kind}>", *self.texts(held, json.dumps))
        except MissionError as error:
            raise self.said(error) from None

    def said(self, error: MissionError) -> MissionError:
        """What is said of a text, of the document: without line and column."""
        kind = (error.file or "")[1:-1]
        if error.file != f"<{kind}>":
            return error
        words = str(error).removeprefix(f"{error.file}:{error.line}:{error.column}: ")
        path = error.path or ""
        if kind != self.kind:
            words = f"{kind}.{words}" if path else f"{kind}: {words}"
            path = f"{kind}.{path}" if path else kind
        return MissionError(f"<{self.kind}>: {words}", f"<{self.kind}>", path=path or None)


def read(kind: Kind, file: str, text: str, vehicle: str | None = None, gains: str | None = None) -> None:
    """Has the library read a text. ``MissionError``: it is refused."""
    if kind == "mission":
        _READER.mission(text, file, vehicle, gains)
    elif kind == "vehicle":
        _READER.vehicle(text, file)
    else:
        _READER.gains(text, file)


def opened(kind: Kind, name: str | os.PathLike[str]) -> tuple[dict[str, Any], str, str]:
    """A document by name or path, with paths that lead there from anywhere; its file and text."""
    found, text = _samara.document_text(kind, name)
    read(kind, os.fspath(found), text)
    file = beside("", os.fspath(found))
    return from_anywhere(kind, json.loads(text), lambda _, path: beside(file, path)), file, text


def _from_here(key: str, path: str) -> str:
    """A path that is given from the current folder; vehicle and gains may go by their names."""
    if path.startswith(BUILT_IN) or os.path.isabs(path):
        return path
    is_document = key in within("mission")
    return beside("", os.fspath(_samara.document_text(key, path)[0]) if is_document else path)
