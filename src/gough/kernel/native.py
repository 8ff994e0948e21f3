"""LLVM text to object code, and object code into this process.

The passes before code generation find little to do, for the tape shares everything already; so they are few.  Loading
is ORC's (MCJIT crashes on a truncated object where ORC raises).
"""

from __future__ import annotations

import functools
import itertools

import llvmlite
import llvmlite.binding as llvm

from . import lanes, ops

_numbers = itertools.count()


@functools.cache
def _target():
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_triple(llvm.get_process_triple())


def _machine(level: int):
    return _target().create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
        opt=level,
        reloc="pic",
        codemodel="default",
    )


def version() -> str:
    """What an object code depends on beside its text: compiler and processor."""
    features = ",".join(sorted(lanes.host_features()))
    return f"llvmlite {llvmlite.__version__}; LLVM {llvm.llvm_version_info}; {llvm.get_host_cpu_name()}; {features}"


def compile_text(text: str, level: int = 2) -> bytes:
    """The object code of a module."""
    machine = _machine(level)
    module = llvm.parse_assembly(text)
    options = llvm.create_pipeline_tuning_options(speed_level=1)
    options.slp_vectorization = options.loop_vectorization = options.loop_unrolling = False
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    return machine.emit_object(module)


@functools.cache
def _compiler():
    return llvm.create_lljit_compiler(_machine(2), suppress_errors=True)


class Library:
    """Object code in memory.  It lives as long as this object; keep it as long as a pointer into it."""

    def __init__(self, image: bytes, symbols: dict[str, str], export: str):
        builder = llvm.JITLibraryBuilder().add_object_img(image).export_symbol(export)
        for name, symbol in symbols.items():
            address = ops.address(symbol)
            if address is None:
                raise RuntimeError(f"this machine has no function {symbol}")
            builder.import_symbol(name, address)
        for symbol in ("memcpy", "memset", "memmove", "floor", "ceil"):  # LLVM may call these on its own
            builder.import_symbol(symbol, ops.address(symbol))
        self._tracker = builder.link(_compiler(), f"gough.{next(_numbers)}")
        self.address = self._tracker[export]
