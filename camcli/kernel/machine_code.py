"""Machine code in memory: an entry of the kernel that LLVM has loaded, and how it is called.

It is called as numba calls its own functions from each other, without numba.
"""

import struct
from ctypes import CFUNCTYPE, addressof, byref, c_char, c_char_p, c_int32, c_int64, c_void_p
from typing import Any

import llvmlite.binding as llvm
from numpy import ndarray

# numba's own convention: where the result goes, where an exception goes, arguments
CALL = CFUNCTYPE(c_int32, c_void_p, c_void_p, c_char_p)


class MachineCode:
    """A compiled entry with one signature; it returns an int.

    Any other kind of argument is a fault of the caller and raises TypeError.
    """

    def __init__(self, name: str, symbol: str, code: bytes, numbers: list, kinds: list):
        """code: an object file with a function `symbol`; numbers, kinds: see `flatten`."""
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        machine = llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine()
        engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
        engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        engine.finalize_object()
        address = engine.get_function_address(symbol)
        if not address:
            raise ValueError(f"no function {symbol}")
        self._engine = engine  # owns the code
        self._function = CALL(address)
        self._name, self._kinds = name, kinds
        self._form = struct.Struct(form_of(numbers))
        self._last: tuple[tuple, list, list] = (), [], []  # cam, and what `flatten` makes of it
        # cam, a column that was the only other argument, and both as they were passed
        self._again: tuple[tuple, Any, bytes] = (), None, b""

    def __call__(self, cam: tuple, *args: Any) -> int:
        """Run the function and return its status; arguments of other kinds are a TypeError.

        What was flattened is kept where the next call has the same cam, or all the same arguments.
        """
        again = self._again
        if again[0] is cam and len(args) == 1 and args[0] is again[1]:
            return self._run(again[2])
        last = self._last
        if last[0] is not cam:  # it is the same for many calls
            last = cam, [], []
            flatten(*last)
            self._last = last
        numbers, kinds = last[1].copy(), last[2].copy()
        flatten(args, numbers, kinds)
        if kinds != self._kinds:
            raise TypeError(f"{self._name} was compiled for other columns")
        try:
            packed = self._form.pack(*numbers)
        except struct.error as error:
            raise TypeError(f"{self._name} was compiled for other arguments ({error})") from None
        if len(args) == 1 and isinstance(args[0], ndarray):
            self._again = cam, args[0], packed
        return self._run(packed)

    def _run(self, packed: bytes) -> int:
        """Call it with these arguments."""
        returned = c_int64()
        failed = self._function(byref(returned), None, packed)
        assert not failed  # the kernel raises nothing
        return returned.value


def form_of(numbers: list) -> str:
    """The form, in the words of `struct`, in which numba takes these numbers."""
    return "=" + "".join("d" if isinstance(number, float) else "q" for number in numbers)


def flatten(values: tuple, numbers: list, kinds: list) -> None:
    """The numbers that numba makes of arguments, each of 8 bytes.

    A tuple is its entries; a column its owner (none: nobody counts references), size, width of an
    entry, address, shape and strides. kinds: what the columns and tables hold.
    """
    for value in values:
        kind = type(value)
        if kind is float or kind is int:
            numbers.append(value)
        elif isinstance(value, tuple):
            flatten(value, numbers, kinds)
        elif isinstance(value, ndarray):
            if not (value.flags.carray and value.ndim == 1):
                raise TypeError("the kernel takes columns that are contiguous and may be written")
            size, width = value.size, value.itemsize
            address = addressof(c_char.from_buffer(value)) if size else 0  # type: ignore[arg-type]
            numbers += (0, 0, size, width, address, size, width)
            kinds.append(value.dtype)
        else:
            numbers.append(value)
