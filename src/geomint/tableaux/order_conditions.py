"""Order conditions, evaluated without round-off for all three kinds of coefficients.

A method has order p exactly if its defect vanishes at p and not at p + 1 (for published decimals:
does not exceed what their last digit explains). Every condition is visited, on rooted trees,
ordered forests or words, so that no coefficient can be wrong unnoticed.
"""

from decimal import ROUND_HALF_EVEN, Context, Decimal, localcontext
from fractions import Fraction
from functools import cache
from itertools import chain
from math import prod
from typing import TypeAlias

from ._commutator_free import CommutatorFreeTableau, Flow
from ._composition import Composition
from ._exact import Row
from ._tableau import Tableau
from ._words import compose, distance, exponential

Tree: TypeAlias = "tuple[Tree, ...]"
"""A rooted tree: the subtrees that hang on its root. A forest has the same form."""

_DIGITS = Context(prec=80, rounding=ROUND_HALF_EVEN)


def runge_kutta_defect(tableau: Tableau, order: int, weights: Row | None = None) -> Fraction:
    r"""Return the largest violation of the conditions up to an order.

    .. math:: \max_{|\tau| \le p} \Big| \sum_i b_i \Phi_i(\tau) - 1 / \gamma(\tau) \Big|

    over all rooted trees; E. Hairer, S. P. Nørsett, G. Wanner, *Solving Ordinary Differential
    Equations I*, 2nd ed., Theorem II.2.13.

    Parameters
    ----------
    tableau : Tableau
        Any Runge-Kutta method.
    order : int
        Largest order p of a tree.
    weights : tuple of Fraction, optional
        Weights in place of b, such as ``tableau.b_hat``.
    """
    b = tableau.b if weights is None else weights

    @cache
    def inner(tree: Tree) -> Row:
        """Elementary weights of the stage values, sum_j a_ij Phi_j."""
        return tuple(_dot(a, outer(tree)) for a in tableau.A)

    def outer(tree: Tree) -> Row:
        """Elementary weights Phi_i of the stage derivatives."""
        columns = [inner(child) for child in tree]
        return tuple(prod((x[i] for x in columns), start=Fraction(1)) for i in range(len(b)))

    trees = chain.from_iterable(_rooted_trees(n) for n in range(1, order + 1))
    return max(abs(_dot(b, outer(tree)) - Fraction(1, _density(tree))) for tree in trees)


def commutator_free_defect(tableau: CommutatorFreeTableau, order: int) -> Fraction:
    """Return the largest violation of the conditions up to an order, on any Lie group.

    Series are indexed by ordered forests (H. Munthe-Kaas, BIT 35 (1995) 572; B. Owren,
    A. Marthinsen, BIT 39 (1999) 116). The generator of a stage with the series alpha has the
    coefficient ``alpha(forest)`` at the tree whose root carries that forest, and the exponentials
    of generators frozen at the start of the step compose as series of words in trees.
    """
    values: list[dict[Tree, Fraction]] = []
    for each in tableau.flows:
        values.append(_carried(each, values, order))
    exact = {forest: _exact_flow(forest) for forest in _ordered_forests(order)}
    return distance(values[-1], exact, Fraction(0))


def composition_defect(composition: Composition, order: int) -> Fraction:
    """Return the largest violation of the conditions up to an order, to about 70 digits.

    A symmetric base method of order 2m is the flow of ``h X_1 + h^(2m+1) X_(2m+1) +
    h^(2m+3) X_(2m+3) + ...`` with fields that satisfy no relation; the composition is compared
    with the flow of ``h X_1`` word by word (E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical
    Integration*, 2nd ed., Section V.3).
    """
    letters = [1, *range(composition.base_order + 1, order + 1, 2)]
    with localcontext(_DIGITS):
        one = Decimal(1)
        series: dict[tuple[int, ...], Decimal] = {(): one}
        for fraction in composition.gamma_exact:
            gamma = Decimal(fraction.numerator) / fraction.denominator
            step = exponential({k: gamma**k for k in letters}, _identity, order, one)
            series = compose(series, step, _identity, order)
        exact = exponential({1: one}, _identity, order, one)
        return Fraction(distance(series, exact, Decimal(0)))


def _dot(x: Row, y: Row) -> Fraction:
    """Return the sum of products, skipping the zeros of x."""
    return sum((p * q for p, q in zip(x, y, strict=True) if p), Fraction(0))


def _identity(k: int) -> int:
    """Weight of the field X_k."""
    return k


def _size(tree: Tree) -> int:
    """Return the number of nodes of a tree."""
    return 1 + sum(map(_size, tree))


def _density(tree: Tree) -> int:
    """Return the density gamma of a tree: its size times the densities of its subtrees."""
    return _size(tree) * prod(map(_density, tree))


@cache
def _rooted_trees(size: int) -> frozenset[Tree]:
    """Return the rooted trees of a size, subtrees sorted: graft a leaf in every way."""
    if size == 1:
        return frozenset([()])
    return frozenset(grown for tree in _rooted_trees(size - 1) for grown in _grafted(tree))


def _grafted(tree: Tree) -> list[Tree]:
    """Return the trees that have one leaf more."""
    grown = [tuple(sorted(((), *tree)))]
    for i, child in enumerate(tree):
        rest = tree[:i] + tree[i + 1 :]
        grown += [tuple(sorted((bigger, *rest))) for bigger in _grafted(child)]
    return grown


@cache
def _ordered_forests(size: int) -> tuple[Tree, ...]:
    """Return the ordered forests with at most `size` nodes."""
    longer = (
        (tree, *rest)
        for tree in (_ordered_forests(size - 1) if size else ())
        for rest in _ordered_forests(size - _size(tree))
    )
    return ((), *longer)


def _exact_flow(forest: Tree) -> Fraction:
    """Return the coefficient of a forest in the exact flow over one step.

    The flow satisfies ``Psi' = Psi B(Psi)``, where B grafts a forest on a new root: splitting off
    the last tree, with the forest ``forest[-1]`` above its root, and integrating divides by the
    number of nodes.
    """
    if not forest:
        return Fraction(1)
    nodes = sum(map(_size, forest))
    return _exact_flow(forest[:-1]) * _exact_flow(forest[-1]) / nodes


def _carried(each: Flow, stages: list[dict[Tree, Fraction]], order: int) -> dict[Tree, Fraction]:
    """Return the series of the value a flow leads to, given those of the earlier stages."""
    series: dict[Tree, Fraction] = {(): Fraction(1)}
    if each.start:
        series = stages[each.start - 1]
    for a in each.exponentials:
        field: dict[Tree, Fraction] = {}
        for coefficient, stage in zip(a, stages, strict=False):
            for forest, alpha in stage.items():
                if _size(forest) <= order:
                    field[forest] = field.get(forest, Fraction(0)) + coefficient * alpha
        series = compose(series, exponential(field, _size, order, Fraction(1)), _size, order)
    return series
