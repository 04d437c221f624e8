from __future__ import annotations

import json
import struct

import equinox as eqx
import jax
import numpy as np
import pytest
import safetensors.numpy

from jaxwalk.interfaces import Box, Discrete
from jaxwalk.learning.actor import make_actor
from jaxwalk.learning.config import RoleConfig
from jaxwalk.policies import LearnedPolicy, PolicyError, load_policy, read_metadata, save_policy

KEYS = jax.random.split(jax.random.key(5), 7)
made = eqx.filter_jit(make_actor)


@eqx.filter_jit
def act(policy, memory, seen):
    return policy.act(KEYS, memory, seen)[0]


@pytest.fixture(scope="module")
def actors():
    return {
        "driver": made(jax.random.key(0), 4, Box(2), RoleConfig(actor_hidden=(8, 6), observes="route")),
        "pedestrian": made(jax.random.key(1), 3, Discrete(2), RoleConfig(actor_hidden=(8,))),
    }


@pytest.fixture
def file(tmp_path, actors):
    path = tmp_path / "pair.safetensors"
    save_policy(path, actors, {"recipe": "fast", "seed": 3, "results": {"goal": 0.98}})
    return path


@pytest.mark.parametrize("sample", [False, True])
@pytest.mark.parametrize(("role", "shape"), [("driver", (4, 7)), ("pedestrian", (3, 12, 7))])
def test_loaded_acts_like_saved(file, actors, role, shape, sample):
    seen = jax.random.normal(jax.random.key(2), shape)
    saved, loaded = (
        LearnedPolicy(actors[role], role, sample),
        load_policy(file, role, sample=sample, expect_size=shape[0]),
    )
    memory = loaded.init(shape[1:-1], shape[-1:])
    np.testing.assert_array_equal(act(loaded, memory, seen), act(saved, memory, seen))
    assert loaded.view.name == ("route" if role == "driver" else "paper")


def test_sampling_differs_from_the_mode_and_stays_in_the_box(actors):
    seen = np.float32(3.0) * np.asarray(jax.random.normal(jax.random.key(2), (4, 7)))
    drawn, mode = (
        np.asarray(act(LearnedPolicy(actors["driver"], "driver", sample), None, seen)) for sample in (True, False)
    )
    assert not np.allclose(drawn, mode, equal_nan=True)
    assert np.abs(drawn).max() <= 1


def test_metadata_comes_back(file):
    metadata = read_metadata(file)
    assert (metadata["recipe"], metadata["seed"], metadata["results"]) == ("fast", 3, {"goal": 0.98})
    assert metadata["roles"]["driver"] == {"observes": "route", "kind": "clipped", "sizes": (4, 8, 6, 2), "hold": 1}


def test_a_save_leaves_nothing_beside_the_file(file):
    assert [path.name for path in file.parent.iterdir()] == [file.name]


def refusal(path, role="driver", **options):
    with pytest.raises(PolicyError) as caught:
        load_policy(path, role, **options)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    return message


def test_wrong_files_are_refused_in_one_clear_line(file, tmp_path, actors):
    assert "no such file" in refusal(tmp_path / "absent.safetensors")
    assert "holds no cyclist policy (it has: driver, pedestrian)" in refusal(file, "cyclist")
    assert "reads 4 numbers ('route'), but the environment gives 34" in refusal(file, expect_size=34)
    alone = tmp_path / "alone.safetensors"
    save_policy(alone, {"driver": actors["driver"]}, {})
    assert "holds no pedestrian policy" in refusal(alone, "pedestrian")
    text = tmp_path / "text.safetensors"
    text.write_text("not a policy at all")
    assert "damaged" in refusal(text)
    foreign = tmp_path / "foreign.safetensors"
    safetensors.numpy.save_file({"x": np.zeros(3)}, foreign)
    assert "not of jaxwalk" in refusal(foreign)


@pytest.mark.parametrize("keep", [0, 5, 40, 300, -1])
def test_a_cut_file_is_refused(file, keep):
    file.write_bytes(file.read_bytes()[:keep])
    assert "damaged" in refusal(file)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"format": 99}, "has format 99"),
        ({"roles": {"driver": {"observes": "route", "kind": "tanh", "sizes": [4, 8, 2]}}}, "don't match its header"),
        ({"roles": {"driver": {"observes": "route", "kind": "tanh", "sizes": [4]}}}, "(sizes: [4])"),
        ({"roles": {"driver": {"observes": "route", "kind": "tanh", "sizes": [4, 0, 2]}}}, "(sizes: [4, 0, 2])"),
        ({"roles": {"driver": {"observes": "route", "kind": "tanh", "sizes": [4, 8, 2], "hold": 0}}}, "(hold: 0)"),
        ({"roles": {"driver": {"observes": "route"}}}, "header"),
        ({"roles": 3}, "header"),
    ],
)
def test_a_false_header_is_refused(file, change, complaint):
    arrays = safetensors.numpy.load_file(file)
    content = file.read_bytes()
    (length,) = struct.unpack("<Q", content[:8])
    header = json.loads(json.loads(content[8 : 8 + length])["__metadata__"]["jaxwalk"])
    safetensors.numpy.save_file(arrays, file, {"jaxwalk": json.dumps(header | change)})
    assert complaint in refusal(file)


@pytest.mark.parametrize(
    ("name", "spoil", "message"),
    [
        (
            "driver.layer0.weight",
            lambda x: x.astype(np.float16),
            "layer0.weight holds something else than finite float32",
        ),
        (
            "driver.layer0.bias",
            lambda x: np.full_like(x, np.nan),
            "layer0.bias holds something else than finite float32",
        ),
        ("driver.layer0.bias", lambda x: x[:1], "arrays don't match its header"),
    ],
)
def test_arrays_must_be_numbers_of_the_network(file, name, spoil, message):
    with safetensors.safe_open(file, "numpy") as opened:
        header = opened.metadata()
    arrays = safetensors.numpy.load_file(file)
    safetensors.numpy.save_file(arrays | {name: spoil(arrays[name])}, file, header)
    with pytest.raises(PolicyError, match=message):
        load_policy(file, "driver")
