"""C text → a shared library in the user's cache: the compiler, its flags, the cache."""

from sym2real.native.cache import library as library
from sym2real.native.compiler import find_compiler as find_compiler
