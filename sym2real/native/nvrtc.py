"""CUDA text → PTX by NVRTC (its wheel needs no GPU), and PTX → a function that runs where there is one."""

from __future__ import annotations

import ctypes
import importlib.util
from functools import lru_cache
from pathlib import Path

from sym2real.errors import CompilationError, MissingDependencyError

OLDEST = "compute_80"  # PTX of it runs on every newer device


@lru_cache(maxsize=1)
def _nvrtc() -> ctypes.CDLL:
    """The library of the ``nvidia-cuda-nvrtc`` wheel, or the one that torch brings.

    Raises:
        MissingDependencyError: when there is none.
    """
    found = importlib.util.find_spec("nvidia")
    for folder in (found.submodule_search_locations or []) if found else []:
        for file in sorted(Path(folder).rglob("libnvrtc.so*")):
            return ctypes.CDLL(str(file))
    try:
        return ctypes.CDLL("libnvrtc.so")
    except OSError as error:
        raise MissingDependencyError("CUDA kernels need NVRTC: pip install 'sym2real[gpu]'") from error


def compile_cuda(text: str, architecture: str = OLDEST) -> bytes:
    """PTX of a CUDA text.

    Raises:
        MissingDependencyError: without NVRTC.
        CompilationError: with NVRTC's own words.
    """
    library, program = _nvrtc(), ctypes.c_void_p()
    library.nvrtcCreateProgram(ctypes.byref(program), text.encode(), b"kernel.cu", 0, None, None)
    options = (ctypes.c_char_p * 2)(f"--gpu-architecture={architecture}".encode(), b"--fmad=true")
    failed = library.nvrtcCompileProgram(program, len(options), options)
    size = ctypes.c_size_t()
    if failed:
        library.nvrtcGetProgramLogSize(program, ctypes.byref(size))
        log = ctypes.create_string_buffer(size.value)
        library.nvrtcGetProgramLog(program, log)
        raise CompilationError(f"NVRTC failed: {log.value.decode()[-2000:]}")
    library.nvrtcGetPTXSize(program, ctypes.byref(size))
    ptx = ctypes.create_string_buffer(size.value)
    library.nvrtcGetPTX(program, ptx)
    library.nvrtcDestroyProgram(ctypes.byref(program))
    return ptx.raw


class CudaFunction:
    """A function of a PTX module, in the context that torch has made current.

    Args:
        ptx: from :func:`compile_cuda`.
        name: of the kernel.

    Raises:
        CompilationError: when the driver refuses it.
    """

    def __init__(self, ptx: bytes, name: str) -> None:
        self._driver = ctypes.CDLL("libcuda.so.1")
        module, self._function = ctypes.c_void_p(), ctypes.c_void_p()
        self._checked(self._driver.cuModuleLoadData(ctypes.byref(module), ptx))
        self._checked(self._driver.cuModuleGetFunction(ctypes.byref(self._function), module, name.encode()))

    def __call__(self, blocks: int, threads: int, stream: int, *arguments: ctypes.Structure | ctypes.c_void_p) -> None:
        """Start it on a stream with so many blocks of so many threads."""
        pointers = (ctypes.c_void_p * len(arguments))(*(ctypes.addressof(one) for one in arguments))
        launch = self._driver.cuLaunchKernel
        self._checked(launch(self._function, blocks, 1, 1, threads, 1, 1, 0, ctypes.c_void_p(stream), pointers, None))

    @staticmethod
    def _checked(code: int) -> None:
        if code:
            raise CompilationError(f"the CUDA driver answered with error {code}")
