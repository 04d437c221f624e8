"""How tests compile: programs run a few times only, so compiling them well takes longer than running them badly.

What runs often, or is compared with recorded numbers, asks for more: `sim.play.AS_SHIPPED`. Nothing here imports JAX,
which reads these variables when it starts.
"""

from __future__ import annotations

from importlib.metadata import version

from packaging.version import Version

CAN_EMIT_SIMPLY = Version(version("jaxlib")) < Version("0.11.1")
"""Whether XLA has a choice not to use its fusion emitters. Without it, they are always on, and the flag, which is then
unknown, ends the process."""
QUICKLY = {
    "JAX_DISABLE_MOST_OPTIMIZATIONS": "1",
    "JAX_TRACEBACK_IN_LOCATIONS_LIMIT": "0",
    "XLA_FLAGS": "--xla_cpu_parallel_codegen_split_count=1"
    + (" --xla_cpu_use_fusion_emitters=false" if CAN_EMIT_SIMPLY else ""),
}
"""Environment variables of the tests, and of the processes that they start."""
