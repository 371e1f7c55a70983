"""Progress of runs on the terminal."""

import sys
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars


class Progress:
    """Bars when the output is a terminal, plain lines otherwise, nothing when there is nothing to wait for."""

    def __init__(self) -> None:
        console = Console(stderr=True)
        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
        self._bars = Bars(*columns, console=console) if console.is_terminal else None
        self._tasks: dict[str, TaskID] = {}

    def __enter__(self) -> "Progress":
        if self._bars:
            self._bars.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._bars:
            self._bars.stop()

    def update(self, study: str, done: int, total: int) -> None:
        if self._bars:
            if study not in self._tasks:
                self._tasks[study] = self._bars.add_task(study, total=total)
            self._bars.update(self._tasks[study], completed=done)
        elif done == total:
            print(f"{study}: {total} runs", file=sys.stderr)
