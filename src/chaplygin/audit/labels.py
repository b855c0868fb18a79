r"""The labels of the paper's source, in its order: every ``\label{…}`` is the label of a claim."""

from __future__ import annotations

__all__ = ["LABELS", "UNLABELLED"]

# fmt: off
LABELS = (
    "constraints", "Hamilton", "ham:eq", "moment_map", "dim:uslov", "red:eq", "bundle*",
    "mom:map", "red:eq2", "sym:red", "KF", "ch-lagr", "ch-constr", "red:lag", "c1", "c2", "c3",
    "c4", "ch", "hg", "oO", "K", "PE", "ch-red", "ch-red2", "mu", "SO(n-1):red", "mu*", "iso",
    "Chap", "mu-ch", "cl:int", "cl", "zero", "uslovi", "smene", "veza", "phi", "T1", "r1", "r2",
    "red:ham", "hat", "IK", "OMEGA", "2-form", "IM", "nova", "sphere", "operator", "IOP",
    "IOP1", "sing", "ro1", "ro2", "operator*", "xi", "VOLUME", "redLR", "DENSITY", "div1",
    "div2", "div3", "ham0", "hamiltonian", "main", "CM", "mapping", "hamiltonian*", "psi",
    "hamiltonian-flow", "ham_q", "ham_p", "*", "***", "**", "referee", "classical", "3.1", "la",
    "3.2", "ints", "tr1", "fedorov", "VC", "PoissonV", "VFK", "bundle", "cond_X", "dotX->P",
    "condX", "rest_St", "dot_P", "inertia_tensor", "extended1", "extended2", "ham:ves",
    "elipsoid", "CH-VP", "linearizacija", "kk", "komutiranje", "S_n", "SI",
)
# fmt: on

# Theorems, lemmas and remarks without a label: where the claims about them are. Lemma 1 is veza.
UNLABELLED = {
    "Theorem 3": ("theorem:ro",),
    "Theorem 9": ("theorem:lagrange",),
    "Remark 1": ("remark:rubber",),
    "Remark 2": ("remark:physical", "remark:lagrange", "remark:lagrange:J"),
    "Remark 3": ("remark:densities", "remark:densities:3"),
    "Remark 5": ("remark:hochgerner",),
    "Remark 6": ("remark:FeJo",),
    "Remark 8": ("remark:operators", "remark:operators:tr1"),
    "Remark 9": ("remark:right-invariance", "remark:not-noether", "remark:last"),
}
