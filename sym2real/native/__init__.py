"""C text → a shared library in the user's cache: the compiler, its flags, the cache."""

from sym2real.native.cache import library
from sym2real.native.compiler import Compiler, find_compiler

__all__ = ["Compiler", "find_compiler", "library"]
