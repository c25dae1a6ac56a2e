"""The reference of ``samara_tpf``, built from its types and docstrings::

    pip install --no-deps -r python/docs/requirements.txt
    python -m sphinx -W python/docs target/reference/html

Nothing is compiled for it: the stub of the extension module stands in its place. A public name that is on no page is a
warning, as is a reference that leads nowhere.
"""

from __future__ import annotations

import __future__

import importlib
import os
import re
import sys
from pathlib import Path
from types import ModuleType
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
Scalar = TypeVar("Scalar")


def stand_in(name: str, stub: Path) -> None:
    """A module of what a stub declares, under the name of the module that it is of."""
    module = ModuleType(name)
    module.__package__ = name.rpartition(".")[0]
    sys.modules[name] = module
    flags = __future__.annotations.compiler_flag
    exec(compile(stub.read_text(encoding="utf-8"), stub, "exec", flags, dont_inherit=True), module.__dict__)


class ArrayLike:
    """NumPy's by name: the union that it stands for fills a page."""


class NDArray(Generic[Scalar]):
    """NumPy's by name."""


ArrayLike.__module__ = NDArray.__module__ = "numpy.typing"
vars(numpy.typing).update(ArrayLike=ArrayLike, NDArray=NDArray)
stand_in("samara_tpf._samara", PACKAGE / "samara_tpf/_samara.pyi")
PUBLIC = [importlib.import_module(name) for name in ("samara_tpf", "samara_tpf.inside", "samara_tpf.gym")]
# Aliases of types, which are shown by their names, too.
ALIASES = {
    f"{module.__name__}.{name}": getattr(module, name)
    for module, names in zip(PUBLIC, [("MissionLike", "GainsLike", "TrajectoryLike"), (), ("Action",)], strict=True)
    for name in names
}
for alias in ALIASES:
    of, _, name = alias.rpartition(".")
    for own in [vars(module) for place, module in sys.modules.items() if place.startswith("samara_tpf.")]:
        if name in own:
            own[name] = type(name, (), {"__module__": of})

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
nitpicky = True
# What is others' has no page here.
nitpick_ignore_regex = [(".*", r"(numpy|np|npt|pandas|pyarrow|gymnasium|os|collections|typing)\b.*")]
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
        module, _, alias = name.rpartition(".")
        said = ModuleAnalyzer.for_module("samara_tpf._given" if module == "samara_tpf" else module).find_attr_docs()
        types = re.sub(r"~[\w.]*\.", "", stringify_annotation(ALIASES[name], "smart"))
        lines[:] = [*said["", alias], f"``{types}``", ""]


def reference(app: Sphinx, env: BuildEnvironment, node: Any, content: Any) -> Any:
    """Public names in the place of those of the private modules that hold them."""
    module, _, name = node.get("reftarget", "").rpartition(".")
    if module.startswith("samara_tpf._") and name in PUBLIC[0].__all__:
        python = env.get_domain("py")
        return python.resolve_xref(env, node["refdoc"], app.builder, "obj", f"samara_tpf.{name}", node, content)
    return None


def nothing_is_missing(app: Sphinx, env: BuildEnvironment) -> None:
    """A warning for each public name that is on no page."""
    there = env.domaindata["py"]["objects"]
    for name in [f"{module.__name__}.{name}" for module in PUBLIC for name in module.__all__]:
        if name not in there:
            logging.getLogger(__name__).warning("%s is public, and on no page of python/docs", name)


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
    app.connect("missing-reference", reference)
    app.connect("env-check-consistency", nothing_is_missing)
