"""How the kernel becomes machine code: numba infers types and lowers, LLVM optimises.

`numba.njit` would do the same in twice the time. Here numba knows only the types and operators that
the kernel uses, runs only the passes that change something in it, and leaves all functions to LLVM
in one module, which is optimised for an entry as a whole. Importing this module imports numba.
"""

import operator
from collections.abc import Callable
from functools import cache, partial, reduce
from typing import Any

import llvmlite.binding as llvm
import numba
from numba.core import cgutils, codegen, compiler, cpu, types, typing
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager
from numba.core.typed_passes import (
    NativeLowering,
    NoPythonBackend,
    NopythonTypeInference,
    PreLowerStripPhis,
)
from numba.core.typing import templates
from numba.core.typing.templates import AbstractTemplate
from numba.core.untyped_passes import IRProcessing, ReconstructSSA, TranslateByteCode

from camcli.kernel.marks import FUNCTIONS, OUTLINED

# Not those for closures, literals, expressions of arrays, parallel loops and reference counts.
PASSES: list[Any] = [TranslateByteCode, IRProcessing, ReconstructSSA, NopythonTypeInference]
PASSES += [PreLowerStripPhis, NativeLowering, NoPythonBackend]


def _is_compiled_by_numba(template: Any) -> bool:
    """Whether a function of numba's is written in Python, which numba compiles itself."""
    return hasattr(template, "_overload_func") or hasattr(template, "_overload_attr")


class _Types(typing.Context):
    """What operators and functions return for types of arguments; each answer is kept."""

    def __init__(self) -> None:
        super().__init__()
        self._answers: dict = {}

    def load_additional_registries(self) -> None:
        from numba.core.typing import mathdecl

        self.install_registry(mathdecl.registry)

    def refresh(self) -> None:
        if not self._registries:
            super().refresh()

    def install_registry(self, registry: Any) -> None:
        """Take what is in a registry of numba, without the functions that numba compiles itself.

        A registry holds what numba knows of operators, functions, attributes and global names, each
        as templates that give the type of a result. Those that numba compiles itself are in it
        where numba has compiled something else in this process before; `_Target` cannot lower them,
        and does without them where numba is fresh.
        """
        loader = templates.RegistryLoader(registry)
        self._registries[registry] = loader
        for template in loader.new_registrations("functions"):
            if not _is_compiled_by_numba(template):
                self.insert_function(template(self))
        for template in loader.new_registrations("attributes"):
            if not _is_compiled_by_numba(template):
                self.insert_attributes(template(self))
        for value, kind in loader.new_registrations("globals"):
            known = self._lookup_global(value)
            if isinstance(kind, types.Function):
                kept = [each for each in kind.templates if not _is_compiled_by_numba(each)]
                if not kept:
                    continue
                kind = types.Function(tuple(kept))
            if known is None:
                self.insert_global(value, kind)
            else:  # another template of a name that is there, as for other types of arguments
                self._remove_global(value)
                self.insert_global(value, known.augment(kind))

    def resolve_function_type(self, function: Any, args: Any, keywords: Any) -> Any:
        """The signature of a call with these types of arguments; each answer is kept."""
        key = function, args, *dict(keywords).items()
        if key not in self._answers:
            self._answers[key] = super().resolve_function_type(function, args, keywords)
        return self._answers[key]


class _Target(cpu.CPUContext):
    """How operators and functions become instructions of LLVM."""

    def load_additional_registries(self) -> None:
        """Take what the kernel needs of numba's operators; numba calls it once, at first use.

        Each of the modules that are imported puts the machine code of some operators into numba's
        list of all; that of `sqrt` is a registry of its own. They are imported here, after `_Types`
        is filled, because what they would add to it for other types takes longer.
        """
        from numba.cpython import builtins, listobj, mathimpl, numbers, rangeobj, tupleobj  # noqa
        from numba.np import arrayobj  # noqa

        self.install_registry(mathimpl.registry)

    def refresh(self) -> None:
        if not self._registries:
            super().refresh()

    def mangler(self, name: str, args: Any, *, abi_tags: Any = (), uid: Any = None) -> str:
        return f"{name}.{uid}"  # numba's names tell all types, and are most of a module's text

    def post_lowering(self, module: Any, library: Any) -> None:
        pass  # no reference counts, whose runtime numba would link


class _Library(codegen.JITCodeLibrary):
    """Where numba puts a function: into the module of all."""

    module: Any

    def create_ir_module(self, name: str) -> Any:
        return self.module

    def add_ir_module(self, module: Any) -> None:
        pass

    def finalize(self) -> None:
        pass


class _Compiler(compiler.CompilerBase):
    """numba's compiler with the passes PASSES alone."""

    def define_pipelines(self) -> list:
        """numba asks for its pipelines by this name."""
        manager = PassManager("kernel")
        for step in PASSES:
            manager.add_pass(step, step.__name__)
        manager.finalize()
        return [manager]


_types = _Types()
_target = _Target(_types)
_codegen = _target.codegen()
_codegen._library_class = _Library  # also of what numba compiles for an operator
_library = _Library(_codegen, "kernel")
_parts: list = []  # modules of the entries before, whose functions the next one may call


@global_compiler_lock
def machine_code(entry: Callable, args: tuple) -> tuple[str, bytes]:
    """(the name of a function that calls the entry, the object file that has it).

    The function takes the address at which its arguments stand, of the types of `args`, one after
    the other, and returns what the entry returns, all in numba's own convention.

    numba puts the entry, and the functions that it calls, into a module of LLVM of their own; those
    that it has compiled for an entry before it only names. So the modules of the entries before are
    linked to it, and all is then optimised as a whole.
    """
    _Library.module = _codegen._create_empty_module("kernel")  # numba fills it
    kind = numba.typeof(args)

    def arguments(address: int) -> Any:
        """The tuple of arguments at an address; `load` makes its machine code."""

    def load(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        """Read from the address, which is the only one of the values."""
        pointer = context.get_value_type(kind).as_pointer()
        return builder.load(builder.inttoptr(values[0], pointer))

    def call(address: int) -> int:
        """What is compiled: the entry, with the arguments at an address."""
        return entry(*arguments(address))

    _declare(arguments, lambda address: _lowered(arguments, load, kind, address))
    name = _compiled(call, types.intp).fndesc.llvm_func_name
    part = llvm.parse_assembly(str(_Library.module))
    part.verify()
    module = part.clone()  # linking changes it; `part` is kept for the entries to come
    for other in _parts:
        module.link_in(other, preserve=True)
    _parts.append(part)
    return name, _optimised(module, name)


def _optimised(module: Any, name: str) -> bytes:
    """The object file of a module, in which one function alone is seen from outside."""
    for function in module.functions:
        if not function.is_declaration and function.name != name:
            function.linkage = llvm.Linkage.internal
    optimise, builder = _codegen._module_pass_manager()
    remove_unused = llvm.create_new_module_pass_manager()
    remove_unused.add_global_dead_code_eliminate_pass()  # what this entry does not call
    remove_unused.run(module, builder)
    optimise.run(module, builder)
    return _codegen._tm.emit_object(module)


def _compiled(function: Callable, *args: Any) -> Any:
    """numba's result for a function and types of arguments; its code is then in the module.

    An outlined function stays a call, others are put into their callers by LLVM. The error model of
    NumPy spares the tests for a division by zero. There is no wrapper for Python or C.
    """
    flags: Any = compiler.Flags()
    flags.error_model = "numpy"
    flags.forceinline = function not in OUTLINED
    flags.no_compile = True
    flags.no_cpython_wrapper = True
    flags.no_cfunc_wrapper = True
    result = compiler.compile_extra(
        _types, _target, function, args, None, flags, {}, _library, _Compiler
    )
    _target.insert_user_function(function, result.fndesc)
    return result


def _lowered(function: Callable, lower: Callable, returns: Any, *args: Any) -> Any:
    """The signature of a function whose machine code `lower` makes, as numba calls it.

    returns, args: the types of its result and of its arguments.
    """
    _target.insert_func_defn([(lower, function, args)])
    return returns(*args)


def _declare(function: Callable, typed: Callable) -> None:
    """Tell numba of a function.

    typed: called with the types of its arguments, returns its signature; once for each such types.
    """
    signature_of = cache(typed)
    template = type(
        function.__name__,
        (AbstractTemplate,),
        {"key": function, "generic": lambda self, args, keywords: signature_of(*args)},
    )
    _types.insert_user_function(function, template)


def _extreme(sign: str, context: Any, builder: Any, signature: Any, values: Any) -> Any:
    """Machine code of Python's min (sign <) or max (>) of numbers of one type.

    Of equal ones it is the first, as in Python. context and signature: as numba calls it.
    """
    is_real = signature.return_type == types.float64
    compare = builder.fcmp_ordered if is_real else builder.icmp_signed
    return reduce(lambda a, b: builder.select(compare(sign, b, a), b, a), values)


def _read(context: Any, builder: Any, signature: Any, values: Any) -> Any:
    """Machine code of column[n]; numba's own first adds the length to an n below zero."""
    from numba.np import arrayobj

    column, place = _place(context, builder, signature, values)
    return arrayobj.load_item(context, builder, column, place)


def _write(context: Any, builder: Any, signature: Any, values: Any) -> None:
    """Machine code of column[n] = value."""
    from numba.np import arrayobj

    column, place = _place(context, builder, signature, values)
    value = context.cast(builder, values[2], signature.args[2], column.dtype)
    arrayobj.store_item(context, builder, column, value, place)


def _place(context: Any, builder: Any, signature: Any, values: Any) -> tuple[Any, Any]:
    """(type of the column or table, address of its entry values[1]); the kernel counts from 0."""
    from numba.np import arrayobj

    kind = signature.args[0]
    column = arrayobj.make_array(kind)(context, builder, values[0])
    return kind, cgutils.get_item_pointer(context, builder, kind, column, [values[1]])


def _whole(context: Any, builder: Any, signature: Any, values: Any) -> Any:
    """Python's int of a float."""
    return builder.fptosi(values[0], context.get_value_type(signature.return_type))


for _one in FUNCTIONS:
    _declare(_one, lambda *args, one=_one: _compiled(one, *args).signature)
_declare(min, lambda *args: _lowered(min, partial(_extreme, "<"), args[0], *args))
_declare(max, lambda *args: _lowered(max, partial(_extreme, ">"), args[0], *args))
_declare(int, lambda *args: _lowered(int, _whole, types.intp, *args))
_target.insert_func_defn(
    [
        (_read, operator.getitem, (types.Array, types.Integer)),
        (_write, operator.setitem, (types.Array, types.Integer, types.Number)),
    ]
)
_types.refresh()
