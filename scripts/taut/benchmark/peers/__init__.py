"""The codes that take part, one module each: a new one is a module with a `PEER` and a line here."""

from taut.benchmark.entrant import Peer
from taut.benchmark.peers import exudyn, pinocchio, scipy, sundials, taut

PEERS: dict[str, Peer] = {
    peer.name: peer for peer in (taut.PEER, scipy.PEER, sundials.PEER, pinocchio.PEER, exudyn.PEER)
}
