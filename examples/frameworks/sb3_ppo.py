"""Train a driver with Stable-Baselines3's PPO among people who always go, and compare it with the route-follower.

    pip install 'jaxwalk[frameworks]'
    python examples/frameworks/sb3_ppo.py                   # some minutes on two cores
    python examples/frameworks/sb3_ppo.py --brief           # very briefly, as a test

``PPO("MlpPolicy", gymnasium.make("jaxwalk/Street-v0"))`` works as it is, too, with a single street;
`StreetVecEnv` steps 512 at once.
"""

import argparse
import time

import gymnasium
import numpy as np
import torch
from stable_baselines3 import PPO

import jaxwalk.adapters.gymnasium
from jaxwalk import Street, evaluate, summarise
from jaxwalk.adapters.stable_baselines3 import StreetVecEnv
from jaxwalk.metrics import OUTCOMES
from jaxwalk.policies import AlwaysGo, RouteFollower
from jaxwalk.recipes import RECIPES
from jaxwalk.scenarios import Drawn

gymnasium.register_envs(jaxwalk.adapters.gymnasium)

SCALE = 0.1  # critics learn values of about 1 fastest
REWARD = {term: SCALE * weight for term, weight in RECIPES["fast"].driver_weights.items()}


def outcomes(model, scenarios, *, seed, batch=512):
    """Return the shares of goals and collisions in scenarios 0, 1, ... of a seed, through the adapter."""
    batch = min(batch, scenarios)
    streets = gymnasium.make_vec("jaxwalk/Street-v0", num_envs=batch)
    goals = collisions = 0
    for first in range(0, scenarios, batch):
        observation, _ = streets.reset(seed=seed, options={"scenario": first})
        playing = np.ones(batch, bool)
        while playing.any():
            actions, _ = model.predict(observation, deterministic=True)
            observation, _, terminated, truncated, info = streets.step(actions)
            ended = playing & (terminated | truncated)
            goals += int((ended & info["goal"]).sum()) if ended.any() else 0
            collisions += int((ended & info["collision"]).sum()) if ended.any() else 0
            playing &= ~ended
    return goals / scenarios, collisions / scenarios


def train(options):
    """Train PPO with the numbers of jaxwalk's recipe ``fast``."""
    count, steps = options.environments, 64
    model = PPO(
        "MlpPolicy",
        StreetVecEnv(count, reward=REWARD),
        n_steps=steps,
        batch_size=count * steps // 32,
        n_epochs=2,
        learning_rate=lambda left: 1e-3 * left,
        gamma=0.995,
        ent_coef=0.001,
        policy_kwargs={"net_arch": [256, 256], "activation_fn": torch.nn.ReLU, "log_std_init": float(np.log(0.5))},
        seed=options.seed,
        device="cpu",
    )
    begun = time.perf_counter()
    model.learn(options.steps)
    print(f"{model.num_timesteps:,} steps in {time.perf_counter() - begun:.0f} s", flush=True)
    return model


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--steps", type=int, default=4_000_000, help="steps of all environments together")
parser.add_argument("--environments", type=int, default=512)
parser.add_argument(
    "--scenarios", type=int, default=2048, help="scenarios of the evaluation; a multiple of 512, or fewer"
)
parser.add_argument("--seed", type=int, default=0)
parser.add_argument("--out", help="where to write the policy, as Stable-Baselines3 does (.zip)")
parser.add_argument("--brief", action="store_true", help="run very briefly, as a test")
options = parser.parse_args()
if options.brief:
    options.environments, options.steps, options.scenarios = 32, 4096, 32

model = train(options)
if options.out:
    model.save(options.out)
goals, collisions = outcomes(model, options.scenarios, seed=0)
print(f"PPO:            goals {goals:.1%}, collisions {collisions:.1%}")
rows = evaluate(
    Street.create(), {"driver": RouteFollower(), "pedestrian": AlwaysGo()}, Drawn(Street.create(), 0, options.scenarios)
)
rule = summarise(rows)[OUTCOMES]
print(f"route-follower: goals {rule.goal.value:.1%}, collisions {rule.collision.value:.1%}")
if not options.brief and not (goals > rule.goal.value and collisions < rule.collision.value):
    raise SystemExit("PPO has not learned to drive better than the rule")
