"""The sources of the systems: where each was posed, solved or Hamiltonised.

A source is one literal. `JOVANOVIC_2010`, the paper whose systems these are, comes with geomint, whose
citation it belongs to.
"""

from __future__ import annotations

import geomint as gi
from geomint.references.literature import JOVANOVIC_2010

__all__ = ["BALL", "CLASSICAL_BALL", "CLEBSCH", "ELLIPSOID", "NEUMANN", "POISSON_BALL", "RUBBER",
           "VESELOVA"]  # fmt: skip

CHAPLYGIN_1903 = gi.Reference(
    key="Chaplygin2002",
    authors=("Chaplygin, Sergey A.",),
    title="On a ball’s rolling on a horizontal plane",
    journal="Regular and Chaotic Dynamics",
    volume="7",
    number="2",
    pages="131--148",
    year=2002,
    note="Translation of Matematicheskii Sbornik 24 (1903) 139--168",
)
FEDOROV_KOZLOV_1995 = gi.Reference(
    key="FedorovKozlov1995",
    authors=("Fedorov, Yuri N.", "Kozlov, Valery V."),
    title="Various aspects of n-dimensional rigid body dynamics",
    journal="American Mathematical Society Translations, Series 2",
    volume="168",
    pages="141--171",
    year=1995,
)
BORISOV_MAMAEV_2001 = gi.Reference(
    key="BorisovMamaev2001",
    authors=("Borisov, Alexey V.", "Mamaev, Ivan S."),
    title="Chaplygin’s ball rolling problem is Hamiltonian",
    journal="Mathematical Notes",
    volume="70",
    pages="720--723",
    year=2001,
)
VESELOV_VESELOVA_1988 = gi.Reference(
    key="VeselovVeselova1988",
    authors=("Veselov, Alexander P.", "Veselova, Ludmila E."),
    title="Integrable nonholonomic systems on Lie groups",
    journal="Mathematical Notes",
    volume="44",
    pages="810--819",
    year=1988,
)
FEDOROV_JOVANOVIC_2004 = gi.Reference(
    key="FedorovJovanovic2004",
    authors=("Fedorov, Yuri N.", "Jovanović, Božidar"),
    title="Nonholonomic LR systems as generalized Chaplygin systems with an invariant measure and "
    "flows on homogeneous spaces",
    journal="Journal of Nonlinear Science",
    volume="14",
    pages="341--381",
    year=2004,
    arxiv="math-ph/0307016",
)
EHLERS_2005 = gi.Reference(
    key="Ehlers2005",
    kind="incollection",
    authors=("Ehlers, Kurt", "Koiller, Jair", "Montgomery, Richard", "Rios, Pedro M."),
    title="Nonholonomic systems via moving frames: Cartan equivalence and Chaplygin Hamiltonization",
    booktitle="The Breadth of Symplectic and Poisson Geometry",
    series="Progress in Mathematics",
    volume="232",
    pages="75--120",
    publisher="Birkhäuser",
    year=2005,
)
JOVANOVIC_2009 = gi.Reference(
    key="Jovanovic2009",
    authors=("Jovanović, Božidar",),
    title="LR and L+R systems",
    journal="Journal of Physics A: Mathematical and Theoretical",
    volume="42",
    pages="225202",
    year=2009,
)
JACOBI_1839 = gi.Reference(
    key="Jacobi1839",
    authors=("Jacobi, Carl Gustav Jacob",),
    title="Note von der geodätischen Linie auf einem Ellipsoid und den verschiedenen Anwendungen "
    "einer merkwürdigen analytischen Substitution",
    journal="Journal für die reine und angewandte Mathematik",
    volume="19",
    pages="309--313",
    year=1839,
)
NEUMANN_1859 = gi.Reference(
    key="Neumann1859",
    authors=("Neumann, Carl",),
    title="De problemate quodam mechanico, quod ad primam integralium ultraellipticorum classem "
    "revocatur",
    journal="Journal für die reine und angewandte Mathematik",
    volume="56",
    pages="46--63",
    year=1859,
    doi="10.1515/crll.1859.56.46",
)
CLEBSCH_1871 = gi.Reference(
    key="Clebsch1871",
    authors=("Clebsch, Alfred",),
    title="Ueber die Bewegung eines Körpers in einer Flüssigkeit",
    journal="Mathematische Annalen",
    volume="3",
    pages="238--262",
    year=1871,
)
MOSER_1980 = gi.Reference(
    key="Moser1980",
    kind="incollection",
    authors=("Moser, Jürgen",),
    title="Geometry of quadrics and spectral theory",
    booktitle="The Chern Symposium 1979",
    pages="147--188",
    publisher="Springer",
    year=1980,
    doi="10.1007/978-1-4613-8109-9_7",
)

# --- of each system -----------------------------------------------------------------------------------

BALL = (JOVANOVIC_2010, CHAPLYGIN_1903, FEDOROV_KOZLOV_1995)
CLASSICAL_BALL = (CHAPLYGIN_1903, JOVANOVIC_2010)
POISSON_BALL = (BORISOV_MAMAEV_2001, CHAPLYGIN_1903)
VESELOVA = (VESELOV_VESELOVA_1988, FEDOROV_JOVANOVIC_2004, JOVANOVIC_2010)
RUBBER = (EHLERS_2005, JOVANOVIC_2009)
ELLIPSOID = (JACOBI_1839, MOSER_1980)
NEUMANN = (NEUMANN_1859, MOSER_1980)
CLEBSCH = (CLEBSCH_1871, MOSER_1980)
