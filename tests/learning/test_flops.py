"""Operations counted by hand: two for each weight and row, and three times that, less the first layer's, in a fit."""

from __future__ import annotations

from dataclasses import replace

import pytest

from jaxwalk import Street
from jaxwalk.learning.actor import CHOSEN_PART
from jaxwalk.learning.config import CostLimit, RoleConfig, TrainConfig
from jaxwalk.learning.flops import Sizes, fit_flops, forward_flops, network_flops, passes, sizes_of
from jaxwalk.recipes import FAST, PAPER
from learning.games import ROLES, with_roles

SIZES = Sizes(
    observations={"driver": {"paper": 5, "global": 7}, "pedestrian": {"paper": 3}},
    actions={"driver": 2, "pedestrian": 2},
    agents={"driver": 1, "pedestrian": 4},
)
SMALL = {"environments": 10, "steps": 8, "minibatches": 4}


def test_one_row():
    assert forward_flops((3, 4, 2)) == 2 * (12 + 8)
    assert fit_flops((3, 4, 2)) == 2 * (2 * 12 + 3 * 8)  # no gradient of the three inputs


@pytest.mark.parametrize(("epochs", "made"), [(4, 4.0), (0.5, 0.5), (0.3, 0.25), (0.01, 0.25), (1.5, 1.5)])
def test_a_broken_epoch_is_whole_minibatches(epochs, made):
    assert passes(TrainConfig(ROLES, **SMALL), epochs) == made


def test_individual_credit():
    driver = RoleConfig(actor_hidden=(4,), critic_hidden=(6,), critic_observes=("paper", "global"), epochs=2)
    pedestrian = RoleConfig(actor_hidden=(8,), critic_hidden=(2,), epochs=1)
    found = network_flops(TrainConfig({"driver": driver, "pedestrian": pedestrian}, **SMALL), SIZES)
    # layers: 5-4-2 and 3-8-2 act, 12-6-1 and 3-2-1 judge
    assert found.acting == 2 * (20 + 8) + 4 * 2 * (24 + 16)
    assert found.judging == pytest.approx(9 / 8 * (2 * (72 + 6) + 4 * 2 * (6 + 2)))
    assert found.fits == {
        "driver": 2 * 2 * (2 * 20 + 3 * 8),
        "driver critic": 2 * 2 * (2 * 72 + 3 * 6),
        "pedestrian": 4 * 2 * (2 * 24 + 3 * 16),
        "pedestrian critic": 4 * 2 * (2 * 6 + 3 * 2),
    }
    assert found.total == pytest.approx(found.acting + found.judging + 256 + 648 + 768 + 144)


def test_a_gated_role_costs_part_of_its_rows():
    pedestrian = RoleConfig(actor_hidden=(8,), gated=True, epochs=1)
    config = TrainConfig(ROLES | {"pedestrian": pedestrian}, **SMALL)
    whole, found = network_flops(TrainConfig(ROLES, **SMALL), SIZES), network_flops(config, SIZES)
    driver = whole.acting - 4 * forward_flops((3, 128, 128, 2))
    glanced, fitted = -(-40 // CHOSEN_PART) / 10, 10 / 10  # room for the first of 8 steps, twice: a quarter
    assert found.acting == pytest.approx(driver + glanced * 2 * (24 + 16))
    assert found.fits["pedestrian"] == pytest.approx(fitted * 2 * (2 * 24 + 3 * 16))
    assert found.fits["pedestrian critic"] == pytest.approx(fitted * fit_flops((3, 128, 128, 1)))
    judged = whole.judging - 9 / 8 * 4 * forward_flops((3, 128, 128, 1))
    assert found.judging == pytest.approx(judged + (glanced + 4 / 8) * forward_flops((3, 128, 128, 1)))


def test_stand_ins_leave_fewer_rows():
    driver = RoleConfig(actor_hidden=(4,), fixed=0.2, early=0.3)
    found = network_flops(TrainConfig(ROLES | {"driver": driver}, **SMALL), SIZES)
    whole = network_flops(TrainConfig(ROLES | {"driver": replace(driver, fixed=0.0, early=0.0)}, **SMALL), SIZES)
    assert found.fits["driver"] == 0.5 * whole.fits["driver"]
    assert whole.acting - found.acting == pytest.approx(0.2 * 2 * (20 + 8))


def test_a_role_that_does_not_learn_costs_nothing():
    alone = TrainConfig(ROLES | {"pedestrian": RoleConfig(fixed=1.0)}, **SMALL)
    assert set(network_flops(alone, SIZES).fits) == {"driver", "driver critic"}


def test_a_limit_costs_another_critic():
    limited = RoleConfig(limits=(CostLimit("contact", limit=0.01),))
    plain, found = (network_flops(TrainConfig(ROLES | {"driver": x}, **SMALL), SIZES) for x in (RoleConfig(), limited))
    assert found.fits == plain.fits | {"driver contact critic": plain.fits["driver critic"]}
    assert found.acting == plain.acting
    assert found.judging - plain.judging == pytest.approx(9 / 8 * forward_flops((5, 128, 128, 1)))


def test_the_paper_recipe(street):
    """On the paper's street: 0.77 MFLOP in the rollout, 2.21 in an epoch, 9.6 in all."""
    found = network_flops(PAPER.train, sizes_of(street, PAPER.train))
    rollout = found.acting + found.judging
    assert rollout == pytest.approx(0.77e6, rel=0.01)
    assert sum(found.fits.values()) / 4 == pytest.approx(2.21e6, rel=0.01)
    assert found.total == pytest.approx(9.6e6, rel=0.01)
    assert found.fits["pedestrian"] / found.total == pytest.approx(0.55, abs=0.01)


def test_sizes_are_those_of_what_is_read(street):
    fast = FAST.train
    sizes = sizes_of(street, fast)
    assert {reader: set(seen) for reader, seen in sizes.observations.items()} == {
        "driver": {"route-footprint", "global"},
        "pedestrian": {"kerb"},
    }
    assert sizes.agents == {"driver": 1, "pedestrian": 12}
    assert sizes.actions == {"driver": 2, "pedestrian": 2}
    no_world = with_roles(fast, driver=replace(fast.roles["driver"], critic_observes=("route",)))
    assert set(sizes_of(street, no_world).observations["driver"]) == {"route-footprint", "route"}


def test_critics_read_as_many_numbers_where_people_are_hidden(street):
    hiding = Street.create(config=replace(street.config, perception=True))
    there, here = (network_flops(FAST.train, sizes_of(at, FAST.train)) for at in (hiding, street))
    assert there == here
