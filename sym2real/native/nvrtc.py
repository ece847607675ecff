"""CUDA text → machine code by NVRTC (its wheel needs no GPU), and code → kernels that run where there is a GPU."""

import ctypes
import importlib.util
from functools import lru_cache
from pathlib import Path

import torch

from sym2real.errors import CompilationError, MissingDependencyError


@lru_cache(maxsize=1)
def _nvrtc() -> ctypes.CDLL:
    """The library that torch or the wheel ``nvidia-cuda-nvrtc`` brings, of torch's own version of CUDA before others.

    Raises:
        MissingDependencyError: when there is none.
    """
    package, major = importlib.util.find_spec("nvidia"), (torch.version.cuda or "").partition(".")[0]
    places = package.submodule_search_locations or [] if package else []
    files = [file for place in places for file in Path(place).rglob("libnvrtc.so*")]
    own = sorted(files, key=lambda file: (not file.name.endswith(f".so.{major}"), str(file)))[:1]
    try:
        return ctypes.CDLL(str(own[0]) if own else "libnvrtc.so")
    except OSError as error:
        raise MissingDependencyError("CUDA kernels need NVRTC: pip install 'sym2real[gpu]'") from error


def compile_cuda(text: str, architecture: str) -> bytes:
    """Machine code of a CUDA text for devices of an architecture, such as ``"sm_90"``.

    No PTX: a driver that is older than NVRTC, of the same major version, runs the one and refuses the other.

    Raises:
        MissingDependencyError: without NVRTC.
        CompilationError: with NVRTC's own words.
    """
    library, program = _nvrtc(), ctypes.c_void_p()
    library.nvrtcCreateProgram(ctypes.byref(program), text.encode(), b"kernel.cu", 0, None, None)
    options = (ctypes.c_char_p * 2)(f"--gpu-architecture={architecture}".encode(), b"--fmad=true")
    size = ctypes.c_size_t()
    try:
        if library.nvrtcCompileProgram(program, len(options), options):
            library.nvrtcGetProgramLogSize(program, ctypes.byref(size))
            log = ctypes.create_string_buffer(size.value)
            library.nvrtcGetProgramLog(program, log)
            raise CompilationError(f"NVRTC failed: {log.value.decode()[-2000:]}")
        library.nvrtcGetCUBINSize(program, ctypes.byref(size))
        code = ctypes.create_string_buffer(size.value)
        library.nvrtcGetCUBIN(program, code)
        return code.raw
    finally:
        library.nvrtcDestroyProgram(ctypes.byref(program))


class CudaModule:
    """A CUDA text, compiled for a device and loaded there.

    Args:
        text: of kernels with C names.
        device: of torch.

    Raises:
        MissingDependencyError: without NVRTC.
        CompilationError: when it does not compile or the driver refuses it.
    """

    def __init__(self, text: str, device: torch.device) -> None:
        if not torch.cuda.is_available():
            raise CompilationError("there is no CUDA device here, or torch was built without CUDA")
        major, minor = torch.cuda.get_device_capability(device)
        code = compile_cuda(text, f"sm_{major}{minor}")
        self._device, self._driver, self._module = device, ctypes.CDLL("libcuda.so.1"), ctypes.c_void_p()
        with torch.cuda.device(device):
            torch.zeros(1, device=device)  # makes the context current
            self._checked(self._driver.cuModuleLoadData(ctypes.byref(self._module), code))

    def __call__(self, kernel: str, blocks: int, threads: int, *arguments: ctypes.Structure | ctypes.c_void_p) -> None:
        """Start a kernel on torch's present stream with so many blocks of so many threads."""
        function = ctypes.c_void_p()
        self._checked(self._driver.cuModuleGetFunction(ctypes.byref(function), self._module, kernel.encode()))
        pointers = (ctypes.c_void_p * len(arguments))(*(ctypes.addressof(argument) for argument in arguments))
        stream = ctypes.c_void_p(torch.cuda.current_stream(self._device).cuda_stream)
        sizes = (blocks, 1, 1, threads, 1, 1, 0)
        # The driver launches in the current context, which need not be that of this module's device.
        with torch.cuda.device(self._device):
            self._checked(self._driver.cuLaunchKernel(function, *sizes, stream, pointers, None))

    @staticmethod
    def _checked(code: int) -> None:
        if code:
            raise CompilationError(f"the CUDA driver answered with error {code}")
