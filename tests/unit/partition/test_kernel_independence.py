"""Robots compute the same goals on any kind of x86-64 processor, to the last bit."""

import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).with_name("partition_on_one_kernel.py")
AVX512 = "X86_V4 AVX512_ICL AVX512_SPR"
KERNELS = {
    # What the processor must be able to do, and how BLAS, NumPy and the C library are told what it can.
    "SSE": (
        "sse3",
        {
            "OPENBLAS_CORETYPE": "Prescott",
            "NPY_DISABLE_CPU_FEATURES": f"X86_V3 {AVX512}",
            "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX2_Usable,-FMA_Usable",
        },
    ),
    "AVX2": ("avx2", {"OPENBLAS_CORETYPE": "Haswell", "NPY_DISABLE_CPU_FEATURES": AVX512}),
    "AVX-512": ("avx512bw", {"OPENBLAS_CORETYPE": "SkylakeX"}),
}


def runnable() -> dict[str, dict[str, str]]:
    """Return the environments of the kernels that this processor can run."""
    flags = {"sse3", *Path("/proc/cpuinfo").read_text(encoding="ascii").split()}
    return {name: environment for name, (flag, environment) in KERNELS.items() if flag in flags}


@pytest.mark.skipif(platform.machine() != "x86_64", reason="the kernels are those of x86-64")
def test_every_kernel_computes_the_same_goals_to_the_last_bit() -> None:
    running = {
        name: subprocess.Popen(
            [sys.executable, str(PROGRAM)],
            env={
                **os.environ,
                **environment,
                "PYTHONPATH": os.pathsep.join(path for path in sys.path if path),
                "PYTHONWARNINGS": "ignore",
            },
            stdout=subprocess.PIPE,
            text=True,
        )
        for name, environment in runnable().items()
    }
    found = {name: process.communicate()[0].splitlines() for name, process in running.items()}

    assert all(process.returncode == 0 for process in running.values())
    products = {lines[0] for lines in found.values()}
    assert len(products) > 1 or len(found) == 1  # the kernels do round differently
    first, *others = (lines[1:] for lines in found.values())
    assert len(first) == 12
    for other in others:
        assert other == first
