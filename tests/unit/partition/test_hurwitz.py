import numpy as np
import pytest

from swarm_msgs_py.partition.hurwitz import hurwitz_fill, hurwitz_radii


def test_fifty_circles_on_314_square_meters_are_as_large_as_the_specification_says() -> None:
    radii = hurwitz_radii(314.0, 50, 1.2, 2.0)

    assert radii[0] == pytest.approx(3.08, abs=0.005)
    assert radii[-1] == pytest.approx(0.44, abs=0.005)
    assert (np.diff(radii) < 0.0).all()


@pytest.mark.parametrize(("exponent", "shift"), [(1.2, 2.0), (1.5, 1.0), (1.9, 8.0)])
def test_the_fill_is_the_area_of_the_circles(exponent: float, shift: float) -> None:
    radii = hurwitz_radii(100.0, 40, exponent, shift)

    assert np.pi * (radii**2).sum() / 100.0 == pytest.approx(hurwitz_fill(40, exponent, shift))


def test_all_circles_together_have_the_whole_area() -> None:
    fills = [hurwitz_fill(count, 1.9, 1.0) for count in (10, 1000, 1_000_000)]

    assert fills == sorted(fills)
    assert fills[-1] == pytest.approx(1.0, abs=1e-5)
