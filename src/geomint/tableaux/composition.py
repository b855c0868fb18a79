"""Symmetric compositions of symmetric methods, mostly of order two; a method is one literal.

The digits are those published; where order and number of stages leave no freedom they are continued
to 50 (``yoshida-6``), or computed (Suzuki's and the triple jumps). The order conditions then hold up
to the last digit given.
"""

from decimal import ROUND_HALF_EVEN, Context, Decimal, localcontext

from ..references.literature import (
    HLW_2006,
    KAHAN_LI_1997,
    SOFRONIOU_SPALETTA_2005,
    SUZUKI_1990,
    YOSHIDA_1990,
)
from ..references.reference import Reference
from ._composition import Composition

_TABLES = HLW_2006.at("Section V.3.2")


def _about_one(name: str, sides: int, order: int, references: tuple[Reference, ...]) -> Composition:
    """Return the composition of s equal steps on either side of one: 1/(2s − (2s)^(1/(order − 1))).

    For bases of the order before.
    """
    with localcontext(Context(prec=60, rounding=ROUND_HALF_EVEN)):
        both = Decimal(2 * sides)
        fraction = 1 / (both - both ** (1 / Decimal(order - 1)))
        text = f"{fraction:.50f}"
    return Composition(f"{name}-{order}", order, order - 2, (text,) * sides, references)


_METHODS = (
    *(
        _about_one(name, sides, order, references)
        for order in (4, 6, 8, 10)
        for name, sides, references in (
            ("triple-jump", 1, (SUZUKI_1990, YOSHIDA_1990, HLW_2006.at("Eq. II.(4.4)"))),
            ("suzuki", 2, (SUZUKI_1990, HLW_2006.at("Eq. II.(4.5)"))),
        )
    ),
    # Solution A. Seven stages determine the coefficients up to a choice among finitely many.
    Composition(
        name="yoshida-6",
        order=6,
        base_order=2,
        fractions=(
            "0.78451361047755726381949763386634987577682441745149",
            "0.23557321335935813368479318297853460168646808210340",
            "-1.1776799841788710069464156809643157346392692526346",
        ),
        references=(YOSHIDA_1990.at("solution A"), _TABLES),
    ),
    Composition(
        name="kahan-li-6",
        order=6,
        base_order=2,
        fractions=(
            "0.39216144400731413927925056",
            "0.33259913678935943859974864",
            "-0.70624617255763935980996482",
            "0.08221359629355080023149045",
        ),
        references=(KAHAN_LI_1997, _TABLES),
    ),
    Composition(
        name="sofroniou-spaletta-6",
        order=6,
        base_order=2,
        fractions=(
            "0.13861930854051695245808013042625",
            "0.13346562851074760407046858832209",
            "0.13070531011449225190542755785015",
            "0.12961893756907034772505366537091",
            "-0.35000324893920896516170830911323",
            "0.11805530653002387170273438954049",
        ),
        references=(SOFRONIOU_SPALETTA_2005,),
    ),
    Composition(
        name="kahan-li-8",
        order=8,
        base_order=2,
        fractions=(
            "0.13020248308889008087881763",
            "0.56116298177510838456196441",
            "-0.38947496264484728640807860",
            "0.15884190655515560089621075",
            "-0.39590389413323757733623154",
            "0.18453964097831570709183254",
            "0.25837438768632204729397911",
            "0.29501172360931029887096624",
        ),
        references=(KAHAN_LI_1997, _TABLES),
    ),
    Composition(
        name="sofroniou-spaletta-8",
        order=8,
        base_order=2,
        fractions=(
            "0.10647728984550031823931967854896",
            "0.10837408645835726397433410591546",
            "0.35337821052654342419534541324080",
            "-0.23341414023165082198780281128319",
            "-0.24445266791528841269462171413216",
            "0.11317848435755633314700952515599",
            "0.11892905625000350062692972283951",
            "0.12603912321825988140305670268365",
            "0.12581718736176041804392391641587",
            "0.11699135019217642180722881433533",
        ),
        references=(SOFRONIOU_SPALETTA_2005,),
    ),
    Composition(
        name="sofroniou-spaletta-10",
        order=10,
        base_order=2,
        fractions=(
            "0.078795722521686419263907679337684",
            "0.31309610341510852776481247192647",
            "0.027918383235078066109520273275299",
            "-0.22959284159390709415121339679655",
            "0.13096206107716486317465685927961",
            "-0.26973340565451071434460973222411",
            "0.074973343155891435666137105641410",
            "0.11199342399981020488957508073640",
            "0.36613344954622675119314812353150",
            "-0.39910563013603589787862981058340",
            "0.10308739852747107731580277001372",
            "0.41143087395589023782070411897608",
            "-0.0048663605831352617621956593099771",
            "-0.39203335370863990644808193642610",
            "0.051942502962449647037182904015976",
            "0.050665090759924496335874344156866",
            "0.049674370639729879054568800279461",
        ),
        references=(SOFRONIOU_SPALETTA_2005,),
    ),
)

COMPOSITIONS = {method.name: method for method in _METHODS}
"""Symmetric compositions by name."""

DEFAULT_COMPOSITION = {
    4: "suzuki-4",
    6: "sofroniou-spaletta-6",
    8: "sofroniou-spaletta-8",
    10: "sofroniou-spaletta-10",
}
"""For each order the composition of a base of order 2 with the smallest error for its base steps.

Measured on the pendulum with Strang splitting as the base method.
"""


def default_composition(base_order: int, order: int) -> Composition | None:
    """Return the composition that raises a base to an order: one made for that base, if there is."""
    for scheme in COMPOSITIONS.values():
        fits = (scheme.base_order, scheme.order) == (base_order, order)
        if fits and scheme.name.startswith("suzuki-"):
            return scheme
    return COMPOSITIONS.get(DEFAULT_COMPOSITION.get(order, ""))
