"""LLVM text becomes machine code, through Numba's LLVM and for Numba's choice of CPU; kept in a cache on disk."""

import functools
import hashlib
import subprocess
import sys
from typing import Any
from weakref import WeakValueDictionary

from lienumba.compiler import cache

LONG_TEXT = 500_000  # characters; beyond, compiling takes longer than starting a process
CHILD = """
import sys
from llvmlite import binding
binding.initialize_native_target()
binding.initialize_native_asmprinter()
from lienumba.compiler.native import _emit
sys.stdout.buffer.write(_emit(sys.stdin.buffer.read().decode(), *sys.argv[1:]))
"""

_engines: WeakValueDictionary[bytes, Any] = WeakValueDictionary()  # by object code


@functools.cache
def cpu() -> tuple[str, str]:
    """Name and features of the CPU to compile for, as Numba sees them (NUMBA_CPU_NAME, NUMBA_CPU_FEATURES)."""
    from llvmlite import binding
    from numba.core import config

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    name = config.CPU_NAME or binding.get_host_cpu_name()
    if config.CPU_FEATURES is not None:
        features = config.CPU_FEATURES
    elif config.CPU_NAME and binding.get_host_cpu_name() != config.CPU_NAME:
        features = ""
    else:
        features = binding.get_host_cpu_features().flatten()
    return name, features


def compile_text(text: str) -> bytes:
    """The object code of a module of LLVM text, from the cache where it is there.

    Long texts are compiled in a process of their own: llvmlite lets only one thread at a time into LLVM.
    """
    name, features = cpu()
    make = _emit if len(text) < LONG_TEXT else _emit_elsewhere
    return cache.remember("\0".join((text, name, features)), lambda: make(text, name, features))


def _emit(text: str, name: str, features: str) -> bytes:
    from llvmlite import binding

    module = binding.parse_assembly(text)
    return bytes(_machine(name, features).emit_object(module))


def _emit_elsewhere(text: str, name: str, features: str) -> bytes:
    command = [sys.executable, "-c", CHILD, name, features]
    try:
        done = subprocess.run(command, input=text.encode(), capture_output=True)
    except OSError:
        return _emit(text, name, features)  # no processes here: slower, the same code
    if done.returncode < 0:
        raise RuntimeError(f"the compiling process was ended by signal {-done.returncode}")
    return done.stdout if done.returncode == 0 else _emit(text, name, features)


def _machine(name: str, features: str) -> Any:
    """Code generation at level 1: straight-line code gains nothing from more, and compiles a fifth faster."""
    from llvmlite import binding

    target = binding.Target.from_default_triple()
    return target.create_target_machine(cpu=name, features=features, opt=1, reloc="pic", codemodel="small", jit=True)


def load(objects: bytes, names: list[str]) -> tuple[Any, dict[str, int]]:
    """An engine with this object code, and the addresses of functions in it, which are good as long as the engine
    lives. Calls the C library's `fma` where the CPU has none."""
    from llvmlite import binding

    key = hashlib.sha256(objects).digest()
    engine = _engines.get(key)
    if engine is None:
        engine = binding.create_mcjit_compiler(binding.parse_assembly(""), _machine(*cpu()))
        engine.add_object_file(binding.ObjectFileRef.from_data(objects))
        engine.finalize_object()
        _engines[key] = engine
    return engine, {name: engine.get_function_address(name) for name in names}
