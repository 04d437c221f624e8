"""All settings of the learner. There is no JAX import, so that command lines start quickly."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

GLOBAL = "global"
"""The name by which a critic reads the environment's global state."""
SHARED = "shared"
"""Name of the one critic of shared credit; the others are named after their roles."""
SNAPSHOTS = (10, 30)
"""Numbers of updates after which a snapshot of a role is kept, for `RoleConfig.early`."""

LARGEST = {"environments": 2**20, "steps": 2**16, "updates": 2**31 - 1, "chunk_rows": 2**31 - 1}
"""Largest values of fields of `TrainConfig`."""
WHOLE_MINIBATCH = 2**30
"""More rows than any minibatch has."""
MOST_LAYERS, MOST_UNITS = 16, 2**14
"""Largest network: number of hidden layers, and units in each."""
LAYERS = f"must be at most {MOST_LAYERS} numbers, each in [1, {MOST_UNITS}]"


@dataclass(frozen=True)
class CostLimit:
    """A limit of one of the environment's costs, for each agent and episode. A PID controller enforces it.

    ``docs/learning.md#limits`` has the formulas. An impossible value raises ValueError, which names the field.
    """

    cost: str
    """Name of the cost in `jaxwalk.interfaces.Outcome.costs`."""
    limit: float
    """The largest mean cost of an episode, or with ``tail`` the largest mean over the worst episodes."""
    worth: float = 1.0
    """What a unit of the cost is worth at a multiplier of 1, in rewards as the learner sees them."""
    tail: float = 0.0
    """Above 0: the limit is one of the conditional value at risk at this level, the mean over the worst 1 - ``tail`` of
    the episodes. Only for a cost that an episode has in no more than one step."""
    proportional: float = 0.1
    """Gain of the smoothed excess over the limit (OmniSafe, CPPOPID.yaml, as the next two) ..."""
    integral: float = 0.01
    """... of the sum of excesses ..."""
    derivative: float = 0.01
    """... and of the cost's rise."""

    def __post_init__(self) -> None:
        """Raise ValueError for a limit that can't be enforced."""
        _require(self, bool(self.cost), "cost", "must name a cost")
        for name in ("limit", "worth"):
            _require(self, 0 < getattr(self, name) < math.inf, name, "must be a finite number above 0")
        for name in ("proportional", "integral", "derivative"):
            _require(self, 0 <= getattr(self, name) < math.inf, name, "must be a finite number of 0 or more")
        _require(self, 0 <= self.tail < 1, "tail", "must lie in [0, 1)")


@dataclass(frozen=True)
class RoleConfig:
    """How one role learns. An impossible value raises ValueError, which names the field."""

    fixed: float = 0.0
    """Share of the environments in which a fixed policy plays the role. With 1, the role is not trained."""
    early: float = 0.0
    """Share of the environments in which the role is played by its earlier versions, those after `SNAPSHOTS` updates.
    The current version plays in the remaining environments, and learns only from those."""
    observes: str = "paper"
    """The observation set that the actor reads."""
    actor_hidden: tuple[int, ...] = (128, 128)
    """Units of the actor's hidden layers (paper, section III-B: 128 pedestrian, 256 driver)."""
    critic_hidden: tuple[int, ...] = (128, 128)
    """Units of the role's own critic's hidden layers; unused with shared credit."""
    critic_observes: tuple[str, ...] = ("paper",)
    """What the role's own critic reads: observation sets of the role, and ``"global"``; unused with shared credit."""
    entropy: float = 0.01
    """Weight of the entropy bonus [1 / nat] (paper, Table II: 0.03 pedestrian, 0.01 driver)."""
    epochs: int | float = 4
    """Passes over each rollout (paper, Table II: 4). Below 1, only that share of the rollout is used: twelve
    pedestrians produce more data than they need."""
    gated: bool = False
    """Only for roles that choose between 0 and 1. A gated role decides only where its observation's first feature is
    above 0, takes 1 elsewhere, and learns only from its decisions."""
    hold: int = 1
    """Gated roles only. Steps for which a decision is kept, as long as there is something to decide."""
    noise: Literal["clipped", "tanh"] = "clipped"
    """Continuous actions only. ``clipped``: the mean is bounded by tanh, noise is added, and the environment gets the
    action clipped to [-1, 1]. ``tanh``: noise is added first, then the sum is squashed. The paper does not say."""
    initial_std: float = 0.6
    """Continuous actions only: standard deviation of the noise at the start of training (the paper does not say)."""
    limits: tuple[CostLimit, ...] = ()
    """Limits of costs, each with a critic and a multiplier of its own. None: the role is paid only its reward."""

    def __post_init__(self) -> None:
        """Raise ValueError for a field that cannot be trained."""
        for name in ("fixed", "early"):
            _require(self, 0 <= getattr(self, name) <= 1, name, "must lie in [0, 1]")
        _require(self, self.fixed + self.early < 1 or not self.learns, "early", "leaves nothing to learn from")
        _require(self, self.hold == 1 or (self.hold > 1 and self.gated), "hold", "must be 1, or more for a gated role")
        alone = not (self.gated and GLOBAL in self.critic_observes)
        _require(self, alone, "critic_observes", f"of a gated role can't have {GLOBAL!r}", None)
        _require(self, 0 <= self.entropy < math.inf, "entropy", "must be a finite number of 0 or more")
        _require(self, 0 < self.epochs < math.inf, "epochs", "must be a finite number above 0")
        _require(self, 0 < self.initial_std < math.inf, "initial_std", "must be a finite number above 0")
        _require(self, self.noise in ("clipped", "tanh"), "noise", 'must be "clipped" or "tanh"')
        _require(self, bool(self.observes) and self.observes != GLOBAL, "observes", "must name an observation set")
        _require(self, len(self.critic_observes) > 0, "critic_observes", "must name at least one observation set")
        once = len({limit.cost for limit in self.limits}) == len(self.limits)
        _require(self, once, "limits", "must be of different costs", None)
        for name in ("actor_hidden", "critic_hidden"):
            _require(self, _possible_layers(getattr(self, name)), name, LAYERS)

    @property
    def learns(self) -> bool:
        """Whether the role is trained."""
        return self.fixed < 1


@dataclass(frozen=True)
class TrainConfig:
    """Settings of a training. An impossible value raises ValueError, which names the field."""

    roles: dict[str, RoleConfig]
    """How each of the environment's roles learns."""
    environments: int = 512
    """Number of parallel environments (paper, Table II)."""
    steps: int = 256
    """Steps of each environment in a rollout (paper, Table II)."""
    minibatches: int = 8
    """Parts into which an epoch divides the rollout's time steps (paper, Table II)."""
    updates: int = 5000
    """Rollouts in the whole training (paper, Table II): its length, and when an annealed learning rate reaches 0."""
    learning_rate: float = 3e-4
    """Adam's step size (paper, Table II)."""
    anneal: bool = False
    """Whether the learning rate falls linearly to 0 over ``updates`` (paper: constant)."""
    adam_epsilon: float = 1e-5
    """Added to the square root in Adam's denominator; the paper does not say, this is usual in PPO."""
    max_grad_norm: float = 0.5
    """Largest norm of each network's gradient (paper, Table II)."""
    discount: float = 0.995
    """Discount factor per step of 0.1 s (paper, Table II)."""
    gae_lambda: float = 0.95
    """Lambda of generalised advantage estimation (paper, Table II)."""
    clip: float = 0.2
    """Clip range of PPO: probability ratios beyond 1 +- this bring no further gain (paper, Table II)."""
    value_coefficient: float = 0.5
    """Weight of the squared value error. Each network has its own Adam, so this only matters for ``max_grad_norm``."""
    reward_scale: float = 1.0
    """Factor on the rewards that the learner sees (not on its metrics): critics learn values of size 1 fastest."""
    credit: Literal["individual", "shared"] = "individual"
    """``individual``: a critic for each role and a value for each agent. ``shared``: one critic on the global state,
    one reward (the mean over learning roles of the mean over a role's agents), one advantage for everybody."""
    shared_critic_hidden: tuple[int, ...] = (256, 256)
    """Units of the shared critic's hidden layers (paper, section III-B); unused with individual credit."""
    chunk_rows: int = 2048
    """Rows (one agent in one step each) whose gradient is computed at once: this affects only speed, never the result.
    About 2,048 suits a CPU's cache; a training that begins on a GPU takes whole minibatches instead of this default."""
    shards: int = 1
    """Devices (accelerators, or CPU cores) that share the environments; each shard has its own stand-ins. More
    shards are faster, but another number of them changes a training as another seed does."""

    def __post_init__(self) -> None:
        """Raise ValueError for settings that cannot be trained."""
        for name in ("environments", "steps", "minibatches", "updates", "chunk_rows", "shards"):
            _require(self, getattr(self, name) >= 1, name, "must be at least 1")
        for name, most in LARGEST.items():
            _require(self, getattr(self, name) <= most, name, f"must be at most {most:,}")
        for name in ("learning_rate", "adam_epsilon", "max_grad_norm", "clip", "value_coefficient", "reward_scale"):
            _require(self, 0 < getattr(self, name) < math.inf, name, "must be a finite number above 0")
        for name in ("discount", "gae_lambda"):
            _require(self, 0 <= getattr(self, name) <= 1, name, "must lie in [0, 1]")
        alone = self.credit == "individual" or not any(self.roles[role].gated for role in self.roles)
        _require(self, alone, "gated", "goes with individual credit only", None)
        alone = self.credit == "individual" or all(self.roles[role].fixed in (0, 1) for role in self.roles)
        _require(self, alone, "fixed", "between 0 and 1 goes with individual credit only", None)
        alone = self.credit == "individual" or all(self.roles[role].early == 0 for role in self.roles)
        _require(self, alone, "early", "goes with individual credit only", None)
        alone = self.credit == "individual" or not any(self.roles[role].limits for role in self.roles)
        _require(self, alone, "limits", "go with individual credit only", None)
        divides = self.steps % self.minibatches == 0
        _require(self, divides, "minibatches", f"must divide steps ({self.steps})")
        divides = self.environments % self.shards == 0
        _require(self, divides, "shards", f"must divide environments ({self.environments})")
        _require(self, self.credit in ("individual", "shared"), "credit", 'must be "individual" or "shared"')
        _require(self, _possible_layers(self.shared_critic_hidden), "shared_critic_hidden", LAYERS)
        for role in self.learning_roles:
            _require(self, own_environments(self, role) >= 1, "environments", f"leave the {role} none to learn from")
        _require(self, bool(self.learning_roles), "fixed", "must be below 1 for at least one role", None)

    def __hash__(self) -> int:
        """Return a hash, so that compiled programs are cached by configuration."""
        return hash(repr(self))

    @property
    def learning_roles(self) -> tuple[str, ...]:
        """Names of the roles that are trained."""
        return tuple(role for role, config in self.roles.items() if config.learns)

    @property
    def limits(self) -> dict[str, tuple[str, CostLimit]]:
        """The limits of learning roles, each with its role, by the name of their critic: role and cost."""
        pairs = ((role, limit) for role in self.learning_roles for limit in self.roles[role].limits)
        return {f"{role} {limit.cost}": (role, limit) for role, limit in pairs}


def own_environments(config: TrainConfig, role: str) -> int:
    """Return the number of environments in which a role's learner plays: all but those of its stand-ins."""
    choice, count = config.roles[role], config.environments // config.shards
    return config.shards * (count - round(choice.fixed * count) - round(choice.early * count))


def _possible_layers(hidden: tuple[int, ...]) -> bool:
    """Return whether the sizes of hidden layers are possible."""
    return len(hidden) <= MOST_LAYERS and all(0 < units <= MOST_UNITS for units in hidden)


def _require(config: object, condition: bool, name: str, message: str, value: object = ...) -> None:
    if not condition:
        shown = getattr(config, name) if value is ... else value
        raise ValueError(f"{name} {message}" + ("" if shown is None else f", not {shown!r}"))
