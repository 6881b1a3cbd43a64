"""Where the numbers of an array stand in memory."""

from __future__ import annotations

import ctypes

import numpy as np

_NOTHING = ctypes.c_char * 0


def address_of(array: np.ndarray) -> int:
    """Address of the first number of a contiguous array; attributes of the array take four times as long to say it."""
    if not array.flags.writeable:  # ctypes wants a buffer that may be written
        return array.ctypes.data
    return ctypes.addressof(_NOTHING.from_buffer(array.data))
