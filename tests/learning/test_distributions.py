from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.stats
from scipy.integrate import quad

from jaxwalk.learning.distributions import Categorical, ClippedGaussian, TanhGaussian

KEYS = jax.random.split(jax.random.key(0), 20_000)
MEAN, STD = 0.4, 0.7


def gaussian(kind, mean=MEAN, std=STD, batch=1):
    return kind(jnp.full((1, batch), mean), jnp.log(jnp.full(1, std)))


def squashed_density(a, mean=MEAN, std=STD):
    return scipy.stats.norm.pdf(np.arctanh(a), mean, std) / (1 - a * a)


def squashed_entropy(mean, std):
    def integrand(u):
        return scipy.stats.norm.pdf(u, mean, std) * np.log(squashed_density(np.tanh(u), mean, std))

    return -quad(integrand, mean - 6 * std, mean + 6 * std)[0]


def test_categorical_against_scipy():
    p = np.array([0.2, 0.5, 0.3])
    choice = Categorical(jnp.log(jnp.array(p))[:, None] + 3.0)
    for n in range(3):
        assert float(choice.log_prob(jnp.array([n]))[0]) == pytest.approx(np.log(p[n]), rel=1e-5)
    assert float(choice.entropy(jnp.array([0]))[0]) == pytest.approx(scipy.stats.entropy(p), rel=1e-5)
    assert choice.mode().tolist() == [1]


def test_categorical_samples_have_its_probabilities():
    p = np.array([0.2, 0.5, 0.3])
    drawn = Categorical(jnp.broadcast_to(jnp.log(jnp.array(p))[:, None], (3, KEYS.size))).sample(KEYS)
    counts = np.bincount(np.asarray(drawn), minlength=3)
    assert scipy.stats.chisquare(counts, p * KEYS.size).pvalue > 1e-3


def test_categorical_survives_masked_and_saturated_logits():
    choice = Categorical(jnp.array([[0.0], [-1e9]]))
    assert (choice.sample(KEYS[:1]), choice.mode()) == (0, 0)
    gradient = jax.grad(
        lambda x: jnp.sum(Categorical(x).entropy(jnp.array([0])) + Categorical(x).log_prob(jnp.array([0])))
    )
    assert np.isfinite(gradient(jnp.array([[1e4], [-1e9]]))).all()


def test_clipped_gaussian_against_scipy():
    choice = gaussian(ClippedGaussian)
    for raw in (-1.7, 0.0, 2.5):
        expected = scipy.stats.norm.logpdf(raw, MEAN, STD)
        assert float(choice.log_prob(jnp.full((1, 1), raw))[0]) == pytest.approx(expected, rel=1e-5)
    entropy = scipy.stats.norm.entropy(MEAN, STD)
    assert float(choice.entropy(jnp.zeros((1, 1)))[0]) == pytest.approx(entropy, rel=1e-5)
    assert choice.action(jnp.array([[-1.7], [2.5], [0.3]])).ravel().tolist() == pytest.approx([-1, 1, 0.3])


@pytest.mark.parametrize("kind", [ClippedGaussian, TanhGaussian])
def test_gaussian_samples_are_gaussian(kind):
    drawn = np.asarray(gaussian(kind, batch=KEYS.size).sample(KEYS))[0]
    assert scipy.stats.kstest(drawn, scipy.stats.norm(MEAN, STD).cdf).pvalue > 1e-3


def test_tanh_gaussian_is_the_density_of_the_squashed_action():
    choice = gaussian(TanhGaussian)
    for a in (-0.9, 0.1, 0.99):
        got = float(choice.log_prob(jnp.full((1, 1), np.arctanh(a)))[0])
        assert got == pytest.approx(np.log(squashed_density(a)), rel=1e-3)
    assert quad(lambda a: squashed_density(a), -1, 1)[0] == pytest.approx(1, rel=1e-4)


def test_tanh_entropy_and_its_slopes_are_those_of_the_squashed_action():
    def estimate(mean, log_std):
        # evaluated, as in training, on samples that were drawn before
        raw = gaussian(TanhGaussian, batch=KEYS.size).sample(KEYS)
        return jnp.mean(TanhGaussian(jnp.full((1, KEYS.size), mean), log_std[None]).entropy(raw))

    got, slopes = jax.value_and_grad(estimate, argnums=(0, 1))(jnp.float32(MEAN), jnp.log(jnp.float32(STD)))
    step = 1e-3
    by_mean = (squashed_entropy(MEAN + step, STD) - squashed_entropy(MEAN - step, STD)) / (2 * step)
    grown, shrunk = (squashed_entropy(MEAN, STD * np.exp(s)) for s in (step, -step))
    assert float(got) == pytest.approx(squashed_entropy(MEAN, STD), abs=0.02)
    assert float(slopes[0]) == pytest.approx(by_mean, abs=0.03)
    assert float(slopes[1]) == pytest.approx((grown - shrunk) / (2 * step), abs=0.03)


@pytest.mark.parametrize("raw", [-50.0, 50.0])
def test_tanh_gaussian_stays_finite_when_saturated(raw):
    def both(mean, log_std):
        choice = TanhGaussian(mean, log_std)
        return jnp.sum(choice.log_prob(jnp.full((1, 1), raw)) + choice.entropy(jnp.full((1, 1), raw)))

    value, slopes = jax.value_and_grad(both, argnums=(0, 1))(jnp.full((1, 1), raw), jnp.zeros(1))
    assert np.isfinite(value)
    assert all(np.isfinite(x).all() for x in slopes)


def test_each_environment_has_its_own_noise_wherever_it_stands():
    choice = Categorical(jnp.zeros((2, 12, 8)))
    drawn = choice.sample(KEYS[:8])
    part = Categorical(jnp.zeros((2, 12, 3))).sample(KEYS[2:5])
    assert drawn.shape == (12, 8)
    assert (drawn[:, 2:5] == part).all()
    assert len({tuple(column) for column in np.asarray(drawn).T}) == 8


def test_two_batch_axes_keep_their_order():
    keys = KEYS[:6].reshape(2, 3)
    wide = ClippedGaussian(jnp.zeros((1, 12, 2, 3)), jnp.zeros(1)).sample(keys)
    one = ClippedGaussian(jnp.zeros((1, 12)), jnp.zeros(1)).sample(keys[1, 2])
    np.testing.assert_array_equal(wide[:, :, 1, 2], one)
