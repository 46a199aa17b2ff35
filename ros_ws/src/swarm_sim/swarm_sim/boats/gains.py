"""Gains that `scripts/tune_boats.py` found for the default boat; run it again when the boat changes."""

from __future__ import annotations

from swarm_sim.boats.ladrc import Bandwidths, LadrcGains
from swarm_sim.boats.pose_pid import PidGains

LADRC_GAINS = LadrcGains.of_bandwidths(Bandwidths(5.74, 17.6, 1.68, 1.13), Bandwidths(4.36, 25.1, 1.97, 1.73))
PID_GAINS = PidGains((27.7, 55.9, 15.4), (35.0, 55.7, 20.8), 0.0621, 0.0244)
ZIEGLER_NICHOLS_GAINS = PidGains((3.91, 3.08, 1.24), (11.0, 13.9, 2.18), 0.0397, 0.0247)
