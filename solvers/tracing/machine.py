"""The machine that code is compiled for: modules become object code, and object code becomes callable."""

from functools import cache
from typing import Any

import llvmlite
from llvmlite import binding, ir

LEVEL = 3
"""Level of optimisation."""


@cache
def _target() -> Any:
    """The target machine of this process, and the engine that holds the code."""
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    cpu, features = _processor()
    target = binding.Target.from_default_triple().create_target_machine(cpu=cpu, features=features, opt=LEVEL, jit=True)
    return target, binding.create_mcjit_compiler(binding.parse_assembly(""), target)


def _processor() -> tuple[str, str]:
    """Name of the processor and what it can do; without its abilities where LLVM does not know them."""
    try:
        features = binding.get_host_cpu_features().flatten()
    except RuntimeError:
        features = ""
    return binding.get_host_cpu_name(), features


@cache
def identity() -> str:
    """Text that tells apart machines and compilers whose code differs."""
    return " ".join([binding.get_process_triple(), *_processor(), llvmlite.__version__, str(LEVEL)])


def object_code(module: ir.Module) -> bytes:
    """Compile a module.

    Loops are neither unrolled nor vectorised: those over particles and nodes take four at a time already, and longer code takes longer to
    compile.

    Raises
    ------
    RuntimeError
        If LLVM refuses the module, as where a value is used outside the branch that computes it.
    """
    target, _ = _target()
    module.triple, module.data_layout = binding.get_process_triple(), str(target.target_data)
    parsed = binding.parse_assembly(str(module))
    parsed.verify()
    options = binding.create_pipeline_tuning_options(speed_level=LEVEL)
    options.loop_unrolling = options.loop_vectorization = options.slp_vectorization = options.loop_interleaving = False
    builder = binding.create_pass_builder(target, options)
    builder.getModulePassManager().run(parsed, builder)
    code: bytes = target.emit_object(parsed)
    return code


def address_of(code: bytes, name: str) -> int:
    """Load object code into this process, and return the address of one of its functions; no two codes may have one of the same name."""
    _, engine = _target()
    engine.add_object_file(binding.ObjectFileRef.from_data(code))
    engine.finalize_object()
    address: int = engine.get_function_address(name)
    return address
