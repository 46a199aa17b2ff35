from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from swarm_sim.camera.square_means import square_means


def sampled(image: np.ndarray, across: float, down: float, side: float) -> np.ndarray:
    """Return the mean over a square, by looking at very many points in it."""
    steps = (np.arange(400) + 0.5) / 400.0 - 0.5
    columns, rows = (np.floor(middle + side * steps).astype(int) for middle in (across, down))
    mean: np.ndarray = image[np.ix_(rows, columns)].mean(axis=(0, 1))
    return mean


@pytest.mark.parametrize("side", [0.4, 1.0, 2.7, 6.0])
def test_means_are_those_of_a_fine_sampling_wherever_the_square_lies(side: float) -> None:
    rng = np.random.default_rng(3)
    image = rng.random((11, 9, 3), dtype=np.float32)
    across, down = rng.uniform(side / 2.0, 9.0 - side / 2.0, (2, 4)), rng.uniform(side / 2.0, 11.0 - side / 2.0, (2, 4))

    means = square_means(image, across, down, side)

    assert means.shape == (2, 4, 3)
    for place in np.ndindex(2, 4):
        expected = sampled(image, float(across[place]), float(down[place]), side)
        assert_allclose(means[place], expected, atol=0.01)


def test_the_mean_over_the_whole_image_is_its_mean() -> None:
    image = np.random.default_rng(4).random((5, 5, 1), dtype=np.float32)

    whole = square_means(image, np.full((1, 1), 2.5), np.full((1, 1), 2.5), 5.0)

    assert whole.item() == pytest.approx(image.mean())


@pytest.mark.parametrize("middle", [(0.4, 2.0), (2.0, 0.4), (4.6, 2.0), (2.0, 4.6)])
def test_a_square_that_leaves_the_image_is_refused(middle: tuple[float, float]) -> None:
    across, down = (np.full((1, 1), along) for along in middle)

    with pytest.raises(ValueError, match="within the image"):
        square_means(np.zeros((5, 5, 1), dtype=np.float32), across, down, 1.0)
