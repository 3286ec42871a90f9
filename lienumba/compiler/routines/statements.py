"""Statements of routines: a function of Python becomes one of LLVM."""

import ast
from collections.abc import Iterable
from types import FunctionType

from lienumba.compiler.routines.arithmetic import binary, cast, compare, constant, scalar
from lienumba.compiler.routines.expressions import Caller, Expressions
from lienumba.compiler.routines.values import (
    BOOL,
    INT,
    NOTHING,
    Array,
    RoutineError,
    Scalar,
    Tuple,
    Value,
    kind_of,
    leaves,
    said,
    with_leaves,
)  # fmt: skip


class Body(Expressions):
    """result: what the function returns, once a return has been met."""

    def __init__(self, function: FunctionType, tree: ast.FunctionDef, call: Caller, arguments: list[Value]) -> None:
        super().__init__(function, call)
        self.result: Value | None = None
        self.function = function
        self._loops: list[tuple[str, str]] = []  # where to go on, and where to go out
        self._left: set[str] = set()  # loops with a break
        names = [given.arg for given in tree.args.args]
        if len(names) != len(arguments):
            raise RoutineError(f"{function.__name__} takes {len(names)} arguments, and got {len(arguments)}")
        every = (node for node in ast.walk(tree) if isinstance(node, ast.Name))
        assigned = {node.id for node in every if isinstance(node.ctx, ast.Store)}
        for name, x in zip(names, arguments, strict=True):
            if name in assigned:
                self._assign_name(name, x)
            else:
                self.fixed[name] = x
        self._suite(tree.body)
        if self.writer.open:
            self._return(ast.Return(None))

    def _suite(self, statements: Iterable[ast.stmt]) -> None:
        for node in statements:
            if not self.writer.open:
                return  # behind a return, a break
            how = getattr(self, f"_{type(node).__name__.lower()}", None)
            try:
                if how is None:
                    raise RoutineError(f"routines know no {type(node).__name__}")
                how(node)
            except RoutineError as error:
                if error.placed:
                    raise
                told = RoutineError(f"{self.function.__code__.co_filename}, line {node.lineno}: {error}")
                told.placed = True
                raise told from None

    def _expr(self, node: ast.Expr) -> None:
        if not isinstance(node.value, ast.Constant):  # the docstring
            self.value(node.value)

    def _assign(self, node: ast.Assign) -> None:
        x = self.value(node.value)
        for target in node.targets:
            self._set(target, x)

    def _augassign(self, node: ast.AugAssign) -> None:
        read = ast.copy_location(ast.BinOp(node.target, node.op, node.value), node)
        self._set(node.target, self.value(read))

    def _set(self, target: ast.expr, x: Value) -> None:
        if isinstance(target, ast.Name):
            self._assign_name(target.id, x)
        elif isinstance(target, ast.Tuple) and isinstance(x, Tuple) and len(target.elts) == len(x.items):
            for part, item in zip(target.elts, x.items, strict=True):
                self._set(part, item)
        elif isinstance(target, ast.Subscript):
            self._set_part(target, scalar(x))
        else:
            raise RoutineError(f"{said(x)} cannot be put into {ast.unparse(target)}")

    def _assign_name(self, name: str, x: Value) -> None:
        if name not in self.slots:
            self.slots[name] = x, [self.writer.slot(leaf.kind) for leaf in leaves(x)]
        like, slots = self.slots[name]
        if kind_of(like) != kind_of(x):
            raise RoutineError(f"{name} is {said(like)}, and cannot become {said(x)}")
        self._put(slots, x)

    def _set_part(self, target: ast.Subscript, x: Scalar) -> None:
        of = self.value(target.value)
        if not isinstance(of, Array):
            raise RoutineError(f"{said(of)} has no parts that can be written")
        part, x = self.part(of, target.slice), cast(self.writer, x, of.kind)
        if not part.shape:
            self.writer.put(self.pointer(part), x)
            return
        count = self._product(part.shape)
        place, again, out = self._counter(constant(0), count)
        element = Array(of.kind, self._behind(part.address, self.writer.get(place, INT)), ())
        self.writer.put(self.pointer(element), x)
        self._count(place, again, out)

    def _counter(self, first: Scalar, end: Scalar) -> tuple[str, str, str]:
        """Begin a loop over whole numbers; returns its slot, where it looks whether it goes on, and where it ends."""
        place, again, inside, out = self.writer.slot(INT), *(self.writer.label() for _ in range(3))
        self.writer.put(place, first)
        self.writer.begin(again)
        self.writer.branch(compare(self.writer, ast.Lt(), self.writer.get(place, INT), end), inside, out)
        self.writer.begin(inside)
        return place, again, out

    def _count(self, place: str, again: str, out: str) -> None:
        self.writer.put(place, binary(self.writer, ast.Add(), self.writer.get(place, INT), constant(1)))
        self.writer.jump(again)
        self.writer.begin(out)

    def _for(self, node: ast.For) -> None:
        call = node.iter
        ranges = isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "range"
        if node.orelse or not isinstance(call, ast.Call) or not ranges:
            raise RoutineError("loops go over a range, and have no else")
        if not 1 <= len(call.args) <= 2:
            raise RoutineError("a range has an end, or a beginning and an end")
        given = [self.number(x, INT) for x in call.args]
        place, again, out = self._counter(constant(0) if len(given) == 1 else given[0], given[-1])
        following = self.writer.label()
        self._set(node.target, self.writer.get(place, INT))
        self._loops.append((following, out))
        self._suite(node.body)
        self._loops.pop()
        self.writer.begin(following)
        self._count(place, again, out)

    def _while(self, node: ast.While) -> None:
        if node.orelse:
            raise RoutineError("loops have no else")
        again, inside, out = (self.writer.label() for _ in range(3))
        endless = isinstance(node.test, ast.Constant) and node.test.value is True
        self.writer.begin(again)
        if not endless:
            self.writer.branch(self.number(node.test, BOOL), inside, out)
            self.writer.begin(inside)
        self._loops.append((again, out))
        self._suite(node.body)
        self._loops.pop()
        self.writer.jump(again)
        if not endless or out in self._left:
            self.writer.begin(out)

    def _break(self, node: ast.Break) -> None:
        out = self._loops[-1][1]
        self._left.add(out)
        self.writer.jump(out)

    def _continue(self, node: ast.Continue) -> None:
        self.writer.jump(self._loops[-1][0])

    def _if(self, node: ast.If) -> None:
        yes, no, end = (self.writer.label() for _ in range(3))
        self.writer.branch(self.number(node.test, BOOL), yes, no if node.orelse else end)
        self.writer.begin(yes)
        self._suite(node.body)
        ends = self.writer.open or not node.orelse
        self.writer.jump(end)
        if node.orelse:
            self.writer.begin(no)
            self._suite(node.orelse)
            ends = ends or self.writer.open
            self.writer.jump(end)
        if ends:
            self.writer.begin(end)

    def _pass(self, node: ast.Pass) -> None:
        pass

    def _return(self, node: ast.Return) -> None:
        x = NOTHING if node.value is None else self.value(node.value)
        if self.result is None:
            self.result = with_leaves(x, (leaf.text for leaf in leaves(x)))
        if kind_of(self.result) != kind_of(x):
            raise RoutineError(f"{self.function.__name__} returns {said(self.result)} and {said(x)}")
        given = leaves(x)
        if len(given) < 2:
            self.writer.do(f"ret {given[0].kind} {given[0].text}" if given else "ret void")
        else:
            whole, text = aggregate(given), "poison"
            for n, leaf in enumerate(given):
                text = self.writer.op(whole, f"insertvalue {whole} {text}, {leaf.kind} {leaf.text}, {n}").text
            self.writer.do(f"ret {whole} {text}")
        self.writer.open = False


def aggregate(registers: list[Scalar]) -> str:
    """The LLVM type of what a function returns."""
    kinds = [x.kind for x in registers]
    return f"{{{', '.join(kinds)}}}" if len(kinds) > 1 else kinds[0] if kinds else "void"
