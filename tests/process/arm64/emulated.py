"""Kernels and drivers as AArch64 code under qemu-user, in the place of this machine's.

What decides about machine code says the other architecture (`native.cpu`, `native._machine`); what would be loaded here
is linked and loaded by a process under qemu (guest.c), which calls it. Both see the same memory at the same address, so
that everything above, such as how runs are packed into lanes, is what it is on any machine.
"""

import contextlib
import ctypes
import mmap
import os
import platform
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from llvmlite import binding

from lienumba.batch import integrate
from lienumba.compiler import cache, flat, native
from lienumba.compiler.memo import Memo
from lienumba.integrators.tracing import machine
from lienumba.mechanics.mechanism.tables import Numbers
from lienumba.sweep.noise import Courses

TRIPLE = "aarch64-unknown-linux-gnu"
SYSROOT = Path("/usr/aarch64-linux-gnu")
COMPILER, LINKER = "aarch64-linux-gnu-gcc", "aarch64-linux-gnu-ld"
PACKAGES = "qemu-user-static gcc-aarch64-linux-gnu libc6-dev-arm64-cross"
ADDRESS, SIZE = 1 << 44, 1 << 28  # of the memory that both see
FIXED = 0x100000  # MAP_FIXED_NOREPLACE of Linux
CPU = ("generic", "")


def missing() -> str:
    """Why nothing can be emulated here, or nothing."""
    if platform.system() != "Linux" or platform.machine() != "x86_64":
        return f"AArch64 is emulated on Linux on x86-64 alone, and this is {platform.system()} on {platform.machine()}"
    lacking = [name for name in (COMPILER, LINKER, "qemu-aarch64") if not _found(name)]
    if not (SYSROOT / "include" / "stdio.h").exists():
        lacking.append(f"{SYSROOT}/include")
    if lacking:
        return f"no {', no '.join(lacking)}: the bits of AArch64 are NOT COMPARED; install Debian's packages {PACKAGES}"
    binding.initialize_all_targets()
    binding.initialize_all_asmprinters()
    try:
        binding.Target.from_triple(TRIPLE)
    except RuntimeError:
        return f"llvmlite {binding.llvm_version_info} has no target {TRIPLE}: the bits of AArch64 are NOT COMPARED"
    return ""


def _found(name: str) -> str | None:
    return shutil.which(name) or shutil.which(f"{name}-static")


class Guest:
    """A process under qemu, and the memory that it shares with this one."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.count, self.used = folder, 0, 0
        self.drivers: dict[Any, Memo[flat.Flat]] = {}
        memory = os.memfd_create("lienumba")
        os.ftruncate(memory, SIZE)
        libc = ctypes.CDLL(None, use_errno=True)
        libc.mmap.restype, libc.mmap.argtypes = ctypes.c_void_p, [ctypes.c_void_p, ctypes.c_size_t, *[ctypes.c_int] * 3,
                                                                  ctypes.c_long]  # fmt: skip
        at = libc.mmap(ADDRESS, SIZE, mmap.PROT_READ | mmap.PROT_WRITE, mmap.MAP_SHARED | FIXED, memory, 0)
        assert at == ADDRESS, os.strerror(ctypes.get_errno())
        self.bytes = np.frombuffer((ctypes.c_char * SIZE).from_address(ADDRESS), np.uint8)
        program = folder / "guest"
        source = Path(__file__).with_name("guest.c")
        subprocess.run([COMPILER, "-O1", "-Wall", "-Werror", source, "-o", program], check=True)
        command = [str(_found("qemu-aarch64")), "-L", str(SYSROOT), str(program), str(memory), str(ADDRESS), str(SIZE)]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True, pass_fds=[memory])
        os.close(memory)

    def close(self) -> None:
        self.process.communicate()
        ctypes.CDLL(None).munmap(ctypes.c_void_p(ADDRESS), ctypes.c_size_t(SIZE))

    def ask(self, request: str) -> str:
        to, back = self.process.stdin, self.process.stdout
        assert to is not None
        assert back is not None
        to.write(request + "\n")
        to.flush()
        answer = back.readline().strip()
        assert answer, f"the emulated process ended at {request!r}: {self.process.wait()}"
        return answer

    def load(self, objects: bytes, names: list[str]) -> tuple[Any, dict[str, int]]:
        """As `native.load`."""
        self.count += 1
        source, library = self.folder / f"{self.count}.o", self.folder / f"{self.count}.so"
        source.write_bytes(objects)
        subprocess.run([LINKER, "-shared", source, "-o", library], check=True)
        assert (answer := self.ask(f"l {library}")) == "loaded", answer
        found = {name: int(self.ask(f"a {name}")) for name in names}
        assert all(found.values()), found
        return None, found

    def aligned(self, *shape: int) -> np.ndarray:
        """As `machine.aligned`, in the memory that both see."""
        return self.array(np.zeros(shape))

    def array(self, x: np.ndarray) -> np.ndarray:
        """The array there: itself, or a copy."""
        if ADDRESS <= x.ctypes.data < ADDRESS + SIZE:
            return x
        first = -(-self.used // machine.ALIGNMENT) * machine.ALIGNMENT
        self.used = first + x.nbytes
        assert self.used <= SIZE
        moved = self.bytes[first : self.used].view(x.dtype).reshape(x.shape)
        moved[...] = x
        return moved

    def function(self, result: None, *kinds: Any) -> Any:
        """As `ctypes.CFUNCTYPE`."""

        def at(address: int) -> Any:
            def call(*given: int) -> None:
                numbers = [address, *given, *[0] * (6 - len(given))]
                assert self.ask(" ".join(["c", *map(str, numbers)])) == "done"

            return call

        return at

    def call(self, called: flat.Flat, *arguments: Any) -> None:
        """As `Flat.__call__`."""
        copies: list[tuple[np.ndarray, np.ndarray]] = []

        def moved(x: Any) -> Any:
            if isinstance(x, tuple):
                return tuple(map(moved, x))
            if isinstance(x, np.ndarray):
                copies.append((x, self.array(x)))
                return copies[-1][1]
            return x

        given: list[int] = []
        numbers: list[float] = []
        assert flat._pack(moved(arguments), given, numbers) == called.kinds
        whole, floats = self.array(np.array(given, np.int64)), self.array(np.array(numbers, np.float64))
        called._call(whole.ctypes.data, floats.ctypes.data)
        for ours, theirs in copies:
            ours[...] = theirs

    @contextlib.contextmanager
    def instead(self, cpu: tuple[str, str] = CPU, level: int = native.LEVEL) -> Iterator[None]:
        """Meanwhile, whatever is compiled is compiled for this CPU, at this level of code generation, and whatever is
        called is called there. Nothing of it is kept on disk."""
        address_of = Numbers.address.fget
        rows_of = Courses.rows
        calls = SimpleNamespace(CFUNCTYPE=self.function, c_int64=ctypes.c_int64)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(cache, "remember", lambda key, make: make())
            patch.setattr(native, "cpu", lambda: cpu)
            patch.setattr(native, "LEVEL", level)
            patch.setattr(native, "LONG_TEXT", np.inf)
            patch.setattr(native, "_machine", _target)
            patch.setattr(native, "load", self.load)
            patch.setattr(flat, "ctypes", calls)
            patch.setattr(flat.Flat, "__call__", lambda called, *arguments: self.call(called, *arguments))
            patch.setattr(machine, "ctypes", calls)
            patch.setattr(machine, "_DRIVERS", self.drivers.setdefault((cpu, level), Memo(2)))
            patch.setattr(machine, "aligned", self.aligned)
            patch.setattr(integrate, "aligned", self.aligned)
            patch.setattr(Numbers, "address", property(lambda numbers: address_of(Numbers(self.array(numbers.array)))))
            patch.setattr(Courses, "rows", lambda courses: self.array(rows_of(courses)))
            yield
        self.used = 0


def _target(name: str, features: str) -> Any:
    """As `native._machine`."""
    target = binding.Target.from_triple(TRIPLE)
    return target.create_target_machine(cpu=name, features=features, opt=native.LEVEL, reloc="pic", codemodel="small")
