"""How Numba compiles kernels here: without work that only other programs need.

Numba counts references, makes notes for debuggers, and optimises each function alone although its
callers contain it. A kernel that counts no references needs none of this, and compiles faster
without it.
"""

from typing import Any

from numba.core import cgutils as _cgutils
from numba.core import ir
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import BaseNativeLowering, NativeLowering, NopythonRewrites
from numba.core.untyped_passes import InlineClosureLikes

cgutils: Any = _cgutils


class _Lower(Lower):
    """Writes the code of a kernel for LLVM."""

    def lower_inst(self, inst: Any) -> None:
        """Leave out the end of a variable, where only a count of references would change."""
        if self.context.enable_nrt or not isinstance(inst, ir.Del):
            super().lower_inst(inst)

    def alloca_lltype(self, name: str, lltype: Any, datamodel: Any = None) -> Any:
        """Room for a variable, without the note for debuggers, for which its size is computed."""
        return cgutils.alloca_once(self.builder, lltype, name=name)


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(BaseNativeLowering):
    _name: Any = "kernel_lowering"
    lowering_class: Any = _Lower


class KernelCompiler(Compiler):
    """Compiles a kernel."""

    def define_pipelines(self) -> list[PassManager]:
        """The passes of Numba. Kernels without arrays of their own have no expressions of arrays
        and no functions within functions."""
        (usual,) = super().define_pipelines()
        needless = () if self.state.flags.nrt else (NopythonRewrites, InlineClosureLikes)
        found = PassManager(usual.pipeline_name)
        for step, note in usual.passes:
            if step not in needless:
                found.add_pass(_Lowering if step is NativeLowering else step, note)
        found.finalize()
        return [found]


class _Part(JITCodeLibrary):
    """The code of a kernel as a part of those that call it.

    Numba optimises each kernel and makes machine code of it, then does so again for its callers,
    which contain it. A part is left as it is until a kernel that Python calls is complete.
    """

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        return 0

    @property
    def codegen(self) -> Any:
        return self

    def set_env(self, name: str, env: Any) -> None:
        pass


class PartCompiler(KernelCompiler):
    """Makes a part of a kernel."""

    def compile_extra(self, func: Any) -> Any:
        self.state.library = _Part(self.state.targetctx.codegen(), func.__qualname__)
        return super().compile_extra(func)
