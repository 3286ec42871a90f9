"""LLVM text that calls a function by its address, for rows of lanes (see `calls`).

The text has no address in it, so object code of it may be kept: it reads the address from a variable, which
`native.load` sets in every process.
"""

from collections.abc import Iterator

from lienumba.compiler.foreign.calls import PREFIX
from lienumba.compiler.native import ADDRESS

NAN = "0x7FF8000000000000"
HEAD = """@{address} = dso_local global ptr null
define i32 @{symbol}(ptr %room, ptr %error, ptr %given, ptr %found, i64 %lanes) {{
begin:
  %function = load ptr, ptr @{address}, align 8
"""


def address_of(symbol: str) -> str:
    """The name of the variable that holds the address behind a symbol."""
    return ADDRESS + symbol.removeprefix(PREFIX)


def by_block(symbol: str) -> str:
    """The text for a function  void (given, found, lanes)."""
    head = HEAD.format(symbol=symbol, address=address_of(symbol))
    return f"{head}  call void %function(ptr %given, ptr %found, i64 %lanes)\n  ret i32 0\n}}\n"


def by_lane(symbol: str, inputs: int, states: int, outputs: int) -> str:
    """The text for a function  void (u, x, y)  of one run, which replaces x.

    Arguments are the inputs, then the states; outputs are those of the function, then its next states. A lane with a
    NaN among its arguments is not called. All outputs of a lane are NaN if it is not called or if one is not finite.
    """
    return "\n".join(_by_lane(symbol, inputs, states, outputs)) + "\n"


def _by_lane(symbol: str, inputs: int, states: int, outputs: int) -> Iterator[str]:
    arrays = {"u": inputs, "x": states, "y": outputs}
    given = [f"{array}{n}" for array in "ux" for n in range(arrays[array])]
    found = [f"{array}{n}" for array in "yx" for n in range(arrays[array])]
    yield HEAD.format(symbol=symbol, address=address_of(symbol)).rstrip()
    for array, size in arrays.items():
        yield f"  %{array} = alloca [{max(size, 1)} x double], align 16"
        for n in range(size):
            yield f"  %{array}{n} = getelementptr double, ptr %{array}, i64 {n}"
    yield "  br label %next"
    yield "next:"
    yield "  %lane = phi i64 [ 0, %begin ], [ %following, %store ]"
    nan = "false"
    for row, place in enumerate(given):
        yield from _place("given", row)
        yield f"  %argument{row} = load double, ptr %given{row}, align 8"
        yield f"  store double %argument{row}, ptr %{place}, align 8"
        yield f"  %own{row} = fcmp uno double %argument{row}, %argument{row}"
        yield f"  %nan{row} = or i1 {nan}, %own{row}"
        nan = f"%nan{row}"
    yield f"  br i1 {nan}, label %store, label %call"
    yield "call:"
    for n in range(outputs):
        yield f"  store double {NAN}, ptr %y{n}, align 8"  # so that what it leaves out is not that of another lane
    yield "  call void %function(ptr %u, ptr %x, ptr %y)"
    total = "0.0"
    for row, place in enumerate(found):
        yield f"  %returned{row} = load double, ptr %{place}, align 8"
        yield f"  %zero{row} = fmul double %returned{row}, 0.0"
        yield f"  %sum{row} = fadd double {total}, %zero{row}"
        total = f"%sum{row}"
    yield f"  %finite = fcmp oeq double {total}, 0.0"
    yield "  br label %store"
    yield "store:"
    yield "  %good = phi i1 [ false, %next ], [ %finite, %call ]"
    for row, place in enumerate(found):
        yield from _place("found", row)
        yield f"  %left{row} = load double, ptr %{place}, align 8"
        yield f"  %output{row} = select i1 %good, double %left{row}, double {NAN}"
        yield f"  store double %output{row}, ptr %found{row}, align 8"
    yield "  %following = add i64 %lane, 1"
    yield "  %more = icmp slt i64 %following, %lanes"
    yield "  br i1 %more, label %next, label %end"
    yield "end:"
    yield "  ret i32 0"
    yield "}"


def _place(array: str, row: int) -> Iterator[str]:
    """The place of the lane in a row of an array."""
    yield f"  %{array}.first{row} = mul i64 %lanes, {row}"
    yield f"  %{array}.index{row} = add i64 %{array}.first{row}, %lane"
    yield f"  %{array}{row} = getelementptr double, ptr %{array}, i64 %{array}.index{row}"
