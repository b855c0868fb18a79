"""Other integrators, run beside geomint's methods: one file a package.

A peer gets the field of a problem as its source says it, compiled or traced, and nothing else of
geomint: its tolerances, formulation and mode are its own best ones.
"""

from ...errors import DomainError, nearest
from .diffrax_peer import DIFFRAX
from .heyoka_peer import HEYOKA
from .lielab_peer import LIELAB
from .mici_peer import MICI
from .peer import Peer
from .scipy_peer import DOP853, LSODA

__all__ = ["PEERS", "find_peers"]

PEERS = {peer.name: peer for peer in (HEYOKA, DOP853, LSODA, DIFFRAX, LIELAB, MICI)}


def find_peers(names: list[str]) -> list[Peer]:
    """Return peers by name, or raise `DomainError` for one that is not known."""
    for name in names:
        if not (isinstance(name, str) and name in PEERS):
            raise DomainError("peers", name, f"some of {list(PEERS)}.{nearest(name, PEERS)}")
    return [PEERS[name] for name in dict.fromkeys(names)]
