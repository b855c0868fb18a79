"""What results of commands can do: be seen, be a table, and be written once more."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import DomainError

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure


class Reported:
    """A result that knows its report, where a command such as `geomint.drift_report` has found it."""

    _make: Callable[[], Any] | None = None  # its report

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in self.__dict__.items() if key != "_make"}

    def _report(self) -> Any:
        if self._make is None:
            raise DomainError(
                "report", ..., "a result of a report, such as geomint.drift_report gives"
            )
        return self._make()

    def report(self, folder: str | PathLike[str], paper: bool = False) -> Path:
        """Write the report into a folder; return the path of its page. `paper`: what is for one too.

        Raises
        ------
        OutputError
            If the folder cannot be written; what was there is as it was.
        DomainError
            Of a result that no command has found.
        """
        written: Path = self._report().write(Path(folder), paper)
        return written

    def plot(self) -> Figure:
        """Return the picture of the report."""
        figure: Figure = next(iter(self._report().pictures.values())).figure
        return figure

    def to_dataframe(self) -> Any:
        """Return the numbers of the report's CSV as a `pandas.DataFrame`."""
        return self._report().to_dataframe()
