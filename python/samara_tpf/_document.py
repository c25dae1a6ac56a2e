"""Documents as objects: their keys are attributes, and the library reads every change at once.

``_documents`` has the keys, made from the schemas; what stands here for a part of a document is a view of its tree.
"""

from __future__ import annotations

import copy
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, MutableSequence, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Self, TypeVar, get_args, get_type_hints, overload

from ._errors import MissionError
from ._tree import (
    BUILT_IN,
    Keys,
    Kind,
    Tree,
    View,
    at,
    beside,
    from_anywhere,
    keys_of,
    opened,
    path_of,
    plain,
    within,
    without,
)

T = TypeVar("T")
P = TypeVar("P", bound="Part")


class Field(Generic[T]):
    """A key of a part, with its type and its meaning."""

    name: str

    def __init__(self, declared: Callable[[Any], T]) -> None:
        self._declared, self.__doc__ = declared, declared.__doc__

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @cached_property
    def _types(self) -> list[Any]:
        """What the type is made of."""
        waiting, found = [get_type_hints(self._declared)["return"]], list[Any]()
        while waiting:
            found.append(waiting.pop())
            waiting += get_args(found[-1])
        return found

    @property
    def part(self) -> type[Part]:
        """The class of an object here."""
        return next((kind for kind in self._types if isinstance(kind, type) and issubclass(kind, Part)), Part)

    @overload
    def __get__(self, part: None, owner: type) -> Self: ...
    @overload
    def __get__(self, part: Part, owner: type) -> T: ...
    def __get__(self, part: Part | None, owner: type) -> Any:
        if part is None:
            return self
        value = part._at(self.name)
        if value is None and NoneType not in self._types:
            raise AttributeError(f"{part._said(self.name)}: there is none")
        return value

    def __delete__(self, part: Part) -> None:
        part._set(self.name, None)


class leaf(Field[T]):  # noqa: N801
    """A number, a text, a word of some."""

    def __set__(self, part: Part, value: T) -> None:
        part._set(self.name, value)


class either(Field[T]):  # noqa: N801
    """A word, or an object or a list in its place."""

    def __set__(self, part: Part, value: T | Mapping[str, Any] | Sequence[float]) -> None:
        part._set(self.name, value)


class listed(Field["Items[T]"], Generic[T]):  # noqa: N801
    """A list, which is empty where there is none."""

    def __init__(self, declared: Callable[[Any], Items[T]]) -> None:
        super().__init__(declared)

    def __set__(self, part: Part, value: Iterable[T] | Iterable[Mapping[str, Any]] | None) -> None:
        # A text is no list of its letters, nor an object one of its keys: the library refuses them.
        given: Any = value
        if isinstance(given, Iterable) and not isinstance(given, str | Mapping):
            given = list(given)
        part._set(self.name, given)


class section(Field[P]):  # noqa: N801
    """A group of keys, which is empty where there is none."""

    def __set__(self, part: Part, value: P | Mapping[str, Any] | None) -> None:
        part._set(self.name, value)


class inner(section[P]):  # noqa: N801
    """A document within a mission: opened when it is first asked for, the mission's own from its first change on."""

    def __set__(self, part: Part, value: P | Mapping[str, Any] | str | os.PathLike[str] | None) -> None:
        part._set(self.name, value)


class Part(View):
    """A group of keys in a document: attributes to be read and set. The library reads every change at once."""

    __slots__ = ()
    _fields: ClassVar[dict[str, Field[Any]]] = {}

    def __init_subclass__(cls) -> None:
        cls._fields = {**cls._fields, **{name: one for name, one in vars(cls).items() if isinstance(one, Field)}}

    @classmethod
    def _of(cls, tree: Tree, keys: Keys) -> Self:
        part = cls.__new__(cls)
        part._tree, part._keys = tree, keys
        return part

    @property
    def _held(self) -> dict[str, Any]:
        held = self._tree.within(self._keys, self._tree.at(self._keys))
        return held if isinstance(held, dict) else {}

    @property
    def document(self) -> dict[str, Any]:
        """A copy of what it holds, as ``json.load`` gives it."""
        return {**super().document}

    def _at(self, key: str) -> Any:
        """What stands at a key: a view of an object or a list, also of one that is not there; else the value."""
        field, keys = self._fields.get(key), (*self._keys, key)
        part = Part if field is None else field.part
        value = self._tree.within(keys, self._held.get(key))
        if isinstance(value, list) or (value is None and isinstance(field, listed)):
            return Items[Any]._of(self._tree, keys, part)
        if isinstance(value, dict) or (value is None and isinstance(field, section)):
            return part._of(self._tree, keys)
        return value

    def _set(self, key: str, value: Any) -> None:
        is_new = bool(self._keys) and self._tree.at(self._keys) is None
        try:
            self._tree.change([((*self._keys, key), value)])
        except MissionError as error:
            if not is_new:
                raise
            words = f"{error}; there is no `{path_of(self._keys)}` yet: set it as a whole, or keys together by `update`"
            raise MissionError(words, error.file, path=error.path) from None

    def _said(self, key: str = "") -> str:
        """The document and a path in it, for messages."""
        return f"<{self._tree.kind}>: {path_of((*self._keys, key) if key else self._keys)}"

    def _unknown(self, key: str) -> str:
        near = get_close_matches(key, self._fields, 1, 0.5)
        hint = f"did you mean `{near[0]}`?" if near else f"expected one of {', '.join(self._fields)}"
        return f"{self._said(key)}: there is no such key; {hint}"

    if not TYPE_CHECKING:  # what is not declared is a mistake

        def __getattr__(self, name: str) -> Any:
            if name.startswith("_"):
                raise AttributeError(name)
            if name in self._fields:
                raise AttributeError(f"{self._said(name)}: there is none")
            raise AttributeError(self._unknown(name))

        def __setattr__(self, name: str, value: Any) -> None:
            if not name.startswith("_") and name not in self._fields:
                raise AttributeError(self._unknown(name))
            object.__setattr__(self, name, value)

    def __getitem__(self, path: str) -> Any:
        found: Any = self
        for key in keys_of(path):
            there = found._held if isinstance(found, Part | Items) else None
            if at(there, (key,)) is None:
                is_unknown = isinstance(found, Part) and isinstance(key, str) and key not in found._fields
                raise KeyError(found._unknown(key) if is_unknown else f"{self._said(path)}: there is none")
            found = found._at(key)
        return found

    def __setitem__(self, path: str, value: Any) -> None:
        self._tree.change([(self._keys + keys_of(path), value)])

    def __delitem__(self, path: str) -> None:
        if path not in self:
            raise KeyError(f"{self._said(path)}: there is none")
        *outer, last = keys_of(path)
        if isinstance(last, int):
            del self[path_of(tuple(outer))][last]
        else:
            self._tree.change([(self._keys + keys_of(path), None)])

    def __contains__(self, path: object) -> bool:
        try:
            return isinstance(path, str) and self[path] is not None
        except KeyError:
            return False

    def __iter__(self) -> Iterator[str]:
        return iter(self._held)

    def __len__(self) -> int:
        return len(self._held)

    def __eq__(self, other: object) -> bool:
        return self._held == (other._held if isinstance(other, Part) else other)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        shown = (f"{key}={_short(value)}" for key, value in self._held.items() if key != "about")
        return f"{type(self).__name__}({', '.join(shown)})"


class Choice(Part):
    """One of some objects, each by its key: to set another one takes the place of the one that is there."""

    def _set(self, key: str, value: Any) -> None:
        if key in self._held or value is None:
            super()._set(key, value)
        else:
            self._tree.change([(self._keys, {key: value})])


class Items(View, MutableSequence[T]):
    """A list in a document. The library reads every change of it at once."""

    __slots__ = ("_part",)
    _part: type[Part]

    @classmethod
    def _of(cls, tree: Tree, keys: Keys, part: type[Part]) -> Self:
        items = cls.__new__(cls)
        items._tree, items._keys, items._part = tree, keys, part
        return items

    @property
    def _held(self) -> list[Any]:
        held = self._tree.at(self._keys)
        return held if isinstance(held, list) else []

    def _edit(self, edit: Callable[[list[Any]], object]) -> None:
        held = [*self._held]
        edit(held)
        self._tree.change([(self._keys, held)])

    @overload
    def __getitem__(self, index: int) -> T: ...
    @overload
    def __getitem__(self, index: slice) -> list[T]: ...
    def __getitem__(self, index: int | slice) -> Any:
        if isinstance(index, slice):
            return [self[i] for i in range(len(self))[index]]
        return self._at(range(len(self))[index])

    def _at(self, index: int) -> Any:
        """What stands at a place: a view of an object or a list, else the value."""
        keys, value = (*self._keys, index), self._held[index]
        if isinstance(value, dict):
            return self._part._of(self._tree, keys)
        return Items[Any]._of(self._tree, keys, self._part) if isinstance(value, list) else value

    def __setitem__(self, index: int | slice, value: Any) -> None:
        self._edit(lambda held: held.__setitem__(index, value))

    def __delitem__(self, index: int | slice) -> None:
        self._edit(lambda held: held.__delitem__(index))

    def insert(self, index: int, value: T | Mapping[str, Any]) -> None:
        """Inserts an entry before the one of this number."""
        self._edit(lambda held: held.insert(index, value))

    def append(self, value: T | Mapping[str, Any]) -> None:
        """Appends an entry."""
        self.insert(len(self), value)

    def extend(self, values: Iterable[T] | Iterable[Mapping[str, Any]]) -> None:
        """Appends some entries, which are read together."""
        self._edit(lambda held: held.extend(values))

    def clear(self) -> None:
        """Takes all entries away."""
        self._edit(list.clear)

    def reverse(self) -> None:
        """Turns the order of the entries about."""
        self._edit(list.reverse)

    def __len__(self) -> int:
        return len(self._held)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Items):
            return self._held == other._held
        return isinstance(other, Sequence) and self._held == list(other)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return repr(self._held)


class Document(Part, Mapping[str, Any]):
    """A document to be edited: its keys as attributes, and by path as a mapping.

    What is set is read by the library at once, the whole of it: what is refused raises ``MissionError``, with the path,
    and has changed nothing. Several keys that are good only together go by ``update``, or in ``with m.together():``.
    """

    __slots__ = ()
    _kind: ClassVar[Kind] = "mission"

    def __init_subclass__(cls, kind: Kind | None = None) -> None:
        super().__init_subclass__()
        cls._kind = kind or cls._kind

    def __init__(
        self,
        given: str | os.PathLike[str] | Mapping[str, Any],
        *,
        base: str | os.PathLike[str] | None = None,
    ) -> None:
        """``given``: a name, a path, a ``dict`` or such a document, of which this is a copy.

        Relative paths in a ``dict`` start from the folder ``base``, the current one where it is left out.
        """
        if isinstance(given, Document):
            if given._kind != self._kind:
                raise TypeError(f"a document of the kind {self._kind} is expected, found one of the kind {given._kind}")
            self._tree = given.copy()._tree
        elif isinstance(given, Mapping):
            document = json.loads(json.dumps(dict(given), default=plain))
            folder = os.path.join(os.fspath(base or ""), "")
            tree = Tree(self._kind, from_anywhere(self._kind, document, lambda _, path: beside(folder, path)))
            tree.check(tree.held)
            self._tree = tree
        else:
            held, file, text = opened(self._kind, given)
            self._tree = Tree(self._kind, held, (file, text))
        self._keys = ()

    def _given(self) -> tuple[str, str, str | None, str | None]:
        """File, text, and the texts of vehicle and gains where they are not those of the files that it names."""
        tree = self._tree
        if tree.read is not None and tree.held == tree.origin:
            return (*tree.read, None, None)
        text, vehicle, gains = tree.texts(tree.held, written)
        return "<mission>", text, vehicle, gains

    def copy(self) -> Self:
        """A document of its own with the same content."""
        tree = self._tree.another() if not self._keys else Tree(self._kind, self._held)
        return self._of(tree, ())

    __copy__ = copy

    def update(self, changes: Mapping[str, Any] | None = None, /, **more: Any) -> None:
        """Sets keys by path, ``{"release.hang_s": 2.0}``, which are read together; ``None`` takes a key away."""
        given = {**(changes or {}), **more}
        self._tree.change((self._keys + keys_of(path), value) for path, value in given.items())

    def replace(self, changes: Mapping[str, Any] | None = None, /, **more: Any) -> Self:
        """A copy with other values of some keys, as for ``update``."""
        other = self.copy()
        other.update(changes, **more)
        return other

    @contextmanager
    def together(self) -> Iterator[Self]:
        """Changes inside of a ``with`` are read together at its end; refused, none of them has been made."""
        with self._tree.together():
            yield self

    @property
    def changes(self) -> dict[str, tuple[Any, Any]]:
        """What was changed since it was opened: by path, the value that was there and the one that is, or ``None``."""
        return dict(self._changes((), self._tree.at(self._keys, self._tree.origin), self._tree.at(self._keys)))

    def _changes(self, keys: Keys, before: Any, after: Any) -> Iterator[tuple[str, tuple[Any, Any]]]:
        if before == after:
            return
        before, after = (self._tree.within(self._keys + keys, node) for node in (before, after))
        if isinstance(before, dict) and isinstance(after, dict):
            for key in dict.fromkeys([*before, *after]):
                yield from self._changes((*keys, key), before.get(key), after.get(key))
        elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after) and not _flat(after):
            for index, pair in enumerate(zip(before, after, strict=True)):
                yield from self._changes((*keys, index), *pair)
        else:
            yield path_of(keys), (copy.deepcopy(before), copy.deepcopy(after))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the document. Files that it names are named from there, with relative paths.

        Vehicle and gains that were changed, or are of no file, are written beside it, with ``_vehicle`` and ``_gains``
        behind the name of its file.
        """
        file = Path(path).absolute()
        held = self._held
        for kind in within(self._kind):
            if isinstance(document := held.get(kind), dict):
                own = file.with_name(f"{file.stem}_{kind}.json")
                _write(own, kind, document)
                held = {**held, kind: os.fspath(own)}
        _write(file, self._kind, held)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Document):
            return self._held == other
        return self._kind == other._kind and self._whole(other) == other._whole(self)

    def _whole(self, other: Document) -> dict[str, Any]:
        """What it holds, with the documents opened whose paths are not those of another one; not what editors read."""
        whole = {**self._held}
        for kind in within(self._kind):
            if whole.get(kind) != other._held.get(kind):
                whole[kind] = without("$schema", self._tree.within((kind,), whole.get(kind)))
        return without("$schema", whole)

    def __repr__(self) -> str:
        changes = [f"{path} {_short(a)} -> {_short(b)}" for path, (a, b) in self.changes.items()]
        told = ", ".join(changes[:4]) + (f" and {len(changes) - 4} more" if len(changes) > 4 else "")
        return f"<{type(self).__name__} {self._held.get('name')}{': ' if told else ''}{told}>"


def _short(value: Any) -> str:
    """A value as far as it fits in a line with others."""
    text = f"{value:g}" if isinstance(value, float) else repr(value)
    return text if len(text) <= 48 else f"{text[:45]}..."


def _write(file: Path, kind: Kind, document: dict[str, Any]) -> None:
    """Writes a document for the folder of its file."""

    def near(_: str, path: str) -> str:
        return path if path.startswith(BUILT_IN) else os.path.relpath(path, file.parent).replace(os.sep, "/")

    if "://" not in document.get("$schema", "://"):
        document = without("$schema", document)
    file.write_text(written(from_anywhere(kind, document, near)) + "\n", encoding="utf-8")


def _flat(values: list[Any]) -> bool:
    """Whether a list has no object and no list in it."""
    return not any(isinstance(value, dict | list) for value in values)


def written(node: Any, indent: str = "") -> str:
    """A document as JSON for readers: lists of values, and short entries of lists, on a line."""
    inside = f"{indent}  "
    if isinstance(node, dict) and node:
        rows = [f"{_line(key)}: {written(value, inside)}" for key, value in node.items()]
    elif isinstance(node, list) and not _flat(node):
        rows = [line if len(line := _line(value)) <= 100 else written(value, inside) for value in node]
    else:
        return _line(node)
    first, last = "{}" if isinstance(node, dict) else "[]"
    return f"{first}\n" + ",\n".join(inside + row for row in rows) + f"\n{indent}{last}"


def _line(node: Any) -> str:
    return json.dumps(node, ensure_ascii=False)
