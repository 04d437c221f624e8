"""Who plays a role in an adapter: rules by name are those of an evaluation."""

from __future__ import annotations

from jaxwalk.adapters.game import Game
from jaxwalk.adapters.players import player
from jaxwalk.sim.sim_config import SimConfig

RULES = SimConfig(contact="footprint", max_braking=7.6, dt=0.2)


def test_rules_by_name_know_the_numbers_of_the_world():
    """A driver's braking is a share of the world's, and people's waiting is counted in the world's steps."""
    game = Game.create(driver="careful-human", pedestrians="diffusion", config=RULES)
    assert (game.policies["driver"].max_braking, game.policies["pedestrian"].dt) == (7.6, 0.2)


def test_so_do_rules_behind_shields_and_in_mixtures():
    assert player("driver", "oracle+rss", RULES).driver.contact == "footprint"
    assert player("pedestrian", "diffusion:0.5+always-go:0.5", RULES).kinds[0].dt == 0.2
