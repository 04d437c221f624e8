"""Mixtures: everybody is of one kind throughout an episode, in the stated proportions, and acts as that kind does."""

from __future__ import annotations

import equinox as eqx
import jax
import numpy as np
import pytest

from jaxwalk.adapters.players import player
from jaxwalk.exports.sharing import _label
from jaxwalk.policies import AlwaysGo, LearnedPolicy
from jaxwalk.policies.gap_acceptance import GapAccepting
from jaxwalk.policies.mixture import Mixture, kind_draw, kinds_of
from jaxwalk.policies.mixture_names import MixtureError, mixture_of
from jaxwalk.rollout import draw_batch
from jaxwalk.runs.contestant_names import run_folders
from jaxwalk.runs.contestants import contestant
from jaxwalk.runs.policy_origins import policy_origin
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.testing import check_pedestrians
from pytrees import as_numpy


def test_a_kind_is_a_range_of_the_trait():
    kinds = eqx.filter_jit(kinds_of)
    traits = np.float32([0.0, 0.4999, 0.5, 0.7999, 0.8, 0.99])
    assert kinds(traits, (0.5, 0.3, 0.2)).tolist() == [0, 0, 1, 1, 2, 2]
    even = np.linspace(0, 1, 1001, dtype=np.float32)[:-1]
    assert np.bincount(kinds(even, (0.1, 0.6, 0.3))).tolist() == [100, 600, 300]


def test_a_kind_is_no_odd_part_of_learned_people():
    traits = jax.random.uniform(jax.random.key(0), (4, 12, 4000))
    first = np.asarray(kind_draw(traits) < 0.3)
    assert first.mean() == pytest.approx(0.3, abs=0.01)
    for trait in np.asarray(traits):
        assert trait[first].mean() == pytest.approx(0.5, abs=0.01)
        assert trait[first].std() == pytest.approx(12**-0.5, abs=0.01)


def test_everybody_acts_as_their_kind_does(street):
    mixed = Mixture((AlwaysGo(), contestant(street, "pedestrian", "learned"), GapAccepting()), (0.3, 0.5, 0.2))
    check_pedestrians(mixed, street)
    keys = jax.random.split(jax.random.key(1), 3)
    traits, (trait, views) = as_numpy(_seen(street, keys, mixed.view))
    np.testing.assert_allclose(trait, np.modf(traits[2] + traits[3])[0])
    for choice in range(2):  # a kind that never goes, or always, among one that always does
        played = np.asarray(_played(np.full(trait.shape, choice, np.int32), keys, (trait, views[:2])))
        np.testing.assert_array_equal(played == 0, (trait >= 0.25) & (choice == 0))


@eqx.filter_jit
def _seen(street, keys, view):
    """People's traits, and what they see as they set out."""
    scenario = draw_batch(street, keys)
    return scenario.traits, street.observe(scenario, street.reset(scenario), view)


@eqx.filter_jit
def _played(choice, keys, seen):
    """What people do of whom three in four make this choice."""
    given = Mixture((AlwaysGo(), _Always(choice)), (0.25, 0.75))
    return given.act(keys, given.init((12,), (3,)), seen)[0]


class _Always:
    def __init__(self, action):
        self.action, self.view = action, AlwaysGo().view

    def init(self, agents, batch):
        return None

    def act(self, key, memory, seen):
        return self.action, memory


@pytest.mark.parametrize(
    ("name", "fault"),
    [
        ("always-go:0.5+gap-acceptance:0.4", "the shares are 0.9 together, not 1"),
        ("always-go+gap-acceptance:0.4", "'always-go' needs a name and a share between 0 and 1"),
        ("always-go:x+gap-acceptance:0.4", "'always-go:x' needs a name and a share"),
        ("always-go:nan+gap-acceptance:0.4", "'always-go:nan' needs a name and a share"),
        ("always-go:1+gap-acceptance:0.4", "'always-go:1' needs a name and a share"),
        (":0.5+gap-acceptance:0.5", "':0.5' needs a name and a share"),
        ("always-go:0.5+always-go:0.5", "names always-go twice"),
    ],
)
def test_a_wrong_mixture_is_refused_in_words(name, fault):
    with pytest.raises(MixtureError, match="as in gap-acceptance") as refused:
        mixture_of("pedestrian", name)
    assert fault in str(refused.value)


def test_a_path_with_a_plus_is_no_mixture(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert mixture_of("pedestrian", "learned") == {}
    assert mixture_of("driver", "a:0.5+b:0.5") == {}
    assert mixture_of("pedestrian", "runs/a:0.25+learned:0.75") == {"runs/a": 0.25, "learned": 0.75}
    (tmp_path / "a:0.5+b:0.5").mkdir()
    assert mixture_of("pedestrian", "a:0.5+b:0.5") == {}
    (tmp_path / "run").mkdir()
    assert run_folders(["learned", "run:0.5+learned:0.5", "wrong+run"]) == ["run"]


def test_the_origin_of_a_mixture_holds_the_hashes_of_its_files():
    one = policy_origin("pedestrian", "always-go:0.5+learned:0.5")
    other = policy_origin("pedestrian", "always-go:0.5+learned-0.1:0.5")
    assert one.kind == "mixture" and one.sha256 and one.sha256 != other.sha256


def test_adapters_take_mixtures():
    mixed = player("pedestrian", "gap-acceptance:0.5+learned:0.3+always-go:0.2", SimConfig())
    assert isinstance(mixed, Mixture) and mixed.shares == (0.5, 0.3, 0.2)
    assert [type(kind) for kind in mixed.kinds] == [GapAccepting, LearnedPolicy, AlwaysGo]
    assert mixed.kinds[1].sample


def test_a_card_names_the_kinds_for_readers_elsewhere(tmp_path):
    assert _label("learned:0.3+always-go:0.7") == "learned:0.3+always-go:0.7"
    assert _label(f"{tmp_path}/a.safetensors:0.3+always-go:0.7") == "a.safetensors:0.3+always-go:0.7"
