"""LLVM text becomes machine code, through Numba's LLVM and for Numba's choice of CPU; kept in a cache on disk."""

import ctypes
import functools
from typing import Any

from lienumba.compiler import cache

_engines: list[Any] = []  # machine code lives as long as its engine


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
    elif config.CPU_NAME and config.CPU_NAME != binding.get_host_cpu_name():
        features = ""
    else:
        features = binding.get_host_cpu_features().flatten()
    return name, features


def compile_text(text: str) -> bytes:
    """The object code of a module of LLVM text, from the cache where it is there."""
    name, features = cpu()
    return cache.remember("\0".join((text, name, features)), lambda: _emit(text, name, features))


def _emit(text: str, name: str, features: str) -> bytes:
    from llvmlite import binding

    module = binding.parse_assembly(text, context=binding.create_context())  # its own: threads compile side by side
    return bytes(_machine(name, features).emit_object(module))


def _machine(name: str, features: str) -> Any:
    from llvmlite import binding

    target = binding.Target.from_default_triple()
    return target.create_target_machine(cpu=name, features=features, opt=3, reloc="pic", codemodel="jitdefault", jit=True)


def load(objects: bytes, names: list[str]) -> dict[str, int]:
    """The addresses of functions in object code. Calls the C library's `fma` where the CPU has none."""
    from llvmlite import binding

    ctypes.CDLL(None)
    engine = binding.create_mcjit_compiler(binding.parse_assembly(""), _machine(*cpu()))
    engine.add_object_file(binding.ObjectFileRef.from_data(objects))
    engine.finalize_object()
    _engines.append(engine)
    return {name: engine.get_function_address(name) for name in names}
