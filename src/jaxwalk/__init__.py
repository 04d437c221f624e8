"""jaxwalk: how does a self-driving car behave among people who may jaywalk?

The public names, lazily: ``import jaxwalk`` loads no JAX; the first use of a name loads what that name needs.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jaxwalk.evaluation import evaluate as evaluate
    from jaxwalk.evaluation import play as play
    from jaxwalk.maps import load_map as load_map
    from jaxwalk.metrics import measure as measure
    from jaxwalk.metrics import summarise as summarise
    from jaxwalk.policies import DRIVERS as DRIVERS
    from jaxwalk.policies import POPULATIONS as POPULATIONS
    from jaxwalk.policies import LearnedPolicy as LearnedPolicy
    from jaxwalk.policies import load_policy as load_policy
    from jaxwalk.scenarios import Drawn as Drawn
    from jaxwalk.sim.environment import Street as Street
    from jaxwalk.sim.sim_config import SimConfig as SimConfig
    from jaxwalk.sim.trajectory import Trajectory as Trajectory

    __version__: str

# Public name -> the module that holds it. A new name goes here and, for type checkers, in the imports above.
_HOMES = {
    "DRIVERS": "jaxwalk.policies",
    "Drawn": "jaxwalk.scenarios",
    "LearnedPolicy": "jaxwalk.policies",
    "POPULATIONS": "jaxwalk.policies",
    "SimConfig": "jaxwalk.sim.sim_config",
    "Street": "jaxwalk.sim.environment",
    "Trajectory": "jaxwalk.sim.trajectory",
    "evaluate": "jaxwalk.evaluation",
    "load_map": "jaxwalk.maps",
    "load_policy": "jaxwalk.policies",
    "measure": "jaxwalk.metrics",
    "play": "jaxwalk.evaluation",
    "summarise": "jaxwalk.metrics",
}

__all__ = [*_HOMES, "__version__"]  # pyright: ignore[reportUnsupportedDunderAll] (each import above re-exports itself)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        value = version("jaxwalk")
    elif name in _HOMES:
        value = getattr(import_module(_HOMES[name]), name)
    else:
        raise AttributeError(f"module 'jaxwalk' has no attribute {name!r}")
    globals()[name] = value  # the next use is an ordinary attribute access
    return value


def __dir__() -> list[str]:
    return list(__all__)
