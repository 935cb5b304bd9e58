"""The LLVM compiler and loader of this process: assembly text to object code to addresses.

Code is loaded once and stays for the life of the process, so an address never dangles.
llvmlite is imported when it is first needed.
"""

from __future__ import annotations

import ctypes
import sys
import threading
from functools import cache
from typing import Any, Final

from acausal.codegen.ir import MATH_FUNCTIONS

_lock: Final = threading.RLock()


class _Engine:
    """LLVM's target machine and loader. Everything they hold must outlive the code."""

    def __init__(self) -> None:
        import llvmlite.binding as llvm

        self.llvm: Any = llvm
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        self.cpu: str = llvm.get_host_cpu_name()
        self.features: str = llvm.get_host_cpu_features().flatten()
        self.version: str = ".".join(map(str, llvm.llvm_version_info))
        self.triple: str = llvm.get_process_triple()
        self.compilers: dict[int, Any] = {}
        self.loader: Any = llvm.create_mcjit_compiler(
            llvm.parse_assembly(""), self.target_machine(1)
        )
        library = ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None)
        for name in (*MATH_FUNCTIONS, "memcpy", "memset", "memmove", "memcmp"):
            address = ctypes.cast(getattr(library, name), ctypes.c_void_p).value
            llvm.add_symbol(name, address)

    def target_machine(self, level: int) -> Any:
        return self.llvm.Target.from_triple(self.triple).create_target_machine(
            cpu=self.cpu,
            features=self.features,
            opt=level,
            reloc="default",
            codemodel="jitdefault",
            jit=True,
        )


@cache
def _engine() -> _Engine:
    return _Engine()


def target_identity() -> str:
    """Return what object code depends on besides its source: LLVM version, processor, platform."""
    with _lock:
        engine = _engine()
    return "\n".join((engine.version, engine.triple, engine.cpu, engine.features))


def compile_object(text: str, level: int = 1, *, passes: bool = False) -> bytes:
    """Return the object code of a module.

    Args:
        text: LLVM assembly.
        level: Effort of code generation, 0 to 3.
        passes: Whether to run LLVM's optimisation passes of that level before.

    Raises:
        RuntimeError: The text is not a valid module (an internal error).
    """
    with _lock:
        engine = _engine()
        llvm = engine.llvm
        module = llvm.parse_assembly(text)
        machine = engine.compilers.get(level)
        if machine is None:  # making one takes as long as compiling a small kernel
            machine = engine.compilers[level] = engine.target_machine(level)
        if passes:
            options = llvm.create_pipeline_tuning_options(speed_level=level)
            builder = llvm.create_pass_builder(machine, options)
            builder.getModulePassManager().run(module, builder)
        return bytes(machine.emit_object(module))


def load_objects(objects: list[bytes]) -> None:
    """Load object code; its functions can be found with ``address_of`` from then on."""
    with _lock:
        engine = _engine()
        for data in objects:
            engine.loader.add_object_file(engine.llvm.ObjectFileRef.from_data(data))
        engine.loader.finalize_object()


def address_of(name: str) -> int:
    """Return the address of a loaded function.

    Raises:
        LookupError: No loaded object has this function (an internal error).
    """
    with _lock:
        address = int(_engine().loader.get_function_address(name))
    if not address:
        raise LookupError(f"no loaded function {name}")
    return address
