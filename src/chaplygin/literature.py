"""The sources of the systems: where each was posed, solved or Hamiltonised.

They lie in ``literature.toml``. `JOVANOVIC_2010`, the paper whose systems these are, comes with
geomint, whose citation it belongs to.
"""

from geomint.references.literature import JOVANOVIC_2010, sources

SOURCES = sources(__file__)

BALL = (JOVANOVIC_2010, SOURCES["CHAPLYGIN_1903"], SOURCES["FEDOROV_KOZLOV_1995"])
CLASSICAL_BALL = (SOURCES["CHAPLYGIN_1903"], JOVANOVIC_2010)
POISSON_BALL = (SOURCES["BORISOV_MAMAEV_2001"], SOURCES["CHAPLYGIN_1903"])
VESELOVA = (
    SOURCES["VESELOV_VESELOVA_1988"],
    SOURCES["FEDOROV_JOVANOVIC_2004"],
    JOVANOVIC_2010,
)
RUBBER = (SOURCES["EHLERS_2005"], SOURCES["JOVANOVIC_2009"])
ELLIPSOID = (SOURCES["JACOBI_1839"], SOURCES["MOSER_1980"])
NEUMANN = (SOURCES["NEUMANN_1859"], SOURCES["MOSER_1980"])
CLEBSCH = (SOURCES["CLEBSCH_1871"], SOURCES["MOSER_1980"])
