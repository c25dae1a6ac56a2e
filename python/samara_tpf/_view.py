"""A mission, or a run, in the browser: ``samara view`` in a process of its own."""

from __future__ import annotations

import atexit
import os
import re
import subprocess
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile
from types import TracebackType
from typing import Self

from ._checks import in_range
from ._given import MissionLike
from ._on_disk import mission_on_disk
from ._program import SERVED, failure

# How long it may take to end when it is asked to [s].
_PATIENCE_S = 5.0


class View:
    """A page that is served to this machine, until it is closed or this interpreter ends."""

    url: str
    """Address of the page, for a browser on this machine; whoever has it may look."""

    def __init__(self, words: list[str], folder: TemporaryDirectory[str]) -> None:
        self._folder = folder
        with TemporaryFile() as reported:
            # A session of its own: Ctrl-C on the terminal is for what this interpreter does.
            self._process = subprocess.Popen(
                [*SERVED, "view", *words],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=reported,
                start_new_session=True,
                text=True,
            )
            atexit.register(self.close)
            try:
                self.url = self._address()
                if not self.url:
                    reported.seek(0)
                    raise failure("view", self._process.wait(), reported.read())
            except BaseException:
                self.close()
                raise

    def _address(self) -> str:
        """The address, when it is printed; nothing where it is not."""
        assert self._process.stdout is not None
        found = (re.match(r"http://127\.0\.0\.1:\d+/#\w+$", line) for line in self._process.stdout)
        return next((address.group() for address in found if address), "")

    @property
    def closed(self) -> bool:
        """Whether nothing is served any more."""
        return self._process.poll() is not None

    def close(self) -> None:
        """Ends it; the page stays as it is, and nothing more is flown."""
        atexit.unregister(self.close)
        if self._process.poll() is None:
            self._process.terminate()
            try:
                self._process.wait(_PATIENCE_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()
        self._folder.cleanup()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _repr_html_(self) -> str:
        if self.closed:
            return "<p>closed</p>"
        # The page forbids to be framed: it is opened beside the notebook.
        shown = escape(self.url.split("#")[0])
        return f'<p><a href="{escape(self.url)}" target="_blank" rel="noopener">{shown}</a></p>'

    def __repr__(self) -> str:
        return f"<View: {'closed' if self.closed else self.url}>"


def view(
    mission: MissionLike = "titan_drop",
    port: int | None = None,
    open: bool = True,
    *,
    base: str | os.PathLike[str] | None = None,
) -> View:
    """Serves a page on which a mission is looked at, changed and flown anew at once, as ``samara view``.

    ``mission`` may also be the folder of a run, whose pages and worst trials are shown; ``port``: of 127.0.0.1, any
    free one unless given; ``open``: open the page in the browser, where there is a display. It ends with ``close()``,
    at the end of a ``with`` or of this interpreter, and what the page wrote beside a mission given as a ``dict`` with
    it.

    ``MissionError``: the mission is refused, or the port is taken.
    """
    in_range("port", port, 1, 65535)
    folder: TemporaryDirectory[str] = TemporaryDirectory(prefix="samara-view-")
    try:
        subject = mission_on_disk(mission, Path(folder.name), base)
        words = [f"--port={port or 0}", *([] if open else ["--no-open"]), "--", subject]
        return View(words, folder)
    except BaseException:
        folder.cleanup()
        raise
