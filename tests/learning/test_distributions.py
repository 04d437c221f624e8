from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.stats
from scipy.integrate import quad

from jaxwalk.learning.distributions import Categorical, ClippedGaussian, TanhGaussian

KEYS = np.asarray(jax.random.key_data(jax.random.split(jax.random.key(0), 20_000)))
"""As words, so that taking some of them compiles nothing."""
MEAN, STD = 0.4, 0.7


def compiled(question):
    """What a distribution answers, as one program: one operation after the other, each would be a program."""
    return jax.jit(lambda choice, *given: getattr(choice, question)(*given))


mode, action, log_prob, entropy = map(compiled, ("mode", "action", "log_prob", "entropy"))
sample = jax.jit(lambda choice, words: choice.sample(jax.random.wrap_key_data(words)))


def floats(numbers):
    return jax.device_put(np.asarray(numbers, np.float32))


def gaussian(kind, mean=MEAN, std=STD, batch=1):
    return kind(floats(np.full((1, batch), mean)), floats(np.log([std])))


def squashed_density(a, mean=MEAN, std=STD):
    return scipy.stats.norm.pdf(np.arctanh(a), mean, std) / (1 - a * a)


def squashed_entropy(mean, std):
    def integrand(u):
        return scipy.stats.norm.pdf(u, mean, std) * np.log(squashed_density(np.tanh(u), mean, std))

    return -quad(integrand, mean - 6 * std, mean + 6 * std)[0]


def test_categorical_against_scipy():
    p = np.array([0.2, 0.5, 0.3])
    choice = Categorical(floats(np.log(p)[:, None] + 3.0))
    for n in range(3):
        assert log_prob(choice, np.array([n], np.int32)).tolist() == pytest.approx([np.log(p[n])], rel=1e-5)
    assert entropy(choice, np.array([0], np.int32)).tolist() == pytest.approx([scipy.stats.entropy(p)], rel=1e-5)
    assert mode(choice).tolist() == [1]


def test_categorical_samples_have_its_probabilities():
    p = np.array([0.2, 0.5, 0.3])
    drawn = sample(Categorical(floats(np.broadcast_to(np.log(p)[:, None], (3, len(KEYS))))), KEYS)
    counts = np.bincount(np.asarray(drawn), minlength=3)
    assert scipy.stats.chisquare(counts, p * len(KEYS)).pvalue > 1e-3


def test_categorical_survives_masked_and_saturated_logits():
    choice = Categorical(floats([[0.0], [-1e9]]))
    assert (sample(choice, KEYS[:1]).tolist(), mode(choice).tolist()) == ([0], [0])
    gradient = jax.grad(
        lambda x: jnp.sum(Categorical(x).entropy(jnp.array([0])) + Categorical(x).log_prob(jnp.array([0])))
    )
    assert np.isfinite(jax.jit(gradient)(floats([[1e4], [-1e9]]))).all()


def test_clipped_gaussian_against_scipy():
    choice = gaussian(ClippedGaussian)
    for raw in (-1.7, 0.0, 2.5):
        expected = scipy.stats.norm.logpdf(raw, MEAN, STD)
        assert log_prob(choice, floats([[raw]])).tolist() == pytest.approx([expected], rel=1e-5)
    expected = scipy.stats.norm.entropy(MEAN, STD)
    assert entropy(choice, floats([[0.0]])).tolist() == pytest.approx([expected], rel=1e-5)
    limited = np.asarray(action(choice, floats([[-1.7], [2.5], [0.3]])))
    assert limited.ravel().tolist() == pytest.approx([-1, 1, 0.3])


@pytest.mark.parametrize("kind", [ClippedGaussian, TanhGaussian])
def test_gaussian_samples_are_gaussian(kind):
    drawn = np.asarray(sample(gaussian(kind, batch=len(KEYS)), KEYS))[0]
    assert scipy.stats.kstest(drawn, scipy.stats.norm(MEAN, STD).cdf).pvalue > 1e-3


def test_tanh_gaussian_is_the_density_of_the_squashed_action():
    choice = gaussian(TanhGaussian)
    for a in (-0.9, 0.1, 0.99):
        got = log_prob(choice, floats([[np.arctanh(a)]])).tolist()
        assert got == pytest.approx([np.log(squashed_density(a))], rel=1e-3)
    assert quad(lambda a: squashed_density(a), -1, 1)[0] == pytest.approx(1, rel=1e-4)


def test_tanh_entropy_and_its_slopes_are_those_of_the_squashed_action():
    def estimate(mean, log_std):
        # evaluated, as in training, on samples that were drawn before
        raw = sample(gaussian(TanhGaussian, batch=len(KEYS)), KEYS)
        return jnp.mean(TanhGaussian(jnp.full((1, len(KEYS)), mean), log_std[None]).entropy(raw))

    with_slopes = jax.jit(jax.value_and_grad(estimate, argnums=(0, 1)))
    got, slopes = with_slopes(np.float32(MEAN), np.log(np.float32(STD)))
    step = 1e-3
    by_mean = (squashed_entropy(MEAN + step, STD) - squashed_entropy(MEAN - step, STD)) / (2 * step)
    grown, shrunk = (squashed_entropy(MEAN, STD * np.exp(s)) for s in (step, -step))
    assert float(got) == pytest.approx(squashed_entropy(MEAN, STD), abs=0.02)
    assert float(slopes[0]) == pytest.approx(by_mean, abs=0.03)
    assert float(slopes[1]) == pytest.approx((grown - shrunk) / (2 * step), abs=0.03)


@jax.jit
@partial(jax.value_and_grad, argnums=(0, 1))
def both_with_slopes(mean, log_std, raw):
    choice = TanhGaussian(mean, log_std)
    return jnp.sum(choice.log_prob(raw) + choice.entropy(raw))


@pytest.mark.parametrize("raw", [-50.0, 50.0])
def test_tanh_gaussian_stays_finite_when_saturated(raw):
    value, slopes = both_with_slopes(floats([[raw]]), floats([0.0]), floats([[raw]]))
    assert np.isfinite(value)
    assert all(np.isfinite(x).all() for x in slopes)


def test_each_environment_has_its_own_noise_wherever_it_stands():
    drawn = np.asarray(sample(Categorical(floats(np.zeros((2, 12, 8)))), KEYS[:8]))
    part = np.asarray(sample(Categorical(floats(np.zeros((2, 12, 3)))), KEYS[2:5]))
    assert drawn.shape == (12, 8)
    assert (drawn[:, 2:5] == part).all()
    assert len({tuple(column) for column in drawn.T}) == 8


def test_two_batch_axes_keep_their_order():
    keys = KEYS[:6].reshape(2, 3, 2)
    wide = sample(ClippedGaussian(floats(np.zeros((1, 12, 2, 3))), floats([0.0])), keys)
    one = sample(ClippedGaussian(floats(np.zeros((1, 12))), floats([0.0])), keys[1, 2])
    np.testing.assert_array_equal(np.asarray(wide)[:, :, 1, 2], one)
