"""Numba compiles a function for rows of lanes, and lienumba takes over its LLVM text.

Each lane is guarded: where the function raises, or returns what is not finite, all outputs of the lane are NaN. The
text calls nothing outside of itself, so it needs no Numba, and no mathematics library decides about its bits.
"""

import re
from collections.abc import Iterator, Sequence
from math import nan
from types import FunctionType
from typing import Any

from llvmlite import binding
from numba import carray, config, njit, types
from numba.core.errors import NumbaError, UnsupportedBytecodeError
from numba.extending import typeof_impl

from lienumba import laws
from lienumba.compiler import jit
from lienumba.compiler.foreign.calls import Argument, Foreign
from lienumba.compiler.foreign.identity import identity
from lienumba.compiler.foreign.jitted import Jitted
from lienumba.errors import BadValueError

OPTIONS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}  # 1/0 raises
GUARDED = OPTIONS | {"boundscheck": True, "forceinline": True}  # an index out of range raises
EXACT = (  # intrinsics of LLVM that are instructions, or exact
    "abs", "assume", "bswap", "ceil", "copysign", "ctlz", "ctpop", "cttz", "expect", "experimental", "fabs", "floor",
    "fptosi", "fptoui", "fshl", "fshr", "lifetime", "masked", "maximum", "maxnum", "minimum", "minnum", "nearbyint",
    "rint", "round", "roundeven", "sadd", "smax", "smin", "smul", "sqrt", "ssub", "stackrestore", "stacksave", "trunc",
    "uadd", "umax", "umin", "umul", "usub", "vector",
)  # fmt: skip
LAWS = {"pow": "exp and log, as exp(x*log(a))", "exp2": "exp, as exp(x*log(2))"}  # in place of a symbol
REMEDIES = (  # by how a symbol begins
    ("frem", "uses % or // of floats, an operation of a mathematics library", "take mod and floor of lienumba.laws"),
    ("mem", "moves memory", "write it with loops over numbers"),
    ("NRT_", "allocates memory", "keep numbers in variables, tuples and the law's memory, and tables in arrays"),
    ("numba_gil", "needs Python while it runs", "let it raise with constant texts, and print nothing"),
    ("Py", "needs Python while it runs", "let it raise with constant texts, and print nothing"),
    ("numba_", "needs Numba while it runs", "write it with loops, or with functions of lienumba.laws"),
)
NUMBA_SAYS = (  # what a message of Numba's has in it, and the remedy
    ("getitem", "numbers arrive as floats: write int(n) for an index"),
    ("re-entrant", "let it not call itself, and write a loop"),
    ("is not defined", "correct the name, or define it above"),
)
# Of a size that is known, as of tuples: LLVM may call the C library for the first kind, and never for the second.
MEMORY = re.compile(r"@llvm\.mem(set\.p0|cpy\.p0\.p0)\.i64(\([^()]*(?:\(\d+\)[^()]*)*, i64 \d+, i1 false\))")
WHOLE = re.compile(r"= fpto([su])i double (\S+) to (i\d+)")  # undefined beyond what fits, in other ways on each machine
ROOT = "@llvm.sqrt.f64("  # an instruction, in place of the function of the C library
INLINE = (
    "\ndeclare void @llvm.memset.inline.p0.i64(ptr, i8, i64 immarg, i1 immarg)"
    "\ndeclare void @llvm.memcpy.inline.p0.p0.i64(ptr, ptr, i64 immarg, i1 immarg)\n"
)
_CALLED: dict[str, Any] = {}  # functions that others call, by their identity


@typeof_impl.register(Jitted)
def typeof_jitted(function: Jitted, context: Any) -> types.Type:
    """Of one that another one calls. Numba holds it by a weak reference, and freezes what it reads."""
    said = identity(function.py_func)
    if said not in _CALLED:
        _CALLED[said] = njit(**GUARDED)(function.py_func)
    return types.Dispatcher(_CALLED[said])


def compiled(function: FunctionType, symbol: str, arguments: Sequence[Argument]) -> Foreign:
    """The function for such arguments under this symbol.

    Raises BadValueError for what cannot be compiled, or calls something outside of itself.
    """
    if config.DISABLE_JIT:
        raise BadValueError("NUMBA_DISABLE_JIT is set, so that Numba compiles nothing", "unset it")
    jit.register()
    types_of = tuple(map(_type_of, arguments))
    inner = njit(**GUARDED)(function)
    try:
        inner.compile(types_of)
        own, scalar = _returned(function.__name__, inner.overloads[types_of].signature.return_type)
        names: dict[str, Any] = {"function": inner, "nan": nan, "carray": carray}
        exec("\n".join(_source(arguments, own, scalar)), names)
        names["lane_of"] = njit(**GUARDED)(names["lane_of"])
        whole = njit(**OPTIONS)(names["block"])
        pointer = types.CPointer(types.float64)
        signature = (pointer, pointer, types.int64)
        whole.compile(signature)
    except (NumbaError, UnsupportedBytecodeError) as error:
        said = _said(str(error), function.__code__.co_filename)
        remedy = next((remedy for sign, remedy in NUMBA_SAYS if sign in said), "correct it")
        raise BadValueError(f"Numba cannot compile {function.__name__}: {said}", remedy) from None
    made = whole.overloads[signature]
    text = _complete(function.__name__, made.library.get_llvm_str(), made.fndesc.llvm_func_name, symbol)
    outputs = own + sum(x.size for x in arguments if x.kind == "array")
    return Foreign(symbol, function.__name__, outputs, scalar, text)


def _returned(name: str, kind: types.Type) -> tuple[int, bool]:
    """How many numbers a function returns, and whether that is a single one."""
    each = tuple(kind) if isinstance(kind, types.BaseTuple) else (kind,)
    numbers = (types.Float, types.Integer, types.Boolean)
    if not each or not all(isinstance(x, numbers) for x in each):
        raise BadValueError(f"{name} returns {kind}", "let it return a number, or a tuple of numbers")
    return len(each), not isinstance(kind, types.BaseTuple)


def _type_of(argument: Argument) -> types.Type:
    """Numba's type of an argument. The rows of an array are those of a block, so its numbers lie apart."""
    if argument.kind == "array":
        return types.Array(types.float64, 1, "A")
    return types.UniTuple(types.float64, argument.size) if argument.kind == "tuple" else types.float64


def _source(arguments: Sequence[Argument], outputs: int, scalar: bool) -> Iterator[str]:
    """Write the functions of one lane and of all. A lane with a NaN, as of a run that has failed, is not called: loops
    need not end there. Arrays are the last rows of what is found, so the function writes to its place. One call stands
    between try and except, since Numba compiles each expression there apart."""
    row, end, passed, numbers = 0, outputs, [], []
    yield "def lane_of(given, found, lanes, lane):"
    for argument in arguments:
        own = [f"u{row + n}" for n in range(argument.size)]
        if argument.kind == "array":
            yield f"    u{row} = carray(found, ({end + argument.size}, lanes))[{end}:, lane]"
            yield f"    for n in range({argument.size}):"
            yield f"        u{row}[n] = given[({row} + n) * lanes + lane]"
            yield f"        if u{row}[n] != u{row}[n]:"
            yield "            return"
            end += argument.size
        else:
            yield from (f"    {u} = given[{row + n} * lanes + lane]" for n, u in enumerate(own))
            numbers += own
        passed.append(f"({', '.join(own)},)" if argument.kind == "tuple" else own[0])
        row += argument.size
    results = [f"x{n}" for n in range(outputs)]
    yield f"    if {' or '.join(f'{u} != {u}' for u in numbers) or 'False'}:"
    yield "        return"
    yield f"    {', '.join(results)}{'' if scalar else ','} = function({', '.join(passed)})"
    yield f"    total = {' + '.join(f'0.0 * {x}' for x in results)}"
    yield f"    for n in range({outputs}, {end}):"
    yield "        total += 0.0 * found[n * lanes + lane]"
    yield "    if total == 0.0:"
    yield from (f"        found[{n} * lanes + lane] = {x}" for n, x in enumerate(results))
    yield "def block(given, found, lanes):"
    yield "    for lane in range(lanes):"
    yield f"        for n in range({outputs}):"
    yield "            found[n * lanes + lane] = nan"
    yield "        try:"
    yield "            lane_of(given, found, lanes, lane)"
    yield "        except Exception:"
    yield "            pass"
    if end > outputs:
        yield "        if found[lane] != found[lane]:"
        yield f"            for n in range({outputs}, {end}):"
        yield "                found[n * lanes + lane] = nan"


def _complete(name: str, text: str, entry: str, symbol: str) -> str:
    """The text of a module with one function that is seen from outside, under this symbol, and all that it needs."""
    module = binding.parse_assembly(_without_library(text))
    for x in (*module.functions, *module.global_variables):
        if not x.is_declaration:
            x.linkage = "external" if x.name == entry else "internal"
    module.get_function(entry).name = symbol
    passes = binding.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    machine = binding.Target.from_default_triple().create_target_machine()
    passes.run(module, binding.create_pass_builder(machine, binding.create_pipeline_tuning_options(speed_level=1)))
    for outside in _outside(module):
        raise _refused(name, outside)
    return str(module)


def _without_library(text: str) -> str:
    """The text with instructions for roots, for memory of a size that is known, and for whole numbers of floats, where
    what does not fit becomes the nearest that does."""
    declared = [f"declare double {ROOT}double)"] if ROOT not in text else []
    declared += {f"declare {size} @llvm.fpto{sign}i.sat.{size}.f64(double)" for sign, _, size in WHOLE.findall(text)}
    text = re.sub(r"^declare .*@sqrt\(.*$", "", text, flags=re.MULTILINE).replace("@sqrt(", ROOT)
    text = WHOLE.sub(r"= call \3 @llvm.fpto\1i.sat.\3.f64(double \2)", text)
    return "\n".join([MEMORY.sub(_inline, text), INLINE, *declared])


def _inline(found: re.Match[str]) -> str:
    kind, _, pointers = found[1].partition(".")
    return f"@llvm.mem{kind}.inline.{pointers}.i64{found[2]}"


def _outside(module: Any) -> Iterator[str]:
    """What a module calls outside of itself, or lets a library do."""
    for x in (*module.functions, *module.global_variables):
        _, intrinsic, rest = x.name.partition("llvm.")
        if x.is_declaration and not (intrinsic and (rest.partition(".")[0] in EXACT or ".inline." in rest)):
            yield rest.partition(".")[0] if intrinsic else x.name
    for function in module.functions:
        for block in function.blocks:
            if any(instruction.opcode == "frem" for instruction in block.instructions):
                yield "frem"


def _refused(name: str, symbol: str) -> BadValueError:
    """The error of a symbol that is not part of a text."""
    for start, what, remedy in REMEDIES:
        if symbol.startswith(start):
            return BadValueError(f"{name} {what} ({symbol})", remedy)
    rule = f"{name} calls {symbol} of a mathematics library, whose bits differ between machines"
    instead = LAWS.get(symbol, symbol if symbol in laws.__all__ else "other functions")
    return BadValueError(rule, f"take {instead} of lienumba.laws")


def _said(message: str, file: str) -> str:
    """The sentence in a message of Numba's, and the line of the user's file that it names."""
    text = re.sub(r"\x1b\[[\d;]*m|<source missing[^>]*>", "", message)
    text = re.sub(r"<(?:built-in )?function (\w+)[^>]*>", r"\1", re.sub(r" from '[^']*'", "", text))
    lines = [line.strip() for line in text.splitlines()]
    useful = [line for line in lines if line and not line.startswith(("Failed in", "File ", "During:", "-", "^"))]
    numbers = re.findall(rf'File "{re.escape(file)}", line (\d+)', text)
    return f"{' '.join(useful[:2])}{f' (line {numbers[0]})' if numbers else ''}"
