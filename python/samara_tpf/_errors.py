"""Why a verb has no answer."""

from __future__ import annotations

from typing import Any


class MissionError(ValueError):
    """A mission, a file or a choice that is refused.

    The text is the one that the program prints. ``file`` is the file that is at fault and ``path`` the place in
    the document (``site.gravity_m_s2``, ``rotors[2].axis_body``), where there is one; ``line`` and ``column``
    count from 1. A mission given as a ``dict`` is read as the text ``json.dumps(mission, indent=2)``; of what is set in
    a ``Mission`` there is the path alone.
    """

    file: str | None
    line: int | None
    column: int | None
    path: str | None

    def __init__(
        self,
        message: str,
        file: str | None = None,
        line: int | None = None,
        column: int | None = None,
        path: str | None = None,
    ) -> None:
        super().__init__(message)
        self.file = file
        self.line = line
        self.column = column
        self.path = path

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.file, self.line, self.column, self.path)


class PlanError(RuntimeError):
    """No plan was found to fly, tune or assess.

    ``status`` is the solver's, as in ``Plan.status``; ``diagnosis`` says why, in words.
    """

    status: str
    diagnosis: str

    def __init__(self, status: str, diagnosis: str) -> None:
        super().__init__(f"no plan to fly: {status}: {diagnosis}")
        self.status = status
        self.diagnosis = diagnosis

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.status, self.diagnosis)


class ControllerError(ValueError):
    """What a controller of one's own returned is refused: NaN, no numbers, or not one for each rotor.

    ``since_reset_s`` is the time since the controller's reset [s].
    """

    since_reset_s: float

    def __init__(self, message: str, since_reset_s: float) -> None:
        super().__init__(message)
        self.since_reset_s = since_reset_s

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.since_reset_s)


class TuneError(RuntimeError):
    """A search found no gains that fly every release."""
