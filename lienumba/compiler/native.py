"""LLVM text becomes machine code, through Numba's LLVM and for Numba's choice of CPU; kept in a cache on disk."""

import ctypes
import functools
import hashlib
import os
import re
import subprocess
import sys
from typing import Any
from weakref import WeakValueDictionary

from lienumba.compiler import cache

LONG_TEXT = 500_000  # characters; beyond, compiling takes longer than starting a process
ADDRESS = "lienumba_address_"  # of every variable in object code that holds an address; 32 hexadecimal digits follow
LEVEL = 1  # of code generation: straight-line code gains nothing from more, and compiles a fifth faster
CONFIGURED = ".numba_config.yaml"  # Numba's settings, where it is started
CHILD = """
import sys
from llvmlite import binding
binding.initialize_native_target()
binding.initialize_native_asmprinter()
from lienumba.compiler.native import emit
sys.stdout.buffer.write(emit(sys.stdin.buffer.read().decode(), *sys.argv[1:]))
"""

WIDE = """define void @copy(ptr %to, ptr %from) {
%x = load <8 x double>, ptr %from, align 8
store <8 x double> %x, ptr %to, align 8
ret void
}"""

ADDRESSES: dict[str, int] = {}  # of functions that other libraries have in this process, by those variables
_engines: WeakValueDictionary[bytes, Any] = WeakValueDictionary()  # by object code


@functools.cache
def cpu() -> tuple[str, str]:
    """Name and features of the CPU to compile for, as Numba sees them (NUMBA_CPU_NAME, NUMBA_CPU_FEATURES)."""
    from llvmlite import binding

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    _, features = _wanted()
    name, host = cpu_name(), binding.get_host_cpu_name()
    if features is None:
        features = "" if name != host else str(binding.get_host_cpu_features().flatten())
    return name, features


def cpu_name() -> str:
    """The CPU that Numba compiles for."""
    from llvmlite import binding

    return str(_wanted()[0] or binding.get_host_cpu_name())


def _wanted() -> tuple[str | None, str | None]:
    """The CPU and the features that Numba is told to compile for; it is imported for that where a file tells it."""
    if "numba" in sys.modules or os.path.exists(CONFIGURED):
        from numba.core import config

        return config.CPU_NAME, config.CPU_FEATURES
    name = os.environ.get("NUMBA_CPU_NAME")
    return name, os.environ.get("NUMBA_CPU_FEATURES", "" if str(name).lower() == "generic" else None)


@functools.cache
def register_lanes() -> int:
    """How many doubles a vector register has, four at least, as LLVM says, which knows CPUs by their names alone."""
    from llvmlite import binding

    module = binding.parse_assembly(WIDE)
    return 8 if "zmm" in _machine(*cpu()).emit_assembly(module) else 4


def compile_text(text: str) -> bytes:
    """The object code of a module of LLVM text, from the cache where it is there.

    Long texts are compiled in a process of their own: llvmlite lets only one thread at a time into LLVM.
    """
    name, features = cpu()
    make = emit if len(text) < LONG_TEXT else _emit_elsewhere
    return cache.remember(_key(text), lambda: make(text, name, features))


def entry(text: str) -> str:
    """The name of the entry in the cache that `compile_text` reads or leaves."""
    return cache.name_of(_key(text))


def _key(text: str) -> str:
    return "\0".join((text, *cpu(), str(LEVEL)))


def emit(text: str, name: str, features: str, passes: int = 0) -> bytes:
    """The object code of a module of LLVM text for this CPU; passes: the level of LLVM's passes over it."""
    from llvmlite import binding

    module, machine = binding.parse_assembly(text), _machine(name, features)
    if passes:
        options = binding.create_pipeline_tuning_options(speed_level=passes)
        options.loop_unrolling = options.loop_vectorization = options.slp_vectorization = False  # lanes are vectors
        builder = binding.create_pass_builder(machine, options)
        builder.getModulePassManager().run(module, builder)
    return bytes(machine.emit_object(module))


def _emit_elsewhere(text: str, name: str, features: str) -> bytes:
    command = [sys.executable, "-c", CHILD, name, features]
    try:
        done = subprocess.run(command, input=text.encode(), capture_output=True)
    except OSError:
        return emit(text, name, features)  # no processes here: slower, the same code
    if done.returncode < 0:
        raise RuntimeError(f"the compiling process was ended by signal {-done.returncode}")
    return done.stdout if done.returncode == 0 else emit(text, name, features)


def _machine(name: str, features: str) -> Any:
    from llvmlite import binding

    target = binding.Target.from_default_triple()
    return target.create_target_machine(
        cpu=name, features=features, opt=LEVEL, reloc="pic", codemodel="small", jit=True
    )


def load(objects: bytes, names: list[str]) -> tuple[Any, dict[str, int]]:
    """An engine with this object code, and the addresses of functions in it, which are good as long as the engine
    lives. Calls the C library's `fma` where the CPU has none. Variables that hold addresses are set."""
    from llvmlite import binding

    key = hashlib.sha256(objects).digest()
    engine = _engines.get(key)
    if engine is None:
        # With llvmlite's own manager all sections lie together: between those of LLVM's a process with much memory in
        # use may have more than the 2 GB that code can reach. It has no room for calls of the C library.
        name, features = cpu()
        together = True if "+fma" in features.split(",") else None  # None: as llvmlite thinks best
        engine = binding.create_mcjit_compiler(binding.parse_assembly(""), _machine(name, features), use_lmm=together)
        engine.add_object_file(binding.ObjectFileRef.from_data(objects))
        engine.finalize_object()
        for name in {name.decode() for name in re.findall(ADDRESS.encode() + b"[0-9a-f]{32}", objects)}:
            ctypes.c_void_p.from_address(engine.get_global_value_address(name)).value = ADDRESSES[name]
        _engines[key] = engine
    return engine, {name: engine.get_function_address(name) for name in names}
