"""Train the pedestrians with JaxMARL's own IPPO script: when should they wait for a car that ignores them?

    pip install jaxmarl distrax hydra-core omegaconf wandb      # in the environment of jaxwalk
    git clone https://github.com/FLAIROX/JaxMARL       # its scripts are not in the package
    python examples/frameworks/jaxmarl_ippo.py JaxMARL/baselines/IPPO/ippo_ff_mpe.py

The script is unchanged: it calls ``jaxmarl.make`` for an environment by name, and gets jaxwalk's here. It supports
agents that are all alike and choose among a few actions, so it trains the twelve pedestrians, and a rule drives. The
configuration is the script's, except for the first lines.

The source package of JaxMARL 0.0.2 has scripts too, and its IPPO runs as well. It counts a step for each agent:

    pip download --no-deps --no-binary :all: jaxmarl==0.0.2 && tar -xf jaxmarl-0.0.2.tar.gz
    python examples/frameworks/jaxmarl_ippo.py jaxmarl-0.0.2/baselines/IPPO/ippo_mpe.py --steps 12e6
"""

import argparse
import importlib.util
import time
from pathlib import Path
from unittest import mock

import jax
import jaxmarl
import numpy as np
import wandb

from jaxwalk.adapters.jaxmarl import StreetMARL

CONFIG = {
    "ENV_NAME": "jaxwalk",
    "ENV_KWARGS": {"driver": "route-follower", "pedestrian_observation": "kerb"},
    "NUM_ENVS": 64,
    "LR": 1e-3,
    "GAMMA": 0.995,
    # As in the script's ippo_ff_mpe.yaml:
    "NUM_STEPS": 128,
    "UPDATE_EPOCHS": 4,
    "NUM_MINIBATCHES": 4,
    "GAE_LAMBDA": 0.95,
    "CLIP_EPS": 0.2,
    "ENT_COEF": 0.01,
    "VF_COEF": 0.5,
    "MAX_GRAD_NORM": 0.5,
    "ACTIVATION": "tanh",
    "ANNEAL_LR": True,
}

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("script", type=Path, help="JaxMARL's baselines/IPPO/ippo_ff_mpe.py, or ippo_mpe.py of 0.0.2")
parser.add_argument("--steps", type=float, default=1e6, help="training steps, as the script counts them")
parser.add_argument("--brief", action="store_true", help="run very briefly, as a test")
options = parser.parse_args()
config = CONFIG | {"TOTAL_TIMESTEPS": options.steps}
if options.brief:
    config |= {"NUM_ENVS": 8, "TOTAL_TIMESTEPS": 12 * 8 * 128 * 3}

if not hasattr(jax, "tree_map"):
    jax.tree_map = jax.tree.map  # the script of 0.0.2 uses the name that JAX had until 2024
spec = importlib.util.spec_from_file_location("ippo", options.script)
ippo = importlib.util.module_from_spec(spec)
spec.loader.exec_module(ippo)

wandb.init(mode="disabled")
begun = time.perf_counter()
with mock.patch.object(jaxmarl, "make", lambda name, **chosen: StreetMARL(**chosen)):
    train = ippo.make_train(config)
metrics = jax.device_get(jax.jit(train)(jax.random.PRNGKey(0))["metrics"])
print(f"{config['TOTAL_TIMESTEPS']:,.0f} steps in {time.perf_counter() - begun:.0f} s, compiling included")


def per_episode(name, updates):
    """Return the share of episodes of some updates that ended in this way."""
    return metrics[name][updates].sum() / metrics["returned_episode"][updates].sum()


tenth = max(1, len(metrics["returned_episode"]) // 10)
for when, updates in (("first tenth", slice(0, tenth)), ("last tenth", slice(-tenth, None))):
    if metrics["returned_episode"][updates].sum() == 0:
        print(f"{when}: no episode ended")
        continue
    print(
        f"{when}: collisions in {per_episode('collision', updates):.1%} of the episodes, "
        f"goals in {per_episode('goal', updates):.1%}, "
        f"return of a pedestrian {np.mean(metrics['returned_episode_returns'][updates]) / 12:.2f}"
    )
