"""Lanes: one program text for one number (W = 1) or W numbers, and which mathematical functions it calls.

One lane calls the C library and rounds after every operation.  Several lanes call glibc's libmvec, whose every lane is
within 4 ulp of the C library and does not depend on its neighbours, and may fuse a product and a sum.  What libmvec
lacks on this machine is called lane by lane.
"""

from __future__ import annotations

import functools
import platform
from dataclasses import dataclass

from . import ops

_ISA = {8: "e", 4: "d", 2: "b"}  # the letter of libmvec's names: AVX-512, AVX2, SSE


@dataclass(frozen=True)
class Lanes:
    """LLVM's names for W doubles, W conditions, W integers."""

    width: int

    @property
    def number(self) -> str:
        return self._of("double")

    @property
    def condition(self) -> str:
        return self._of("i1")

    @property
    def integer(self) -> str:
        return self._of("i64")

    @property
    def align(self) -> int:
        return 8 * self.width

    @property
    def flags(self) -> str:
        """What + - * may do beside rounding once: fuse, in lanes."""
        return "contract " if self.width > 1 else ""

    def _of(self, kind: str) -> str:
        return kind if self.width == 1 else f"<{self.width} x {kind}>"

    def suffix(self, kind: str = "f64") -> str:
        """The end of an intrinsic's name."""
        return kind if self.width == 1 else f"v{self.width}{kind}"

    def constant(self, value: str, kind: str = "double") -> str:
        """The same constant in every lane."""
        return value if self.width == 1 else f"splat ({kind} {value})"

    def splat(self, register: str, target: str, kind: str = "double") -> str:
        """Text that puts one number into every lane of `target`."""
        if self.width == 1:
            return f"  {target} = bitcast {kind} {register} to {kind}\n"
        vector = self._of(kind)
        return (
            f"  {target}.one = insertelement {vector} poison, {kind} {register}, i64 0\n"
            f"  {target} = shufflevector {vector} {target}.one, {vector} poison, <{self.width} x i32> zeroinitializer\n"
        )

    def any(self, register: str, target: str) -> str:
        """Text that says whether a condition holds in any lane."""
        if self.width == 1:
            return f"  {target} = bitcast i1 {register} to i1\n"
        return f"  {target} = call i1 @llvm.vector.reduce.or.v{self.width}i1({self.condition} {register})\n"


def native_width() -> int:
    """8 with AVX-512, 4 with AVX2, else 2."""
    features = host_features()
    return 8 if "+avx512f" in features else 4 if "+avx2" in features else 2


@functools.cache
def host_features() -> frozenset[str]:
    import llvmlite.binding as llvm

    return frozenset(llvm.get_host_cpu_features().flatten().split(","))


def vector_symbol(function: str, width: int) -> str | None:
    """libmvec's name of a function for `width` lanes, if this machine has it.

    The library has the functions for every processor; called on one without the registers they expect, half of the
    lanes would be lost.
    """
    needed = {8: "+avx512f", 4: "+avx2"}.get(width)
    if width not in _ISA or platform.machine() != "x86_64" or (needed and needed not in host_features()):
        return None
    symbol = f"_ZGV{_ISA[width]}N{width}{'v' * ops.LIBM[function]}_{function}"
    return symbol if ops.address(symbol) else None


_PURE = "nounwind willreturn memory(none)"


class Calls:
    """The mathematical functions that a module calls: collects them, gives their declarations and their addresses.

    They get names of our own, so that LLVM, which knows what `sin` is, folds and rewrites nothing.
    """

    def __init__(self, lanes: Lanes):
        self.lanes = lanes
        self.used: dict[tuple[str, bool], str] = {}  # function, exact -> symbol or "" for lane by lane
        self.symbols: dict[str, str] = {}  # name in the module -> symbol of the library

    def name(self, function: str, exact: bool = False) -> str:
        """The name under which the module calls this function on all lanes; `exact`: the C library in every lane."""
        key = function, exact and self.lanes.width > 1
        if key not in self.used:
            scalar = self.lanes.width == 1
            symbol = function if scalar else "" if exact else vector_symbol(function, self.lanes.width) or ""
            self.used[key] = symbol
            self.symbols[f"gough.{symbol or function}"] = symbol or function
        symbol = self.used[key]
        return f"@gough.{symbol}" if symbol else f"@each.{function}"

    def text(self) -> str:
        """Declarations, and the functions that call the C library lane by lane."""
        lines = []
        for function, symbol in dict.fromkeys((function, symbol) for (function, _), symbol in self.used.items()):
            count = ops.LIBM[function]
            kind = self.lanes.number if symbol else "double"
            lines.append(f"declare {kind} @gough.{symbol or function}({', '.join([kind] * count)}) {_PURE}\n")
            if not symbol:
                lines.append(self._each(function, count))
        return "".join(lines)

    def _each(self, function: str, count: int) -> str:
        v, width = self.lanes.number, self.lanes.width
        parameters = ", ".join(f"{v} %x{i}" for i in range(count))
        lines = [f"define internal {v} @each.{function}({parameters}) noinline nounwind willreturn memory(none) {{\n"]
        result = "poison"
        for lane in range(width):
            for i in range(count):
                lines.append(f"  %a{i}.{lane} = extractelement {v} %x{i}, i64 {lane}\n")
            arguments = ", ".join(f"double %a{i}.{lane}" for i in range(count))
            lines.append(f"  %y{lane} = call double @gough.{function}({arguments})\n")
            lines.append(f"  %r{lane} = insertelement {v} {result}, double %y{lane}, i64 {lane}\n")
            result = f"%r{lane}"
        lines.append(f"  ret {v} {result}\n}}\n")
        return "".join(lines)
