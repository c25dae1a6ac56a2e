"""The reference of ``samara_tpf``, built from its types and docstrings::

    pip install --no-deps -r python/docs/requirements.txt
    python -m sphinx -W python/docs target/reference/html

Nothing is compiled for it: the stub of the extension module stands in its place. A public name that is on no page is a
warning, as is a reference that leads nowhere.
"""

from __future__ import annotations

import __future__

import ast
import importlib
import os
import re
import sys
from collections.abc import Callable, Container, Iterator
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, Generic, TypeVar

import numpy.typing
from docutils import nodes
from docutils.parsers.rst import Directive
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.pycode import ModuleAnalyzer
from sphinx.util import logging
from sphinx.util.typing import stringify_annotation

PACKAGE = Path(__file__).resolve().parents[1]
sys.path.insert(0, os.fspath(PACKAGE))
STUB = "samara_tpf._samara"
Scalar = TypeVar("Scalar")


def stand_in(name: str, stub: Path) -> Callable[[], None]:
    """A module of what a stub declares, under the name of the module that it is of.

    What the stub takes from its package, for types alone, comes by a call once the package is there.
    """
    module = ModuleType(name)
    module.__package__ = name.rpartition(".")[0]
    sys.modules[name] = module
    tree = ast.parse(stub.read_text(encoding="utf-8"))
    own = [node for node in tree.body if isinstance(node, ast.ImportFrom) and node.level]

    def run(body: list[Any]) -> None:
        flags = __future__.annotations.compiler_flag
        exec(compile(ast.Module(body, []), stub, "exec", flags, dont_inherit=True), module.__dict__)

    run([node for node in tree.body if node not in own])
    return lambda: run(own)


class ArrayLike:
    """NumPy's by name: the union that it stands for fills a page."""


class NDArray(Generic[Scalar]):
    """NumPy's by name."""


ArrayLike.__module__ = NDArray.__module__ = "numpy.typing"
vars(numpy.typing).update(ArrayLike=ArrayLike, NDArray=NDArray)
types_of_stub = stand_in(STUB, PACKAGE / "samara_tpf/_samara.pyi")
importlib.import_module("samara_tpf._verbs")
PUBLIC = [importlib.import_module(name) for name in ("samara_tpf", "samara_tpf.inside", "samara_tpf.gym")]
types_of_stub()
# The modules of the package, and the public aliases of types in them, which are shown by their names, too.
OWN = {name: module for name, module in sys.modules.items() if name.startswith("samara_tpf.") and name != STUB}
ALIASES = {
    f"{module.__name__}.{name}": value
    for module in PUBLIC
    for name, value in ((name, getattr(module, name)) for name in module.__all__)
    if not isinstance(value, type | FunctionType | float)
}
for alias in ALIASES:
    of, _, name = alias.rpartition(".")
    for module in OWN.values():
        if name in vars(module):
            setattr(module, name, type(name, (), {"__module__": of}))

# Keys of documents are shown as properties, with the types that they are declared with.
for kind in vars(OWN["samara_tpf._documents"]).values():
    if isinstance(kind, type):
        for name, field in list(vars(kind).items()):
            if isinstance(field, OWN["samara_tpf._document"].Field):
                setattr(kind, name, property(field._declared))

project = "samara_tpf"
html_title = "samara for Python"
html_theme = "alabaster"
html_theme_options = {
    "page_width": "76rem",
    "sidebar_width": "15rem",
    "body_max_width": "58rem",
    "font_size": "1rem",
    "code_font_size": "0.85em",
    "show_powered_by": False,
}
html_copy_source = False
html_show_copyright = False

extensions = ["sphinx.ext.autodoc"]
default_role = "literal"
nitpicky = True
# What is others' has no page here.
nitpick_ignore_regex = [(".*", r"(numpy|np|npt|pandas|polars|pyarrow|gymnasium|os|collections|typing)\b.*"), (".*", r"samara_tpf\._\w+\.[A-Z]")]
add_module_names = False
toc_object_entries_show_parents = "hide"
python_maximum_signature_line_length = 90
autoclass_content = "both"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
autodoc_preserve_defaults = True
# Classes whose objects are made by whoever reads this; all others are what a verb gives.
MADE = {"Columns", "Judge", "Vehicle", "DropEnv", "DropVectorEnv"}


def signature(app: Sphinx, what: str, name: str, of: Any, options: Any, arguments: str | None, returns: Any) -> Any:
    """None of a class whose objects verbs give."""
    if what in ("class", "exception") and arguments and name.rpartition(".")[2] not in MADE:
        return "", None
    return None


def docstring(app: Sphinx, what: str, name: str, of: Any, options: Any, lines: list[str]) -> None:
    """What an alias of types stands for, and what stands below it in the module that it is of."""
    if name in ALIASES:
        alias = ("", name.rpartition(".")[2])
        for said in (ModuleAnalyzer.for_module(module).find_attr_docs() for module in OWN):
            if alias in said:
                types = re.sub(r"~[\w.]*\.", "", stringify_annotation(ALIASES[name], "smart"))
                lines[:] = [*said[alias], f"``{types}``", ""]
    # Magnitudes, which are no names of something to be put in their place.
    lines[:] = [line if "`" in line else line.replace("|", r"\|") for line in lines]


def titles(app: Sphinx, tree: nodes.document, page: str) -> None:
    """What a link says under the pointer: public names in the place of the private modules that hold them."""
    for link in tree.findall(nodes.reference):
        if title := link.get("reftitle"):
            link["reftitle"] = re.sub(r"^samara_tpf\._\w+\.", "samara_tpf.", title)


def public(module: ModuleType, there: Container[str]) -> Iterator[str]:
    """Public names of a module, and of its classes that are there, but for what is a base's of others."""
    for name in module.__all__:
        yield (whole := f"{module.__name__}.{name}")
        if isinstance(of := getattr(module, name), type) and whole in there:
            others = [base for base in of.__mro__[1:] if not base.__module__.startswith("samara_tpf.")]
            for member in dict.fromkeys([*vars(of), *vars(of).get("__annotations__", {})]):
                if not member.startswith("_") and not any(hasattr(base, member) for base in others):
                    yield f"{whole}.{member}"


def nothing_is_missing(app: Sphinx, env: BuildEnvironment) -> None:
    """A warning for each public name that is on no page, as one without a docstring is."""
    there = env.domaindata["py"]["objects"]
    for name in [name for module in PUBLIC for name in public(module, there) if name not in there]:
        logging.getLogger(__name__).warning("%s is public, and has no docstring or no page in python/docs", name)


class Help(Directive):
    """What ``python -m samara_tpf.campaign --help`` prints."""

    def run(self) -> list[nodes.Node]:
        os.environ["COLUMNS"] = "96"
        text = importlib.import_module("samara_tpf.campaign.arguments").parser().format_help()
        return [nodes.literal_block(text, text, language="none")]


def setup(app: Sphinx) -> None:
    app.add_directive("help", Help)
    app.connect("autodoc-process-signature", signature)
    app.connect("autodoc-process-docstring", docstring)
    app.connect("doctree-resolved", titles)
    app.connect("env-check-consistency", nothing_is_missing)
