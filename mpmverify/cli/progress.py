"""Progress of runs on the terminal."""

from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bars


class Progress:
    """A bar for each study at work, below what is printed meanwhile; without a terminal, plain lines on standard error alone.

    The time left follows from the speed of the last runs.

    Parameters
    ----------
    console : Console
        Where the bars are; lines that are printed to it go above them.
    """

    def __init__(self, console: Console) -> None:
        times = (TimeElapsedColumn(), TextColumn("left:"), TimeRemainingColumn())
        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), *times)
        bars = Bars(*columns, console=console, redirect_stdout=False, redirect_stderr=False)
        self._console = console
        self._bars = bars if console.is_terminal else None
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
            if done == total:
                self._bars.remove_task(self._tasks.pop(study))
                self._bars.refresh()  # or else the next line that is printed draws it again
        elif self._console.stderr and done == total:
            self._console.print(f"{study}: {total} runs", highlight=False, markup=False)
