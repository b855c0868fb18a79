"""The sources of the methods, the package itself, and the paper whose systems come with it.

A source is one literal; methods and tableaux say which are theirs. DOIs are given where they have been
looked up.
"""

from __future__ import annotations

from .reference import Reference

# --- the package, without its version, as in CITATION.cff ---------------------------------------------

GEOMINT = Reference(
    key="geomint",
    kind="misc",
    authors=("The geomint authors",),
    title="geomint: structure-preserving integration of nonholonomic and Hamiltonian systems",
)
JOVANOVIC_2010 = Reference(
    key="Jovanovic2010",
    authors=("Jovanović, Božidar",),
    title="Hamiltonization and integrability of the Chaplygin sphere in Rⁿ",
    journal="Journal of Nonlinear Science",
    volume="20",
    pages="569--593",
    year=2010,
    arxiv="0902.4397",
)

# --- books --------------------------------------------------------------------------------------------

HLW_2006 = Reference(
    key="HairerLubichWanner2006",
    kind="book",
    authors=("Hairer, Ernst", "Lubich, Christian", "Wanner, Gerhard"),
    title="Geometric Numerical Integration: Structure-Preserving Algorithms for Ordinary "
    "Differential Equations",
    edition="2nd",
    series="Springer Series in Computational Mathematics",
    volume="31",
    publisher="Springer",
    year=2006,
    doi="10.1007/3-540-30666-8",
)
HNW_1993 = Reference(
    key="HairerNorsettWanner1993",
    kind="book",
    authors=("Hairer, Ernst", "Nørsett, Syvert P.", "Wanner, Gerhard"),
    title="Solving Ordinary Differential Equations I: Nonstiff Problems",
    edition="2nd",
    series="Springer Series in Computational Mathematics",
    volume="8",
    publisher="Springer",
    year=1993,
    doi="10.1007/978-3-540-78862-1",
)

# --- Runge–Kutta methods ------------------------------------------------------------------------------

HEUN_1900 = Reference(
    key="Heun1900",
    authors=("Heun, Karl",),
    title="Neue Methoden zur approximativen Integration der Differentialgleichungen einer "
    "unabhängigen Veränderlichen",
    journal="Zeitschrift für Mathematik und Physik",
    volume="45",
    pages="23--38",
    year=1900,
)
KUTTA_1901 = Reference(
    key="Kutta1901",
    authors=("Kutta, Wilhelm",),
    title="Beitrag zur näherungsweisen Integration totaler Differentialgleichungen",
    journal="Zeitschrift für Mathematik und Physik",
    volume="46",
    pages="435--453",
    year=1901,
)
BOGACKI_SHAMPINE_1989 = Reference(
    key="BogackiShampine1989",
    authors=("Bogacki, Przemyslaw", "Shampine, Lawrence F."),
    title="A 3(2) pair of Runge–Kutta formulas",
    journal="Applied Mathematics Letters",
    volume="2",
    number="4",
    pages="321--325",
    year=1989,
    doi="10.1016/0893-9659(89)90079-7",
)
DORMAND_PRINCE_1980 = Reference(
    key="DormandPrince1980",
    authors=("Dormand, John R.", "Prince, Peter J."),
    title="A family of embedded Runge–Kutta formulae",
    journal="Journal of Computational and Applied Mathematics",
    volume="6",
    number="1",
    pages="19--26",
    year=1980,
    doi="10.1016/0771-050X(80)90013-3",
)
BUTCHER_1964 = Reference(
    key="Butcher1964",
    authors=("Butcher, John C.",),
    title="Implicit Runge–Kutta processes",
    journal="Mathematics of Computation",
    volume="18",
    number="85",
    pages="50--64",
    year=1964,
    doi="10.1090/S0025-5718-1964-0159424-9",
)

# --- methods on groups --------------------------------------------------------------------------------

MUNTHE_KAAS_1999 = Reference(
    key="MuntheKaas1999",
    authors=("Munthe-Kaas, Hans",),
    title="High order Runge–Kutta methods on manifolds",
    journal="Applied Numerical Mathematics",
    volume="29",
    number="1",
    pages="115--127",
    year=1999,
    doi="10.1016/S0168-9274(98)00030-0",
)
LIE_GROUP_METHODS_2000 = Reference(
    key="Iserles2000",
    authors=("Iserles, Arieh", "Munthe-Kaas, Hans Z.", "Nørsett, Syvert P.", "Zanna, Antonella"),
    title="Lie-group methods",
    journal="Acta Numerica",
    volume="9",
    pages="215--365",
    year=2000,
    doi="10.1017/S0962492900002154",
)
CROUCH_GROSSMAN_1993 = Reference(
    key="CrouchGrossman1993",
    authors=("Crouch, Peter E.", "Grossman, Robert"),
    title="Numerical integration of ordinary differential equations on manifolds",
    journal="Journal of Nonlinear Science",
    volume="3",
    pages="1--33",
    year=1993,
    doi="10.1007/BF02429858",
)
JACKIEWICZ_MARTHINSEN_OWREN_2000 = Reference(
    key="JackiewiczMarthinsenOwren2000",
    authors=("Jackiewicz, Zdzislaw", "Marthinsen, Arne", "Owren, Brynjulf"),
    title="Construction of Runge–Kutta methods of Crouch–Grossman type of high order",
    journal="Advances in Computational Mathematics",
    volume="13",
    number="4",
    pages="405--415",
    year=2000,
    doi="10.1023/A:1016645730465",
)
CELLEDONI_MARTHINSEN_OWREN_2003 = Reference(
    key="CelledoniMarthinsenOwren2003",
    authors=("Celledoni, Elena", "Marthinsen, Arne", "Owren, Brynjulf"),
    title="Commutator-free Lie group methods",
    journal="Future Generation Computer Systems",
    volume="19",
    number="3",
    pages="341--352",
    year=2003,
    doi="10.1016/S0167-739X(02)00161-9",
)

# --- constraints, splittings, compositions ------------------------------------------------------------

ANDERSEN_1983 = Reference(
    key="Andersen1983",
    authors=("Andersen, Hans C.",),
    title="Rattle: A “velocity” version of the Shake algorithm for molecular dynamics calculations",
    journal="Journal of Computational Physics",
    volume="52",
    number="1",
    pages="24--34",
    year=1983,
    doi="10.1016/0021-9991(83)90014-1",
)
JAY_1996 = Reference(
    key="Jay1996",
    authors=("Jay, Laurent",),
    title="Symplectic partitioned Runge–Kutta methods for constrained Hamiltonian systems",
    journal="SIAM Journal on Numerical Analysis",
    volume="33",
    number="1",
    pages="368--387",
    year=1996,
    doi="10.1137/0733019",
)
STRANG_1968 = Reference(
    key="Strang1968",
    authors=("Strang, Gilbert",),
    title="On the construction and comparison of difference schemes",
    journal="SIAM Journal on Numerical Analysis",
    volume="5",
    number="3",
    pages="506--517",
    year=1968,
    doi="10.1137/0705041",
)
VERLET_1967 = Reference(
    key="Verlet1967",
    authors=("Verlet, Loup",),
    title="Computer “experiments” on classical fluids. I. Thermodynamical properties of "
    "Lennard-Jones molecules",
    journal="Physical Review",
    volume="159",
    number="1",
    pages="98--103",
    year=1967,
    doi="10.1103/PhysRev.159.98",
)
SUZUKI_1990 = Reference(
    key="Suzuki1990",
    authors=("Suzuki, Masuo",),
    title="Fractal decomposition of exponential operators with applications to many-body theories "
    "and Monte Carlo simulations",
    journal="Physics Letters A",
    volume="146",
    number="6",
    pages="319--323",
    year=1990,
    doi="10.1016/0375-9601(90)90962-N",
)
YOSHIDA_1990 = Reference(
    key="Yoshida1990",
    authors=("Yoshida, Haruo",),
    title="Construction of higher order symplectic integrators",
    journal="Physics Letters A",
    volume="150",
    number="5--7",
    pages="262--268",
    year=1990,
    doi="10.1016/0375-9601(90)90092-3",
)
KAHAN_LI_1997 = Reference(
    key="KahanLi1997",
    authors=("Kahan, William", "Li, Ren-Cang"),
    title="Composition constants for raising the orders of unconventional schemes for ordinary "
    "differential equations",
    journal="Mathematics of Computation",
    volume="66",
    number="219",
    pages="1089--1099",
    year=1997,
    doi="10.1090/S0025-5718-97-00873-9",
)
SOFRONIOU_SPALETTA_2005 = Reference(
    key="SofroniouSpaletta2005",
    authors=("Sofroniou, Mark", "Spaletta, Giulia"),
    title="Derivation of symmetric composition constants for symmetric integrators",
    journal="Optimization Methods and Software",
    volume="20",
    number="4--5",
    pages="597--613",
    year=2005,
    doi="10.1080/10556780500140664",
)
