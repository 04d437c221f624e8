"""jaxwalk: how does a self-driving car behave among people who may jaywalk?

The public names, lazily: ``import jaxwalk`` loads no JAX; the first use of a name loads what that name needs.
"""

from typing import TYPE_CHECKING, Any

from jaxwalk.lazy import imported_when_used

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
    from jaxwalk.runs.entry import resume as resume
    from jaxwalk.runs.entry import train as train
    from jaxwalk.scenarios import Drawn as Drawn
    from jaxwalk.sim.environment import Street as Street
    from jaxwalk.sim.sim_config import SimConfig as SimConfig
    from jaxwalk.sim.trajectory import Trajectory as Trajectory

    __version__: str

# Public name -> the room or module that holds it. A new name goes here and, for type checkers, in the imports above.
_HOMES = {
    "DRIVERS": "policies",
    "Drawn": "scenarios",
    "LearnedPolicy": "policies",
    "POPULATIONS": "policies",
    "SimConfig": "sim.sim_config",
    "Street": "sim.environment",
    "Trajectory": "sim.trajectory",
    "evaluate": "evaluation",
    "load_map": "maps",
    "load_policy": "policies",
    "measure": "metrics",
    "play": "evaluation",
    "resume": "runs.entry",
    "summarise": "metrics",
    "train": "runs.entry",
}

__all__ = [*_HOMES, "__version__"]  # pyright: ignore[reportUnsupportedDunderAll] (each import above re-exports itself)

_import, _ = imported_when_used(__name__, _HOMES)


def __getattr__(name: str) -> Any:
    if name != "__version__":
        return _import(name)
    from importlib.metadata import version

    return version("jaxwalk")


def __dir__() -> list[str]:
    return list(__all__)
