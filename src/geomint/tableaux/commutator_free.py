"""Explicit Lie group methods without commutators; a method is one literal."""

from fractions import Fraction

from ..references.literature import (
    CELLEDONI_MARTHINSEN_OWREN_2003,
    CROUCH_GROSSMAN_1993,
    JACKIEWICZ_MARTHINSEN_OWREN_2000,
    LIE_GROUP_METHODS_2000,
)
from ._commutator_free import CommutatorFreeTableau, flow

_CMO = CELLEDONI_MARTHINSEN_OWREN_2003

_METHODS = (
    CommutatorFreeTableau(
        name="cf-1",
        order=1,
        stages=(flow(0),),
        update=flow(0, "1"),
        references=(LIE_GROUP_METHODS_2000.at("Lie–Euler method"),),
    ),
    CommutatorFreeTableau(
        name="cf-2",
        order=2,
        stages=(flow(0), flow(0, "1/2")),
        update=flow(0, "0 1"),
        references=(LIE_GROUP_METHODS_2000.at("Lie midpoint method"),),
    ),
    # Three exponentials: the update goes on from the second stage, exp(K_1 / 3) y.
    CommutatorFreeTableau(
        name="cf-3",
        order=3,
        stages=(flow(0), flow(0, "1/3"), flow(0, "0 2/3")),
        update=flow(2, "-1/12 0 3/4"),
        references=(_CMO.at("three stages of order 3"),),
    ),
    # Built on the classical method of order 4; the fourth stage goes on from the second.
    CommutatorFreeTableau(
        name="cf-4",
        order=4,
        stages=(flow(0), flow(0, "1/2"), flow(0, "0 1/2"), flow(2, "-1/2 0 1")),
        update=flow(0, "1/4 1/6 1/6 -1/12", "-1/12 1/6 1/6 1/4"),
        references=(_CMO.at("four stages of order 4"),),
    ),
    # Crouch-Grossman: every exponential is of one generator.
    CommutatorFreeTableau(
        name="cg-2",
        order=2,
        stages=(flow(0), flow(0, "1")),
        update=flow(0, "1/2", "0 1/2"),
        references=(CROUCH_GROSSMAN_1993,),  # the conditions of order 2 on Heun's tableau
    ),
    CommutatorFreeTableau(
        name="cg-3",
        order=3,
        stages=(flow(0), flow(0, "3/4"), flow(0, "119/216", "0 17/108")),
        update=flow(0, "13/51", "0 -2/3", "0 0 24/17"),
        references=(CROUCH_GROSSMAN_1993,),
    ),
    # Published with 16 digits; here the nearest solution of all the conditions, which continues
    # every one of them. In copies a_54 often ends ...3565: that misses the conditions by 3e-15.
    CommutatorFreeTableau(
        name="cg-4",
        order=4,
        stages=(
            flow(0),
            flow(0, "0.8177227988124851838643834158477231926607"),
            flow(
                0,
                "0.3199876375476426814096092583290347703441",
                "0 0.06598642635560218735460322866733355427146",
            ),
            flow(
                0,
                "0.9214417194464946126029556144479668945508",
                "0 0.4997857776773572986305806224416389033074",
                "0 0 -1.096998444837158207718266818416109475641",
            ),
            flow(
                0,
                "0.3552358559023322010541568194471209164805",
                "0 0.2390958372307325695852991306951424279748",
                "0 0 1.39185657242032459428673699011534979186",
                "0 0 0 -1.109297939211346510584177249926216330247",
            ),
        ),
        update=flow(
            0,
            "0.1370831520630755370295947735676935348783",
            "0 -0.01836985315640201911261088774542920720619",
            "0 0 0.7397813985370779989291436164906624843028",
            "0 0 0 -0.1907142565505888966977465770334247975224",
            "0 0 0 0 0.3322195591068373798516190747204979855475",
        ),
        references=(CROUCH_GROSSMAN_1993, JACKIEWICZ_MARTHINSEN_OWREN_2000),
        tolerance=Fraction(1, 10**38),
    ),
)

COMMUTATOR_FREE = {method.name: method for method in _METHODS}
"""Commutator-free and Crouch-Grossman methods by name."""
