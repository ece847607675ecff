"""The arithmetic limit: multiply-or-FMA slots of a sample's step at this machine's measured throughput."""

import ctypes
from functools import lru_cache

from sym2real.native import library
from sym2real.symbolic.c_functions import preamble

# Of the quadrotor's reference equations: with normalisation and cost, and for four normal numbers.
SLOTS = 840 + 140
CHAINS, ROUNDS = 12, 400_000

TEXT = """
EXPORTED float multiply_adds(float c, float d) {
    v x[%d];
    for (int i = 0; i < %d; i++) x[i] = splat(c + i);
    for (int round = 0; round < %d; round++) {
#pragma GCC unroll 16
        for (int i = 0; i < %d; i++) x[i] = x[i] * c + d;
    }
    v sum = x[0];
    for (int i = 1; i < %d; i++) sum += x[i];
    return sum[0];
}
EXPORTED int lanes(void) { return WIDTH; }
"""


@lru_cache(maxsize=1)
def _kernel() -> ctypes.CDLL:
    return library(preamble(single=True) + TEXT % (CHAINS, CHAINS, ROUNDS, CHAINS, CHAINS))


def multiply_adds() -> int:
    """Independent chains of vector multiply-adds, about a millisecond of them; how many were computed."""
    kernel = _kernel()
    kernel.multiply_adds(ctypes.c_float(0.5), ctypes.c_float(0.1))
    return CHAINS * ROUNDS * int(kernel.lanes())
