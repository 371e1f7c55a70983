"""Compiled functions: a traced function is called once with values for its arguments, and what it emits becomes machine code.

Python runs the traced function once for each combination of kinds of arguments. Object code is kept on the disk, if a folder of
sources is named, under a name that changes with the sources, the kinds and the machine.
"""

import hashlib
import itertools
import threading
from collections.abc import Callable
from ctypes import CFUNCTYPE, c_void_p
from pathlib import Path
from typing import Any

import numpy as np
from llvmlite import ir

from . import arguments as border
from . import disk
from .machine import address_of, identity, object_code
from .threads import start_threads
from .values import INTEGER

NUMBERS = itertools.count()
"""Counter that makes the names of functions unique that are not on the disk."""
ENTRY = CFUNCTYPE(None, c_void_p, c_void_p)
"""What Python calls: the addresses of the slots of the arguments and of the result. Other threads of Python run meanwhile."""


def checksum(folder: Path) -> str:
    """Checksum of the names and contents of the Python files in a folder, those below it included, and of the tracing compiler.

    Parameters
    ----------
    folder : Path
        Of the code that is compiled.
    """
    found = hashlib.sha256()
    for part in (folder, Path(__file__).parent):
        for path in sorted(part.rglob("*.py")):
            content = path.read_bytes()
            found.update(f"{path.relative_to(part).as_posix()} {len(content)}\n".encode() + content)
    return found.hexdigest()


class Entry:
    """Compiled code for arguments of some kinds.

    Parameters
    ----------
    kinds : tuple
        Kinds of the arguments, see `arguments.kinds_of`.
    address : int
    form : list, int or None
        Form of the result, see `arguments.form_of`.
    """

    def __init__(self, kinds: Any, address: int, form: Any) -> None:
        self._kinds, self._run, self._form, self._room = kinds, ENTRY(address), form, border.room(form)

    def __call__(self, *arguments: Any) -> Any:
        return self.bound()(*arguments)

    def bound(self, *first: Any) -> Callable[..., Any]:
        """Return the code with its first arguments given for all calls: arrays, which calls may change, and numbers.

        Raises
        ------
        TypeError
            If the arguments, here or of a call, are of other kinds than the code.
        """
        known, count = border.slots_of(first), len(first) + 1
        self._check(first, self._kinds[1:count])

        def call(*rest: Any, held: tuple[Any, ...] = first) -> Any:  # the arrays live as long as what knows their addresses
            self._check(rest, self._kinds[count:])
            slots, result = np.append(known, border.slots_of(rest)), np.empty(self._room, dtype=np.int64)
            self._run(slots.ctypes.data, result.ctypes.data)
            return border.read(self._form, iter(result))

        return call

    @staticmethod
    def _check(arguments: tuple[Any, ...], kinds: tuple[Any, ...]) -> None:
        if border.kinds_of(arguments)[1:] != kinds:
            raise TypeError(
                "the arguments are of other kinds than those that the code was compiled for: ask for an entry for these"
            )


class Compiled:
    """A traced function that Python calls.

    Parameters
    ----------
    function : callable
        Of numbers, C-contiguous arrays of doubles or integers, None, and tuples of these; returns numbers, None, or tuples of these.
        Named tuples that it returns become plain ones.
    name : str, optional
        Of the function on the disk; no other one of these sources has it.
    sources : Path, optional
        Folder of the code that is compiled; without it nothing is kept on the disk.

    Attributes
    ----------
    from_disk, made : int
        Numbers of entries that were found on the disk, and that were compiled.

    Raises
    ------
    TypeError
        When a call is compiled, if the function branches on a value or uses one as the wrong type.
    RuntimeError
        When a call is compiled, if LLVM refuses the code.
    """

    def __init__(self, function: Callable[..., Any], name: str = "", sources: Path | None = None) -> None:
        self._function, self._name, self._sources = function, name, sources
        # Of what this process has imported, whatever the files hold later.
        self._checksum = checksum(sources) if sources else ""
        self._entries: dict[Any, Entry] = {}
        self._lock = threading.Lock()
        self.from_disk = self.made = 0

    def __call__(self, *arguments: Any) -> Any:
        return self.entry(*arguments)(*arguments)

    def entry(self, *arguments: Any) -> Entry:
        """Return the code for arguments of these kinds; it is compiled if need be, and not run."""
        kinds = border.kinds_of(arguments)
        with self._lock:
            if kinds not in self._entries:
                self._entries[kinds] = self._found(kinds)
        return self._entries[kinds]

    def _found(self, kinds: Any) -> Entry:
        """Entry from the disk, or else compiled."""
        folder = disk.folder_for(self._sources) if self._sources else None
        if folder is None or self._sources is None:
            name = f"entry_{next(NUMBERS)}"
            kept, _ = self._compiled(kinds, name)
            return Entry(kinds, address_of(kept.code, name), kept.form)
        said = f"{self._checksum} {identity()} {border.spelled(kinds)}"
        name = f"{self._name}-{hashlib.sha256(said.encode()).hexdigest()[:32]}"
        path = folder / f"{name}.code"
        found = disk.read(path)
        if found and (not found.threads or start_threads()):
            self.from_disk += 1
            return Entry(kinds, address_of(found.code, name), found.form)
        kept, lasting = self._compiled(kinds, name)
        if lasting and checksum(self._sources) == self._checksum:
            disk.write(path, kept)
        return Entry(kinds, address_of(kept.code, name), kept.form)

    def _compiled(self, kinds: Any, name: str) -> tuple[disk.Kept, bool]:
        """Code with a function of this name; and whether other processes may use it, which is not so where threads cannot be launched."""
        self.made += 1
        module = ir.Module(name)
        main = ir.Function(module, ir.FunctionType(ir.VoidType(), [border.SLOTS] * 2), name)
        builder = ir.IRBuilder(main.append_basic_block())
        slots, room = main.args
        codes = (
            builder.load(builder.gep(slots, [INTEGER(k)], inbounds=True, source_etype=INTEGER), typ=INTEGER)
            for k in range(border.count_slots(kinds))
        )
        result = self._function(*border.loaded(builder, kinds, codes))
        form = border.form_of(result)
        border.store(builder, result, room)
        builder.ret_void()
        threads = getattr(module, "in_threads", None)
        return disk.Kept(object_code(module), form, bool(threads)), threads is not False
