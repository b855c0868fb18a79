"""The pairs of Lobatto IIIA and IIIB: order conditions in 50 digits, structure in floating point."""

from __future__ import annotations

from operator import attrgetter

import mpmath as mp
import numpy as np
import pytest

from geomint.tableaux import MAX_LOBATTO_STAGES, LobattoPair, lobatto_pair

EPSILON = 2.0**-52
PAIRS = [lobatto_pair(s) for s in range(2, MAX_LOBATTO_STAGES + 1)]
each_pair = pytest.mark.parametrize("pair", PAIRS, ids=attrgetter("stages"))


def exact(pair: LobattoPair) -> tuple[list, list, list, list]:
    """c, b, A of IIIA, A of IIIB, from the pair's digits and b_i â_ij + b_j a_ji = b_i b_j."""
    s = range(pair.stages)
    c, b = ([mp.mpf(str(x)) for x in row] for row in (pair.nodes, pair.weights))
    a = [[b[j] * (mp.mpf("0.5") + mp.mpf(str(pair.excess[i][j]))) for j in s] for i in s]
    return c, b, a, [[b[j] - b[j] * a[j][i] / b[i] for j in s] for i in s]


@each_pair
def test_conditions(pair: LobattoPair) -> None:
    """B(2s − 2), C(s) of IIIA, C(s − 2) and D(s) of IIIB, and no more: Hairer, Wanner, IV.5."""
    s = pair.stages
    with mp.workdps(50):
        c, b, a, hat = exact(pair)
        for k in range(1, 2 * s - 1):
            assert abs(mp.fsum(b[j] * c[j] ** (k - 1) for j in range(s)) - mp.mpf(1) / k) < 1e-45
        wrong = mp.fsum(b[j] * c[j] ** (2 * s - 2) for j in range(s)) - mp.mpf(1) / (2 * s - 1)
        assert abs(wrong) > 1e-12
        for i in range(s):
            for k in range(1, s + 1):
                for matrix, last in ((a, s), (hat, s - 2)):
                    left = mp.fsum(matrix[i][j] * c[j] ** (k - 1) for j in range(s)) - c[i] ** k / k
                    assert k > last or abs(left) < 1e-45
                column = mp.fsum(b[j] * c[j] ** (k - 1) * hat[j][i] for j in range(s))
                assert abs(column - b[i] * (1 - c[i] ** k) / k) < 1e-45


@each_pair
def test_nodes_are_those_of_lobatto(pair: LobattoPair) -> None:
    """0, 1, and the zeros of P'_(s−1) between them, in their order and symmetric."""
    n, c = pair.stages - 1, pair.nodes
    assert (c[0], c[-1]) == (0, 1)
    assert list(c) == sorted(c)
    with mp.workdps(50):
        for x in c[1:-1]:
            slope = mp.diff(lambda z: mp.legendre(n, z), 2 * mp.mpf(str(x)) - 1)
            assert abs(slope) < 1e-20
        assert all(abs(x + y - 1) < 1e-50 for x, y in zip(c, c[::-1], strict=True))


@each_pair
def test_structure_in_floating_point(pair: LobattoPair) -> None:
    """Symplectic exactly, symmetric, first and last stages where they belong."""
    mu, nu, s = pair.mu, pair.nu, pair.stages
    assert (mu + nu.T == 1.0).all()
    np.testing.assert_array_equal(mu, 1.0 - mu[::-1, ::-1])
    np.testing.assert_array_equal(pair.b, pair.b[::-1])
    np.testing.assert_allclose(pair.c + pair.c[::-1], 1.0, rtol=0, atol=EPSILON)
    np.testing.assert_array_equal(mu[[0, -1]], [[0.0] * s, [1.0] * s])
    np.testing.assert_array_equal(nu[:, [0, -1]], [[1.0, 0.0]] * s)
    for array in (mu, nu, pair.b, pair.c, pair.impulses):
        assert not array.flags.writeable


@each_pair
def test_impulses(pair: LobattoPair) -> None:
    """The inverse of what takes impulses to displacements."""
    with mp.workdps(50):
        _, b, a, hat = exact(pair)
        s = range(pair.stages)
        product = [[mp.fsum(a[i][j] * hat[j][k] / b[k] for j in s) for k in s[:-1]] for i in s[1:]]
        inverse = mp.matrix(product) ** -1
        assert np.max(np.abs(pair.impulses[-1])) == np.max(np.abs(pair.impulses[:, 0])) == 0.0
        for k in s[:-1]:
            for i in s[1:]:
                expected = float(inverse[k, i - 1])
                assert pair.impulses[k, i] == pytest.approx(expected, rel=1e-13, abs=1e-13)


def test_two_and_three_stages() -> None:
    """RATTLE: the trapezoidal rule for q; the tables of Hairer, Lubich, Wanner, II.1.4."""
    two, three = lobatto_pair(2), lobatto_pair(3)
    np.testing.assert_array_equal(two.b, [0.5, 0.5])
    np.testing.assert_array_equal(two.mu, [[0.0, 0.0], [1.0, 1.0]])
    np.testing.assert_array_equal(two.nu, [[1.0, 0.0], [1.0, 0.0]])
    assert two.order == 2
    a = [[0, 0, 0], [5 / 24, 1 / 3, -1 / 24], [1 / 6, 2 / 3, 1 / 6]]
    hat = [[1 / 6, -1 / 6, 0], [1 / 6, 1 / 3, 0], [1 / 6, 5 / 6, 0]]
    np.testing.assert_allclose(three.mu * three.b, a, rtol=0, atol=EPSILON)
    np.testing.assert_allclose(three.nu * three.b, hat, rtol=0, atol=EPSILON)


@each_pair
@pytest.mark.parametrize("ratio", [1.0, -0.5, 0.25])
def test_predictor_reproduces_polynomials(pair: LobattoPair, ratio: float) -> None:
    """Increments of polynomials of degree s − 1, carried to the next step."""
    for k in range(pair.stages):
        before = pair.b * pair.c**k
        after = ratio * pair.b * (1.0 + ratio * pair.c) ** k
        size = np.abs(pair.predictor(ratio)).max()
        np.testing.assert_allclose(
            pair.predictor(ratio) @ before, after, rtol=0, atol=8 * EPSILON * size
        )


@pytest.mark.parametrize("stages", [1, 0, -3, MAX_LOBATTO_STAGES + 1, 2.5, "4"])
def test_numbers_of_stages(stages: object) -> None:
    with pytest.raises(ValueError, match="2 to 8 stages"):
        lobatto_pair(stages)  # type: ignore[arg-type]
    assert lobatto_pair(7).mu is lobatto_pair(7).mu
